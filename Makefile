# Everything a developer or a visitor runs. Needs cargo (with rustfmt and clippy) and Python >= 3.11.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
WHEELS := target/wheels
NBCONVERT := $(BIN)/python -m nbconvert --log-level=ERROR
PROFILE := --profile dist

define INSTALL_WHEEL
$(PIP) install --no-compile "$$(echo $(WHEELS)/standfast-*.whl)$(if $(EXTRA),[$(EXTRA)])"
$(PIP) install --no-compile --no-deps --force-reinstall $(WHEELS)/standfast-*.whl
endef

# `wheel` if there is none, or if a source is newer than it; otherwise the environment alone.
BUILT := $(firstword $(wildcard $(WHEELS)/standfast-*.whl))
FRESH_WHEEL := $(if $(BUILT),$(if $(shell find crates python Cargo.toml Cargo.lock pyproject.toml -type f -not -name '*.pyc' -newer $(BUILT) | head -n 1),wheel,$(BIN)/maturin),wheel)

.PHONY: demo check test rust python long bits bench caps explorer site tour links gallery paper maps robot sweeps chart frames growth atlas accuracy safe feet calls footprint fuzz mutate crate audit dist pythons version wheel clean
ifndef SIDE_BY_SIDE
.NOTPARALLEL:
endif

# Installs standfast with its plots and shows a clattering rod; see clattering_rod.png afterwards.
demo: EXTRA := plot
demo: PROFILE := --release
demo: wheel
	$(BIN)/standfast run examples/clattering_rod.toml --plot clattering_rod.png

# For daily use, a minute once everything has been built: lints, unit tests, and the Python tests that take seconds, on a wheel that
# is built quickly.
QUICK := tests/structure tests/modes/test_modes.py tests/motion/test_known_answers.py tests/motion/test_reference.py \
	tests/motion/test_plastic.py tests/python_api/test_options.py tests/python_api/test_messages.py tests/python_api/test_zero.py
check: EXTRA := test
check: PROFILE := --profile quick
check: wheel
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --profile quick --quiet -- -D warnings
	$(RUST_TESTS) --lib --quiet
	$(BIN)/ruff format --check --quiet python tests examples benches site paper
	$(BIN)/ruff check --quiet python tests examples benches site paper
	$(BIN)/python -m pytest -q -n 2 $(QUICK)

# With the binding, so that the tests, the wheel and the documentation are built from the same dependencies.
RUST_TESTS := cargo test -p standfast -p standfast-python -p standfast-site --profile quick

# One build for all tests, with checks of overflows; then the tests in Rust and in Python side by side. The wheel that users install is
# optimised more and has the same bits: `make bits`.
test: EXTRA := test
test: PROFILE := --profile quick
test:
	$(RUST_TESTS) --no-run
	$(MAKE) --no-print-directory wheel EXTRA=$(EXTRA) PROFILE="$(PROFILE)"
	+@$(MAKE) --no-print-directory --jobs=2 --output-sync=line SIDE_BY_SIDE=yes rust python

rust:
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --profile quick -- -D warnings
	cargo check -p standfast --no-default-features --profile quick --quiet
	RUSTDOCFLAGS="-D warnings" cargo doc -p standfast --no-deps --profile quick --quiet
	$(RUST_TESTS)

# On the wheel that is installed.
python:
	$(BIN)/ruff format --check python tests examples benches site paper
	$(BIN)/ruff check python tests examples benches site paper
	$(BIN)/python -m mypy
	$(BIN)/python -m mypy.stubtest --mypy-config-file pyproject.toml standfast
	$(BIN)/python -m pytest -n 2 --dist worksteal

# Larger campaigns of the same tests: about three hours on two cores. `make -k long` goes on after one that fails; `make long-walls`
# runs one of them.
LONG := $(BIN)/python -m pytest -q -n 2 --dist worksteal
CAMPAIGNS := long-rust long-files long-oracle long-symmetry long-relations long-together long-middle long-bounces long-fuzz \
	long-kicks long-sensitivity long-vertices long-friction long-modes long-walls long-ground long-stability long-cut long-joints long-systems long-sides long-films
.PHONY: $(CAMPAIGNS)
long: $(CAMPAIGNS)
long $(CAMPAIGNS): EXTRA := test
long $(CAMPAIGNS): PROFILE := --profile quick
$(CAMPAIGNS): wheel
long-rust:
	cargo test -p standfast --profile quick -- --ignored --skip mutated
long-files:
	STANDFAST_FUZZ_INPUTS=20000 cargo test -p standfast --profile quick --test fuzz
long-oracle:
	STANDFAST_ORACLE_CASES=3000 STANDFAST_ENCLOSURES=10000 $(LONG) tests/motion/test_oracle.py tests/motion/test_enclosure.py
long-symmetry:
	STANDFAST_SYMMETRY_SCENES=1500 STANDFAST_POSTURES=250 $(LONG) tests/motion/test_symmetry.py tests/motion/test_order.py
long-relations:
	STANDFAST_KICKED_RUNS=3000 STANDFAST_ENERGY_RUNS=1500 STANDFAST_FORCES_RUNS=2000 STANDFAST_RELATIONS_RUNS=5000 $(LONG) \
		tests/motion/test_excitation.py tests/motion/test_energy.py tests/motion/test_forces.py tests/motion/test_relations.py
long-together:
	STANDFAST_TOGETHER=10000 STANDFAST_FLAT_DROPS=2000 STANDFAST_STACKS=1000 STANDFAST_SHAFTS=2000 $(LONG) \
		tests/motion/test_together.py tests/motion/test_shafts.py
long-middle:
	STANDFAST_MIDDLE_FEET=1000 STANDFAST_ROWS_OF_FEET=2000 $(LONG) tests/motion/test_middle_foot.py
long-bounces:
	STANDFAST_TIES=10000 STANDFAST_FLUSH_HITS=2000 STANDFAST_ZERO_KICKS=20000 STANDFAST_BOUNCES=2000 \
	STANDFAST_ROCKING=2000 $(LONG) \
		tests/motion/test_ties.py tests/motion/test_kicks_at_events.py tests/motion/test_bounces.py tests/motion/test_rocking.py
long-fuzz:
	STANDFAST_FUZZ_SCENES=3000 STANDFAST_TERRAIN_SCENES=10000 STANDFAST_ENDLESS=40000 $(LONG) \
		tests/motion/test_fuzz_scenes.py tests/terrain/test_terrain.py tests/motion/test_endless.py
long-kicks:
	STANDFAST_STANCES=3000 STANDFAST_STABILITY_POSTURES=500 STANDFAST_KICKED_POSTURES=500 $(LONG) tests/stability/test_stability.py
long-sensitivity:
	STANDFAST_SENSITIVITY=500 $(LONG) tests/motion/test_sensitivity.py
long-vertices:
	STANDFAST_CONVEX_BODIES=2000 STANDFAST_VERTICES=1000 STANDFAST_VERTICES_STEPPED=50 $(LONG) \
		tests/terrain/test_convex_vertices.py tests/terrain/test_vertices.py
long-friction:
	STANDFAST_FRICTION_SCENES=500 STANDFAST_JAM_BOXES=5000 STANDFAST_BELTS=5000 $(LONG) \
		tests/motion/test_friction.py tests/motion/test_jam.py tests/motion/test_surfaces.py
long-modes:
	STANDFAST_MODES_CASES=2000 STANDFAST_OWN_GROUND=3400 $(LONG) tests/modes/test_modes_brute.py tests/terrain/test_own_ground.py
long-walls:
	STANDFAST_WALL_SCENES=20000 STANDFAST_THROWS=5000 STANDFAST_EDGE_RUNS=3000 STANDFAST_STAIRS=3000 $(LONG) \
		tests/terrain/test_walls.py tests/terrain/test_shapes.py tests/terrain/test_edges.py
long-ground:
	STANDFAST_SIDES_TERRAINS=1400 STANDFAST_SIDES_POINTS=100 STANDFAST_TOUCHING_SCENES=10000 STANDFAST_REACH=1000 $(LONG) \
		tests/terrain/test_ground_sides.py tests/terrain/test_touching.py tests/terrain/test_reach.py
long-stability:
	STANDFAST_WALL_STANCES=3000 STANDFAST_WALL_KICKED=150 STANDFAST_VERDICTS=2000 STANDFAST_EXISTENCE=20000 STANDFAST_DRIFT=20000 \
		STANDFAST_CERTIFICATES=2000 STANDFAST_FEET=400 STANDFAST_FEET_EVENTS=1000 STANDFAST_WELLS=60 STANDFAST_JAMS=1000 \
		STANDFAST_JAMS_KICKS=200 STANDFAST_FLIGHTS=200 STANDFAST_PUSHED=200 $(LONG) tests/stability
long-cut:
	STANDFAST_CUT=2000 STANDFAST_MOVED=12500 STANDFAST_LINES=1000 STANDFAST_SAFE=60 $(LONG) \
		tests/stability/test_cut_flights.py tests/stability/test_lines.py tests/stability/test_safe_speed.py
long-joints:
	STANDFAST_JOINTS=10000 $(LONG) tests/mechanisms/test_joints.py
long-systems:
	STANDFAST_ASSEMBLIES=290 STANDFAST_DROPPED_STACKS=300 STANDFAST_SYSTEM_VERDICTS=500 STANDFAST_SYSTEM_KICKS=10 STANDFAST_PLANTED=60 $(LONG) \
		tests/mechanisms/test_system_campaigns.py
long-sides:
	STANDFAST_SIDE_THROWS=9000 STANDFAST_SIDE_STEPPED=200 STANDFAST_EDGE_THROWS=40000 STANDFAST_FLUSH_SLIDES=10000 \
		STANDFAST_DISCS=20000 STANDFAST_CORNER_THROWS=5000 $(LONG) tests/motion/test_sides_on_corners.py tests/motion/test_ends_of_sides.py \
		tests/motion/test_discs_on_terrain.py tests/motion/test_discs_on_corners.py
long-films:
	STANDFAST_FILMS=20 $(LONG) tests/python_api/test_animation.py

# The bits of every answer on 11 000 seeded scenes beside those that tests/data/bits.txt has: half a minute.
bits: EXTRA :=
bits: wheel
	$(BIN)/python tests/bits.py

bench:
	cargo bench -p standfast-benches --bench collision --bench run --bench batch --bench modes --bench mechanism

# The explorer as a page of one file that needs no server: target/explorer/index.html, with the core as WebAssembly in it. Then
# tests/python_api/test_wasm.py compares its answers with those of the wheel.
explorer: EXTRA :=
explorer: PROFILE := --profile quick
explorer: $(FRESH_WHEEL)
	crates/wasm/build.sh
	$(BIN)/python -m standfast.page target/explorer/standfast.wasm target/explorer/index.html

# The documentation as a site of pages that need no network: target/site/index.html, from docs/ and the docstrings. It takes the wheel that
# is there, if no source is newer. The explorer is in it where Rust's library for WebAssembly is found or can be fetched.
site: EXTRA := site
site: PROFILE := --profile quick
site: $(FRESH_WHEEL)
	$(INSTALL_WHEEL)
	$(BIN)/zensical build --clean --strict
	if crates/wasm/build.sh; then $(BIN)/python -m standfast.page target/explorer/standfast.wasm target/site/explorer.html; \
		else cp site/no_explorer.html target/site/explorer.html; fi
	$(NBCONVERT) --to html --TemplateExporter.extra_template_basedirs=site --template=tour --output-dir=target/site examples/tour.ipynb

# Runs the notebook of the tour, and stores it with its outputs. What only a kernel can show, in cells with the tag `live`, is not stored.
tour: EXTRA := notebook,site
tour: wheel
	$(PIP) install "ipykernel>=7,<8"
	$(NBCONVERT) --to notebook --inplace --execute --ExecutePreprocessor.store_widget_state=False \
		--ExecutePreprocessor.record_timing=False examples/tour.ipynb
	$(NBCONVERT) --to notebook --inplace --TagRemovePreprocessor.enabled=True \
		--TagRemovePreprocessor.remove_all_outputs_tags=live examples/tour.ipynb

# Follows every link of the site that `make site` has built.
PORT := 8199
links:
	@$(BIN)/python -m http.server --directory target/site --bind 127.0.0.1 $(PORT) > /dev/null 2>&1 & server=$$!; sleep 1; \
		$(BIN)/linkchecker --no-status http://127.0.0.1:$(PORT)/; code=$$?; kill $$server; exit $$code

# Every command of the README and of the site, copied and run in a fresh clone; it builds the package twice, optimised.
commands:
	$(PYTHON) tests/commands.py

# The pictures and films of the gallery, the recipes and the tutorials, by the code beside them, and the film at the top of the site: two
# minutes.
gallery: EXTRA := plot,map
gallery: wheel
	$(PIP) install --no-compile "pymunk==7.3.1"
	$(BIN)/python site/gallery.py > /dev/null
	$(BIN)/python site/beside_an_engine.py

# The paper in paper/: its numbers computed anew and compared with its text, and target/paper.html where pandoc is installed.
paper: EXTRA := map
paper: PROFILE := --profile quick
paper: $(FRESH_WHEEL)
	$(INSTALL_WHEEL)
	$(PIP) install --no-compile "matplotlib>=3.8" "pymunk==7.3.1"
	$(BIN)/python paper/check_numbers.py
	command -v pandoc > /dev/null && pandoc --standalone --citeproc --resource-path=paper paper/paper.md -o target/paper.html || true

# Instruction counts against their caps. Needs valgrind and gungraun-runner 0.20.0 (cargo install gungraun-runner --version 0.20.0).
caps:
	cargo bench -p standfast-benches --bench caps

# Speed against accuracy beside every other engine that is installed (Siconos: Debian's python3-siconos): half an hour.
chart: EXTRA := plot,peers
chart: wheel
	$(BIN)/python benches/work_precision/chart.py

# Whole runs up to rest, beside Box2D with its usual step up to the same time.
frames:
	cargo run --release --quiet --manifest-path benches/work_precision/engines/Cargo.toml -- frames benches/work_precision/scenes.json

# How the cost grows with the work.
growth: EXTRA := plot
growth: wheel
	$(BIN)/python benches/growth.py

# The page of the atlas, its picture, and the files of its truths.
atlas: EXTRA := test,peers
atlas: wheel
	cd tests && export PYTHONPATH=oracles && ../$(BIN)/python -m atlas.page && ../$(BIN)/python -m atlas.difficulty

# Errors against arbitrary precision, by family of random scenes: minutes.
accuracy: EXTRA := test
accuracy: wheel
	$(BIN)/python benches/accuracy.py

# Calls from Python: one run, and a million at once.
calls: EXTRA :=
calls: wheel
	$(BIN)/python benches/calls.py

# Time of the import beyond numpy's, and size of the wheel.
footprint: EXTRA :=
footprint: wheel
	$(BIN)/python benches/footprint.py

# How far a guaranteed speed is from the smallest kick that does not come back, and whether all slower ones do: two hours.
safe: EXTRA :=
safe: wheel
	$(BIN)/python benches/safe_speeds.py 500 1000

# Which bodies on random feet are undecided, and which verdicts have certificates: a minute and a half.
feet: EXTRA :=
feet: wheel
	$(BIN)/python benches/open_feet.py

# Seconds for a map of 500 x 500 postures, a table of undecided postures, and pictures of maps: second_figure.png, third_figure.png,
# shape_chaos.png.
maps: EXTRA := plot,map
maps: wheel
	$(BIN)/python benches/maps.py
	$(BIN)/python benches/open_postures.py
	$(BIN)/python examples/second_figure.py
	$(BIN)/python examples/third_figure.py
	$(BIN)/python examples/shape_chaos.py

# Robots from URDF files through Pinocchio: the pictures of their page, chains beside them, and MuJoCo beside Pinocchio.
robot: EXTRA := test,robots
robot: wheel
	$(PIP) install --no-compile "mujoco==4.0.0"
	$(BIN)/python examples/robot.py docs/robot.png
	$(BIN)/python examples/footholds.py docs/footholds.png
	$(BIN)/python -m pytest -q tests/mechanisms/test_robot.py tests/mechanisms/test_robots.py

# Seconds for a map of a million postures: one thread, all cores, and a Dask cluster of this machine.
sweeps: EXTRA := test
sweeps: wheel
	$(BIN)/python benches/sweeps.py

# Fuzz targets, each for a quarter of an hour or ten million inputs. Needs nightly Rust and cargo-fuzz.
fuzz:
	for target in scene motion modes standing; do \
		mkdir -p target/fuzz/$$target; \
		cargo +nightly fuzz run -O $$target target/fuzz/$$target fuzz/corpus/$$target -- \
			-runs=10000000 -max_total_time=900 -timeout=10 || exit 1; \
	done

# Offspring of the fuzz targets' corpora, a quarter of an hour of each.
mutate:
	STANDFAST_FUZZ_SECONDS=900 cargo test --release -p standfast --test fuzz -- --ignored --nocapture mutated

# The crate as it is published: packed, unpacked elsewhere, and tested there.
crate:
	cargo package -p standfast --allow-dirty --no-verify --target-dir target/crate
	rm -rf target/crate/alone && mkdir -p target/crate/alone
	tar -xzf target/crate/package/standfast-*.crate -C target/crate/alone --strip-components=1
	test -f target/crate/alone/LICENSE-MIT -a -f target/crate/alone/LICENSE-APACHE -a -f target/crate/alone/README.md
	cd target/crate/alone && printf '\n[workspace]\n[profile.test]\nopt-level = 2\n' >> Cargo.toml && cargo test --target-dir ../build

# Licences, origins and known faults of all packages that are built in. Needs cargo-deny, and the network unless DENY=--offline.
audit:
	cargo deny $(DENY) --workspace --all-features check

# What a release uploads, in target/dist: the source distribution, and from it the wheel for Linux; their descriptions, the tag of the
# wheel (auditwheel), and the types of the public names (pyright) are checked. The workflow `release` does it for every platform.
DIST := target/dist
UNPACKED := target/unpacked
dist: $(BIN)/maturin
	$(PIP) install --no-compile "maturin[zig]>=1.16,<2"
	rm -rf $(DIST) $(UNPACKED) && mkdir -p $(DIST) $(UNPACKED)
	$(BIN)/maturin sdist --out $(DIST)
	tar -xzf $(DIST)/standfast-*.tar.gz -C $(UNPACKED) --strip-components=1
	. $(BIN)/activate && cd $(UNPACKED) && maturin build --profile dist --zig --compatibility manylinux_2_28 --target-dir ../dist-build --out ../dist
	$(PIP) install --no-compile "$$(echo $(DIST)/standfast-*.whl)[map,notebook,plot,release]"
	$(PIP) install --no-compile --no-deps --force-reinstall $(DIST)/standfast-*.whl
	$(BIN)/twine check --strict $(DIST)/*
	$(BIN)/auditwheel show $(DIST)/*.whl
	. $(BIN)/activate && pyright --outputjson --ignoreexternal --verifytypes standfast | python -c 'import json, sys; \
		share = json.load(sys.stdin)["typeCompleteness"]["completenessScore"]; \
		print(f"{share:.1%} of the public names have known types"); sys.exit(share < 0.99)'

# The wheel of `make dist` in a new environment of each Python that is found, without a compiler.
PYTHONS ?= $(shell for v in 11 12 13 14; do python3.$$v -c 'import sys; print(sys.executable)' 2> /dev/null; done; true)
pythons:
	$(PYTHON) tests/pythons.py $(DIST) $(PYTHONS)

# The next version: its number in every file that has it, its date in the changelog, a commit and a tag. VERSION=0.2.0
version:
	$(BIN)/bump-my-version bump --new-version $(VERSION)

# The wheel, compiled in target/ like everything else, installed into .venv with the extra asked for.
wheel: $(BIN)/maturin
	rm -f $(WHEELS)/standfast-*.whl
	$(BIN)/maturin build $(PROFILE) --out $(WHEELS)
	$(INSTALL_WHEEL)

$(BIN)/maturin:
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit("standfast needs Python 3.11 or newer; say make PYTHON=/path/to/python3")'
	$(PYTHON) -m venv $(VENV)
	$(PIP) install --no-compile "maturin>=1.16,<2"

clean:
	cargo clean
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache .hypothesis clattering_rod.png second_figure.png third_figure.png shape_chaos.png robot.png

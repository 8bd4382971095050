"""Error messages for wrong inputs, in full, for review."""

import math
import os
import shlex
import subprocess
import sys
from importlib.metadata import version

import numpy as np
import pytest
import standfast as sf
from bodies import with_defaults
from standfast.cli import main

#: cyclopts 4, for Python 3.10, has no completion for PowerShell.
SHELLS = '"zsh", "bash", "fish"'
if not version("cyclopts").startswith("4."):
    SHELLS += ', "powershell"'
TOML = """\
gravity = 9.81
restitution = 0.1
[body]
mass = 1.0
gyration_radius = 0.2
center_of_mass = [0.0, 0.0]
[[contact]]
point = [-0.5, 0.0]
[[contact]]
point = [0.5, 0.0]
slope = 0.0
[start]
q = [0.0, 0.011, 0.002]
[run]
model = "full"
"""
JSON = """\
{"gravity": 9.81, "restitution": 0.1,
"body": {"mass": 1.0, "gyration_radius": 0.2, "center_of_mass": [0.0, 0.0]},
"contact": [
{"point": [-0.5, 0.0]},
{"point": [0.5, 0.0], "slope": 0.0}
],
"start": {"q": [0.0, 0.011, 0.002]},
"run": {"model": "full"}}
"""
BODY = "[body]\nmass = 1.0\ngyration_radius = 0.2\ncenter_of_mass = [0.0, 0.0]"
BOTH = "[[contact]]\npoint = [-0.5, 0.0]\n[[contact]]"
BOM = "\ufeff"

#: A text in the TOML file, its replacement, and the message after the file name.
IN_TOML = [
    # Numbers out of range.
    ("mass = 1.0", "mass = 0.0", "line 4, column 8: body.mass = 0.0 is outside its range: finite and > 0, from 1e-150 to 1e150"),
    ("gravity = 9.81", "gravity = -9.81", "line 1, column 11: gravity = -9.81 is outside its range: finite and >= 0: 0, or from 1e-150 to 1e150"),
    ("gravity = 9.81", BOM + "gravity = -9.81", "line 1, column 11: gravity = -9.81 is outside its range: finite and >= 0: 0, or from 1e-150 to 1e150"),
    ("slope = 0.0", "slope = 4.0", "line 11, column 9: contact.2.slope = 4.0 cannot be used: -pi < slope <= pi, in rad; did you mean math.radians(4) = 0.06981317007977318?"),
    ("[0.5, 0.0]", "[0.5, nan]", "line 10, column 15: contact.2.point.y = NaN is outside its range: finite, at most 1e150 in size"),
    ("slope = 0.0", "tangential_restitution = 1.0", "line 11, column 26: contact.2.tangential_restitution = 1.0 is outside its range: 0 <= tangential_restitution < 1"),
    ("slope = 0.0", "segment = [1.0, 2.0]", "line 11, column 11: contact.2.segment = (1.0, 2.0) cannot be used: low <= 0 <= high with low < high"),
    ("0.011", "inf", "line 13, column 11: start.q.y = inf is outside its range: finite, at most 1e150 in size"),
    ("mass = 1.0", "mass = 1e999", "line 4, column 8, body.mass: floating-point number overflowed"),
    ('model = "full"', "event_limit = 99999999999999999999999", "line 15, column 15, run.event_limit: invalid type: integer `99999999999999999999999`, expected an integer >= 0"),
    # Wrong kinds of values.
    ("mass = 1.0", "mass = '1'", 'line 4, column 8, body.mass: invalid type: string "1", expected a number'),
    ('model = "full"', 'model = "ful"', "line 15, column 9, run.model: unknown variant `ful`, expected one of `auto`, `local`, `full`; did you mean `full`?"),
    ('model = "full"', "model = { full = 1 }", "line 15, column 9, run.model: invalid type: table, expected a string"),
    ('model = "full"', "time_limit = { inf = 1 }", 'line 15, column 14, run.time_limit: a number, "inf" or "-inf" is needed'),
    (BODY, "body = [1.0, 0.2, [0.0, 0.0]]", "line 3, column 8, body: invalid type: array, expected a table"),
    ("[run]", "[[run]]", "line 14, column 1, run: invalid type: array, expected a table"),
    (BOTH, "[contact]", "line 7, column 1, contact: invalid type: table, expected an array of tables, each under [[contact]] in TOML"),
    # Missing, unknown and duplicate fields.
    ("mass = 1.0\n", "", "line 3, column 1, body: missing field `mass`"),
    ("mass = 1.0", "mass = 1.0\ncolour = 1", "line 5, column 1, body.colour: unknown field `colour`, expected one of `mass`, `gyration_radius`, `center_of_mass`, `outline`"),
    ("mass = 1.0", "mas = 1.0", "line 4, column 1, body.mas: unknown field `mas`, expected one of `mass`, `gyration_radius`, `center_of_mass`, `outline`; did you mean `mass`?"),
    (BOTH, BOTH.replace("[[contact]]", "[[contacts]]"), "line 7, column 3, contacts: unknown field `contacts`, expected one of `gravity`, `restitution`, `terrain`, `surfaces`, `ground`, `body`, `contact`, `start`, `run`, `kick`, `force`, `ground_motion`; did you mean `[[contact]]`?"),
    ("slope = 0.0", "slop = 0.0", "line 11, column 1, contact.2.slop: unknown field `slop`, expected one of `point`, `slope`, `friction`, `restitution`, `tangential_restitution`, `radius`, `center`, `surface_speed`, `segment`; did you mean `slope`?"),
    ("slope = 0.0", "slope = 30.0", "line 11, column 9: contact.2.slope = 30.0 cannot be used: -pi < slope <= pi, in rad; did you mean math.radians(30) = 0.5235987755982988?"),
    ("mass = 1.0", "mass = 1.0\nmass = 1.0", "line 5, column 1: duplicate key `mass`"),
    (TOML, "", "is empty"),
    ("gravity = 9.81", "gravity = 9.81\nterrain = []", "line 2, column 11, terrain: invalid length 0, expected vertices; leave an empty list out"),
    ("gravity", BOM + BOM + "gravity", "line 1, column 1: invalid unquoted key, expected letters, numbers, `-`, `_`"),
]  # fmt: skip

#: As `IN_TOML`.
IN_JSON = [
    ('"mass": 1.0', '"mass": 0.0', "line 2, column 18: body.mass = 0.0 is outside its range: finite and > 0, from 1e-150 to 1e150"),
    ("0.011", "1e200", "line 7, column 22: start.q.y = 1e200 is outside its range: finite, at most 1e150 in size"),
    ("0.011", "1e999", "line 7, column 26, start.q.2: a number within the range of doubles is needed"),
    ("0.011", "NaN", "line 7, column 22, start.q.2: a value of JSON is needed: no NaN, no Infinity, no comment"),
    ('"mass": 1.0', '"mass": null', "line 2, column 18, body.mass: invalid type: null, expected a number"),
    ('"full"', "null", "line 8, column 18, run.model: invalid type: null, expected a string"),
    ('"full"', '{"full": null}', "line 8, column 18, run.model: invalid type: table, expected a string"),
    ('"model": "full"', '"event_limit": -1', "line 8, column 24, run.event_limit: invalid value: integer `-1`, expected an integer >= 0"),
    ('"contact"', '"contacts"', "line 3, column 13, contacts: unknown field `contacts`, expected one of `gravity`, `restitution`, `terrain`, `surfaces`, `ground`, `body`, `contact`, `start`, `run`, `kick`, `force`, `ground_motion`; did you mean `contact`?"),
    ('{"model": "full"}', '["full"]', "line 8, column 8, run: invalid type: array, expected a table"),
    ('{"point": [0.5, 0.0], "slope": 0.0}', "[[0.5, 0.0]]", "line 5, column 1, contact.2: invalid type: array, expected a table"),
    (JSON, "[9.81, 0.1]", "line 1, column 1: invalid type: array, expected a table"),
    ('"mass": 1.0', '"mass": 1.0, "mass": 1.0', "line 2, column 28: duplicate key `mass`"),
    ('"start"', "start", "line 7, column 1: key must be a string"),
    ('{"model": "full"}', '{"model": "full" ψ}', "line 8, column 25, run: expected `,` or `}`"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "text", "old", "new", "message"),
    [("scene.toml", TOML, *row) for row in IN_TOML]
    + [("scene.json", JSON, *row) for row in IN_JSON],
)
def test_a_wrong_scene_file(tmp_path, name, text, old, new, message):
    assert old in text
    path = tmp_path / name
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ValueError) as error:  # noqa: PT011
        sf.load(path)
    assert str(error.value) == f"{path}: {message}"


ROD = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
START = {"q": (0.0, 0.011, 0.002), "qdot": (0.0, 0.0, 0.0)}
SCENE = sf.Scene(ROD, **START)
RUN = SCENE.simulate()
RUNS = sf.simulate_many(ROD, **START)
OPTIONS = (
    "the options of simulate are model, impact, simultaneous, stop, time, time_limit, event_limit,"
    " sensitivity_limit, neighbourhood, edges, jams, record, certify"
)
#: A body that is almost a point mass.
NEEDLE = sf.Posture.rod(half_length=0.5, gyration_radius=1e-9, restitution=0.1)


body = with_defaults(
    sf.Posture,
    mass=1.0,
    gyration_radius=0.2,
    center_of_mass=(0.0, 0.3),
    contacts=[sf.Contact((-0.5, 0.0)), sf.Contact((0.5, 0.0))],
    restitution=0.1,
)


#: A call in Python, the error, and its message.
IN_PYTHON = [
    # Bodies.
    (lambda: body(mass=0), ValueError, "mass = 0.0 is outside its range: finite and > 0, from 1e-150 to 1e150"),
    (lambda: body(mass="1"), TypeError, "mass = '1' cannot be used: a number is needed"),
    (lambda: body(restitution=1.5), ValueError, "restitution = 1.5 is outside its range: 0 <= restitution <= 1: 0, or from 1e-60 on"),
    (lambda: body(restitution=1e-61), ValueError, "restitution = 1e-61 is outside its range: 0 <= restitution <= 1: 0, or from 1e-60 on"),
    (lambda: body(contacts=None), TypeError, "contacts = None cannot be used: a sequence with an entry for each contact is needed"),
    (lambda: body(contacts=[1]), TypeError, "contacts.1 = 1 cannot be used: a Contact is needed"),
    (lambda: body(terrain=[]), ValueError, "terrain = [] cannot be used: None, or a sequence of 2 to 1024 vertices (x, y)"),
    (lambda: body(terrain=[(-1, 0), (1, 0), (0, 0)]), ValueError, "terrain = [pieces 1 and 2 meet] cannot be used: a terrain must not meet itself; piece k goes from vertex k to vertex k + 1"),
    (lambda: body(terrain=[(-2, 0), (2, 0), (2, 1), (0, 1), (0, -1)]), ValueError, "terrain = [pieces 1 and 4 meet] cannot be used: a terrain must not meet itself; piece k goes from vertex k to vertex k + 1"),
    (lambda: body(terrain=[(-2, 0), (2, 0), (2, 0)]), ValueError, "terrain.3 = [2.0, 0.0] twice cannot be used: a vertex must differ from the one before it"),
    (lambda: sf.GroundMotion([0, 1]), ValueError, "acceleration, tilt = none cannot be used: exactly one of them is needed"),
    (lambda: sf.GroundMotion([0, 1], tilt=[0]), ValueError, "ground_motion.tilt = [1 entries] cannot be used: 2 entries, as many as times"),
    (lambda: sf.GroundMotion([0, 0], tilt=[0, 1]), ValueError, "ground_motion.times.2 = 0.0 after 0.0 cannot be used: increasing times"),
    (lambda: sf.GroundMotion([0], [(0, math.inf)]), ValueError, "ground_motion.acceleration.1.y = inf is outside its range: finite, at most 1e150 in size"),
    (lambda: sf.simulate(ROD, (0, 1, 0), (0, 0, 0), kicks=[(1, 2)]), TypeError, "kicks.1 = (1, 2) cannot be used: a Kick is needed"),
    (lambda: sf.simulate(ROD, (0, 1, 0), (0, 0, 0), kicks=None), TypeError, "kicks = None cannot be used: a sequence is needed"),
    (lambda: sf.simulate(ROD, (0, 1, 0), dt=0.01), TypeError, "simulate() got an unexpected keyword argument 'dt'; there is no time step, every event is computed; 'time_limit' ends a run"),
    (lambda: sf.simulate(ROD, (0, 1, 0), t_end=3), TypeError, "simulate() got an unexpected keyword argument 't_end'; did you mean 'time_limit'?"),
    (lambda: sf.simulate(ROD, (0, 1, 0), law="newton"), TypeError, "simulate() got an unexpected keyword argument 'law'; did you mean 'impact'?"),
    (lambda: sf.Contact((0, 0), mu=0.5), TypeError, "Contact() got an unexpected keyword argument 'mu'; did you mean 'friction'?"),
    (lambda: sf.simulate(ROD, (0, 1, 0), impact="Moreau"), ValueError, 'impact = "Moreau" cannot be used: one of `auto`, `newton`, `poisson`, `stronge`, `chatterjee-ruina`, `moreau`; did you mean "moreau"?'),
    (lambda: sf.simulate(ROD, (0, 1, 0), impact="chatterjee_ruina"), ValueError, 'impact = "chatterjee_ruina" cannot be used: one of `auto`, `newton`, `poisson`, `stronge`, `chatterjee-ruina`, `moreau`; did you mean "chatterjee-ruina"?'),
    (lambda: sf.simulate(ROD, (0, 1, 0), forces=[1]), TypeError, "forces.1 = 1 cannot be used: a Force is needed"),
    (lambda: sf.simulate(ROD, (0, 1, 0), (0, 0, 0), ground_motion=[1]), TypeError, "ground_motion = [1] cannot be used: None or a GroundMotion is needed"),
    (lambda: sf.simulate(ROD, (0, 1, 0), (0, 0, 0), kicks=[sf.Kick(-1, (0, 1))]), ValueError, "kicks.1.time = -1.0 is outside its range: finite, not before the start"),
    (lambda: sf.simulate(ROD, (0, 1, 0), (0, 0, 0), kicks=[sf.Kick(1, (0, 1))], certify=True), ValueError, "certify = true cannot be used: false, because the run has kicks, forces or a ground_motion"),
    (lambda: sf.Contact((0, 0), tangential_restitution=1), ValueError, "tangential_restitution = 1.0 is outside its range: 0 <= tangential_restitution < 1"),
    (lambda: sf.Contact((0, 0), slope=30), ValueError, "slope = 30.0 cannot be used: -pi < slope <= pi, in rad; did you mean math.radians(30) = 0.5235987755982988?"),
    (lambda: sf.Contact((0, 0), slope=-100.5), ValueError, "slope = -100.5 cannot be used: -pi < slope <= pi, in rad; did you mean math.radians(-100.5) = -1.7540558982543013?"),
    (lambda: sf.Contact((0, 0), slop=0.1), TypeError, "Contact() got an unexpected keyword argument 'slop'; did you mean 'slope'?"),
    (lambda: body(gravit=1), TypeError, "Posture() got an unexpected keyword argument 'gravit'; did you mean 'gravity'?"),
    (lambda: body(colour=1), TypeError, "Posture() got an unexpected keyword argument 'colour'"),
    (lambda: sf.Posture.rod(0.5, 0.2, 0.1, frictoin=1), TypeError, "Posture.rod() got an unexpected keyword argument 'frictoin'; did you mean 'friction'?"),
    (lambda: sf.Contact((0, 0, 0)), ValueError, "point = (0, 0, 0) cannot be used: 2 numbers are needed, not 3"),
    (lambda: body().local(q=None), TypeError, "q = None cannot be used: 3 numbers are needed"),
    # Runs.
    (lambda: sf.simulate(None, **START), TypeError, "posture = None cannot be used: a Posture or a Mechanism is needed"),
    (lambda: sf.simulate(ROD, (0, -1, 0), (0, 0, 0)), ValueError, "q puts contact 1 into the terrain: its gap -1.0 m is below -5e-13 m; allowed are gaps >= 0; touching(1, theta) of a posture has the q at which this contact touches"),
    (lambda: sf.simulate(body(contacts=[sf.Contact((x, 0)) for x in (0, 1e-10)]), **START), ValueError, "distance between contacts 1 and 2 in body sizes (or between their unit normals) = 3.3333333333333337e-10 is outside its range: 0, which makes them one contact, or at least 1e-6"),
    (lambda: sf.simulate(body(contacts=[sf.Contact((1, 0), friction=x) for x in (0, 1)]), **START), ValueError, "contacts.2.point = [1.0, 0.0] cannot be used: contact 1 is at the same point; place them apart, or give both the same slope, segment, friction and restitution (a corner of the ground needs terrain=)"),
    (lambda: sf.simulate(body(contacts=[sf.Contact((x, 0), friction=2e6) for x in (0, 1)]), **START), ValueError, "contacts.1.friction = 2000000.0 is outside its range: at most 1e6 for motion"),
    (lambda: sf.simulate(ROD, **START, model="ful"), ValueError, 'model = "ful" cannot be used: one of `auto`, `local`, `full`'),
    (lambda: sf.simulate(ROD, **START, event_limit=1e6), TypeError, "event_limit = 1000000.0 cannot be used: an integer from 0 to 18446744073709551615 is needed"),
    (lambda: sf.simulate(ROD, **START, stop="time"), ValueError, 'time_limit = none cannot be used: stop = "time" needs a finite time_limit'),
    (lambda: sf.simulate(ROD, **START, modle="full"), TypeError, "simulate() got an unexpected keyword argument 'modle'; did you mean 'model'?"),
    (lambda: sf.simulate_many(ROD, **START, theads=2), TypeError, "simulate_many() got an unexpected keyword argument 'theads'; did you mean 'threads'?"),
    (lambda: ROD.local().simulate((0, 1), (1, 0), omga=2), TypeError, "LocalModel.simulate() got an unexpected keyword argument 'omga'; did you mean 'omega'?"),
    (lambda: SCENE.simulate(modle="full"), TypeError, f"modle = 'full' cannot be used: {OPTIONS}; did you mean 'model'?"),
    (lambda: sf.Scene(ROD, **START, options=["full"]), TypeError, "options = ['full'] cannot be used: None or a dict is needed"),
    (lambda: RUN.at(math.nan), ValueError, f"t = NaN cannot be used: from 0.0 on: at rest from {RUN.time!r} on"),
    (lambda: RUN.sample(1.5), TypeError, "n = 1.5 cannot be used: an integer from 2 to 10000000 is needed"),
    (lambda: RUNS[1], IndexError, "index = 1 cannot be used: there are 1 runs, from 0"),
    (lambda: RUNS[True], TypeError, "index = True cannot be used: an integer is needed"),
    (lambda: sf.simulate_many(ROD, np.broadcast_to(0.0, (10**12, 3)), (0, 0, 0)), MemoryError, "1000000000000 runs take 512 bytes each"),
    # Functions of postures.
    (lambda: sf.stability(None), TypeError, "posture = None cannot be used: a Posture, a Mechanism or a sequence of them is needed"),
    (lambda: sf.stability(ROD, trial=10), TypeError, "stability() got an unexpected keyword argument 'trial'; did you mean 'trials'?"),
    (lambda: sf.contact_modes(ROD, wrensh=(1, 0, 0)), TypeError, "contact_modes() got an unexpected keyword argument 'wrensh'; did you mean 'wrench'?"),
    (lambda: sf.stability(ROD, trials=-1), ValueError, "trials = -1 cannot be used: an integer from 0 to 100000000 is needed"),
    (lambda: sf.stability(ROD, trials=10**10), ValueError, "trials = 10000000000 cannot be used: an integer from 0 to 100000000 is needed"),
    (lambda: sf.robustness(ROD, [0.1, 0.2], 10**6, over={"mass": np.arange(1, 1000)}), ValueError, "trials = 1000000 cannot be used: at most 1000000000 kicks of all sizes at all points together are allowed"),
    (lambda: sf.sweep(ROD, {"mass": np.arange(1, 10001), "gravity": np.arange(1, 9001)}, ["stability", "by"]), ValueError, "over = a grid of shape [10000, 9000] of 2 quantities cannot be used: at most 100000000 values"),
    (lambda: RUN.film(1), ValueError, "frames = 1 cannot be used: an integer from 2 to 100000 is needed"),
    (lambda: sf.stability(NEEDLE), ValueError, "(distance of contacts.1.point from center_of_mass) / gyration_radius = 499999999.99999994 is outside its range: at most 1e4; forces on longer arms have few correct digits"),
    (lambda: sf.contact_modes(ROD, method="fast"), ValueError, 'method = "fast" cannot be used: one of `auto`, `enumerate`, `qp`'),
    (lambda: sf.theory.clattering_bound(1.5), ValueError, "restitution = 1.5 is outside its range: 0 <= restitution < 1"),
    # Maps.
    (lambda: sf.sweep(ROD, {1: [1]}), TypeError, "over = {1: [1]} cannot be used: values by the path of their parameter are allowed"),
    (lambda: sf.sweep(ROD, {"mass": [1, -1]}), ValueError, "mass = -1.0 is outside its range: finite and > 0, from 1e-150 to 1e150"),
    (lambda: sf.sweep(ROD, {"mass": np.broadcast_to(1.0, 10**9)}), ValueError, "over = a grid of shape [1000000000] cannot be used: at most 100000000 points"),
    (lambda: sf.sweep(ROD, {"mass": np.ma.array([1.0], mask=True)}), TypeError, "mass = masked_array(data=[--], mask=[ True], fill_value=1e+20, dtyp… cannot be used: an array without masked entries is needed"),
    (lambda: sf.sweep(ROD, {"mass": []}), ValueError, "mass = [] cannot be used: at least one value"),
    (lambda: sf.sweep(ROD, {"mass": [1]}, None), TypeError, "quantity = None cannot be used: a name, or a sequence of names, is allowed"),
    (lambda: sf.sweep(ROD, {"mass": [1]}, "zeno_time", **START, certify=True), ValueError, "certify = true cannot be used: false, because a map has no proved bounds"),
    (lambda: sf.sweep(ROD, {"mass": [1]}, tread=3), TypeError, "tread = 3 cannot be used: no keyword of sweep; those of simulate are certify, edges, event_limit, impact, model, neighbourhood, record, sensitivity_limit, simultaneous, stop, time, time_limit; did you mean 'threads'?"),
    (lambda: sf.sweep(ROD, {"mass": [1]}, cache=3), TypeError, "cache = 3 cannot be used: None or a folder is allowed"),
    (lambda: sf.sweep(ROD, {"mass": [1]}, progress="x"), TypeError, "progress = 'x' cannot be used: None, True or False is allowed"),
    (lambda: sf.sweep(ROD, {"mass": [1]}, chunk=0), ValueError, "chunk = 0 cannot be used: None or an integer >= 1 is allowed"),
    # Files.
    (lambda: sf.load("nowhere.toml"), FileNotFoundError, "[Errno 2] No such file or directory: 'nowhere.toml'"),
    (lambda: SCENE.save("nowhere/scene.toml"), FileNotFoundError, "[Errno 2] No such file or directory: 'nowhere/scene.toml'"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("ask", "kind", "message"), IN_PYTHON, ids=[row[2] for row in IN_PYTHON]
)
def test_a_wrong_argument(tmp_path, monkeypatch, ask, kind, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(kind) as error:
        ask()
    assert type(error.value) is kind
    assert str(error.value) == message


#: Arguments of the command, and the message after its name. `rod.toml` and a folder `folder.json` exist.
ON_THE_LINE = [
    ("walk", 'Unknown command "walk". Available commands: run, animate, explore, modes, stability, check, robustness, map, ...'),
    ("run", "run needs a scene file, TOML or JSON, such as examples/stairs.toml; standfast run --help says more"),
    ("run rod.toml --colour", "Unknown option: --colour."),
    ("run rod.toml rod.toml", "too many arguments: rod.toml"),
    ("run nowhere.toml", "nowhere.toml: No such file or directory"),
    ("run rod.toml --json", 'Command "run" parameter --json requires an argument.'),
    ("run rod.toml --json --plot rod.png", "Invalid value for --json: --plot is an option; a path is needed, or -"),
    ("run rod.toml --json ''", "Invalid value for --json: the path is empty"),
    ("run rod.toml --json folder.json", "--json folder.json: is a directory"),
    ("run rod.toml --json rod.toml", "--json rod.toml: is the scene file"),
    ("run rod.toml --plot rod.jpg", "--plot rod.jpg: the name must end in .png, .pdf, .svg"),
    ("stability rod.toml --trials many", "Invalid value for --trials: 'many' is not an integer >= 0"),
    ("modes rod.toml --json folder.json", "--json folder.json: is a directory"),
    ("map rod.toml --over mass=1:2:3 --netcdf folder.json", "--netcdf folder.json: is a directory"),
    ("map rod.toml --over mass=1:2:3 --netcdf rod.toml", "--netcdf rod.toml: is the scene file"),
    ("map rod.toml --over mass=1:2:3 --netcdf nowhere/map.nc", "--netcdf nowhere/map.nc: nowhere is not a directory"),
    ("--install-completion --shell tcsh", f'Invalid value "tcsh" for --shell. Choose from: {SHELLS}.'),
    ("map rod.toml", "map needs --over PATH=LOW:HIGH:COUNT, such as --over center_of_mass.x=-1:1:200; standfast map --help says more"),
    ("map rod.toml --over mass=1:2", "--over mass=1:2: PATH=LOW:HIGH:COUNT is needed, such as center_of_mass.x=-1:1:200"),
    ("map rod.toml --over mass=1e308:-1e308:3", "--over mass=1e308:-1e308:3: PATH=LOW:HIGH:COUNT is needed, such as center_of_mass.x=-1:1:200"),
    ("map rod.toml --over mass=-1:1:3", "--over mass=-1:1:3: mass = -1.0 is outside its range: finite and > 0, from 1e-150 to 1e150"),
    ("map rod.toml --over mass=1:2:3 --over mass=1:2:3", "--over mass=1:2:3: mass is given twice"),
    ("map rod.toml --over mass=1:2:99999999", "--over mass=1:2:99999999: at most 10000000 values"),
]  # fmt: skip


@pytest.mark.parametrize(("line", "message"), ON_THE_LINE)
def test_a_wrong_command_line(tmp_path, monkeypatch, capsys, line, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.toml").write_text(TOML, encoding="utf-8")
    (tmp_path / "folder.json").mkdir()
    assert main(shlex.split(line)) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", f"standfast: {message}\n")


def test_a_name_of_another_kind_of_file_is_read_as_toml(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(TOML.replace("mass = 1.0", "mass = 0.0"), encoding="utf-8")
    with pytest.raises(
        ValueError, match=r"scene\.yaml: read as TOML, line 4, column 8:"
    ):
        sf.load(path)
    path.write_text(TOML, encoding="utf-8")
    assert sf.load(path).posture == ROD


def other_files(folder):
    """Files that are no scenes, with their kinds."""
    run, verdict, modes, schema, picture, data = (
        folder / name for name in ("run.json", "v.json", "m", "s.json", "p.png", "m.nc")
    )
    RUN.to_json(run)
    sf.stability(ROD).to_json(verdict)
    sf.contact_modes(ROD).to_json(modes)
    schema.write_text(sf.schema(), encoding="utf-8")
    RUN.plot(picture)
    sf.sweep(ROD, {"mass": [1, 2]}).to_netcdf(data)
    return {
        run: "the result of a run (JSON)",
        verdict: "a verdict on stability (JSON)",
        modes: "a table of contact modes (JSON)",
        schema: "the JSON Schema of scene files",
        picture: "a picture",
        data: "a NetCDF file (such as a map)",
    }


def test_a_file_of_another_kind_is_named(tmp_path):
    for path, kind in other_files(tmp_path).items():
        with pytest.raises(ValueError, match=r"not a scene") as error:
            sf.load(path)
        assert str(error.value) == f"{path}: is {kind}, not a scene file"
    svg, large = tmp_path / "run.svg", tmp_path / "large.json"
    RUN.plot(svg)
    with pytest.raises(ValueError, match="is a picture, not a scene file"):
        sf.load(svg)
    # A result that is larger than any scene file.
    large.write_text((tmp_path / "run.json").read_text() + " " * 2**20)
    with pytest.raises(ValueError, match="is the result of a run"):
        sf.load(large)


def test_what_an_encoding_lacks_is_no_reason_to_lose_an_answer(tmp_path):
    path = tmp_path / "stäbe_ψ.toml"
    path.write_text(TOML, encoding="utf-8")
    for arguments in (["run", path], ["map", path, "--over", "gravity=1:2:3"]):
        done = subprocess.run(
            [sys.executable, "-m", "standfast.cli", *arguments],
            env={**os.environ, "PYTHONIOENCODING": "cp1252"},
            capture_output=True,
            timeout=60,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, b"")
        assert done.stdout.decode("cp1252").startswith("stäbe_?.toml")

"""The rooms of the core: a module uses only modules above it in `lib.rs`, and a type has its methods in the room where it is
defined."""

import re
from pathlib import Path

CORE = Path(__file__).parents[2] / "crates" / "core" / "src"

Sources = dict[str, str]


def sources(unit_tests: bool = False) -> Sources:
    """The text of each file, by path, without comments and, unless they are asked for, without unit tests."""
    texts = {}
    for path in CORE.rglob("*.rs"):
        text = re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
        if not unit_tests:
            text = re.sub(
                r"#\[cfg\(test\)\]\s*(?:pub\(crate\) )?mod tests \{.*",
                "",
                text,
                flags=re.DOTALL,
            )
        texts[path.relative_to(CORE).as_posix()] = text
    return texts


def room(file: str) -> str:
    return file.split("/")[0].removesuffix(".rs")


def rooms(texts: Sources) -> list[str]:
    return re.findall(r"^(?:pub )?mod (\w+);", texts["lib.rs"], flags=re.MULTILINE)


def upward_imports(texts: Sources) -> list[str]:
    """Uses of a room that `lib.rs` declares later, or of names that `lib.rs` exports."""
    order = rooms(texts)
    found = []
    for file, text in texts.items():
        if file == "lib.rs":
            continue
        known = order[: order.index(room(file)) + 1]
        used = re.findall(r"\bcrate::(\w+)", text)
        for group in re.findall(r"\bcrate::\{([^;]*)\};", text):
            used += re.findall(r"(?:^|,)\s*(\w+)", group)
        found += [f"{file} uses {name}" for name in used if name not in known]
        # `super` refers to the same room.
        depth = file.removesuffix("/mod.rs").count("/") + bool(
            re.search(r"\bmod \w+ \{", text)
        )
        paths = re.findall(r"(?:super::)+", text)
        found += [f"{file} leaves its room" for p in paths if p.count("super") > depth]
    return found


def methods_away_from_their_type(texts: Sources) -> list[str]:
    homes: dict[str, set[str]] = {}
    for file, text in texts.items():
        for name in re.findall(r"\b(?:struct|enum|trait|type) (\w+)", text):
            homes.setdefault(name, set()).add(room(file))
    found = []
    block = re.compile(
        r"^impl(?:<[^{]*?>)? (?:(?:\w+::)*(\w+)(?:<[^{]*?>)? for )?&?(?:\w+::)*(\w+)",
        flags=re.MULTILINE,
    )
    for file, text in texts.items():
        for trait, name in block.findall(text):
            home = homes.get(name, {room(file)}) | homes.get(trait, set())
            if room(file) not in home:
                found.append(f"{file}: impl {name}")
    return found


def test_knowledge_goes_down_only():
    assert upward_imports(sources()) == []


def test_unit_tests_use_their_room_and_those_above_it_in_the_list_only():
    assert upward_imports(sources(unit_tests=True)) == []


def binding() -> Sources:
    folder = CORE.parents[1] / "py" / "src"
    return {
        path.stem: re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
        for path in folder.glob("*.rs")
    }


def python() -> Sources:
    """The text of each module; a folder is one module."""
    folder = CORE.parents[2] / "python" / "standfast"
    texts = {path.stem: path.read_text(encoding="utf-8") for path in folder.glob("*.py")}  # fmt: skip
    for path in sorted(folder.glob("*/*.py")):
        texts.setdefault(path.parent.name, "")
        texts[path.parent.name] += path.read_text(encoding="utf-8")
    return texts


def circles(uses: dict[str, set[str]]) -> list[str]:
    """Files that use one another, directly or through others."""
    reached = {file: set(used) for file, used in uses.items()}
    for through in uses:
        for known in reached.values():
            if through in known:
                known |= reached[through]
    return sorted(file for file, known in reached.items() if file in known)


def used_in_binding(texts: Sources) -> dict[str, set[str]]:
    """The files that each file of the binding uses; `lib` is the list of what Python sees and uses all."""
    return {
        file: set(re.findall(r"\bcrate::(\w+)", text)) & set(texts)
        for file, text in texts.items()
    }


def used_in_python(texts: Sources) -> dict[str, set[str]]:
    """The modules that each module imports, anywhere in it; the package itself is `__init__`."""
    uses: dict[str, set[str]] = {}
    for file, text in texts.items():
        found = re.findall(r"^\s*from (?:standfast)?\.(\w+) import", text, flags=re.M)
        found += re.findall(r"^\s*import standfast\.(\w+)", text, flags=re.M)
        for names in re.findall(
            r"^\s*from standfast import ([\w, ]+)$", text, flags=re.M
        ):
            parts = [name.split(" as ")[0].strip() for name in names.split(",")]
            found += [
                part if part in {*texts, "_core"} else "__init__" for part in parts
            ]
        if re.search(r"^\s*import standfast(?: as \w+)?$", text, flags=re.M):
            found.append("__init__")
        uses[file] = set(found) & set(texts)
    return uses


def used_in_core(texts: Sources) -> dict[str, set[str]]:
    """The files of its own room that each file of the core imports by name."""
    uses = {}
    for file, text in texts.items():
        home, _, _ = file.rpartition("/")
        path = "::".join(["crate", *home.split("/")]) if home else "crate"
        names = re.findall(rf"\b(?:{path}|super)::(\w+)::", text)
        own = {f"{home}/{name}.rs" if home else f"{name}.rs" for name in names}
        uses[file] = own & set(texts)
    return uses


def test_no_files_of_a_room_of_the_core_use_one_another():
    assert circles(used_in_core(sources())) == []


def test_no_files_of_the_binding_or_of_the_package_use_one_another():
    assert circles(used_in_binding(binding())) == []
    assert circles(used_in_python(python())) == []


def test_the_checker_of_certificates_uses_nothing_else():
    assert used_in_python(python())["certificate"] == set()


def test_a_circle_is_found():
    texts = python()
    texts["units"] += "\nfrom standfast.maps import sweep\n"
    assert {"units", "maps"} <= set(circles(used_in_python(texts)))
    texts = sources()
    texts["motion/record.rs"] += "use crate::motion::driver::Driver;"
    found = circles(used_in_core(texts))
    assert {"motion/record.rs", "motion/driver.rs"} <= set(found)
    texts = binding()
    texts["convert"] += "\nuse crate::run::PyRun;\n"
    assert {"convert", "run"} <= set(circles(used_in_binding(texts)))


def test_an_upward_import_is_found():
    texts = sources()
    for planted in (
        "use crate::motion::record::Record;",
        "use crate::{error, simulate};",
        "use super::motion;",
        "fn f() { crate::simulate(); }",
        "use crate::Outcome;",
    ):
        wrong = texts | {"flight.rs": texts["flight.rs"] + planted}
        assert len(upward_imports(wrong)) == 1, planted


def test_every_file_is_in_a_room():
    texts = sources()
    assert {room(file) for file in texts} - {"lib"} == set(rooms(texts))


def test_methods_are_in_the_room_of_their_type():
    assert methods_away_from_their_type(sources()) == []


def test_methods_elsewhere_are_found():
    texts = sources()
    wrong = texts | {"flight.rs": texts["flight.rs"] + "\nimpl Posture {\n}\n"}
    more = methods_away_from_their_type(wrong)
    assert more == [*methods_away_from_their_type(texts), "flight.rs: impl Posture"]


# Ranges of input, numbers justified where they are defined, units, and parameters that only change the cost of a search.
NOT_TOLERANCES = {
    "collisions/log.rs": {"1e-3"},
    "enclosure/full.rs": {"1e-35"},
    "error.rs": {"1e-60"},
    "impact/newton.rs": {"1e-150"},
    "math/turn.rs": {"2.449_293_598_294_706_4e-16", "5.989_539_619_436_679e-33"},
    "options.rs": {"1e-12"},
    "simulate/limits.rs": {"1e-6"},
    "stability/cells.rs": {"1e-4"},
    "stability/certify.rs": {"1e-10", "1e-8", "1e-6"},
    "stability/corner.rs": {"1e-4"},
    "stability/mod.rs": {"1e-12"},
    "stability/reduced.rs": {"1e-12"},
    "stability/trap.rs": {"1e-7", "1e-3"},
    "stability/trials.rs": {"1e-3"},
    "sustained/step.rs": {"1e-100"},
}


def bare_tolerances(texts: Sources) -> list[str]:
    found = []
    for file, text in texts.items():
        code = re.sub(r'"(?:[^"\\]|\\.)*"', "", text)
        numbers = re.findall(r"\b[\d_]+(?:\.[\d_]+)?e-\d+", code)
        known = NOT_TOLERANCES.get(file, set())
        if file != "tolerance.rs":
            found += [f"{file}: {number}" for number in numbers if number not in known]
    return found


def test_tolerances_are_in_one_file():
    assert bare_tolerances(sources()) == []


def test_a_bare_tolerance_is_found():
    texts = sources()
    texts["flight.rs"] += "fn f(x: f64) -> bool { x < 1e-9 }"
    assert bare_tolerances(texts) == ["flight.rs: 1e-9"]


def test_each_tolerance_has_a_range():
    text = (CORE / "tolerance.rs").read_text(encoding="utf-8")
    blocks = re.findall(r"((?:///[^\n]*\n)+)pub(?:\(crate\))? const (\w+)", text)
    assert len(blocks) > 80
    assert [name for doc, name in blocks if "Range:" not in doc] == []


FUNCTION = r"((?:^///.*\n)+)((?:^#\[.*\n)*)^pub (?:const )?fn (\w+)"


def functions_without_example(texts: Sources) -> list[str]:
    """Public functions whose documentation neither has an example with an assertion nor begins with "As" and the function it varies."""
    found = []
    for file, text in texts.items():
        for doc, attributes, name in re.findall(FUNCTION, text, flags=re.MULTILINE):
            doc = re.sub(r"^/// ?", "", doc, flags=re.MULTILINE)
            examples = re.findall(
                r"^```\n(.*?)^```$", doc, flags=re.DOTALL | re.MULTILINE
            )
            shown = any(
                re.search(r"^ *assert", code, re.MULTILINE) for code in examples
            )
            if not (shown or doc.startswith("As [`") or "doc(hidden)" in attributes):
                found.append(f"{file}: {name}")
    return found


def commented_sources() -> Sources:
    """The text of each file, by path."""
    return {
        path.relative_to(CORE).as_posix(): path.read_text(encoding="utf-8")
        for path in CORE.rglob("*.rs")
    }


def test_each_public_function_has_an_example():
    texts = commented_sources()
    for text in texts.values():
        every = re.findall(r"^pub (?:const )?fn \w+", text, flags=re.MULTILINE)
        assert len(re.findall(FUNCTION, text, flags=re.MULTILINE)) == len(every)
    assert functions_without_example(texts) == []


def test_a_function_without_example_is_found():
    for doc in ("/// It.\n", "/// It.\n/// ```\n/// f();\n/// ```\n"):
        texts = {"flight.rs": f"{doc}#[must_use]\npub fn f() {{}}\n"}
        assert functions_without_example(texts) == ["flight.rs: f"]

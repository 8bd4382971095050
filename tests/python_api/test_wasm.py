"""The engine as WebAssembly gives the answers of the one that Python calls, to the last byte. `make explorer` builds it."""

import json
import shutil
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import bits
import pytest
import standfast as sf
from standfast import page

ROOT = Path(__file__).parents[2]
CRATE = ROOT / "crates" / "wasm"
MODULE = ROOT / "target" / "explorer" / "standfast.wasm"
NODE = shutil.which("node")
RANDOM = 360

built = pytest.mark.skipif(
    NODE is None or not MODULE.exists(),
    reason="node is not installed" if NODE is None else "needs make explorer",
)

#: The answers to a list of questions.
RUNNER = """
const { readFileSync } = require("node:fs");
const [source, moduleFile] = process.argv.slice(1);
const engine = new Function(`${source}; return engine;`)();
const module = new WebAssembly.Module(readFileSync(moduleFile));
if (WebAssembly.Module.imports(module).length) throw new Error("the module has imports");
const ask = engine(module);
const questions = JSON.parse(readFileSync(0, "utf8"));
process.stdout.write(JSON.stringify(questions.map((question) => ask(question))));
"""


def in_node(questions: list[str]) -> list[str]:
    """The answers of WebAssembly."""
    done = subprocess.run(
        [NODE, "-e", RUNNER, page.script(("engine.js",)), MODULE],
        input=json.dumps(questions),
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def differences(questions: list[str]) -> list[str]:
    """The questions whose answers are not the same bytes. After a change of the core: is the module that of this core?"""
    pairs = zip(questions, in_node(questions), strict=True)
    return [question for question, answer in pairs if answer != sf.ask(question)]


def question(ask: str, scene: object, **more: object) -> str:
    return json.dumps({"ask": ask, "scene": scene} | more)


def drawn(k: int) -> dict:
    """A random scene, in the form of a file: the models, laws and grounds in turn, on 1 to 6 contacts."""
    draw = bits.Draw(5, k)
    model, law = bits.MODELS[k % 3], bits.LAWS[k // 3 % 5]
    body = bits.posture(draw, 1 + k // 15 % 6, bits.GROUNDS[k // 90 % 4])
    q, qdot = bits.state(draw, body)
    options = {"model": model, "impact": law, "event_limit": 1000, "time_limit": 2.0}
    return json.loads(sf.Scene(body, q, qdot, options).to_json())


def of_examples() -> Iterator[str]:
    for path in sorted((ROOT / "examples").glob("*.toml")):
        text = path.read_text(encoding="utf-8")
        for ask in ["scene", "posture", "motion"]:
            yield question(ask, text)


def maps() -> Iterator[str]:
    rod = (ROOT / "examples" / "clattering_rod.toml").read_text(encoding="utf-8")
    over = [
        {"path": "center_of_mass.x", "values": [k / 16 for k in range(-16, 17)]},
        {"path": "friction", "values": [k / 8 for k in range(9)]},
    ]
    names = ["stability", "by", "equilibrium_margin", "fate", "zeno_time"]
    for name in names:
        yield question("map", rod, over=over, quantity=[name])


def packages(folder: Path) -> set[tuple[str, str]]:
    text = (folder / "Cargo.lock").read_text(encoding="utf-8")
    found = tomllib.loads(text)["package"]
    return {(x["name"], x["version"]) for x in found if "source" in x}


def test_it_is_built_from_the_packages_of_the_core():
    """The two have a list each."""
    assert len(packages(CRATE)) > 20
    assert packages(CRATE) <= packages(ROOT)


@built
def test_the_examples_have_the_same_answers():
    questions = list(of_examples())
    assert len(questions) >= 18
    assert differences(questions) == []


@built
def test_maps_have_the_same_answers():
    questions = list(maps())
    answers = [json.loads(sf.ask(question)) for question in questions]
    assert [answer for answer in answers if "error" in answer] == []
    assert differences(questions) == []


@built
def test_random_scenes_have_the_same_answers():
    scenes = [drawn(k) for k in range(RANDOM)]
    questions = [question("motion", scene, frames=50) for scene in scenes]
    moved = sum("error" not in json.loads(sf.ask(asked)) for asked in questions)
    # The others are refused: a model or a law of impact is not for every body.
    assert moved > RANDOM / 3
    questions += [question("posture", scene) for scene in scenes]
    assert differences(questions) == []


@built
def test_a_wrong_question_has_the_same_answer():
    questions = ["", "{}", '"μ', question("motion", 1), question("no", "μ")]
    assert differences(questions) == []


@built
def test_the_largest_answer_comes_through():
    """The memory of the module grows more than once."""
    rod = (ROOT / "examples" / "clattering_rod.toml").read_text(encoding="utf-8")
    questions = [question("motion", rod, frames=100_000)]
    assert len(sf.ask(questions[0])) > 10_000_000
    assert differences(questions * 2) == []

"""What a notebook shows: tables with the numbers of `print`, pictures to scale, the player and the explorer."""

import ast
import contextlib
import html
import json
import math
import re
import shutil
import sys
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import standfast as sf
from standfast.notebook import ROWS
from standfast.page import data, film_page
from standfast.report import account, decimal
from standfast.widget import Widget

TOUR = Path(__file__).parents[2] / "examples" / "tour.ipynb"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
SVG = "{http://www.w3.org/2000/svg}"
VOID = {"br", "hr", "img", "input", "link", "meta"}

CRATE = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)
ROD = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
BALL = sf.Posture(1, 0.4, (0.0, 0.2), [sf.Contact((0, 0))], restitution=0.5)
VALLEY = sf.Posture(
    2.5,
    0.3,
    (0.1, 0.4),
    [sf.Contact((-0.5, 0.25), friction=0.3, restitution=0.2), sf.Contact((0.5, 0.25))],
    restitution=0.1,
    terrain=[(-1.0, 0.5), (0.0, 0.0), (1.0, 0.5)],
)


def rocking(**options) -> sf.Run:
    q = CRATE.touching(contact=1, theta=0.2)
    return sf.simulate(CRATE, q, (0, 0, 0), impact="moreau", **options)


def clattering() -> sf.Run:
    return sf.simulate(ROD, (0.0, 0.011, 0.002), (0.1, 0.0, 0.0), model="local")


def toppling() -> sf.System:
    blocks = {"low": sf.Block(1, 0.5), "high": sf.Block(1, 0.5, at=(0.6, 0.5))}
    return sf.System(blocks, friction=0.6)


def pushed() -> sf.results.LoadFactor:
    factor = sf.load_factor(sf.System([sf.Block(2, 1)]), acceleration=(9.81, 0))
    assert factor is not None
    return factor


SHOWN = {
    "posture": lambda: CRATE,
    "posture of a ball": lambda: BALL,
    "posture in a valley": lambda: VALLEY,
    "run": rocking,
    "run of the local model": clattering,
    "run without record": lambda: rocking(record=False),
    "run without a body": lambda: ROD.local().simulate((0.01, 0.02), (0.0, 0.0)),
    "verdict": lambda: sf.stability(VALLEY),
    "modes": lambda: sf.contact_modes(CRATE),
    "system": toppling,
    "mode of a system": lambda: sf.onset(toppling()),
    "mode that holds": lambda: sf.onset(sf.System([sf.Block(1, 1)])),
    "load factor": pushed,
}


class Nesting(HTMLParser):
    """Fails where a tag is not closed in order; collects the cells of tables and the preformatted texts."""

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.cells: list[str] = []
        self.texts: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        if tag in ("td", "th", "pre"):
            (self.texts if tag == "pre" else self.cells).append("")

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        for tag, found in (("pre", self.texts), ("td", self.cells), ("th", self.cells)):
            if tag in self.open:
                found[-1] += data


def picture(shown: str) -> ET.Element:
    return ET.fromstring(re.search(r"<svg.*?</svg>", shown, re.DOTALL)[0])


@pytest.mark.parametrize("kind", SHOWN)
def test_the_html_is_well_formed(kind):
    shown = SHOWN[kind]()._repr_html_()
    Nesting(shown)
    assert ("<svg" in shown) == (kind not in ("modes", "run without a body"))
    if "<svg" in shown:
        assert picture(shown).tag == f"{SVG}svg"
        assert "nan" not in shown.split("</svg>")[0]


@pytest.mark.parametrize(
    "kind", ["verdict", "modes", "mode of a system", "mode that holds"]
)
def test_a_table_is_that_of_print(kind):
    value = SHOWN[kind]()
    shown = value._repr_html_()
    assert Nesting(shown).texts == [str(value)]
    assert ("a_n &gt; 0" in shown) == (kind in ("verdict", "modes"))


def test_a_posture_has_its_data_with_units():
    cells = Nesting(VALLEY._repr_html_()).cells
    for text in ("2.5 kg", "0.3 m", "(0.1, 0.4) m", "9.81 m/s²"):
        assert text in cells
    first, second = cells.index("1"), cells.index("2")
    slope = math.atan(0.5)
    assert cells[first : first + 5] == [
        "1",
        "(-0.5, 0.25)",
        f"{-slope:g}",
        "0.3",
        "0.2",
    ]
    assert cells[second:] == ["2", "(0.5, 0.25)", f"{slope:g}", "0", "0.1"]


def test_a_run_has_its_outcome_zeno_points_and_phases_and_its_report():
    run = rocking()
    found = Nesting(run._repr_html_())
    assert found.texts == [account(run, "run")]
    assert f"rest at {decimal(run.time)} s" in found.cells
    zeno, phases = run.zeno_points, run.phases
    for time in [z.time for z in zeno[:ROWS]] + [p.end for p in phases[:ROWS]]:
        assert decimal(time) in found.cells
    assert [c for c in found.cells if re.fullmatch("[SFRL]{4}", c)] == [
        phase.mode for phase in phases[:ROWS]
    ]
    assert [c for c in found.cells if c.endswith(" more")] == [
        f"and {len(found) - ROWS} more" for found in (zeno, phases) if len(found) > ROWS
    ]


@pytest.mark.parametrize("simulated", [rocking, clattering])
def test_the_picture_of_a_run_is_to_scale(simulated):
    run = simulated()
    drawn = [
        [float(circle.get("cx")), -float(circle.get("cy"))]
        for circle in picture(run._repr_html_()).iter(f"{SVG}circle")
    ]
    center = np.array(run.posture.center_of_mass) + run.q[:2]
    world = np.vstack([run.points_at(run.time), center])
    # One scale and one shift map the world to the picture, within the tenth of a pixel to which it is written.
    spread = [np.array(p) - np.mean(p, axis=0) for p in (drawn, world)]
    scale = np.linalg.norm(spread[0]) / np.linalg.norm(spread[1])
    np.testing.assert_allclose(spread[0], scale * spread[1], atol=0.1)


def test_a_system_has_its_bodies_and_its_contacts_to_scale():
    system = toppling()
    shown = system._repr_html_()
    cells = Nesting(shown).cells
    assert cells[cells.index("high") :] == ["high", "0.5", "(0.6, 0.75)"]
    circles = [*picture(shown).iter(f"{SVG}circle")]
    drawn = np.array([(float(c.get("cx")), -float(c.get("cy"))) for c in circles])
    world = np.array([contact.point for contact in system.contacts])
    spread = [p - p.mean(axis=0) for p in (drawn, world)]
    scale = np.linalg.norm(spread[0]) / np.linalg.norm(spread[1])
    np.testing.assert_allclose(spread[0], scale * spread[1], atol=0.1)


def test_a_load_factor_says_what_forces_hold_and_what_moves():
    factor = pushed()
    found = Nesting(factor._repr_html_())
    assert f"forces hold up to {factor.static:.4g} times the load" in found.cells
    assert factor.complete
    assert f"moves from {factor.moves:.4g} times the load on" in found.cells
    assert found.texts == [str(factor.mode)]


def test_the_player_holds_the_film():
    run = rocking()
    shown = run.show(height=500, clock="zeno")._repr_html_()
    frame = re.fullmatch(
        r'<iframe srcdoc="([^"]*)" [^<>]*height="500"[^<>]*></iframe>', shown
    )
    page = html.unescape(frame[1])
    assert data(run.film()) in page
    assert page == film_page(
        run, f"Player of a run: rest at {run.time} s", None, "zeno"
    )
    assert repr(run.show()) == f"<Player of a run: rest at {run.time} s>"
    # A frame has no access to the notebook.
    assert 'sandbox="allow-scripts"' in shown


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"height": 50},
            "height = 50 cannot be used: an integer from 100 to 10000 is needed",
        ),
        ({"clock": "slow"}, "clock"),
        ({"speed": 0.0}, "speed"),
    ],
)
def test_a_wrong_argument_of_show_is_named(options, message):
    with pytest.raises(ValueError, match=message):
        rocking().show(**options)


def question(scene: sf.Scene) -> str:
    return json.dumps({"ask": "posture", "scene": json.loads(scene.to_json())})


def test_the_widget_answers_as_ask_does(monkeypatch):
    widget = sf.explore(CRATE)
    sent = []
    monkeypatch.setattr(widget, "send", sent.append)
    asked = [question(widget.scene), "{}"]
    for number, text in enumerate(asked):
        widget._handle_custom_msg({"id": number, "question": text}, [])
    assert sent == [{"id": k, "answer": sf.ask(q)} for k, q in enumerate(asked)]


@pytest.mark.parametrize(
    "posture", [CRATE, BALL, VALLEY], ids=["crate", "ball", "valley"]
)
def test_the_widget_has_its_posture_and_takes_another(posture):
    widget = sf.explore(posture)
    assert widget.posture == posture
    scene = sf.Scene(
        ROD, (0, 0.1, 0), (0, 0, 1.0), {"impact": "moreau"}, [sf.Kick(0.1, (1, 0))]
    )
    widget.scene = scene
    assert widget.scene == scene
    assert widget.posture == ROD
    widget.posture = posture
    assert widget.scene == sf.Scene(posture, (0, 0, 0), (0, 0, 0))
    # All of it is JSON for a browser, which has no infinity.
    json.dumps(widget.get_state(), allow_nan=False, default=str)


def test_explore_without_a_scene_has_none_until_the_page_has_chosen():
    with pytest.raises(ValueError, match="the cell has not been shown yet"):
        _ = sf.explore().scene


def test_explore_refuses_anything_else():
    with pytest.raises(
        TypeError, match="scene = 3 cannot be used: a Posture or a Scene"
    ):
        sf.explore(3)


def test_explore_without_anywidget_says_what_to_install(monkeypatch):
    monkeypatch.delitem(sys.modules, "standfast.widget")
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(
        ImportError,
        match=r"explore needs anywidget: pip install anywidget",
    ):
        sf.explore(CRATE)


def outputs() -> list[tuple[str, str, object]]:
    """Runs the tour: the text of each cell, its kind, and the value of its last expression."""
    names: dict[str, object] = {}
    found = []
    for cell in json.loads(TOUR.read_text(encoding="utf-8"))["cells"]:
        source = "".join(cell["source"])
        value = None
        if cell["cell_type"] == "code":
            tree = ast.parse(source)
            last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
            exec(compile(tree, TOUR.name, "exec"), names)
            if last is not None:
                value = eval(
                    compile(ast.Expression(last.value), TOUR.name, "eval"), names
                )
        found.append((source, cell["cell_type"], value))
    return found


def test_every_cell_of_the_tour_shows_something():
    shown = [value for _, kind, value in outputs() if kind == "code"]
    assert [type(value).__name__ for value in shown] == [
        "Posture",
        "Verdict",
        "Modes",
        "Run",
        "Player",
        "Widget",
        "Posture",
    ]
    for value in shown:
        assert isinstance(value, Widget) or value._repr_html_()
    assert shown[3].outcome == "rest"


def test_the_tour_is_stored_with_its_outputs():
    """As they are now: otherwise `make tour`. The cell with the tag `live` needs a kernel; it has none."""
    assert TOUR.stat().st_size < 1.5e6
    cells = json.loads(TOUR.read_text(encoding="utf-8"))["cells"]
    for cell, (_, kind, value) in zip(cells, outputs(), strict=True):
        if kind != "code":
            continue
        if cell["metadata"].get("tags") == ["live"]:
            assert isinstance(value, Widget)
            assert cell["outputs"] == []
            continue
        (output,) = cell["outputs"]
        assert output["output_type"] == "execute_result"
        assert "".join(output["data"]["text/plain"]) == repr(value)
        assert "<" in output["data"]["text/html"][0]


#: Renders the widget as a notebook does, with a model whose messages the page's function `kernel` answers.
CELL = """async ({ esm, css, state, dark }) => {
  document.head.appendChild(document.createElement("style")).textContent = css;
  document.body.dataset.jpThemeLight = String(!dark);
  const listeners = {};
  const fire = (name, ...rest) => (listeners[name] ?? []).forEach((heard) => heard(...rest));
  window.model = {
    get: (name) => state[name],
    set: (name, value) => {
      if (JSON.stringify(value) === JSON.stringify(state[name])) return;
      state[name] = value;
      fire(`change:${name}`);
    },
    save_changes: () => { window.saved = JSON.parse(JSON.stringify(state)); },
    on: (name, heard) => { (listeners[name] ??= []).push(heard); },
    off: (name, heard) => { listeners[name] = (listeners[name] ?? []).filter((other) => other !== heard); },
    send: async (content) => fire("msg:custom", JSON.parse(await window.kernel(JSON.stringify(content)))),
  };
  const module = await import(URL.createObjectURL(new Blob([esm], { type: "text/javascript" })));
  window.show = () => module.default.render({ model: window.model, el: document.body.appendChild(document.createElement("div")) });
  window.end = window.show();
}"""


@contextlib.contextmanager
def shown_in_browser(widget: Widget, dark: bool = False):
    """The page that shows the widget, and all that it complains of."""
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    if CHROMIUM is None:
        pytest.skip("needs chromium")
    with playwright.sync_playwright() as engine:
        browser = engine.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        try:
            page = browser.new_page(viewport={"width": 1100, "height": 900})
            complaints: list[str] = []
            page.on(
                "console",
                lambda m: complaints.append(m.text) if m.type == "error" else None,
            )
            page.on("pageerror", lambda error: complaints.append(str(error)))

            def kernel(content: str) -> str:
                answers = []
                widget.send = answers.append
                widget._handle_custom_msg(json.loads(content), [])
                return json.dumps(answers[0])

            page.expose_function("kernel", kernel)
            page.set_content("<!DOCTYPE html><title>cell</title>")
            page.evaluate(
                CELL,
                {
                    "esm": widget._esm,
                    "css": widget._css,
                    "state": {"_scene": widget._scene},
                    "dark": dark,
                },
            )
            yield page, complaints
        finally:
            browser.close()


@pytest.mark.xdist_group("browser")
def test_the_cell_shows_the_scene_and_gives_back_what_was_changed():
    widget = sf.explore(CRATE)
    with shown_in_browser(widget) as (page, complaints):
        verdict = page.locator(".sf-verdict h2")
        page.wait_for_function("document.querySelector('.sf-verdict h2')")
        assert sf.stability(CRATE).frictional_stability in verdict.inner_text().lower()
        # The scene comes back as the widget takes it.
        page.wait_for_function("window.saved?._scene")
        widget._scene = page.evaluate("window.saved._scene")
        assert widget.posture == CRATE
        # A slider changes the scene of the widget, and the widget that of the page.
        slider = page.get_by_role("slider", name="friction μ, all contacts")
        slider.fill("0.25")
        page.wait_for_function(
            "window.saved._scene.contact.every((c) => c.friction === 0.25)"
        )
        widget._scene = page.evaluate("window.saved._scene")
        assert [contact.friction for contact in widget.posture.contacts] == [0.25] * 4
        widget.posture = VALLEY
        page.evaluate("(scene) => window.model.set('_scene', scene)", widget._scene)
        page.wait_for_function("document.querySelectorAll('[data-handle]').length >= 6")
        page.wait_for_function("document.querySelector('.sf-error').hidden")
        page.evaluate("window.end()")
        assert complaints == []


@pytest.mark.xdist_group("browser")
def test_two_cells_of_one_widget_show_the_same_and_take_no_answers_of_each_other():
    widget = sf.explore(CRATE)
    asked = []
    widget.on_msg(lambda widget, content, buffers: asked.append(content["id"]))
    with shown_in_browser(widget) as (page, complaints):
        page.evaluate("() => { window.show(); }")
        both = "[...document.querySelectorAll('.sf-verdict')].filter((v) => v.dataset.state === '{}').length === 2"
        page.wait_for_function(both.format("stable"))
        page.get_by_role("slider", name="friction μ, all contacts").first.fill("0")
        page.wait_for_function(both.format("unstable"))
        assert complaints == []
    assert len(set(asked)) == len(asked) > 4

"""The pages in a real browser: the player of a film, and the explorer with its server. Needs Chromium and playwright; without them the tests
are skipped by name."""

import json
import math
import shutil
import threading
from contextlib import contextmanager
from pathlib import Path
from queue import Queue

import numpy as np
import pytest
import standfast as sf
from standfast import page
from standfast.server import Limits, serve
from test_wasm import drawn

sync_api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium"),
    pytest.mark.xdist_group("browser"),
]

EXAMPLES = Path(__file__).parents[2] / "examples"
#: The browser asks nobody but the page's server.
ARGUMENTS = ("--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update", "--disable-sync")  # fmt: skip
#: Legs on two slopes: stable while the centre of mass is between the feet.
LEGS = {
    "gravity": 9.81,
    "restitution": 0.1,
    "body": {"mass": 1.0, "gyration_radius": 0.4, "center_of_mass": [0.05, 0.35]},
    "contact": [
        {"point": [-0.5, 0.0], "slope": -0.35, "friction": 0.6},
        {"point": [0.5, 0.0], "slope": 0.35, "friction": 0.6},
    ],
}


@pytest.fixture(scope="module")
def browser():
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM, args=list(ARGUMENTS)
        )
        yield chromium
        chromium.close()


@contextmanager
def opened(browser, address, **options):
    """A page, on which nothing may go to the console and no error may be raised."""
    said = []
    context = browser.new_context(
        **{"viewport": {"width": 1300, "height": 900}, **options}
    )
    shown = context.new_page()
    shown.set_default_timeout(15_000)
    shown.on("console", lambda message: said.append(message.text))
    shown.on("pageerror", lambda error: said.append(str(error)))
    shown.on(
        "requestfailed", lambda request: said.append(f"{request.failure} {request.url}")
    )
    shown.goto(address)
    yield shown
    # What is under way when the page is left is given up.
    assert [text for text in said if not text.startswith("net::ERR_ABORTED")] == []
    context.close()


@contextmanager
def explorer(browser, scene=None, grace=0.5, **options):
    """The explorer, and what it asks. grace: how long the server waits for a page that comes back, s."""
    addresses, asked = Queue(), []

    def answer(question):
        asked.append(json.loads(question))
        return sf.ask(question, seconds=10)

    served = threading.Thread(
        target=serve,
        args=(page.explorer_page(scene), answer),
        kwargs={"opened": addresses.put, "limits": Limits(grace=grace)},
    )
    served.start()
    with opened(browser, addresses.get(timeout=10), **options) as shown:
        shown.wait_for_selector(".sf-view [data-handle]")
        yield shown, asked
    # The server ends with its page.
    served.join(timeout=15)
    assert not served.is_alive()


def scene_of(shown):
    """The scene that the address of the page holds."""
    return shown.evaluate(
        """() => { const text = new URLSearchParams(location.hash.slice(1)).get("scene");
        return JSON.parse(atob(text.replace(/-/g, "+").replace(/_/g, "/"))); }"""
    )


def verdict(shown):
    return shown.locator(".sf-verdict").get_attribute("data-state")


def settled(shown, state):
    """Waits for a verdict, and for the film after it."""
    shown.wait_for_selector(f'.sf-verdict[data-state="{state}"]')
    answered(shown)


def answered(shown):
    """Waits until nothing is asked about the scene any more."""
    shown.wait_for_timeout(50)
    shown.wait_for_selector(".sf-root[aria-busy=false]")


def drag(shown, at, by):
    """Presses in the middle of what is at `at`, moves by `by` (px), and releases."""
    box = shown.locator(at).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    shown.mouse.move(x, y)
    shown.mouse.down()
    for k in range(1, 11):
        shown.mouse.move(x + by[0] * k / 10, y + by[1] * k / 10)
    shown.mouse.up()


def seek(shown, share):
    """Shows this share of the film."""
    shown.locator(".sf-play").click()
    shown.locator(".sf-play").click()
    shown.evaluate(
        """(share) => { const seek = document.querySelector(".sf-seek");
        seek.value = share * Number(seek.max); seek.dispatchEvent(new Event("input")); }""",
        share,
    )


def letters(shown):
    """The numbers and letters of the contacts in the picture."""
    texts = shown.locator(".sf-view svg text").all_text_contents()
    return [text.replace(" ", "") for text in texts]


def test_a_side_on_the_edge_of_a_table_has_its_letter_and_force(browser):
    with explorer(browser) as (shown, _):
        shown.select_option(".sf-preset", "Box over a table edge")
        settled(shown, "unstable")
        assert letters(shown)[:5] == ["1", "2", "3", "4", "5F"]
        # Its marker is at the corner of the ground.
        handle = shown.locator('circle[aria-label^="vertex 2 of the ground"]')
        x, y = (handle.get_attribute(name) for name in ("cx", "cy"))
        assert shown.locator(f'.sf-view circle[cx="{x}"][cy="{y}"][r="4"]').count() == 1
        seek(shown, 0.3)
        assert "SSSSF" in shown.locator(".sf-readout").inner_text()
        assert "5F" in letters(shown)
        seek(shown, 0.75)
        assert "SSSSS" in shown.locator(".sf-readout").inner_text()
        assert not any(text.startswith("5") for text in letters(shown))


def test_the_scenes_to_begin_with_have_answers(browser):
    with explorer(browser) as (shown, _):
        names = shown.locator(".sf-preset option").all_inner_texts()[1:]
        assert {"Box over a table edge", "Box on stairs", "Ball with backspin"} <= {*names}  # fmt: skip
        for name in names:
            shown.select_option(".sf-preset", name)
            answered(shown)
            assert shown.locator(".sf-error").is_hidden(), name
            seek(shown, 0.5)
            assert "mode" in shown.locator(".sf-readout").inner_text(), name


def test_dragging_the_centre_of_mass_out_of_the_region_changes_the_verdict(browser):
    with explorer(browser, LEGS) as (shown, asked):
        settled(shown, "stable")
        assert "corner-map" in shown.locator(".sf-verdict h2").inner_text()
        drag(shown, '[data-handle="0"]', (300, 0))
        settled(shown, "unstable")
        scene = scene_of(shown)
        x, y = scene["body"]["center_of_mass"]
        assert x > 0.5
        assert y == pytest.approx(0.35, abs=1e-9)
        # What the page says is what the package says.
        told = json.loads(sf.ask(json.dumps({"ask": "posture", "scene": scene})))
        text = shown.locator(".sf-verdict").inner_text()
        assert told["verdict"]["in_words"] in text
        assert f"Why ({told['verdict']['by']}): " in text
        words = shown.locator(".sf-modes tr.yes td:first-child").all_inner_texts()
        assert [word.removeprefix("✓ ") for word in words] == told["modes"][
            "consistent"
        ]
        # The map around the body has been drawn, first coarse and then fine.
        assert shown.locator(".sf-view image").count() == 1
        cells = {len(q["over"][1]["values"]) for q in asked if q["ask"] == "map"}
        assert 60 in cells
        # Undo and redo.
        shown.keyboard.press("Control+z")
        settled(shown, "stable")
        shown.keyboard.press("Control+y")
        settled(shown, "unstable")


def test_a_kick_plays_to_rest(browser):
    with explorer(browser, LEGS) as (shown, asked):
        settled(shown, "stable")
        body = shown.locator(".sf-view path.body").bounding_box()
        middle = body["x"] + body["width"] / 2, body["y"] + body["height"] / 2
        shown.mouse.move(*middle)
        shown.mouse.down()
        shown.mouse.move(middle[0] + 60, middle[1], steps=5)
        shown.mouse.up()
        answered(shown)
        assert "end" not in shown.locator(".sf-readout").inner_text()
        shown.select_option(".sf-speed", index=5)  # the fastest
        shown.wait_for_selector(".sf-readout:has-text('end: rest')")
        (kick,) = scene_of(shown)["kick"]
        assert kick["impulse"][0] > 0
        assert abs(kick["impulse"][1]) < 1e-9
        # The end of the film is the end of the run that Python computes from the same scene.
        question = [q for q in asked if q["ask"] == "motion"][-1]
        film = json.loads(sf.ask(json.dumps(question)))
        assert film["outcome"] == "rest"
        assert f"t = {film['end']:.7g}"[:9] in shown.locator(".sf-readout").inner_text()


def field(shown, name):
    return shown.locator(f'input[type=number][aria-label="{name}"]')


def entered(shown, name, value):
    field(shown, name).fill(value)
    field(shown, name).press("Enter")
    answered(shown)


def test_a_kick_keeps_the_start_as_if_it_were_typed(browser):
    with explorer(browser) as (shown, asked):
        shown.select_option(".sf-preset", "Box on stairs")
        answered(shown)
        assert field(shown, "start, velocity, x").input_value() == "3"
        run = shown.locator(".sf-run")
        assert "Started with the velocity (3, 0) m/s: the body" in run.inner_text()
        shown.locator('[data-handle="0"]').focus()
        shown.keyboard.press("k")
        answered(shown)
        scene = scene_of(shown)
        assert scene["start"]["qdot"] == [3, 0, 0]
        assert "Started with the velocity (3, 0) m/s, kicked with" in run.inner_text()
        (kick,) = scene["kick"]
        shown.locator(".sf-undo").click()
        answered(shown)
        entered(shown, "impulse of the kick, x", repr(kick["impulse"][0]))
        asked = [q for q in asked if q["ask"] == "motion" and "kick" in q["scene"]]
        pressed, typed = (json.loads(sf.ask(json.dumps(q))) for q in asked)
        assert pressed["frames"] == typed["frames"]
        # The start is typed, too.
        entered(shown, "start, velocity, turn", "-2.5")
        entered(shown, "start, displaced by, y", "0.1")
        assert scene_of(shown)["start"] == {"q": [0, 0.1, 0], "qdot": [3, 0, -2.5]}
        assert "Started displaced by (0, 0.1) m" in run.inner_text()


def test_a_changed_scene_says_so(browser, tmp_path):
    with explorer(browser) as (shown, _):
        settled(shown, "stable")

        def title():
            return shown.eval_on_selector(
                ".sf-preset", "list => list.selectedOptions[0].textContent"
            )

        shown.select_option(".sf-preset", "Box on stairs")
        answered(shown)
        assert title() == "Box on stairs"
        entered(shown, "start, velocity, x", "2")
        assert title() == "Box on stairs, changed"
        entered(shown, "start, velocity, x", "3")
        assert title() == "Box on stairs"
        entered(shown, "mass m / kg", "3")
        shown.set_input_files(".sf-file", EXAMPLES / "stairs.toml")
        answered(shown)
        assert title() == "stairs.toml"
        shown.locator(".sf-undo").click()
        answered(shown)
        assert title() == "Box on stairs, changed"
        shown.locator(".sf-undo").click()
        answered(shown)
        assert title() == "Box on stairs"
        # A file that is no scene leaves the name.
        (tmp_path / "wrong.toml").write_text("gravity = -1\n", encoding="utf-8")
        shown.set_input_files(".sf-file", tmp_path / "wrong.toml")
        shown.wait_for_selector(".sf-error:visible")
        assert title() == "Box on stairs"


def test_what_is_of_the_scene_before_is_dimmed(browser, monkeypatch):
    ask, go = sf.ask, threading.Event()

    def slow(question, **options):
        if json.loads(question)["ask"] == "motion":
            go.wait(10)
        return ask(question, **options)

    def opacity(name):
        return shown.eval_on_selector(name, "e => +getComputedStyle(e).opacity")

    with explorer(browser) as (shown, _):
        answered(shown)
        monkeypatch.setattr(sf, "ask", slow)
        shown.select_option(".sf-preset", "Box on stairs")
        shown.wait_for_timeout(600)
        assert shown.locator(".sf-wait").is_visible()
        for name in (".sf-run p", ".sf-readout", ".sf-panels"):
            assert opacity(name) < 0.5, name
        go.set()
        answered(shown)
        shown.wait_for_timeout(300)
        assert shown.locator(".sf-wait").is_hidden()
        for name in (".sf-run p", ".sf-readout", ".sf-panels", ".sf-verdict"):
            assert opacity(name) == 1, name


def test_a_run_that_cannot_be_computed_has_no_numbers(browser):
    with explorer(browser, LEGS) as (shown, _):
        settled(shown, "stable")
        entered(shown, "friction μ, all contacts", "-1")
        assert "could not be computed" in shown.locator(".sf-run").inner_text()
        assert "rest" not in shown.locator(".sf-run").inner_text()
        shown.locator(".sf-undo").click()
        answered(shown)
        assert "comes to rest" in shown.locator(".sf-run").inner_text()


def inside(shown, part):
    """Whether a part of the picture is inside it."""
    view, box = (
        shown.locator(name).bounding_box() for name in (".sf-view", f".sf-view {part}")
    )
    return all(
        view[axis] <= box[axis] and box[axis] + box[size] <= view[axis] + view[size]
        for axis, size in (("x", "width"), ("y", "height"))
    )


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
def test_the_stairs_the_path_and_the_kick_are_in_the_picture(browser, width, height):
    size = {"viewport": {"width": width, "height": height}}
    with explorer(browser, **size) as (shown, _):
        shown.select_option(".sf-preset", "Box on stairs")
        answered(shown)
        assert inside(shown, ".sf-path")
        for vertex in range(2, 7):
            assert inside(shown, f'[aria-label^="vertex {vertex} of"]'), vertex
        # The label of a kick stays, however long its arrow is.
        for impulse in ("100", "-100"):
            for axis in "xy":
                entered(shown, f"impulse of the kick, {axis}", impulse)
                assert inside(shown, 'text:has-text("kick")'), (axis, impulse)


def test_a_vertex_of_the_ground_and_a_contact_on_it_are_dragged(browser):
    with explorer(browser) as (shown, _):
        shown.select_option(".sf-preset", "Box on stairs")
        answered(shown)
        for name in ("vertex 2 of the ground", "contact 3"):
            drag(shown, f'circle[aria-label^="{name}"]', (8, 0))
            answered(shown)
            assert shown.locator(".sf-error").is_hidden(), name
        assert scene_of(shown)["terrain"][1][0] > 0
        assert scene_of(shown)["contact"][2]["point"][0] > -0.75


def touched(shown, start, by):
    """Moves a finger from a place by a vector, px."""
    session = shown.context.new_cdp_session(shown)

    def send(kind, *places):
        points = [{"x": x, "y": y} for x, y in places]
        session.send(
            "Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points}
        )

    send("Start", start)
    for k in range(1, 11):
        send("Move", [v + d * k / 10 for v, d in zip(start, by, strict=True)])
        shown.wait_for_timeout(16)
    send("End")
    shown.wait_for_timeout(300)


def test_on_a_phone(browser):
    phone = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}  # fmt: skip
    with explorer(browser, **phone) as (shown, _):
        shown.select_option(".sf-preset", "Box on stairs")
        answered(shown)
        parts = ("theme", "open", "view", "controls", "readout", "run", "verdict", "hint", "panels")  # fmt: skip
        tops = [shown.locator(f".sf-{name}").bounding_box()["y"] for name in parts]
        assert tops == sorted(tops)
        assert shown.locator(".sf-keys").is_hidden()
        small = shown.evaluate(
            """() => [...document.querySelectorAll("input[type=number], select")]
            .filter((e) => parseFloat(getComputedStyle(e).fontSize) < 16).map((e) => e.outerHTML)"""
        )
        assert small == []
        # A swipe beside the body scrolls the page, also while the film is shown, which goes on.
        view = shown.locator(".sf-view").bounding_box()
        beside = view["x"] + 300, view["y"] + 60
        shown.locator(".sf-play").tap()
        touched(shown, beside, (0, -150))
        assert shown.evaluate("scrollY") > 50
        assert shown.locator(".sf-said").get_attribute("data-watching") == "true"
        shown.evaluate("scrollTo(0, 0)")
        shown.touchscreen.tap(*beside)
        assert shown.locator(".sf-said").get_attribute("data-watching") == "false"
        # A finger on the body, between its handles, kicks it.
        body = shown.locator(".sf-view path.body").bounding_box()
        start = body["x"] + body["width"] / 2, body["y"] + body["height"] / 2 + 17
        touched(shown, start, (20, -60))
        answered(shown)
        (kick,) = scene_of(shown)["kick"]
        assert kick["impulse"][0] > 0
        assert kick["impulse"][1] > 0
        assert shown.evaluate("scrollY") == 0


def test_keys_move_what_is_focused_and_play(browser):
    with explorer(browser, LEGS) as (shown, _):
        settled(shown, "stable")
        shown.locator('[data-handle="0"]').focus()
        shown.keyboard.press("Shift+ArrowRight")
        answered(shown)
        moved = scene_of(shown)["body"]["center_of_mass"]
        size = math.hypot(0.55, 0.35)
        assert moved == pytest.approx([0.05 + 0.1 * size, 0.35], abs=1e-12)
        # The focus stays on the handle.
        shown.keyboard.press("ArrowUp")
        answered(shown)
        assert scene_of(shown)["body"]["center_of_mass"][1] > 0.35
        shown.keyboard.press("k")
        answered(shown)
        assert "end" not in shown.locator(".sf-readout").inner_text()
        shown.select_option(".sf-speed", index=5)  # the fastest
        shown.wait_for_selector(".sf-readout:has-text('end: rest')")


def test_a_slope_and_a_slider(browser):
    with explorer(browser, LEGS) as (shown, _):
        settled(shown, "stable")
        # The knob of the slope of contact 2: from 0.35 rad upwards.
        drag(shown, '[data-handle="4"]', (0, -60))
        answered(shown)
        scene = scene_of(shown)
        assert scene["contact"][1]["slope"] > 0.45
        assert scene["contact"][0]["slope"] == -0.35
        shown.locator("[data-slider='0']").fill("0.1")
        answered(shown)
        assert {c["friction"] for c in scene_of(shown)["contact"]} == {0.1}
        shown.select_option(".sf-law", "moreau")
        answered(shown)
        assert scene_of(shown)["run"]["impact"] == "moreau"


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
def test_it_opens_quietly_and_no_column_is_clipped(browser, width, height):
    """`opened` sees to it that nothing goes to the console."""
    size = {"viewport": {"width": width, "height": height}}
    with explorer(browser, **size) as (shown, _):
        settled(shown, "stable")
        names = shown.locator(".sf-preset option").all_inner_texts()[1:]
        for name in names:
            shown.select_option(".sf-preset", name)
            answered(shown)
            assert shown.locator(".sf-error").is_hidden(), name
            assert shown.locator(".sf-warnings").inner_text() == "", name
            assert shown.evaluate("document.documentElement.scrollWidth") <= width
            wide = shown.evaluate(
                """() => [...document.querySelectorAll(".sf-right *:not(input, select, option)")]
                .filter((e) => e.getBoundingClientRect().right > document.querySelector(".sf-run").getBoundingClientRect().right + 1)
                .map((e) => e.outerHTML)"""
            )
            assert wide == [], name


def test_numbers_are_typed(browser):
    with explorer(browser, LEGS) as (shown, _):
        settled(shown, "stable")

        def typed(name, value):
            entered(shown, name, value)
            return scene_of(shown)

        slider = shown.locator("[data-slider='0']")
        for contact in typed("friction μ, all contacts", "0.35")["contact"]:
            assert contact["friction"] == 0.35
        assert slider.input_value() == "0.35"
        assert typed("restitution e", "0.3")["restitution"] == 0.3
        assert typed("mass m / kg", "2.5")["body"]["mass"] == 2.5
        scene = typed("radius of gyration ρ / m", "3")
        assert scene["body"]["gyration_radius"] == 3.0
        assert typed("contact 2, slope", "0.4")["contact"][1]["slope"] == 0.4
        assert typed("contact 1, x", "-0.6")["contact"][0]["point"] == [-0.6, 0.0]
        scene = typed("contact 1, friction", "0.7")
        assert [c["friction"] for c in scene["contact"]] == [0.7, 0.35]
        typed("impulse of the kick, x", "0.3")
        (kick,) = typed("point of the kick, y", "0.5")["kick"]
        assert kick["impulse"] == [0.3, 0.0]
        assert kick["point"] == [0.05, 0.5]
        # A place that changes the verdict, also by undo, which goes through the fields as well.
        name = "centre of mass, x"
        assert typed(name, "0.9")["body"]["center_of_mass"] == [0.9, 0.35]
        settled(shown, "unstable")
        shown.locator(".sf-undo").click()
        answered(shown)
        assert field(shown, name).input_value() == "0.05"
        # What cannot be used is named, and undone.
        typed("friction μ, all contacts", "-1")
        assert "friction" in shown.locator(".sf-error").inner_text()
        shown.locator(".sf-undo").click()
        answered(shown)
        assert shown.locator(".sf-error").is_hidden()


def test_a_field_follows_the_handle_that_is_dragged(browser):
    with explorer(browser, LEGS) as (shown, _):
        settled(shown, "stable")
        drag(shown, '[data-handle="0"]', (40, 0))
        answered(shown)
        x = scene_of(shown)["body"]["center_of_mass"][0]
        typed = field(shown, "centre of mass, x")
        assert float(typed.input_value()) == pytest.approx(x, abs=1e-4)
        assert float(typed.get_attribute("title")) == x


def test_the_map_has_the_tints_of_its_legend(browser):
    with explorer(browser) as (shown, _):
        settled(shown, "stable")
        tints = """async () => {
            const image = document.querySelector(".sf-view image");
            const picture = new Image(); picture.src = image.getAttribute("href"); await picture.decode();
            const canvas = new OffscreenCanvas(picture.width, picture.height), context = canvas.getContext("2d");
            context.drawImage(picture, 0, 0);
            const { data } = context.getImageData(0, 0, picture.width, picture.height);
            const tint = (r, g, b, a) => `${a ? [r, g, b] : [0, 0, 0]},${Math.round(a)}`;
            const found = new Set();
            for (let k = 0; k < data.length; k += 4) found.add(tint(...data.slice(k, k + 4)));
            const legend = [...document.querySelectorAll(".sf-legend b")].map((b) => {
              const { backgroundColor, opacity } = getComputedStyle(b);
              return tint(...backgroundColor.match(/\\d+/g).map(Number), 255 * opacity);
            });
            return { opacity: getComputedStyle(image).opacity, found: [...found].sort(), legend: legend.sort() };
        }"""
        told = shown.evaluate(tints)
        assert told["opacity"] == "1"
        assert len(told["legend"]) >= 4
        found, legend = (
            np.array([[int(v) for v in tint.split(",")] for tint in told[name]])
            for name in ("found", "legend")
        )
        away = abs(found[:, None] - legend).max(axis=-1)
        # A canvas keeps the product of colour and opacity, rounded.
        assert (away.min(axis=0) <= 2).all()
        assert (away.min(axis=1) <= 2).all()


def test_the_headline_follows_the_film_and_the_verdict_says_what_it_is_about(browser):
    with explorer(browser) as (shown, _):
        shown.select_option(".sf-preset", "A box and a push")
        settled(shown, "stable")

        def top(name):
            return shown.locator(f".sf-{name}").bounding_box()["y"]

        assert top("verdict") < top("run")
        assert "comes to rest" in shown.locator(".sf-run").inner_text()
        assert "turned by -1.571 rad" in shown.locator(".sf-run").inner_text()
        seek(shown, 0.35)
        assert top("run") < top("verdict")
        assert "This run moves" in shown.locator(".sf-run h3").inner_text()
        seek(shown, 1.0)
        assert "This run comes to rest" in shown.locator(".sf-run h3").inner_text()
        # A press beside the body shows the posture again.
        view = shown.locator(".sf-view").bounding_box()
        shown.mouse.click(view["x"] + 15, view["y"] + 15)
        assert top("verdict") < top("run")


def test_panels_show_the_angle_and_the_ground_and_none_is_empty(browser):
    with explorer(browser) as (shown, _):
        panels = {
            "A box and a push": {"gaps", "angle"},
            "Shaking ground": {"gaps", "angle", "shaking"},
            "Bouncing ball": {"gaps"},
            "Three feet": set(),
        }
        for name, expected in panels.items():
            shown.select_option(".sf-preset", name)
            answered(shown)
            found = {
                n
                for n in ("gaps", "angle", "shaking")
                if shown.locator(f".sf-{n} canvas").count()
            }
            assert found == expected, name


def test_a_link_holds_the_scene(browser):
    with explorer(browser, LEGS, grace=3.0) as (shown, _):
        settled(shown, "stable")
        drag(shown, '[data-handle="0"]', (-20, -60))
        answered(shown)
        link, scene, state = shown.url, scene_of(shown), verdict(shown)
        shown.goto("about:blank")
        shown.goto(link)
        shown.wait_for_selector(".sf-view [data-handle]")
        settled(shown, state)
        assert scene_of(shown) == scene
        assert scene["body"]["center_of_mass"] != LEGS["body"]["center_of_mass"]


def test_a_copied_link_has_the_token_without_which_the_page_is_refused(browser):
    with explorer(browser, LEGS, grace=3.0) as (shown, _):
        settled(shown, "stable")
        scene = scene_of(shown)
        shown.evaluate("navigator.clipboard.writeText = async (text) => { window.copied = text; }")  # fmt: skip
        shown.locator(".sf-link").click()
        link = shown.wait_for_function("window.copied").json_value()
        shown.goto("about:blank")
        shown.goto(link)
        shown.wait_for_selector(".sf-view [data-handle]")
        settled(shown, "stable")
        assert scene_of(shown) == scene


def test_files_are_opened_and_saved(browser, tmp_path):
    with explorer(browser, LEGS) as (shown, _):
        settled(shown, "stable")
        shown.set_input_files(".sf-file", EXAMPLES / "stairs.toml")
        shown.wait_for_selector("[data-handle='8']")
        answered(shown)
        with shown.expect_download() as download:
            shown.locator(".sf-save").click()
        download.value.save_as(tmp_path / "scene.toml")
        saved, original = (
            sf.load(tmp_path / "scene.toml"),
            sf.load(EXAMPLES / "stairs.toml"),
        )
        assert repr(saved) == repr(original)
        for button, magic in ((".sf-png", b"\x89PNG"), (".sf-svg", b"<svg")):
            with shown.expect_download() as download:
                shown.locator(button).click()
            assert Path(download.value.path()).read_bytes().startswith(magic)
        # A file that is no scene changes nothing but the message.
        (tmp_path / "wrong.toml").write_text("gravity = -1\n", encoding="utf-8")
        before = shown.url
        shown.set_input_files(".sf-file", tmp_path / "wrong.toml")
        shown.wait_for_selector(".sf-error:visible")
        assert "line 1" in shown.locator(".sf-error").inner_text()
        assert shown.url == before


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_no_row_of_the_page_is_wider_than_a_phone(browser, scheme):
    phone = {"viewport": {"width": 375, "height": 720}, "color_scheme": scheme}
    with explorer(browser, LEGS, has_touch=True, **phone) as (shown, _):
        settled(shown, "stable")
        assert shown.evaluate("document.documentElement.scrollWidth") <= 375
        assert shown.locator(".sf-root").get_attribute("data-theme") == scheme


def test_every_preset_has_a_verdict_and_a_film(browser):
    with explorer(browser) as (shown, _):
        names = shown.eval_on_selector_all(
            ".sf-preset option", "all => all.map((o) => o.value)"
        )
        for name in filter(None, names):
            shown.select_option(".sf-preset", name)
            answered(shown)
            assert not shown.locator(".sf-error").is_visible(), name
            assert verdict(shown) in ("stable", "unstable", "undecided")


def test_a_film_plays_scrubs_and_steps_from_a_file(browser, tmp_path):
    run = sf.load(EXAMPLES / "clattering_rod.toml").simulate()
    run.animate(tmp_path / "film.html", clock="zeno")
    with opened(browser, (tmp_path / "film.html").as_uri()) as shown:
        readout = shown.locator(".sf-readout")
        assert "t = 0.000000 s" in readout.inner_text()
        assert shown.locator(".sf-clock").input_value() == "zeno"
        # From event to event: the times of the impacts.
        for impact in run.impacts["time"][:5]:
            shown.locator(".sf-after").click()
            assert f"t = {impact:.7g}"[:10] in readout.inner_text()
        shown.locator(".sf-before").click()
        assert f"t = {run.impacts['time'][3]:.7g}"[:10] in readout.inner_text()
        # In the middle of the film the gaps are too small to be seen, and are magnified.
        whole = float(shown.locator(".sf-seek").get_attribute("max"))
        assert whole == pytest.approx(run.film_time(run.time, clock="zeno"))
        shown.locator(".sf-seek").fill(str(whole / 2))
        assert "before the 2-zeno point" in readout.inner_text()
        assert "times as large" in shown.locator(".sf-stage svg").text_content()
        shown.select_option(".sf-speed", index=5)
        shown.locator(".sf-play").click()
        shown.wait_for_selector(".sf-readout:has-text('end: rest')")


def test_the_film_holds_no_text_that_ends_its_script():
    assert "</script" not in page.data({"name": "</script><script>alert(1)</script>"})


MODULE = Path(__file__).parents[2] / "target" / "explorer" / "standfast.wasm"


@pytest.mark.skipif(not MODULE.exists(), reason="needs make explorer")
def test_without_a_server_the_core_is_in_the_page(browser, tmp_path):
    (tmp_path / "index.html").write_text(page.static_page(MODULE.read_bytes()), encoding="utf-8")  # fmt: skip
    with opened(browser, (tmp_path / "index.html").as_uri()) as shown:
        shown.wait_for_selector(".sf-view [data-handle]")
        settled(shown, "stable")
        drag(shown, '[data-handle="0"]', (320, 0))
        settled(shown, "unstable")
        # The answers are those of the wheel, to the last bit.
        scenes = [path.read_text(encoding="utf-8") for path in EXAMPLES.glob("*.toml")]
        scenes += [drawn(k) for k in range(62 - len(scenes))]
        for scene in scenes:
            for question in ("posture", "motion"):
                asked = {"ask": question, "scene": scene}
                told = shown.evaluate("(asked) => window.standfast.ask(asked)", asked)
                assert told == json.loads(sf.ask(json.dumps(asked)))

"""The documentation site in a real browser: its search, its explorer, the width of its pages, and that it asks no other host. Needs
`make site`, Chromium and playwright; without them the tests are skipped by name."""

import http.server
import shutil
import threading
import urllib.parse
from functools import partial
from pathlib import Path

import pytest
from test_explorer import ARGUMENTS, opened

sync_api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
SITE = Path(__file__).parents[2] / "target" / "site"
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium"),
    pytest.mark.skipif(
        not (SITE / "explorer" / "index.html").exists(), reason="needs make site"
    ),
    pytest.mark.xdist_group("browser"),
]
EXPLORER = SITE / "explorer.html"
needs_explorer = pytest.mark.skipif(
    not EXPLORER.exists() or "sf-root" not in EXPLORER.read_text(encoding="utf-8"),
    reason="needs make site with the explorer",
)


@pytest.fixture(scope="module")
def browser():
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=CHROMIUM, args=list(ARGUMENTS)
        )
        yield chromium
        chromium.close()


class Quiet(http.server.SimpleHTTPRequestHandler):
    """A server that writes no log."""

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def address():
    """The site below a folder of its server, as project pages are."""
    handler = partial(Quiet, directory=SITE.parent)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever).start()
        yield f"http://127.0.0.1:{server.server_port}/{SITE.name}"
        server.shutdown()


#: What a visitor types, and the page that has to be the first answer.
FIRST = {
    "ball": "recipe_ball",
    "super ball": "recipe_super_ball",
    "wheel": "recipe_wheel",
    "kerb": "recipe_wheel",
    "die": "recipe_die",
    "dumbbell": "recipe_die",
    "phone": "recipe_phone",
    "drop test": "recipe_phone",
    "push": "recipe_push",
    "slope": "recipe_slope",
    "stack": "recipe_stack",
    "arch": "assemblies",
    "masonry": "assemblies",
    "ladder": "tutorial_ladder",
    "jam": "recipe_chalk",
    "chalk": "recipe_chalk",
    "Painlevé": "tutorial_rod",
    "accelerogram": "tutorial_records",
    "spectrum": "tutorial_records",
    "record": "tutorial_records",
    "overturning": "tutorial_records",
    "URDF": "robots",
    "kick": "tutorial_kicks",
    "certificate": "certificates",
    "install": "",
    "pip": "",
    "map": "maps",
    "Rust": "rust",
    "simulate": "api/simulate",
    "simulate_many": "api/simulate_many",
    "Posture": "api/posture",
    "ZenoPoint": "api/events",
    "friction_margin": "api/forces",
    "ContactProblem": "api/contact_problem",
    "Verdict": "api/verdict",
    "HoldingTorques": "api/mechanism",
    "SystemMode": "api/load_factor",
    "neimark_sacker": "api/theory",
}


def test_the_search_finds_the_right_page_first(browser, address):
    with opened(browser, f"{address}/") as shown:
        shown.wait_for_load_state("networkidle")
        shown.keyboard.press("Control+k")
        entry = shown.get_by_role("combobox", name="Search")
        found = {}
        for word in FIRST:
            entry.fill(word)
            # The answers to this word, not those to the one before.
            query = urllib.parse.quote_plus(word)
            first = shown.locator(f'[role="option"][href*="?h={query}"]').first
            first.wait_for()
            path = urllib.parse.urlparse(first.get_attribute("href")).path
            found[word] = path.removeprefix(f"/{SITE.name}").strip("/")
        assert found == FIRST


def drag_until_unstable(shown):
    """Drags the centre of mass of the explorer in the page beyond the right foot."""
    frame = shown.frame_locator("iframe")
    frame.locator('.sf-verdict[data-state="stable"]').wait_for()
    box = frame.locator('[data-handle="0"]').bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    shown.mouse.move(x, y)
    shown.mouse.down()
    shown.mouse.move(x + 250, y, steps=10)
    shown.mouse.up()
    frame.locator('.sf-verdict[data-state="unstable"]').wait_for()


@needs_explorer
def test_the_explorer_runs_in_its_page(browser, address):
    with opened(browser, f"{address}/explorer/") as shown:
        drag_until_unstable(shown)


@needs_explorer
def test_the_explorer_runs_in_its_page_without_a_server(browser):
    shown = browser.new_page(viewport={"width": 1300, "height": 900})
    shown.goto((SITE / "explorer" / "index.html").as_uri())
    drag_until_unstable(shown)
    shown.close()


def test_a_phone_has_the_link_to_the_explorer_and_no_frame(browser, address):
    phone = {"viewport": {"width": 390, "height": 844}}
    with opened(browser, f"{address}/explorer/", **phone) as shown:
        assert shown.locator("iframe").is_hidden()
        assert shown.locator('a[href$="explorer.html"]').is_visible()


def test_the_tour_shows_its_outputs_and_plays_its_film(browser, address):
    phone = {"viewport": {"width": 390, "height": 844}}
    with opened(browser, f"{address}/tour.html", **phone) as shown:
        assert shown.evaluate("document.documentElement.scrollWidth") <= 390
        assert shown.get_by_text("neutral").count()
        assert shown.locator("svg").count() >= 3
        film = shown.frame_locator("iframe")
        film.locator(".sf-play").click()
        film.locator(".sf-readout").get_by_text("t = ").wait_for()


def test_every_page_fits_a_phone_and_asks_no_other_host(browser, address):
    pages = sorted(SITE.glob("*/index.html"))
    assert len(pages) > 20
    with opened(
        browser, f"{address}/", viewport={"width": 390, "height": 844}
    ) as shown:
        asked = []
        shown.on("request", lambda request: asked.append(request.url))
        for page in pages:
            shown.goto(f"{address}/{page.parent.name}/")
            wide = shown.evaluate("document.documentElement.scrollWidth")
            assert wide <= 390, page.parent.name
        assert len(asked) > len(pages)
        hosts = ("http://127.0.0.1", "data:", "blob:")
        assert [url for url in asked if not url.startswith(hosts)] == []


def test_examples_are_copied_as_code_that_runs(browser, address):
    """Without prompts and without what they print. The docstrings and pages themselves are run by other tests."""
    blocks = 0
    with opened(browser, f"{address}/") as shown:
        for page in sorted(SITE.glob("**/index.html")):
            shown.goto(f"{address}/{page.parent.relative_to(SITE)}/")
            shown.wait_for_load_state("networkidle")
            for text in shown.evaluate(
                """() => [...document.querySelectorAll("[data-clipboard-target]")].map((button) => {
                    button.click();
                    return button.dataset.clipboardText;
                })"""
            ):
                if text and "standfast" not in text.split(maxsplit=1)[0]:
                    blocks += 1
                    if not text.startswith(("pip ", "cargo ", "PYTHONPATH")):
                        compile(text, str(page), "exec")
                assert ">>>" not in (text or "")
    assert blocks > 200

"""The packages: one version, one place of the project's addresses, a description that can be shown anywhere."""

import re
import tomllib
from pathlib import Path

import standfast as sf

ROOT = Path(__file__).parents[2]


def toml(path):
    return tomllib.loads((ROOT / path).read_text(encoding="utf-8"))


def test_the_version_is_the_same_everywhere():
    project = toml("pyproject.toml")
    settings = project["tool"]["bumpversion"]
    assert "version" in project["project"]["dynamic"]
    version = toml("Cargo.toml")["workspace"]["package"]["version"]
    assert sf.__version__ == version
    assert settings["current_version"] == version
    for file in settings["files"]:
        text = (ROOT / file["filename"]).read_text(encoding="utf-8")
        sought = file["search"].format(current_version=version)
        assert len(re.findall(rf"^{re.escape(sought)}$", text, re.MULTILINE)) == 1, file


def test_the_addresses_of_the_project_are_in_one_place():
    package = toml("Cargo.toml")["workspace"]["package"]
    home = package["homepage"]
    for name in ("repository", "documentation"):
        assert package[name].startswith(home)
    holders = []
    for path in ROOT.glob("**/*"):
        parts = path.relative_to(ROOT).parts
        if (
            path.is_file()
            and not {"target", "node_modules"} & set(parts)
            and (not parts[0].startswith(".") or parts[0] == ".github")
            and path.suffix
            in {".cff", ".html", ".js", ".md", ".py", ".pyi", ".rs", ".toml", ".yml"}
            and home in path.read_text(encoding="utf-8")
        ):
            holders.append(path.relative_to(ROOT).as_posix())
    assert holders == ["Cargo.toml"]


def test_the_pages_of_the_packages_have_no_links_into_the_project():
    """A registry shows them alone."""
    for page in (toml("pyproject.toml")["project"]["readme"], "crates/core/README.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        for link in re.findall(r"\]\(([^)]+)\)", text):
            assert link.startswith("https://"), (page, link)

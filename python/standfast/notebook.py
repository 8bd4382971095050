"""What a notebook shows: the HTML of postures, runs, verdicts, contact modes and assemblies with small pictures, and the player.

The pictures take the colour of the text around them, so that they can be read on light and on dark backgrounds.
"""

from collections.abc import Sequence
from contextlib import suppress
from html import escape
from typing import Literal

import numpy as np
import numpy.typing as npt

from standfast._core import LoadFactor, Modes, Posture, Run, System, SystemMode, Verdict
from standfast.page import film_page
from standfast.report import account, decimal, method_named
from standfast.scenery import (
    Piece,
    body_outline,
    displaced,
    ground,
    spokes,
    surface,
    system_ground,
    touching_points,
)
from standfast.table import (
    factor_in_words,
    listed,
    modes_table,
    system_holds,
    system_mode_table,
    verdict_table,
)
from standfast.units import plain

_Floats = npt.NDArray[np.float64]

#: Largest width and height of a picture; margin around the body, depth of the ground, distance of the number of a contact; px.
WIDTH, HEIGHT, MARGIN, DEPTH, LABEL = 300.0, 220.0, 34.0, 9.0, 21.0
#: Least size of what a picture shows, m.
SMALLEST = 1e-300
#: Points of the path of the centre of mass.
PATH = 400
#: Fill of the body, and the path of the centre of mass: of medium brightness.
BODY, COURSE = "#56B4E9", "#D55E00"
#: The colour of the text around.
INK = "currentColor"
#: Style of the cells of a table.
LEFT = ' style="text-align: left; white-space: normal"'
#: Largest number of rows of a table.
ROWS = 6


def of_posture(posture: Posture) -> str:
    """The picture of a posture, and a table of its data."""
    rows = [
        ("mass", f"{posture.mass:g} kg"),
        ("radius of gyration", f"{posture.gyration_radius:g} m"),
        ("centre of mass", f"({_point(posture.center_of_mass)}) m"),
        ("gravity", f"{posture.gravity:g} m/s²"),
    ]
    header = ("contact", "point / m", "slope / rad", "friction", "restitution")
    contacts = [
        (
            f"{number}{' (side)' if number > len(posture.contacts) else ''}",
            f"({_point(contact.point)})",
            plain(contact.slope),
            f"{contact.friction:g}",
            f"{posture.restitution if contact.restitution is None else contact.restitution:g}",
        )
        for number, contact in enumerate(
            [*posture.contacts, *posture.side_contacts], start=1
        )
    ]
    return _beside(picture(posture), _facts(rows) + _table([header, *contacts]))


def of_run(run: Run) -> str:
    """The picture of a run at its end, its outcome, Zeno points and phases, and its report, folded."""
    rows = [
        ("outcome", f"{run.outcome} at {decimal(run.time)} s"),
        ("model", f"{run.model}: {run.model_reason}"),
        ("impacts", f"{run.collisions} one by one"),
        *(("warning", warning) for warning in run.warnings),
    ]
    zeno = [("Zeno point / s", "kind", "contacts", "method", "certified")]
    zeno += [
        (
            decimal(z.time),
            z.kind,
            listed(z.contacts),
            method_named(z),
            "yes" if z.certified else "no",
        )
        for z in run.zeno_points
    ]
    phases = [("mode", "start / s", "end / s")]
    phases += [(p.mode, decimal(p.start), decimal(p.end)) for p in run.phases]
    body = _facts(rows) + "".join(_table(t) for t in (zeno, phases) if len(t) > 1)
    body += f"<details><summary>report</summary>{_text(account(run, 'run'))}</details>"
    if run.posture is None or run.q is None:
        return _beside("", body)
    return _beside(picture(run.posture, run), body)


def of_verdict(verdict: Verdict) -> str:
    """The picture of the posture, if there is one, and the table that `print` has."""
    drawn = "" if verdict.posture is None else picture(verdict.posture)
    return drawn + _text(verdict_table(verdict))


def of_modes(modes: Modes) -> str:
    """The table that `print` has."""
    return _text(modes_table(modes))


def of_system(system: System) -> str:
    """The picture of an assembly, and tables of its data and its bodies."""
    rows = [
        ("bodies", str(len(system.bodies))),
        ("contacts", str(len(system.contacts))),
        ("gravity", f"{system.gravity:g} m/s²"),
    ]
    bodies = [
        (name, f"{body.mass:.4g}", f"({body.center_of_mass[0]:.4g}, {body.center_of_mass[1]:.4g})")
        for name, body in system.bodies.items()
    ]  # fmt: skip
    table = _table([("body", "mass / kg", "centre of mass / m"), *bodies])
    return _beside(system_picture(system), _facts(rows) + table)


def of_system_mode(mode: SystemMode) -> str:
    """The picture of what moves, and the table that `print` has."""
    shown = None if system_holds(mode) else mode
    return _beside(system_picture(mode.system, shown), _text(system_mode_table(mode)))


def of_load_factor(factor: LoadFactor) -> str:
    """Both factors, and the picture of the mode that moves, if there is one."""
    forces, moves = factor_in_words(factor)
    said = _facts([("statics", forces), ("motion", moves)])
    if factor.mode is not None:
        said += _text(system_mode_table(factor.mode))
    return _beside(system_picture(factor.system, factor.mode), said)


class Player:
    """A page in a frame of a cell."""

    def __init__(self, page: str, height: int, name: str):
        self.page: str = page
        self.height: int = height
        self.name: str = name

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{escape(self.page)}" title="{escape(self.name)}" width="100%" height="{self.height}"'
            ' style="border: 0" sandbox="allow-scripts"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<{self.name}>"


def show(
    run: Run, height: int, speed: float | None, clock: Literal["real", "zeno"]
) -> Player:
    """See `Run.show`."""
    if speed is not None:
        run.frame_times(1.0, speed, clock)  # refuses what is no speed of a film
    name = f"Player of a run: {run.outcome} at {run.time} s"
    return Player(film_page(run, name, speed, clock), height, name)


def closed_sides(posture: Posture, run: Run | None) -> dict[int, _Floats]:
    """The corners of the ground (2,) on sides of the body, by the numbers of these contacts: in the nominal posture, or at the end of a
    run."""
    if run is None:
        sides = enumerate(posture.side_contacts, start=len(posture.contacts) + 1)
        return {number: np.array(side.point) for number, side in sides}
    letters = run.phases[-1].mode if run.phases else ""
    return {
        on.number: np.array(on.corner)
        for on, letter in zip(run.contacts, letters, strict=False)
        if on.corner is not None and letter != "S"
    }


def picture(posture: Posture, run: Run | None = None) -> str:
    """An SVG picture of a posture; of a run, at its end, with the path of its centre of mass and in dashes at its start."""
    poses = np.zeros((1, 3))
    if run is not None and run.q is not None:
        poses = run.q[None]
        with suppress(ValueError):  # a run without record
            poses = run.sample(PATH)[1]
    frozen = run is not None and run.model == "local"
    start, end = (body_outline(posture, q, frozen) for q in (poses[0], poses[-1]))
    course = np.array(posture.center_of_mass) + poses[:, :2]
    feet = touching_points(posture, poses[-1], frozen)
    marked = dict(enumerate(feet, start=1)) | closed_sides(posture, run)
    seen = np.vstack([start, end, course, *marked.values()])
    paper = _Paper(seen)
    at, path = paper.at, paper.path
    lines, strips = paper.surface(ground(posture))
    center = at(course[-1])
    marks = []
    for number, (x, y) in zip(
        marked, at(np.array([*marked.values()])).tolist(), strict=True
    ):
        marks.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3"/>')
        beside, below = x + 0.2 * LABEL * np.sign(x - center[0]), y >= center[1] - 1.0
        marks.append(
            f'<text x="{beside:.1f}" y="{y + LABEL if below else y - LABEL / 2:.1f}">{number}</text>'
        )
    drawn = [
        path(*strips, close="Z", fill_opacity=0.25),
        path(*lines, stroke=INK),
        path(end, fill=BODY, fill_opacity=0.4, stroke=INK, stroke_width=1.5),
        *marks,
    ]
    if posture.outline is None:
        lines_of_body = spokes(posture, feet, poses[-1], frozen)
        gaps = np.flatnonzero(np.isnan(lines_of_body[:, 0]))
        arms = np.split(lines_of_body, gaps + 1)[:-1]
        drawn += [
            path(*(arm[:-1] for arm in arms), fill="none", stroke=INK, stroke_width=0.7)
        ]
    if len(poses) > 1:
        drawn[2:2] = [path(start, fill="none", stroke=INK, stroke_dasharray="3 3")]
        drawn += [path(course, fill="none", stroke=COURSE, stroke_width=1.5)]
    drawn += [
        f'<circle cx="{center[0]:.1f}" cy="{center[1]:.1f}" r="4" fill="{COURSE}"/>'
    ]
    return paper.svg(drawn, "The body on its ground")


def system_picture(system: System, mode: SystemMode | None = None) -> str:
    """An SVG picture of an assembly; of a mode, with its bodies moved along their accelerations, and in dashes at rest."""
    rest = [body.outline for body in system.bodies.values()]
    marks = np.array([contact.point for contact in system.contacts]).reshape(-1, 2)
    outlines = rest
    if mode is not None:
        outlines, ends = displaced(mode)
        marks = ends.mean(axis=1)
    paper = _Paper(np.vstack([*rest, *outlines]))
    lines, strips = paper.surface(system_ground(system))
    drawn = [
        paper.path(*strips, close="Z", fill_opacity=0.25),
        paper.path(*lines, stroke=INK),
        paper.path(*outlines, close="Z", fill=BODY, fill_opacity=0.4, stroke=INK),
    ]
    if mode is not None:
        drawn.append(paper.path(*rest, close="Z", fill="none", stroke=INK, stroke_width=0.7, stroke_dasharray="3 3"))  # fmt: skip
    word = "F" * len(marks) if mode is None else mode.word
    for letter, (x, y) in zip(word, paper.at(marks).tolist(), strict=True):
        radius, color = (1.5, INK) if letter == "F" else (3, COURSE)
        drawn.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{color}"/>')
    return paper.svg(drawn, "The bodies and their contacts")


class _Paper:
    """An SVG picture to scale, of all that is near points (n, 2), m."""

    def __init__(self, seen: _Floats):
        low, high = seen.min(axis=0), seen.max(axis=0)
        room = np.array([WIDTH, HEIGHT]) - 2 * MARGIN
        self.scale = float((room / np.maximum(high - low, SMALLEST)).min())
        self.low, self.high = low - MARGIN / self.scale, high + MARGIN / self.scale
        self.width, self.height = (self.high - self.low) * self.scale

    def surface(self, pieces: list[Piece]) -> tuple[list[_Floats], list[_Floats]]:
        return surface(pieces, self.low, self.high, DEPTH / self.scale)

    def at(self, world: _Floats) -> _Floats:
        x, y = (self.scale * (world - self.low)).T
        return np.stack([x, self.height - y], axis=-1)

    def path(self, *parts: _Floats, close: str = "", **look: object) -> str:
        lines = (self.at(part) for part in parts)
        ways = ["M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in line) for line in lines]
        return f'<path d="{"".join(way + close for way in ways)}"{_attributes(look)}/>'

    def svg(self, drawn: Sequence[str], title: str) -> str:
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width:.0f}" height="{self.height:.0f}" viewBox="0 0 {self.width:.1f} {self.height:.1f}" role="img"'
            f' fill="{INK}" font-family="sans-serif" font-size="12" text-anchor="middle" style="flex: none; max-width: 100%">'
            f"<title>{title}</title>{''.join(drawn)}</svg>"
        )


def _attributes(look: dict[str, object]) -> str:
    return "".join(
        f' {name.replace("_", "-")}="{value}"' for name, value in look.items()
    )


def _point(values: tuple[float, float]) -> str:
    return ", ".join(plain(value) for value in values)


def _beside(picture: str, body: str) -> str:
    return (
        '<div style="display: flex; flex-wrap: wrap; gap: 8px 24px; align-items: flex-start">'
        f'{picture}<div style="flex: 1 1 24em; min-width: 0">{body}</div></div>'
    )


def _text(text: str) -> str:
    return f'<pre style="white-space: pre; overflow-x: auto; margin: 0; font-size: 12px; line-height: 1.35">{escape(text)}</pre>'


def _facts(rows: list[tuple[str, str]]) -> str:
    return _cells(
        [f"<th{LEFT}>{escape(a)}</th><td{LEFT}>{escape(b)}</td>" for a, b in rows]
    )


def _table(rows: Sequence[tuple[str, ...]]) -> str:
    """The first rows of a table; the first of them is the header."""
    if len(rows) > ROWS + 1:
        rows = [*rows[: ROWS + 1], (f"and {len(rows) - 1 - ROWS} more",)]
    cells = [
        "".join(f"<{tag}{LEFT}>{escape(cell)}</{tag}>" for cell in row)
        for tag, row in zip(["th"] + ["td"] * len(rows), rows, strict=False)
    ]
    return _cells(cells)


def _cells(rows: list[str]) -> str:
    return f'<table style="margin: 0 0 8px 0">{"".join(f"<tr>{row}</tr>" for row in rows)}</table>'

"""Where is a body in a V stable, and which argument decides? Theorem 3 of the paper (its Fig. 3), and all other arguments.

The V has tan β = 8/15, the two contacts have friction 1/2 and restitution 0.1; the radius of gyration is (a) 0.8, (b) and (c) 0.4,
in half-widths of the V. In (c) jams end by plastic impacts. `python examples/third_figure.py` draws third_figure.png.
"""

import math
import sys

import matplotlib.pyplot as plt
import numpy as np
import standfast as sf
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from standfast.map_plot import COLORS, contacts

#: The panels: radius of gyration, and what ends a jam.
PANELS = {"a": (0.8, "none"), "b": (0.4, "none"), "c": (0.4, "impact")}
#: Colour and text for each argument of a verdict on two contacts. Undecided points are few: in yellow they are seen.
AREAS = {
    "theorem-3": (COLORS["theorem-3"], "stable: Theorem 3, strict reading"),
    "theorem-3-loose": (COLORS["theorem-3-loose"], "stable: Theorem 3"),
    "goyal": (COLORS["goyal"], "stable: Goyal's bound"),
    "corner-map": (COLORS["corner-map"], "stable: corner map"),
    "neutral": (COLORS["neutral"], "stable: every motion ascends, or is level"),
    "accelerating-mode": (COLORS["accelerating-mode"], "unstable: a motion leads away"),
    "growing-cycle": (COLORS["growing-cycle"], "unstable: a cycle grows"),
    "no-solution": (COLORS["no-solution"], "unstable: a contact jams"),
    "undecided": ("#FFFF00", "undecided"),
    "not-equilibrium": ("white", "no forces hold the body"),
}
#: The paper's conditions: drawn where their margins are zero.
LINES = {"clattering_margin": "--", "kinematic_margin": "-"}


def vee(gyration_radius, restitution=0.1):
    """The body in its V."""
    beta = math.atan(8 / 15)
    feet = [
        sf.Contact(point=(side, 8 / 15), slope=side * beta, friction=0.5)
        for side in (-1, 1)
    ]
    return sf.Posture(
        mass=1.0,
        gyration_radius=gyration_radius,
        center_of_mass=(0.0, 0.0),
        contacts=feet,
        restitution=restitution,
    )


def grid(gyration_radius, points, jams="none"):
    """The paper's conditions and the verdict over positions of the centre of mass."""
    return sf.sweep(
        vee(gyration_radius),
        over={
            "center_of_mass.x": np.linspace(-1.3, 1.3, points),
            "center_of_mass.y": np.linspace(-1.0, 3.0, points),
        },
        quantity=[
            "equilibrium",
            "clattering",
            "clattering_margin",
            "kinematic_strong",
            "kinematic_margin",
            "theorem_3",
            "stability",
            "by",
        ],
        jams=jams,
    )


def silent(found):
    """Shares of the equilibria that are undecided: by Theorem 3, and by all tests."""
    equilibria = int(found["equilibrium"].sum())
    before = int((found["equilibrium"] & ~found["theorem_3"]).sum())
    after = int((found["stability"] == "undecided").sum())
    return before / equilibria, after / equilibria


def draw(axes, found, gyration_radius):
    """An area for each argument, lines for the paper's conditions."""
    x, y = (found[f"center_of_mass.{axis}"].values for axis in "xy")
    by = found["by"].values
    picture = np.zeros((*by.shape, 3))
    for word in np.unique(by):
        picture[by == word] = to_rgb(AREAS[word][0])
    axes.imshow(
        picture.swapaxes(0, 1),
        origin="lower",
        extent=(x[0], x[-1], y[0], y[-1]),
        interpolation="nearest",
    )
    for name, style in LINES.items():
        margin = found[name].where(found["equilibrium"]).values.T
        axes.contour(
            x, y, margin, levels=[0], colors="black", linestyles=style, linewidths=1.2
        )
    contacts(axes, found, vee(gyration_radius))
    axes.set_xlim(-1.25, 1.25)


def main(path="third_figure.png", points=300):
    """Draw the panels side by side and print the shares that are undecided."""
    figure, panels = plt.subplots(
        1, len(PANELS), figsize=(11, 7.6), layout="constrained", sharey=True
    )
    seen = set()
    for axes, (part, (radius, jams)) in zip(panels, PANELS.items(), strict=True):
        found = grid(radius, points, jams)
        draw(axes, found, radius)
        seen.update(found["by"].values.flat)
        before, after = silent(found)
        ends = ", jams end by impacts" if jams == "impact" else ""
        axes.set_title(
            f"({part}) ρ = {radius} m{ends}\nundecided by Theorem 3: {100 * before:.1f} %\n"
            f"undecided by all arguments: {100 * after:.2f} %",
            fontsize=11,
        )
        axes.set_xlabel("centre of mass x / m")
        print(
            f"({part}) radius of gyration {radius}{ends}: of all equilibria {100 * before:.1f} % are undecided"
            f" by Theorem 3, {100 * after:.2f} % by all arguments"
        )
    panels[0].set_ylabel("centre of mass y / m")
    handles = [
        Patch(facecolor=color, edgecolor="0.3", label=text)
        for word, (color, text) in AREAS.items()
        if word in seen
    ]
    handles += [
        Line2D(
            [], [], color="black", linestyle="--", label="clattering converges: below"
        ),
        Line2D([], [], color="black", linestyle="-", label="kinematic-strong: inside"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])

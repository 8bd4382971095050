"""Stable positions of the centre of mass: Theorem 3 of the paper (its Fig. 3), and sharper tests.

A body stands in a V of tan β = 8/15 on two contacts with friction 1/2 and restitution 0.1; its radius of gyration
is (a) 0.8, (b) 0.4, in half-widths of the V. `python examples/third_figure.py` draws third_figure.png.
"""

import math
import sys

import matplotlib.pyplot as plt
import numpy as np
import standfast as sf
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from standfast.map_plot import COLORS, contacts

#: Radii of gyration of the two parts.
PARTS = {"a": 0.8, "b": 0.4}
#: Areas of the picture: colour and text.
AREAS = {
    "theorem": (COLORS["theorem-3"], "stable by Theorem 3"),
    "stable": (COLORS["goyal"], "stable by a sharper test"),
    "unstable": (COLORS["unstable"], "unstable: a motion grows"),
    "jams": (COLORS["no-solution"], "unstable: no motion exists"),
    "undecided": (COLORS["undecided"], "undecided"),
    "falls": ("white", "no equilibrium"),
}


def vee(gyration_radius):
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
        restitution=0.1,
    )


def grid(gyration_radius, points):
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
            "kinematic_strong",
            "theorem_3",
            "stability",
            "by",
        ],
    )


def silent(found):
    """Shares of the equilibria that are undecided: by Theorem 3, and by all tests."""
    equilibria = int(found["equilibrium"].sum())
    before = int((found["equilibrium"] & ~found["theorem_3"]).sum())
    after = int((found["stability"] == "undecided").sum())
    return before / equilibria, after / equilibria


def draw(axes, found, part, gyration_radius):
    """Areas for the verdicts, lines for the paper's conditions."""
    x, y = (found[f"center_of_mass.{axis}"].values for axis in "xy")
    equilibrium, theorem = found["equilibrium"].values, found["theorem_3"].values
    verdict = found["stability"].values
    kinds = np.select(
        [
            ~equilibrium,
            theorem,
            verdict == "stable",
            found["by"].values == "no-solution",
            verdict == "unstable",
        ],
        ["falls", "theorem", "stable", "jams", "unstable"],
        "undecided",
    )
    picture = np.zeros((*kinds.shape, 3))
    for kind, (color, _) in AREAS.items():
        picture[kinds == kind] = plt.matplotlib.colors.to_rgb(color)
    extent = (x[0], x[-1], y[0], y[-1])
    axes.imshow(
        picture.swapaxes(0, 1), origin="lower", extent=extent, interpolation="nearest"
    )
    for name, style in (("clattering", "--"), ("kinematic_strong", "-")):
        inside = found[name].values.T.astype(float)
        axes.contour(
            x, y, inside, levels=[0.5], colors="black", linestyles=style, linewidths=1.3
        )
    contacts(axes, found, vee(gyration_radius))
    before, after = silent(found)
    axes.set_title(
        f"({part}) radius of gyration {gyration_radius}\n"
        f"undecided: {100 * before:.1f} % by Theorem 3, {100 * after:.1f} % by all tests"
    )
    axes.set_xlabel("centre of mass x / m")
    axes.set_ylabel("centre of mass y / m")


def main(path="third_figure.png", points=300):
    """Draw both parts side by side and print the shares that are undecided."""
    figure, panels = plt.subplots(1, 2, figsize=(11, 9), layout="constrained")
    for axes, (part, gyration_radius) in zip(panels, PARTS.items(), strict=True):
        found = grid(gyration_radius, points)
        draw(axes, found, part, gyration_radius)
        before, after = silent(found)
        print(
            f"({part}) radius of gyration {gyration_radius}: of all equilibria {100 * before:.1f} % are undecided"
            f" by Theorem 3, {100 * after:.1f} % by all tests"
        )
    handles = [
        Patch(facecolor=color, edgecolor="0.3", label=text)
        for color, text in AREAS.values()
    ]
    handles += [
        Line2D([], [], color="black", linestyle="-", label="kinematic-strong: inside"),
        Line2D(
            [], [], color="black", linestyle="--", label="clattering converges: below"
        ),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])

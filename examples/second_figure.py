"""Bounds on the coupling ψ over the restitution e (Fig. 2 of the paper), and the end of the impacts on either side.

Two contacts of equal gravity start from the same state for every e and ψ. The picture shows the first Zeno point and its
method under both bounds. `python examples/second_figure.py` draws second_figure.png.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import standfast as sf
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

#: Contact 1 has just been hit. Contact 2 comes down so fast that gravity has little effect before its impact.
START = {"gaps": (0.0, 1e-3), "rates": (0.1, -1.0)}
#: Kind and method of the first Zeno point; colours after Okabe and Ito.
KINDS = {
    ("2-zeno", "clatter"): ("#0072B2", "both contacts, clattering"),
    ("2-zeno", "self-similar"): ("#009E73", "both contacts, self-similar"),
    ("2-zeno", "mixed"): ("#CC79A7", "both contacts, no pattern seen"),
    ("2-zeno", "nested"): ("#E69F00", "both contacts, nested"),
    ("1-zeno", "bounce"): ("#D9D9D9", "one contact, bouncing"),
}
#: Between this curve and clattering convergence the self-similar orbit attracts its neighbours.
STABLE = "self-similar orbit stable: above"


def clattering(e):
    """Above this coupling clattering converges: (10) of the paper."""
    return (np.cbrt(e) + np.cbrt(e) ** 2) / (1 + e)


def chatter(e):
    """Above this coupling impacts without gravity never end: Goyal's bound."""
    return 2 * np.sqrt(e) / (1 + e)


def fate(e, psi):
    """Kind and method of the first Zeno point."""
    local = sf.LocalModel(gravity=(1, 1), psi=(psi, psi), phi=(0, 0), restitution=e)
    run = local.simulate(**START, stop="zeno", record=False)
    return run.zeno_points[0].kind, run.zeno_points[0].method


def fates(points):
    """Restitutions, couplings, and the index in `KINDS` of the fate at each pair."""
    middles = (np.arange(points) + 0.5) / points
    kinds = list(KINDS)
    return (
        middles,
        middles,
        np.array([[kinds.index(fate(e, psi)) for psi in middles] for e in middles]),
    )


def main(path="second_figure.png", points=100):
    """Draw the bounds over the fates."""
    e, psi, found = fates(points)
    figure, axes = plt.subplots(figsize=(8, 7), layout="constrained")
    colors = [color for color, _ in KINDS.values()]
    axes.pcolormesh(
        e, psi, found.T, cmap=ListedColormap(colors), vmin=-0.5, vmax=len(KINDS) - 0.5
    )
    fine = np.linspace(0, 1, 500)
    axes.plot(fine, clattering(fine), color="black", linewidth=2)
    axes.plot(fine, chatter(fine), color="black", linestyle="--", linewidth=2)
    inner = fine[1:-1]
    stable = [sf.theory.neimark_sacker(float(x)) for x in inner]
    axes.plot(inner, stable, color="black", linestyle=":", linewidth=2)
    axes.set(
        xlim=(0, 1), ylim=(0, 1), xlabel="restitution e", ylabel="coupling ψ", aspect=1
    )
    handles = [
        Line2D([], [], color="black", linewidth=2, label="clattering converges: above"),
        Line2D([], [], color="black", linestyle="--", label="Goyal's bound"),
        Line2D([], [], color="black", linestyle=":", label=STABLE),
    ]
    for code, (color, text) in enumerate(KINDS.values()):
        if (found == code).any():
            handles.append(Patch(facecolor=color, edgecolor="0.3", label=text))
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])

"""Where the shape of clattering is chaotic: the largest Lyapunov exponent over restitution e and coupling ψ.

Below clattering convergence impacts on two contacts of equal gravity shrink for ever or end on one contact. Divided by their size
they approach a fixed shape or a cycle, or never repeat: chaos, with Λ_1 > 0. `python examples/shape_chaos.py` draws
shape_chaos.png.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import standfast as sf
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

#: States right after an impact at contact 1: gap and rate of contact 2 for a speed of 1 m/s at 1 m/s².
STARTS = [(0.3, -1.0), (0.1, 0.5), (0.05, -1.9), (1.5, 0.2)]
#: Number of impacts over which the exponents are taken, after as many that are not counted.
IMPACTS = 4000
#: Λ_1 above this is chaos. For shapes that repeat Λ_1 is negative, or zero within the scatter of so many impacts.
CHAOS = 0.01
#: Colours after Okabe and Ito.
REPEATS, ENDS = "#56B4E9", "#D9D9D9"


def largest_exponent(e, psi):
    """Λ_1 per impact, the largest over the starts whose impacts do not end; NaN where all end on one contact."""
    local = sf.LocalModel(gravity=(1, 1), psi=(psi, psi), phi=(0, 0), restitution=e)
    found = (
        local.exponents((0, gap), (1, rate), n=IMPACTS, transient=IMPACTS)
        for gap, rate in STARTS
    )
    return max(
        (orbit.lyapunov[0] for orbit in found if orbit.end is None), default=np.nan
    )


def chaos(points, restitutions=(0.6, 1.0), couplings=(0.0, 0.8)):
    """Restitutions, couplings, and Λ_1 at each pair."""
    middles = (np.arange(points) + 0.5) / points
    e = restitutions[0] + middles * np.ptp(restitutions)
    psi = couplings[0] + middles * np.ptp(couplings)
    return e, psi, np.array([[largest_exponent(x, y) for y in psi] for x in e])


def main(path="shape_chaos.png", points=120):
    """Draw Λ_1 where there is chaos, the other cases as areas, and the curve known in closed form."""
    e, psi, found = chaos(points)
    figure, axes = plt.subplots(figsize=(8, 6.5), layout="constrained")
    axes.set_facecolor(ENDS)
    with np.errstate(invalid="ignore"):
        chaotic = found > CHAOS
    repeats = np.ma.masked_where(chaotic | np.isnan(found), np.zeros_like(found))
    axes.pcolormesh(e, psi, repeats.T, cmap=ListedColormap([REPEATS]))
    grows = np.ma.masked_where(~chaotic, found)
    image = axes.pcolormesh(e, psi, grows.T, cmap="YlOrBr", vmin=0.0, vmax=0.4)
    figure.colorbar(image, ax=axes, label="$Λ_1$ per impact, where shapes are chaotic")
    fine = np.linspace(0.6, 1, 400, endpoint=False)
    curve = [sf.theory.neimark_sacker(float(x)) for x in fine]
    axes.plot(fine, curve, color="black", linewidth=2)
    axes.set(xlim=(0.6, 1), ylim=(0, 0.8), xlabel="restitution e", ylabel="coupling ψ")
    handles = [
        Patch(facecolor=plt.get_cmap("YlOrBr")(0.7), label="chaotic shapes"),
        Patch(facecolor=REPEATS, label="shapes that repeat"),
        Patch(facecolor=ENDS, label="impacts end on one contact"),
        Line2D(
            [],
            [],
            color="black",
            linewidth=2,
            label="self-similar shape loses its stability",
        ),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])

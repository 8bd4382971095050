"""Where may the quadruped A1 put its front feet on bumps, and where may its trunk be meanwhile?

10 000 postures under torques that hold them, with their verdicts. `python examples/footholds.py` draws footholds.png. Needs the extras `robots`
and `plot`, with example-robot-data.
"""

import math
import sys
import time
from importlib.metadata import files

import matplotlib.pyplot as plt
import numpy as np
import pinocchio as pin
import standfast as sf
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch
from standfast.colors import COLORS

urdf = next(str(f.locate()) for f in files("example-robot-data") if f.name == "a1.urdf")
# fmt: off
# the robot
robot = sf.robots.sagittal(pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer()))

def leg(along, up):                                    # hip and knee for a foot there: both parts are 0.2 m long
    knee = -2 * math.acos(math.hypot(along, up) / 0.4)
    return math.atan2(-along, -up) - knee / 2, knee

def posture(x, trunk):                                 # front feet at x on bumps, rear feet at 0, hips 0.1805 m before and behind the middle
    height, slope = 0.05 * math.sin(20 * x), math.atan(math.cos(20 * x))
    front, rear = (x - trunk - 0.1805, height - 0.33), (0.1805 - trunk, -0.33)
    if max(math.hypot(*front), math.hypot(*rear)) >= 0.4:
        return None                                    # out of reach
    q = robot.q(trunk, 0.33, joints=[*leg(*front), *leg(*rear)])
    return sf.robots.from_pinocchio(robot, robot.data, q, ["FL_foot", "RL_foot"], ground={"FL_foot": (slope, 0.8)}, friction=0.8, torques="holding", armature=0.003)

def verdicts(footholds, trunks):
    return sf.stability(np.array([[posture(x, trunk) for x in footholds] for trunk in trunks]))
# the map
# fmt: on

#: Colours and texts of the verdicts.
AREAS = {
    "stable": (COLORS["stable"], "stable: proved"),
    "undecided": (COLORS["undecided"], "open: no way to fall found"),
    "no-solution": (COLORS["no-solution"], "unstable: a sliding foot jams"),
    "accelerating-mode": (COLORS["accelerating-mode"], "unstable: leaves its place"),
    "not-equilibrium": (COLORS["not-equilibrium"], "unstable: forces do not hold it"),
}


def word(verdict):
    """The key in `AREAS` of a verdict; None for None."""
    word = verdict and verdict.frictional_stability
    return verdict.by if word == "unstable" else word


def main(path="footholds.png", points=160):
    """Draw the map over footholds and places of the trunk."""
    footholds = np.linspace(-0.05, 0.7, points)
    trunks = np.linspace(-0.06, 0.44, points * 7 // 8)
    start = time.perf_counter()
    words = [[word(verdict) for verdict in row] for row in verdicts(footholds, trunks)]
    count = sum(found is not None for row in words for found in row)
    print(f"{count} postures in {time.perf_counter() - start:.1f} s")
    picture = [[to_rgb(AREAS[f][0] if f else "white") for f in row] for row in words]
    figure, (axes, below) = plt.subplots(2, 1, figsize=(8, 8.6), layout="constrained", height_ratios=[0.5, 0.42])  # fmt: skip
    axes.pcolormesh(footholds, trunks, np.array(picture), shading="nearest")
    axes.set(ylabel="middle of the trunk x / m", xlim=(-0.2, 0.7), aspect="equal")
    axes.set_title("A1 on bumps, friction 0.8, trunk 0.33 m above its rear feet")
    x, trunk = 0.4, 0.18
    axes.plot(x, trunk, "x", color="white", markersize=8, markeredgewidth=2)
    ground = np.linspace(-0.2, 0.7, 300)
    bumps = np.where(ground > footholds[0], 0.05 * np.sin(20 * ground), np.nan)
    below.plot(ground, bumps, color="0.3", linewidth=2)
    below.plot([-0.2, 0.05], [0, 0], color="0.3", linewidth=2, linestyle="--")
    for hip, foot in (
        (trunk - 0.1805, (0.0, 0.0)),
        (trunk + 0.1805, (x, 0.05 * math.sin(20 * x))),
    ):
        angle, _ = leg(foot[0] - hip, foot[1] - 0.33)
        knee = hip - 0.2 * math.sin(angle), 0.33 - 0.2 * math.cos(angle)
        below.plot(*zip((hip, 0.33), knee, foot, strict=True), "o-", color="black")
    below.plot(
        [trunk - 0.1805, trunk + 0.1805], [0.33, 0.33], color="black", linewidth=4
    )
    below.set(xlabel="foothold of the front feet x / m", ylabel="height / m")
    below.set(xlim=(-0.2, 0.7), ylim=(-0.06, 0.36), aspect="equal")
    seen = {found for row in words for found in row}
    handles = [
        Patch(facecolor=color, edgecolor="0.3", label=text)
        for key, (color, text) in AREAS.items()
        if key in seen
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])

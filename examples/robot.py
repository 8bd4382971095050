"""Robots from URDF files: where may the trunk of Solo 8 be, with locked joints and with joints under torques?

The robots move in the plane of x and z, left and right legs together. Torques hold the posture. A foot that slides may then jam
(Painlevé) although the robot stands with locked joints: a leg under torques gives way. The rotors of the motors, reflected through their
gears (armature), prevent it. `python examples/robot.py` draws robot.png for the quadruped Solo 8 and prints the armature at which
verdicts change. Needs the extra `robots`: pin and, for Solo 8, example-robot-data (131 MB); without the latter it ends after its biped.
"""

import math
import sys
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pinocchio as pin
import standfast as sf
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch
from standfast.colors import COLORS

FOLDER = Path(__file__).parent
#: Ground, friction and trunk of the map: the feet below the hips, 0.38 m apart on level ground.
FRICTION, FEET = 0.8, ((0.19, 0.0), (-0.19, 0.0))
#: Length of both parts of a leg of Solo 8 and distance of its hips from the middle of the trunk, in m.
LEG, HIP = 0.16, 0.19
#: Places of the trunk whose armature is varied: its x and z, in m.
PLACES = {"A": (0.0, 0.31), "B": (0.17, 0.25)}
#: The panels of the map: title, locked joints, and armature in kg m² at each joint.
PANELS = (
    ("joints locked", "all", 0.0),
    ("torques, no armature", (), 0.0),
    ("torques, armature 0.001 kg m²", (), 0.001),
    ("torques, armature 0.01 kg m²", (), 0.01),
)
#: Colours and texts of the verdicts.
AREAS = {
    "stable": (COLORS["stable"], "stable: proved"),
    "undecided": (COLORS["undecided"], "open: no way to fall found"),
    "no-solution": (COLORS["no-solution"], "unstable: a sliding foot jams"),
    "accelerating-mode": (COLORS["accelerating-mode"], "unstable: leaves its place"),
    "not-equilibrium": (COLORS["not-equilibrium"], "unstable: forces do not hold it"),
}


def biped_that_jams(armature=0.0, locked=()):
    """A trunk and two straight legs, as wide as they can be. Angles about +y turn x to −z: with the opposite sign of counterclockwise ones."""
    base = pin.JointModelComposite()
    for part in (pin.JointModelPX(), pin.JointModelPZ(), pin.JointModelRY()):
        base.addJoint(part)
    model = pin.buildModelFromUrdf(str(FOLDER / "mechanisms" / "biped.urdf"), base)
    return sf.robots.from_pinocchio(
        model,
        model.createData(),
        [0, 0, 0.166, 0.325, -0.841],
        ["left_foot", "right_foot"],
        ground={"left_foot": (-0.066, 0.667), "right_foot": (-0.091, 0.667)},
        locked=locked,
        torques="holding",
        armature=armature,
    )


def solo():
    """The quadruped Solo 8 in its plane of symmetry; None where its URDF is not installed."""
    try:
        urdf = next(
            f for f in files("example-robot-data") or () if f.name == "solo.urdf"
        )
    except PackageNotFoundError:
        return None
    model = pin.buildModelFromUrdf(str(urdf.locate()), pin.JointModelFreeFlyer())
    return sf.robots.sagittal(model)


def stance(robot, x, z):
    """q of Solo 8 with a level trunk at (x, z), its feet at `FEET` and its knees inwards; None: out of reach."""
    angles = []
    for side, (foot, height) in zip((1, -1), FEET, strict=True):
        along, down = foot - (x + side * HIP), z - height
        reach = math.hypot(along, down)
        if reach >= 2 * LEG:
            return None
        knee = -side * 2 * math.acos(reach / (2 * LEG))
        angles += [math.atan2(-along, down) - 0.5 * knee, knee]
    return robot.q(x, z, joints=angles)


def standing(robot, q, friction=FRICTION, locked=(), armature=0.0):
    """Solo 8 on level ground, under torques that hold it or with locked joints."""
    return sf.robots.from_pinocchio(
        robot,
        robot.data,
        q,
        ["FL_FOOT", "HL_FOOT"],
        friction=friction,
        locked=locked,
        torques="holding",
        armature=armature,
    )


def word(mechanism):
    """The key in `AREAS` of the verdict."""
    verdict = sf.stability(mechanism)
    word = verdict.frictional_stability
    return verdict.by if word == "unstable" else word


def thresholds(of, lowest=1e-5, highest=1e3):
    """The armatures between `lowest` and `highest` at which the verdict on `of(armature)` changes, to the last bit."""
    scan = np.geomspace(lowest, highest, 81)
    words = [word(of(armature)) for armature in scan]
    found = []
    for k in np.flatnonzero(np.array(words[1:]) != np.array(words[:-1])):
        low, high = scan[k], scan[k + 1]
        while low < (middle := 0.5 * (low + high)) < high:
            if word(of(middle)) == words[k]:
                low = middle
            else:
                high = middle
        found.append((high, words[k], word(of(high))))
    return found


def corners(robot, q):
    """The points of the left legs in x and z: front foot, knee, hip, hind hip, knee, foot."""
    pin.framesForwardKinematics(robot.model, robot.data, q)
    names = ("FL_FOOT", "FL_KFE", "FL_HFE", "HL_HFE", "HL_KFE", "HL_FOOT")
    places = [robot.data.oMf[robot.model.getFrameId(name)] for name in names]
    return np.array([place.translation[[0, 2]] for place in places])


def grid(robot, points):
    """Places x, z of the trunk, and for each panel a picture of the verdicts; white: out of reach."""
    x, z = np.linspace(-0.2, 0.2, points), np.linspace(0.08, 0.33, points * 5 // 8)
    pictures = np.ones((len(PANELS), len(z), len(x), 3))
    seen = set()
    for j, height in enumerate(z):
        for k, place in enumerate(x):
            q = stance(robot, place, height)
            if q is None:
                continue
            for picture, (_, locked, armature) in zip(pictures, PANELS, strict=True):
                found = word(standing(robot, q, FRICTION, locked, armature))
                picture[j, k] = to_rgb(AREAS[found][0])
                seen.add(found)
    return x, z, pictures, seen


def main(path="robot.png", points=96):
    """Print the thresholds; draw maps of Solo 8: over places of its trunk, and over armature and friction at two of them."""
    print("biped, legs wide:")
    report(biped_that_jams)
    robot = solo()
    if robot is None:
        print("Solo 8 needs example-robot-data: pip install pin example-robot-data")
        return
    print(f"Solo 8, {pin.computeTotalMass(robot.model):.3f} kg, friction {FRICTION}:")
    figure, panels = plt.subplots(3, 2, figsize=(9, 11.5), layout="constrained")
    panels = panels.ravel()
    x, z, pictures, seen = grid(robot, points)
    for axes, picture, (title, locked, _) in zip(
        panels, pictures, PANELS, strict=False
    ):
        axes.imshow(
            picture,
            origin="lower",
            extent=(x[0], x[-1], z[0], z[-1]),
            interpolation="nearest",
        )
        axes.plot([-0.3, 0.3], [0, 0], color="black", linewidth=2)
        axes.set(xlim=(-0.27, 0.27), ylim=(-0.02, 0.37), title=title)
        axes.set(xlabel="middle of the trunk x / m", ylabel="z / m")
        if locked:
            line = corners(robot, stance(robot, 0.0, 0.22))
            axes.plot(*line.T, "o-", color="black", linewidth=2, markersize=4)
        for name, place in PLACES.items():
            axes.plot(*place, "x", color="black", markersize=7, markeredgewidth=2)
            axes.annotate(
                name, place, (4, 4), textcoords="offset points", weight="bold"
            )
    for axes, (name, place) in zip(panels[len(PANELS) :], PLACES.items(), strict=True):
        print(f"trunk at {name} = {place} m:")
        seen |= draw_armatures(axes, robot, stance(robot, *place), points)
        axes.set_title(f"trunk at {name}: torques, armature and friction")
    handles = [
        Patch(facecolor=color, edgecolor="0.3", label=text)
        for key, (color, text) in AREAS.items()
        if key in seen
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    figure.suptitle(
        f"Solo 8 on level ground, friction {FRICTION}: where may its trunk be?"
    )
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_armatures(axes, robot, q, points):
    """The verdicts over armature and friction, with the armatures at which they change at `FRICTION`; the verdicts that occur."""

    def of(armature=0.0, locked=(), friction=FRICTION):
        return standing(robot, q, friction, locked, armature)

    armatures = np.geomspace(1e-5, 1, points)
    frictions = np.linspace(0.2, 1.4, points * 5 // 8)
    words = [[word(of(a, friction=mu)) for a in armatures] for mu in frictions]
    picture = np.array([[to_rgb(AREAS[found][0]) for found in row] for row in words])
    axes.pcolormesh(armatures, frictions, picture, shading="nearest")
    axes.axhline(FRICTION, color="black", linewidth=0.8)
    for k, (armature, *_) in enumerate(report(of)):
        axes.plot(armature, FRICTION, "o", color="white", markeredgecolor="black")
        axes.annotate(
            f"{armature:.3g}",
            (armature, FRICTION),
            (0, -16 if k % 2 == 0 else 8),
            textcoords="offset points",
            ha="center",
        )
    axes.set(xscale="log", xlabel="armature of each joint / kg m²", ylabel="friction")
    return set(np.ravel(words))


def report(of):
    """Print the verdicts of a robot, locked, under torques alone and at its thresholds; these."""
    print(f"  joints locked         {sf.stability(of(locked='all'))!r}")
    print(f"  torques, no armature  {sf.stability(of())!r}")
    changes = thresholds(of)
    for armature, before, after in changes:
        print(f"  armature {armature:.12f} kg m²: {before} -> {after}")
    return changes


if __name__ == "__main__":
    main(*sys.argv[1:2])

"""Robots from URDF files: M, h and J by Pinocchio, the verdict by standfast, with locked joints and with joints under torques.

The robots move in the plane of x and z, left and right legs together. Torques hold the posture. A foot that slides may then jam
(Painlevé) although the robot stands with locked joints: a leg under torques gives way. The rotors of the motors, reflected through their
gears (armature), prevent it. `python examples/robot.py` draws robot.png for the quadruped Solo 8 and prints the armature at which
verdicts change. Needs the extra `robots`: pin and, for Solo 8, example-robot-data (131 MB); without the latter it ends after its biped.
"""

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
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
#: The panels of the map: title, locked joints, and armature in kg m² at each joint (of a leg; left and right have twice as much).
PANELS = (
    ("joints locked", True, 0.0),
    ("torques, no armature", False, 0.0),
    ("torques, armature 0.001 kg m²", False, 0.001),
    ("torques, armature 0.01 kg m²", False, 0.01),
)
#: Colours and texts of the verdicts.
AREAS = {
    "stable": (COLORS["stable"], "stable: proved"),
    "undecided": (COLORS["undecided"], "open: no way to fall found"),
    "no-solution": (COLORS["no-solution"], "unstable: a sliding foot jams"),
    "accelerating-mode": (COLORS["accelerating-mode"], "unstable: leaves its place"),
    "not-equilibrium": (COLORS["not-equilibrium"], "unstable: forces do not hold it"),
}


@dataclass
class Robot:
    """A robot in the plane of x and z. q = (x, z, pitch, joints): joints of a group have equal angles, feet of a group touch together."""

    urdf: Path
    joints: Sequence[Sequence[str]]
    feet: Sequence[Sequence[str]]
    model: pin.Model = field(init=False)
    S: np.ndarray = field(init=False)

    def __post_init__(self):
        # Three joints instead of the free flyer of Pinocchio: its velocities are in axes of the trunk, these in axes of the world.
        base = pin.JointModelComposite()
        for part in (pin.JointModelPX(), pin.JointModelPZ(), pin.JointModelRY()):
            base.addJoint(part)
        self.model = pin.buildModelFromUrdf(str(self.urdf), base)
        self.data = self.model.createData()
        # q̇ of Pinocchio = S q̇: constant, so that SᵀMS, Sᵀh and JS are those of the robot in the plane.
        self.S = np.zeros((self.model.nv, 3 + len(self.joints)))
        self.S[:3, :3] = np.eye(3)
        for column, group in enumerate(self.joints, start=3):
            for name in group:
                self.S[self.model.joints[self.model.getJointId(name)].idx_v, column] = 1

    def dynamics(self, q):
        """M (dof, dof), h (dof) at rest, and of each foot J (2, dof): its velocity along x and z."""
        whole = self.S @ q
        M = self.S.T @ pin.crba(self.model, self.data, whole) @ self.S
        h = self.S.T @ pin.computeGeneralizedGravity(self.model, self.data, whole)
        pin.computeJointJacobians(self.model, self.data, whole)
        pin.updateFramePlacements(self.model, self.data)
        frames = pin.LOCAL_WORLD_ALIGNED
        J = [
            np.mean([self.jacobian(name, frames)[[0, 2]] for name in group], axis=0)
            for group in self.feet
        ]
        return 0.5 * (M + M.T), h, J  # symmetric to the last bit

    def jacobian(self, foot, frames):
        """J (6, dof) of a foot: linear, then angular velocity."""
        frame = self.model.getFrameId(foot)
        return pin.getFrameJacobian(self.model, self.data, frame, frames) @ self.S

    def mechanism(self, q, slopes, friction, locked=False, armature=0.0):
        """The robot with its feet on ground of `slopes`, under torques that hold it or with locked joints; None: no torques hold it."""
        M, h, J = self.dynamics(q)
        t = [np.array([math.cos(slope), math.sin(slope)]) for slope in slopes]
        n = [np.array([-math.sin(slope), math.cos(slope)]) for slope in slopes]
        rows = [
            sf.ContactRows(ni @ Ji, ti @ Ji, friction=friction)
            for ni, ti, Ji in zip(n, t, J, strict=True)
        ]
        held = holding(h, rows)
        if held is None:
            return None
        load = -h
        load[3:] += held[0]
        joints = range(3, len(h))
        rotors = np.zeros(len(h))
        rotors[3:] = [armature * len(group) for group in self.joints]
        return sf.Mechanism(
            M, load, rows, locked=joints if locked else (), armature=rotors
        )


def holding(h, rows):
    """Torques τ and forces f with Bτ + Jᵀf = h for one internal force: the middle of those that keep f in the friction cones.

    B selects the joints, all coordinates but three. One of the forces of two contacts is free.
    """
    J = np.array([row for foot in rows for row in (foot.tangential, foot.normal)])
    A = np.hstack([np.eye(len(h))[:, 3:], J.T])
    least = np.linalg.lstsq(A, h, rcond=None)[0]
    internal = np.linalg.svd(A)[2][-1]
    joints = len(h) - 3
    low, high = -math.inf, math.inf
    for i, foot in enumerate(rows):
        for side in (-1, 1):
            # spare + s slope ≥ 0: friction left on one side of the cone
            edge = np.zeros(A.shape[1])
            edge[joints + 2 * i : joints + 2 * i + 2] = side, foot.friction
            spare, slope = edge @ least, edge @ internal
            if slope > 0:
                low = max(low, -spare / slope)
            elif slope < 0:
                high = min(high, -spare / slope)
    if low > high or not math.isfinite(low + high):
        return None
    x = least + 0.5 * (low + high) * internal
    return x[:joints], x[joints:]


def word(mechanism):
    """The key in `AREAS` of the verdict."""
    if mechanism is None:
        return "not-equilibrium"
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


def biped():
    """A trunk and two straight legs."""
    return Robot(
        FOLDER / "mechanisms" / "biped.urdf",
        [["left_hip"], ["right_hip"]],
        [["left_foot"], ["right_foot"]],
    )


def biped_that_jams(armature=0.0, locked=False):
    """Its legs as wide as they can be. Angles about +y turn x to −z: with the opposite sign of counterclockwise ones."""
    q = [0, 0, 0.166, 0.325, -0.841]
    return biped().mechanism(q, (-0.066, -0.091), 0.667, locked, armature)


def solo():
    """The quadruped Solo 8; None where its URDF is not installed."""
    try:
        urdf = next(
            f for f in files("example-robot-data") or () if f.name == "solo.urdf"
        )
    except PackageNotFoundError:
        return None
    joints = [
        (f"{leg}L_{joint}", f"{leg}R_{joint}")
        for leg in "FH"
        for joint in ("HFE", "KFE")
    ]
    return Robot(
        Path(urdf.locate()), joints, [("FL_FOOT", "FR_FOOT"), ("HL_FOOT", "HR_FOOT")]
    )


def stance(x, z):
    """q of Solo 8 with a level trunk at (x, z), its feet at `FEET` and its knees inwards; None: out of reach."""
    q = [x, z, 0.0]
    for side, (foot, height) in zip((1, -1), FEET, strict=True):
        along, down = foot - (x + side * HIP), z - height
        reach = math.hypot(along, down)
        if reach >= 2 * LEG:
            return None
        knee = -side * 2 * math.acos(reach / (2 * LEG))
        q += [math.atan2(-along, down) - 0.5 * knee, knee]
    return q


def corners(robot, q):
    """The points of the left legs in x and z: front foot, knee, hip, hind hip, knee, foot."""
    pin.framesForwardKinematics(robot.model, robot.data, robot.S @ q)
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
            q = stance(place, height)
            if q is None:
                continue
            for picture, (_, locked, armature) in zip(pictures, PANELS, strict=True):
                found = word(robot.mechanism(q, (0, 0), FRICTION, locked, armature))
                picture[j, k] = to_rgb(AREAS[found][0])
                seen.add(found)
    return x, z, pictures, seen


def main(path="robot.png", points=96):
    """Print the thresholds; draw maps of Solo 8: over places of its trunk, and over armature and friction at two of them."""
    print("biped, legs wide:")
    report(biped_that_jams)
    robot = solo()
    if robot is None:
        print("Solo 8 needs example-robot-data: pip install 'standfast[robots]'")
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
            line = corners(robot, stance(0.0, 0.22))
            axes.plot(*line.T, "o-", color="black", linewidth=2, markersize=4)
        for name, place in PLACES.items():
            axes.plot(*place, "x", color="black", markersize=7, markeredgewidth=2)
            axes.annotate(
                name, place, (4, 4), textcoords="offset points", weight="bold"
            )
    for axes, (name, place) in zip(panels[len(PANELS) :], PLACES.items(), strict=True):
        print(f"trunk at {name} = {place} m:")
        seen |= draw_armatures(axes, robot, stance(*place), points)
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

    def of(armature=0.0, locked=False, friction=FRICTION):
        return robot.mechanism(q, (0, 0), friction, locked, armature)

    armatures = np.geomspace(1e-5, 1, points)
    frictions = np.linspace(0.2, 1.4, points * 5 // 8)
    words = [[word(of(a, friction=mu)) for a in armatures] for mu in frictions]
    picture = np.array([[to_rgb(AREAS[found][0]) for found in row] for row in words])
    axes.pcolormesh(armatures, frictions, picture, shading="nearest")
    axes.axhline(FRICTION, color="black", linewidth=0.8)
    for armature, *_ in report(of):
        axes.plot(armature, FRICTION, "o", color="white", markeredgecolor="black")
        axes.annotate(
            f"{armature:.3g}",
            (armature, FRICTION),
            (0, -16),
            textcoords="offset points",
            ha="center",
        )
    axes.set(xscale="log", xlabel="armature of each joint / kg m²", ylabel="friction")
    return set(np.ravel(words))


def report(of):
    """Print the verdicts of a robot, locked, under torques alone and at its thresholds; these."""
    print(f"  joints locked         {sf.stability(of(locked=True))!r}")
    print(f"  torques, no armature  {sf.stability(of())!r}")
    changes = thresholds(of)
    for armature, before, after in changes:
        print(f"  armature {armature:.12f} kg m²: {before} -> {after}")
    return changes


if __name__ == "__main__":
    main(*sys.argv[1:2])

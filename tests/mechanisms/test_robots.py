"""Robots of Pinocchio and MuJoCo: beside matrices made by hand, beside differences of postures, and beside each other; wrong inputs."""

import copy
import importlib.metadata
import math
import pickle
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import standfast as sf

pin = pytest.importorskip("pinocchio")

ROOT = Path(__file__).parents[2]
BIPED = ROOT / "examples" / "mechanisms" / "biped.urdf"
#: Rounding errors of some hundred operations, relative to the largest entry.
CLOSE = 1e-12
#: Central differences of 1e-5 of lengths of a metre: 1e-16 / 1e-5, and their squares.
DIFFERENCES = 2e-9


def urdf(name):
    try:
        files = importlib.metadata.files("example-robot-data") or ()
    except importlib.metadata.PackageNotFoundError:
        files = ()
    for file in files:
        # Other folders have robots of the same name.
        if file.name == name and file.parent.name in ("robots", "urdf"):
            return str(file.locate())
    pytest.skip("example-robot-data is not installed")
    return None


def planar_base():
    base = pin.JointModelComposite()
    for part in (pin.JointModelPX(), pin.JointModelPZ(), pin.JointModelRY()):
        base.addJoint(part)
    return base


def in_space(name):
    return pin.buildModelFromUrdf(urdf(name), pin.JointModelFreeFlyer())


def relative(found, expected):
    return np.abs(found - expected).max() / np.abs(expected).max()


# By hand: the base of three joints, S with a column for each group of joints, and the middle of the torques that hold two feet.


class ByHand:
    def __init__(self, path, groups, feet):
        self.model = pin.buildModelFromUrdf(str(path), planar_base())
        self.data, self.groups, self.feet = self.model.createData(), groups, feet
        self.S = np.zeros((self.model.nv, 3 + len(groups)))
        self.S[:3, :3] = np.eye(3)
        for column, group in enumerate(groups, start=3):
            for name in group:
                joint = self.model.joints[self.model.getJointId(name)]
                self.S[joint.idx_v, column] = 1

    def mechanism(self, q, slopes, friction, locked, armature, held=True):
        model, data, S = self.model, self.data, self.S
        M = S.T @ pin.crba(model, data, S @ q) @ S
        h = S.T @ pin.computeGeneralizedGravity(model, data, S @ q)
        pin.computeJointJacobians(model, data, S @ q)
        rows = []
        for slope, group in zip(slopes, self.feet, strict=True):
            frames = [model.getFrameId(name) for name in group]
            J = np.mean([pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)[[0, 2]] @ S for frame in frames], axis=0)  # fmt: skip
            t = np.array([math.cos(slope), math.sin(slope)])
            rows.append(([-t[1], t[0]] @ J, t @ J))
        load = -h
        if held:
            load[3:] += self.middle(h, rows, friction)
        # The pitch counterclockwise.
        sign = np.ones(len(h))
        sign[2] = -1
        rotors = np.zeros(len(h))
        rotors[3:] = [armature * len(group) for group in self.groups]
        return sf.Mechanism(
            0.5 * (M + M.T) * sign * sign[:, None],
            load * sign,
            [sf.ContactRows(N * sign, T * sign, friction=friction) for N, T in rows],
            locked=range(3, len(h)) if locked else (),
            armature=rotors,
        )

    def middle(self, h, rows, friction):
        A = np.hstack([np.eye(len(h))[:, 3:], np.array([[T, N] for N, T in rows]).reshape(4, -1).T])  # fmt: skip
        least, internal = np.linalg.lstsq(A, h, rcond=None)[0], np.linalg.svd(A)[2][-1]
        joints, ends = len(h) - 3, [[], []]
        for i in range(2):
            for side in (-1, 1):
                edge = np.zeros(A.shape[1])
                edge[joints + 2 * i : joints + 2 * i + 2] = side, friction
                slope = edge @ internal
                ends[int(slope < 0)].append(-(edge @ least) / slope)
        return (least + 0.5 * (max(ends[0]) + min(ends[1])) * internal)[:joints]


LEGS = [(f"{leg}L_{joint}", f"{leg}R_{joint}") for leg in "FH" for joint in ("HFE", "KFE")]  # fmt: skip
SOLO_FEET = [("FL_FOOT", "FR_FOOT"), ("HL_FOOT", "HR_FOOT")]


def solo_by_hand():
    return ByHand(urdf("solo.urdf"), LEGS, SOLO_FEET)


def biped_by_hand():
    return ByHand(BIPED, [["left_hip"], ["right_hip"]], [["left_foot"], ["right_foot"]])


def stance(x, z, pitch=0.0, feet=(0.19, -0.19)):
    """Angles of Solo 8 with its feet on the ground at `feet`."""
    angles = []
    for side, foot in zip((1, -1), feet, strict=True):
        hip = np.array([x, z]) + 0.19 * side * np.array([math.cos(pitch), math.sin(pitch)])  # fmt: skip
        along, down = foot - hip[0], hip[1]
        knee = -side * 2 * math.acos(math.hypot(along, down) / 0.32)
        # Angles of joints turn x to −z, the pitch turns x to z.
        angles += [math.atan2(-along, down) - 0.5 * knee + pitch, knee]
    return angles


def same(found, expected, close=CLOSE):
    """M, load, rows and armature; the largest relative error."""
    errors = [
        relative(found.mass_matrix, expected.mass_matrix),
        relative(found.load, expected.load),
        *(
            relative(f.normal, e.normal)
            for f, e in zip(found.contacts, expected.contacts, strict=True)
        ),
        *(
            relative(f.tangential, e.tangential)
            for f, e in zip(found.contacts, expected.contacts, strict=True)
        ),
    ]
    assert max(errors) < close, errors
    assert found.locked == expected.locked
    for one, other in zip(found.contacts, expected.contacts, strict=True):
        assert one.friction == other.friction
    return max(errors)


def words(mechanism):
    verdict = sf.stability(mechanism)
    return verdict.frictional_stability, verdict.by, verdict.reason


@pytest.mark.parametrize("base", ["free flyer", "plane"])
def test_solo_is_the_robot_made_by_hand(base):
    hand = solo_by_hand()
    joint = pin.JointModelFreeFlyer() if base == "free flyer" else planar_base()
    robot = sf.robots.sagittal(pin.buildModelFromUrdf(urdf("solo.urdf"), joint))
    assert robot.joints == tuple(left for left, _ in LEGS)
    assert robot.pairs == tuple(LEGS)
    rng = np.random.default_rng(20_261_128)
    seen = set()
    for _ in range(40):
        x, z, pitch = rng.uniform((-0.01, 0.29, -0.01), (0.01, 0.315, 0.01))
        angles, slopes = stance(x, z, pitch), rng.uniform(-0.03, 0.03, 2)
        locked, armature = bool(rng.integers(2)), rng.choice([0.0, 0.01])
        expected = hand.mechanism(
            np.array([x, z, -pitch, *angles]), slopes, 0.8, locked, armature
        )
        q = robot.q(x, z, pitch, dict(zip(robot.joints, angles, strict=True)))
        ground = {foot: (slope, 0.8) for foot, slope in zip(SOLO_FEET, slopes, strict=True)}  # fmt: skip
        found = sf.robots.from_pinocchio(
            robot,
            robot.data,
            q,
            ["FL_FOOT", ("HL_FOOT", "HR_FOOT")],
            ground=ground,
            locked="all" if locked else (),
            torques=(
                expected.load
                - hand.mechanism(
                    np.array([x, z, -pitch, *angles]),
                    slopes,
                    0.8,
                    locked,
                    armature,
                    held=False,
                ).load
            )[3:],
            armature=armature,
        )
        same(found, expected)
        assert (found.armature == expected.armature).all()
        assert words(found) == words(expected)
        seen.add(words(found)[0])
    assert {"stable", "unstable", "undecided"} >= seen > {"stable"}


def biped(locked=(), torques=None, armature=None):
    model = pin.buildModelFromUrdf(str(BIPED), planar_base())
    return sf.robots.from_pinocchio(
        model,
        model.createData(),
        [0, 0, 0.166, 0.325, -0.841],
        ["left_foot", "right_foot"],
        ground={"left_foot": (-0.066, 0.667), "right_foot": (-0.091, 0.667)},
        locked=locked,
        torques=torques,
        armature=armature,
    )


@pytest.mark.parametrize("locked", [True, False])
def test_the_biped_is_the_robot_made_by_hand(locked):
    q = np.array([0, 0, 0.166, 0.325, -0.841])
    expected = biped_by_hand().mechanism(q, (-0.066, -0.091), 0.667, locked, 0.5)
    found = biped("all" if locked else (), "holding", 0.5)
    if locked:
        # The torques of locked joints do nothing, and are not computed.
        load = expected.load
        load[3:] = found.load[3:]
        expected = sf.Mechanism(expected.mass_matrix, load, expected.contacts, locked=[3, 4], armature=expected.armature)  # fmt: skip
    same(found, expected)
    assert words(found) == words(expected)


def changes(of, low, high):
    """The armature between two at which the verdict changes, to the last bit."""
    first = words(of(low))
    assert first != words(of(high))
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if words(of(middle)) == first else (low, middle)
    return high


def test_the_thresholds_of_armature_of_both():
    """Those of the matrices made by hand."""
    found = changes(lambda armature: biped((), "holding", armature), 1.0, 2.0)
    assert found == pytest.approx(1.602467664252, abs=1e-9)
    robot = sf.robots.sagittal(in_space("solo.urdf"))
    q = robot.q(0.0, 0.31, 0.0, stance(0.0, 0.31))

    def of(armature):
        return sf.robots.from_pinocchio(robot, robot.data, q, ["FL_FOOT", "HL_FOOT"], friction=0.8, torques="holding", armature=armature)  # fmt: skip

    assert changes(of, 1e-4, 1e-3) == pytest.approx(0.000323795175, abs=1e-11)


# Robots in space beside differences of postures: M, load and rows without crba and Jacobians.


def by_differences(robot, base, joints, feet, step=1e-5):
    """M, load and rows (2 for each foot) from places of bodies and feet beside a posture, with the q of the robot only."""
    model, data = robot.model, robot.model.createData()
    masses = [model.inertias[k].mass for k in range(model.njoints)]

    def places(coordinates):
        angles = dict(zip(robot.joints, coordinates[3:], strict=True))
        q = robot.q(*coordinates[:3], {**joints, **angles})
        pin.framesForwardKinematics(model, data, q)
        bodies = [data.oMi[k] for k in range(model.njoints)]
        centers = [place.act(model.inertias[k].lever) for k, place in enumerate(bodies)]
        turns = [place.rotation.copy() for place in bodies]
        points = [np.mean([data.oMf[model.getFrameId(name)].translation for name in foot], axis=0) for foot in feet]  # fmt: skip
        return np.array(centers), turns, np.array(points)

    middle = np.array([*base, *(joints.get(name, 0.0) for name in robot.joints)])
    _, here, _ = places(middle)
    velocities, spins, rows, heights = [], [], [], []
    for k in range(len(middle)):
        change = step * (np.arange(len(middle)) == k)
        (a, A, p), (b, B, r) = places(middle + change), places(middle - change)
        velocities.append((a - b) / (2 * step))
        spins.append([pin.log3(one @ other.T) / (2 * step) for one, other in zip(A, B, strict=True)])  # fmt: skip
        rows.append((p - r)[:, [0, 2]] / (2 * step))
        heights.append(velocities[-1][:, 2])
    inertias = [R @ model.inertias[k].inertia @ R.T for k, R in enumerate(here)]
    M = np.einsum("b,ibx,jbx->ij", masses, velocities, velocities)
    M += np.einsum("ibx,bxy,jby->ij", spins, inertias, spins)
    return M, -9.81 * np.array(heights) @ masses, np.array(rows)


def with_soles(model):
    """Heels and toes of Talos."""
    for side in ("left", "right"):
        joint = model.getJointId(f"leg_{side}_6_joint")
        for name, x in (("heel", -0.1), ("toe", 0.12)):
            place = pin.SE3(np.eye(3), np.array([x, 0, -0.107]))
            model.addFrame(pin.Frame(f"{side}_{name}", joint, place, pin.FrameType.OP_FRAME))  # fmt: skip
    return model


#: The file, pitch, joints, feet, mass in kg, and names of joints that stand still.
ROBOTS = {
    "a1": (
        "a1.urdf",
        0.0,
        {"FL_thigh_joint": 0.8, "FL_calf_joint": -1.6, "RL_thigh_joint": 0.8, "RL_calf_joint": -1.6},
        [("FL_foot", "FR_foot"), ("RL_foot", "RR_foot")],
        13.741,
        ("FL_hip_joint", "RR_hip_joint"),
    ),
    "anymal": (
        "anymal.urdf",
        0.0,
        {"LF_HFE": 0.4, "LF_KFE": -0.8, "LH_HFE": -0.4, "LH_KFE": 0.8},
        [("LF_FOOT", "RF_FOOT"), ("LH_FOOT", "RH_FOOT")],
        30.475,
        ("LF_HAA",),
    ),
    "talos": (
        "talos_reduced.urdf",
        0.0,
        {"leg_left_3_joint": -0.4, "leg_left_4_joint": 0.8, "leg_left_5_joint": -0.4, "arm_left_4_joint": -0.5},
        [("left_toe", "right_toe"), ("left_heel", "right_heel")],
        90.272,
        ("torso_1_joint", "leg_right_2_joint"),
    ),
}  # fmt: skip


def loaded(name):
    file, pitch, joints, feet, mass, fixed = ROBOTS[name]
    model = in_space(file)
    if name == "talos":
        with_soles(model)
    # The centres of the left and the right elbow of Talos are 4.2 cm apart in its file.
    robot = sf.robots.sagittal(model, tolerance=0.05)
    return robot, pitch, joints, feet, mass, fixed


@pytest.mark.parametrize("name", ROBOTS)
def test_robots_in_space_move_in_their_plane(name):
    robot, pitch, joints, feet, mass, fixed = loaded(name)
    assert set(fixed) <= set(robot.fixed)
    for turned in (pitch, 0.3):
        base = (0.2, 0.5, turned)
        mechanism = sf.robots.from_pinocchio(robot, robot.data, robot.q(*base, joints), feet, friction=0.6)  # fmt: skip
        M, load, rows = by_differences(robot, base, joints, feet)
        assert mechanism.mass_matrix[0, 0] == pytest.approx(mass, abs=1e-3)
        assert mechanism.load[1] == pytest.approx(-9.81 * mechanism.mass_matrix[0, 0])
        assert relative(mechanism.mass_matrix, M) < DIFFERENCES
        assert relative(mechanism.load, load) < DIFFERENCES
        for k, contact in enumerate(mechanism.contacts):
            assert relative(contact.tangential, rows[:, k, 0]) < DIFFERENCES
            assert relative(contact.normal, rows[:, k, 1]) < DIFFERENCES


@pytest.mark.parametrize("name", ROBOTS)
def test_feet_of_robots_in_space_carry_their_weight(name):
    robot, pitch, joints, feet, _, _ = loaded(name)
    standing = [foot[0] for foot in feet]
    stiff = sf.robots.from_pinocchio(robot, robot.data, robot.q(0, 0, pitch, joints), standing, friction=0.6, locked="all")  # fmt: skip
    assert sf.stability(stiff).frictional_stability == "stable"
    force = sf.contact_modes(stiff)["FF"].forces
    weight = -stiff.load[1]
    assert sum(up for _, up in force) == pytest.approx(weight, rel=1e-12)
    held = sf.robots.from_pinocchio(robot, robot.data, robot.q(0, 0, pitch, joints), standing, friction=0.6, torques="least")  # fmt: skip
    assert "FF" in sf.contact_modes(held).consistent
    assert sf.stability(held).by != "not-equilibrium"


# MuJoCo's model of the same file.


def in_mujoco(path, feet=()):
    """Compiled without meshes, on a free joint, with a site at each frame named in `feet`."""
    mujoco = pytest.importorskip("mujoco")
    tree = ET.parse(path)
    for link in tree.getroot().iter("link"):
        for part in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(part)
    spec = mujoco.MjSpec.from_string(ET.tostring(tree.getroot(), encoding="unicode"))
    spec.compiler.fusestatic = False
    spec.worldbody.first_body().add_freejoint()
    for foot in feet:
        spec.body(foot).add_site(name=foot)
    return spec.compile()


@pytest.mark.parametrize("feet", ["sites", "bodies"])
def test_a_quadruped_of_mujoco_is_that_of_pinocchio(feet):
    mujoco = pytest.importorskip("mujoco")
    robot, _, joints, pairs, _, _ = loaded("a1")
    sites = [name for pair in pairs for name in pair] if feet == "sites" else ()
    model = in_mujoco(urdf("a1.urdf"), sites)
    other = sf.robots.sagittal(model)
    assert (other.joints, other.pairs) == (robot.joints, robot.pairs)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(20_261_129)
    for locked in ("all", ()):
        place = (*rng.uniform(-1, 1, 2), rng.uniform(-0.3, 0.3))
        data.qpos = other.q(*place, joints)
        data.qvel = moving = rng.normal(size=model.nv)
        options = {
            "ground": {"FL_foot": (0.1, 0.5), "RR_foot": (-0.1, 0.7)},
            "locked": locked,
            "restitution": 0.1,
            "armature": 0.01,
        }
        found = sf.robots.from_mujoco(other, data, ["FR_foot", "RL_foot"], **options)
        assert (data.qvel == moving).all()
        expected = sf.robots.from_pinocchio(robot, robot.data, robot.q(*place, joints), ["FR_foot", "RL_foot"], **options)  # fmt: skip
        # Both integrate the same inertias; MuJoCo keeps them on their principal axes.
        same(found, expected, close=1e-9)
        assert found.restitution == 0.1
        assert words(found) == words(expected)


def test_a_plane_robot_of_mujoco():
    """A pole on a cart is no floating base; a hopper of two slides and a hinge is one. Armature of the model, and in place of it."""
    mujoco = pytest.importorskip("mujoco")
    hopper = """<mujoco><worldbody><body name="trunk" pos="0 0 1">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/><joint name="pitch" axis="0 1 0"/>
      <inertial mass="4" pos="0 0 0" diaginertia=".1 .1 .1"/>
      <body name="leg"><joint name="hip" axis="0 -1 0" armature=".02"/><inertial mass="1" pos="0 0 -.25" diaginertia=".02 .02 .02"/>
        <geom name="toe" type="sphere" size=".01" pos=".1 0 -.5"/><site name="heel" pos="-.1 0 -.5"/></body>
    </body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(hopper)
    data = mujoco.MjData(model)
    M = sf.robots.from_mujoco(model, data, ["toe", "heel"], friction=0.5)
    assert M.dof == 4
    # The pitch is counterclockwise, the hip turns about −y, so counterclockwise too.
    leg = 0.02 + 0.25**2
    assert M.mass_matrix == pytest.approx(
        np.array([[5, 0, 0.25, 0.25], [0, 5, 0, 0], [0.25, 0, 0.1 + leg, leg], [0.25, 0, leg, leg + 0.02]])
    )  # fmt: skip
    assert M.load == pytest.approx([0, -5 * 9.81, 0, 0], abs=1e-12)
    assert M.contacts[0].normal == pytest.approx([0, 1, 0.1, 0.1])
    assert M.contacts[1].tangential == pytest.approx([1, 0, 0.5, 0.5])
    with_other = sf.robots.from_mujoco(model, data, ["toe"], friction=0.5, armature=0.3)
    assert with_other.armature == pytest.approx([0, 0, 0, 0.3])
    assert with_other.mass_matrix[3, 3] == pytest.approx(leg)
    cart = hopper.replace('<joint name="z" type="slide" axis="0 0 1"/>', "")
    model = mujoco.MjModel.from_xml_string(cart)
    M = sf.robots.from_mujoco(model, mujoco.MjData(model), ["toe"], friction=0.5, locked=["hip"])  # fmt: skip
    assert (M.dof, M.locked) == (3, [2])


# Bases.


def test_bases_of_pinocchio_give_one_mechanism():
    """PX, PZ and RY in one joint and in three, JointModelPlanar in its plane, and a free flyer."""
    reference = pin.buildModelFromUrdf(str(BIPED), planar_base())
    q, feet = [0.3, 0.2, 0.166, 0.325, -0.841], ["left_foot", "right_foot"]

    def of(model, q, feet=feet):
        return sf.robots.from_pinocchio(model, model.createData(), q, feet, friction=0.6)  # fmt: skip

    expected = of(reference, q)
    three = pin.Model()
    last = 0
    for name, joint in (("x", pin.JointModelPX()), ("z", pin.JointModelPZ()), ("pitch", pin.JointModelRY())):  # fmt: skip
        last = three.addJoint(last, joint, pin.SE3.Identity(), name)
    # Axes x, y and normal of the joint along x, −z … of the world.
    upright = pin.SE3(pin.utils.rotate("x", math.pi / 2), np.zeros(3))
    planar = pin.Model()
    planar.addJoint(0, pin.JointModelPlanar(), upright, "base")
    back = upright.inverse()
    for model, base, place in ((three, 3, pin.SE3.Identity()), (planar, 1, back)):
        model.appendBodyToJoint(base, reference.inertias[1], place)
        for k in (2, 3):
            leg = model.addJoint(base, pin.JointModelRY(), place * reference.jointPlacements[k], reference.names[k])  # fmt: skip
            model.appendBodyToJoint(leg, reference.inertias[k], pin.SE3.Identity())
        for foot in feet:
            frame = reference.frames[reference.getFrameId(foot)]
            parent = base + frame.parentJoint - 1
            model.addFrame(pin.Frame(foot, parent, frame.placement, pin.FrameType.OP_FRAME))  # fmt: skip
    same(of(three, q), expected)
    turned = [0.3, 0.2, math.cos(-0.166), math.sin(-0.166), 0.325, -0.841]
    same(of(planar, turned), expected, close=1e-11)
    # Both legs in the plane of symmetry: each is its own image.
    flying = sf.robots.sagittal(pin.buildModelFromUrdf(str(BIPED), pin.JointModelFreeFlyer()))  # fmt: skip
    assert flying.pairs == (("left_hip",), ("right_hip",))
    pose = flying.q(0.3, 0.2, -0.166, [0.325, -0.841])
    same(sf.robots.from_pinocchio(flying, flying.data, pose, feet, friction=0.6), expected)  # fmt: skip


def test_a_fixed_base_has_the_coordinates_of_its_joints():
    chain = pin.Model()
    one = chain.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "shoulder")
    two = chain.addJoint(one, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([1.0, 0, 0])), "elbow")  # fmt: skip
    for k in (one, two):
        chain.appendBodyToJoint(k, pin.Inertia(1, np.array([0.5, 0, 0]), np.eye(3) / 12), pin.SE3.Identity())  # fmt: skip
    chain.addFrame(pin.Frame("hand", two, pin.SE3(np.eye(3), np.array([1.0, 0, 0])), pin.FrameType.OP_FRAME))  # fmt: skip
    chain.gravity.linear = np.array([0, -9.81, 0])
    angles = np.array([-0.9, -0.4])
    found = sf.robots.from_pinocchio(chain, chain.createData(), angles, ["hand"], plane="xy", friction=0.5)  # fmt: skip
    links = [sf.Link(mass=1, inertia=1 / 12, length=1, center=0.5)] * 2
    expected = sf.Chain("pinned", links, [sf.Joint("torque"), sf.Joint("torque", parent=1, at=1)], [sf.Foot(2, at=1, friction=0.5)]).mechanism(angles)  # fmt: skip
    same(found, expected)


def test_a_robot_in_the_plane_of_x_and_y():
    """All angles counterclockwise, as in a chain."""
    model = pin.Model()
    model.gravity.linear = np.array([0, -9.81, 0])
    base = model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "trunk")
    model.appendBodyToJoint(base, pin.Inertia(10, np.zeros(3), 0.4 * np.eye(3)), pin.SE3.Identity())  # fmt: skip
    for side in ("left", "right"):
        down = pin.SE3(pin.utils.rotate("z", -math.pi / 2), np.zeros(3))
        leg = model.addJoint(base, pin.JointModelRZ(), down, f"{side}_hip")
        model.appendBodyToJoint(leg, pin.Inertia(1, np.array([0.5, 0, 0]), np.eye(3) / 12), pin.SE3.Identity())  # fmt: skip
        model.addFrame(pin.Frame(f"{side}_foot", leg, pin.SE3(np.eye(3), np.array([1.0, 0, 0])), pin.FrameType.OP_FRAME))  # fmt: skip
    hip = sf.Joint("torque", armature=0.2, parent=1, at=0, angle=-math.pi / 2)
    link = sf.Link(mass=1, inertia=1 / 12, length=1)
    feet = [sf.Foot(2, slope=-0.1, friction=0.6), sf.Foot(3, slope=0.2, friction=0.7)]
    trunk = sf.Link(mass=10, inertia=0.4, length=1, center=0)
    chain = sf.Chain(links=[trunk, link, link], joints=[hip, hip], feet=feet)
    q = np.array([0.3, 0.8, -0.2, -0.5, 0.6])
    theirs = [0.3, 0.8, math.cos(-0.2), math.sin(-0.2), -0.5, 0.6]
    found = sf.robots.from_pinocchio(model, model.createData(), theirs, ["left_foot", "right_foot"], plane="xy", ground={"left_foot": (-0.1, 0.6), "right_foot": (0.2, 0.7)}, armature=0.2)  # fmt: skip
    expected = chain.mechanism(q)
    same(found, expected)
    assert (found.armature == expected.armature).all()


def test_locked_joints_leave_the_rigid_body():
    """x, z and pitch are (x, y, θ) of a body in the plane, also for a base that is turned."""
    robot = sf.robots.sagittal(in_space("solo.urdf"))
    angles = stance(0.02, 0.24, 0.1)
    q = robot.q(0.02, 0.24, 0.1, angles)
    stiff = sf.robots.from_pinocchio(robot, robot.data, q, ["FL_FOOT", "HL_FOOT"], friction=0.8, locked="all")  # fmt: skip
    for contact, x in zip(stiff.contacts, (0.19, -0.19), strict=True):
        assert contact.tangential[:3] == pytest.approx([1, 0, 0.24], abs=1e-3)
        assert contact.normal[:3] == pytest.approx([0, 1, x - 0.02], abs=1e-3)
    body = stiff.posture()
    model, data = robot.model, robot.data
    center = pin.centerOfMass(model, data, q) - q[:3]
    assert body.mass == pytest.approx(pin.computeTotalMass(model), rel=CLOSE)
    assert body.center_of_mass == pytest.approx(center[[0, 2]], abs=1e-9)
    assert words(stiff)[0] == sf.stability(body).frictional_stability == "stable"


# Wrong inputs.


def solo(**change):
    robot = sf.robots.sagittal(in_space("solo.urdf"))
    options = {"q": robot.q(0, 0.25, 0, stance(0, 0.25)), "feet": ["FL_FOOT", "HL_FOOT"], "friction": 0.8}  # fmt: skip
    options |= {key: value for key, value in change.items() if key != "data"}
    return sf.robots.from_pinocchio(robot, change.get("data", robot.data), **options)


def posed(place, value):
    robot = sf.robots.sagittal(in_space("solo.urdf"))
    q = robot.q(0, 0.25, 0, stance(0, 0.25))
    q[place] = value
    return q


def gravity_of(vector, **change):
    model = pin.buildModelFromUrdf(str(BIPED), planar_base())
    model.gravity.linear = np.array(vector, dtype=float)
    return plane_biped(model, **change)


def plane_biped(model=None, q=(0, 0, 0, 0.6, -0.6), feet=("left_foot", "right_foot"), **change):  # fmt: skip
    model = model or pin.buildModelFromUrdf(str(BIPED), planar_base())
    return sf.robots.from_pinocchio(model, model.createData(), q, feet, **{"friction": 0.6, **change})  # fmt: skip


def lopsided(change):
    model = in_space("solo.urdf")
    change(model)
    return sf.robots.sagittal(model)


def heavier(model):
    model.inertias[model.getJointId("FL_KFE")].mass *= 1.2


def shifted_center(model):
    inertia = model.inertias[model.getJointId("FL_KFE")]
    inertia.lever = np.add(inertia.lever, [0.02, 0, 0])


def rounder(model):
    inertia = model.inertias[model.getJointId("FL_KFE")]
    inertia.inertia = inertia.inertia + 0.01 * np.eye(3)


def trunk_beside(model):
    model.inertias[1].lever = np.array([0, 0.05, 0])


def moved_joint(model):
    place = model.jointPlacements[model.getJointId("FL_KFE")]
    place.translation = np.add(place.translation, [0, 0, 0.01])


def pinned_foot():
    model = pin.buildModelFromUrdf(str(BIPED))
    sf.robots.from_pinocchio(model, model.createData(), [0.6, -0.6], ["left_foot"], friction=0.5)  # fmt: skip


def foot_on_the_ground():
    model = pin.buildModelFromUrdf(str(BIPED))
    sf.robots.from_pinocchio(model, model.createData(), [0.6, -0.6], ["trunk"], friction=0.5)  # fmt: skip


def sideways(locked=()):
    model = pin.buildModelFromUrdf(urdf("solo12.urdf"), planar_base())
    return sf.robots.from_pinocchio(model, model.createData(), pin.neutral(model), ["FL_FOOT", "HL_FOOT"], friction=0.6, locked=locked)  # fmt: skip


def abducted(**joints):
    robot = sf.robots.sagittal(in_space("solo12.urdf"))
    q = robot.q(0, 0.25, 0, {"FL_HFE": 0.8, "FL_KFE": -1.6, **joints})
    return sf.robots.from_pinocchio(robot, robot.data, q, ["FL_FOOT", "HL_FOOT"], friction=0.6)  # fmt: skip


WRONG = {
    "no such frame": (lambda: solo(feet=["FL_FOO"]), "'FL_FOO'", "did you mean 'FL_FOOT'?"),
    "no feet": (lambda: solo(feet=[]), "feet = []", "at least one"),
    "a foot twice": (lambda: solo(feet=["FL_FOOT", "FL_FOOT"]), "'FL_FOOT'", "each foot once"),
    "a foot and its image": (lambda: solo(feet=["FL_FOOT", "FR_FOOT"]), "'FR_FOOT'", "'FL_FOOT' is the same one"),
    "feet that are no images": (lambda: solo(feet=[("FL_FOOT", "HR_FOOT")]), "('FL_FOOT', 'HR_FOOT')", "mirror images"),
    "a pair in a plane robot": (lambda: plane_biped(feet=[("left_foot", "right_foot")]), "'left_foot', 'right_foot'", "sagittal"),
    "a foot on the ground": (foot_on_the_ground, "'trunk'", "bodies that move"),
    "a foot of a leg with one joint": (pinned_foot, "foot 'left_foot'", "independent"),
    "q too short": (lambda: solo(q=[0, 0, 0.25]), "q = array of shape [3]", "15 numbers"),
    "q not finite": (lambda: solo(q=posed(9, math.nan)), "q[9] = nan", "finite"),
    "q in degrees": (lambda: solo(q=posed(slice(7, 15), [45, -90] * 4)), "'FL_HFE'", "in degrees?"),
    "q with a pitch in degrees": (lambda: plane_biped(q=[0, 0, 10, 0.6, -0.6]), "q[2] = 10", "in rad"),
    "a quaternion of another length": (lambda: solo(q=posed(slice(3, 7), [0, 0, 0, 2])), "q[3:7]", "length is 2"),
    "roll": (lambda: solo(q=posed(slice(3, 7), [0.6, 0, 0, 0.8])), "q of the base", "roll"),
    "yaw": (lambda: solo(q=posed(slice(3, 7), [0, 0, 0.6, 0.8])), "q of the base", "yaw"),
    "legs apart": (lambda: solo(q=posed(7, 0.3)), "'FL_HFE' and 'FR_HFE'", "mirror images"),
    "abduction to one side": (lambda: abducted(FL_HAA=0.2), "joint 'FL_HFE'", "out of the plane"),
    "a free flyer without sagittal": (
        lambda: plane_biped(in_space("solo.urdf"), feet=["FL_FOOT"]),
        "'root_joint'",
        "sf.robots.sagittal(model)",
    ),
    "joints out of the plane": (sideways, "joint 'FL_HAA'", "lock it"),
    "data of another model": (lambda: solo(data=pin.Model().createData()), "data", "the same model"),
    "no data": (lambda: solo(data=None), "data = NoneType", "createData()"),
    "no model": (lambda: sf.robots.from_pinocchio("solo.urdf", None, [], []), "model = str", "pinocchio.Model"),
    "sagittal of no model": (lambda: sf.robots.sagittal("solo.urdf"), "model = str", "mujoco.MjModel"),
    "no such plane": (lambda: plane_biped(plane="yz"), "plane = 'yz'", "'xz' or 'xy'"),
    "another plane": (lambda: solo(plane="xy"), "plane = 'xy'", "'xz'"),
    "gravity across the plane": (lambda: plane_biped(plane="xy"), "gravity of the model = [0.0, 0.0, -9.81]", "'xy'"),
    "gravity upwards": (lambda: gravity_of([0, 0, 9.81], torques="least"), "gravity of the model = [0.0, 0.0, 9.81]", "downwards"),
    "no gravity to hold against": (lambda: gravity_of([0, 0, 0], torques="holding"), "gravity of the model = [0.0, 0.0, 0.0]", "torques"),
    "ground of no foot": (lambda: solo(ground={"FL_FOO": (0, 0.5)}), "ground = 'FL_FOO'", "did you mean 'FL_FOOT'?"),
    "ground of one foot twice": (lambda: solo(ground={"FL_FOOT": (0, 0.5), "FR_FOOT": (0, 0.6)}), "ground = 'FR_FOOT'", "'FL_FOOT' is the same"),
    "ground without friction": (lambda: solo(ground={"FL_FOOT": 0.1}), "ground['FL_FOOT'] = 0.1", "a pair"),
    "ground of one number": (lambda: solo(ground=0.1, friction=None), "ground = 0.1", "a pair"),
    "friction twice": (lambda: solo(ground=(0.0, 0.5)), "friction = 0.8", "None where ground"),
    "no friction": (lambda: solo(friction=None), "friction = None", "'FL_FOOT'"),
    "negative friction": (lambda: solo(ground={"HL_FOOT": (0, -0.5)}), "friction at ('HL_FOOT', 'HR_FOOT') = -0.5", ">= 0"),
    "a slope in degrees": (lambda: solo(ground={"HL_FOOT": (15, 0.5)}), "slope at ('HL_FOOT', 'HR_FOOT') = 15", "in degrees?"),
    "no such joint to lock": (lambda: solo(locked=["FL_KFF"]), "locked = 'FL_KFF'", "did you mean 'FL_KFE'?"),
    "torques of no kind": (lambda: solo(torques="hold"), "torques = 'hold'", "'holding', 'least'"),
    "torques of all joints": (lambda: solo(torques=np.zeros(8)), "torques = array of shape [8]", "4 joints: FL_HFE"),
    "a torque that is not finite": (lambda: solo(torques=[0, math.inf, 0, 0]), "torques of joint 'FL_KFE' = inf", "finite"),
    "negative armature": (lambda: solo(armature=[0, 0, -0.1, 0]), "armature of joint 'HL_HFE' = -0.1", ">= 0"),
    "a negative number as armature": (lambda: solo(armature=-1), "armature = -1", ">= 0"),
    "restitution": (lambda: solo(restitution=2), "restitution = 2", "<= 1"),
    "masses": (lambda: lopsided(heavier), "'FL_KFE' and 'FR_KFE'", "tolerance=0.03"),
    "centres": (lambda: lopsided(shifted_center), "centres of mass behind joints 'FL_KFE' and 'FR_KFE'", "tolerance"),
    "inertias": (lambda: lopsided(rounder), "inertias behind joints 'FL_KFE' and 'FR_KFE'", "tolerance"),
    "a trunk beside its middle": (lambda: lopsided(trunk_beside), "joint 'root_joint' = 0.05 m", "tolerance"),
    "legs of two lengths": (lambda: lopsided(moved_joint), "joint 'FL_KFE' = not mirrored", "y -> -y"),
    "a fixed base": (lambda: sf.robots.sagittal(pin.buildModelFromUrdf(str(BIPED))), "a robot with a fixed base", "free flyer"),
    "pairs of no joints": (lambda: sf.robots.sagittal(in_space("solo.urdf"), pairs=[("FL_HFE", "FR_HF")]), "pairs = 'FR_HF'", "did you mean 'FR_HFE'?"),
    "pairs that do not mirror": (lambda: sf.robots.sagittal(in_space("solo.urdf"), pairs=[("FL_HFE", "HR_HFE")]), "joint 'FL_HFE'", "'HR_HFE'"),
    "an angle of no joint": (lambda: sf.robots.sagittal(in_space("solo.urdf")).q(joints={"FL_KFF": 1}), "'FL_KFF'", "did you mean 'FL_KFE'?"),
    "a robot that looks along y": (lambda: sf.robots.sagittal(in_space("quadruped.urdf")), "8 joints, none of which moves in the plane", "about y"),
    "q of words": (lambda: solo(q="home"), "q = 'home'", "numbers"),
    "friction of a word": (lambda: solo(friction="ice"), "friction = 'ice'", "number"),
    "friction of a truth value": (lambda: solo(friction=True), "friction = True", "number"),
    "armature of a truth value": (lambda: solo(armature=True), "armature = True", "number"),
    "armature by name": (lambda: solo(armature={"FL_HFE": 1}), "armature = {'FL_HFE': 1}", "4 joints: FL_HFE"),
    "torques by name": (lambda: solo(torques={"FL_HFE": 1}), "torques = {'FL_HFE': 1}", "4 joints: FL_HFE"),
    "torques that hold, whole": (lambda: solo(torques=solo().holding_torques([3, 4, 5, 6])), "torques = <HoldingTorques", ".torques"),
    "locked of nothing": (lambda: solo(locked=None), "locked = None", "names of joints"),
    "locked of a truth value": (lambda: solo(locked=True), "locked = True", "names of joints"),
    "a quaternion of MuJoCo": (lambda: solo(q=posed(slice(3, 7), [1, 0, 0, 0])), "q of the base = roll 3.14159", "(x, y, z, w)"),
    "too many angles": (lambda: sf.robots.sagittal(in_space("solo.urdf")).q(joints=np.zeros(8)), "array of shape [8]", "4 angles"),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_wrong_inputs_are_named(what):
    call, *fragments = WRONG[what]
    with pytest.raises(ValueError, match=re.escape(fragments[0])) as error:
        call()
    for fragment in fragments:
        assert fragment in str(error.value)


def test_a_robot_of_a_plane_of_symmetry_is_copied_and_pickled():
    model = in_space("solo.urdf")
    robot = sf.robots.sagittal(model, pairs=[("FL_HFE", "FR_HFE")])
    for again in (copy.deepcopy(robot), pickle.loads(pickle.dumps(robot))):
        assert again.pairs == robot.pairs
        assert (again.S == robot.S).all()
        assert again.model is not model


def test_what_looks_wrong_and_is_not():
    """A robot that looks the other way, abducted legs that are locked, joints out of the plane that are locked, a tolerance."""
    solo(q=posed(slice(3, 7), [0, 0, 1, 0]))
    every = [f"{a}{b}_HAA" for a in "FH" for b in "LR"]
    assert sideways(locked=every).locked == [3, 6, 9, 12]
    model = in_space("solo.urdf")
    heavier(model)
    assert sf.robots.sagittal(model, tolerance=0.3).joints
    # Names of joints that do not move anyway may be locked.
    robot = sf.robots.sagittal(in_space("solo12.urdf"))
    q = robot.q(0, 0.25, 0, {"FL_HFE": 0.8, "FL_KFE": -1.6})
    stood = sf.robots.from_pinocchio(robot, robot.data, q, ["FL_FOOT", "HL_FOOT"], friction=0.6, locked=["FL_HAA", "FR_KFE"])  # fmt: skip
    assert stood.locked == [3 + robot.joints.index("FL_KFE")]


def test_wrong_models_of_mujoco_are_named():
    mujoco = pytest.importorskip("mujoco")
    model = in_mujoco(urdf("a1.urdf"))
    robot = sf.robots.sagittal(model)
    data = mujoco.MjData(model)
    data.qpos = robot.q()
    with pytest.raises(ValueError, match=r"did you mean 'FL_foot'"):
        sf.robots.from_mujoco(robot, data, ["FL_fot"], friction=0.5)
    with pytest.raises(ValueError, match=r"sf\.robots\.sagittal"):
        sf.robots.from_mujoco(model, data, ["FL_foot"], friction=0.5)
    with pytest.raises(ValueError, match="data of another model"):
        sf.robots.from_mujoco(robot, mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco/>")), ["FL_foot"], friction=0.5)  # fmt: skip
    with pytest.raises(ValueError, match="from_mujoco takes this one"):
        sf.robots.from_pinocchio(robot, data, robot.q(), ["FL_foot"], friction=0.5)
    data.qpos[8] = 60
    with pytest.raises(ValueError, match=r"data\.qpos\[8\] = 60.*in degrees"):
        sf.robots.from_mujoco(robot, data, ["FL_foot"], friction=0.5)
    closed = """<mujoco><worldbody><body name="a"><freejoint/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/></body>
      </worldbody><equality><weld body1="a" body2="world"/></equality></mujoco>"""
    with pytest.raises(ValueError, match="active equalities"):
        sf.robots.sagittal(mujoco.MjModel.from_xml_string(closed))


def test_a_posture_takes_little_time():
    """10 000 postures with their verdicts in 10 s on two cores need less than 2 ms for each; a mechanism is a small part of it."""
    import timeit

    robot = sf.robots.sagittal(in_space("solo.urdf"))
    q = robot.q(0, 0.25, 0, stance(0, 0.25))
    feet = ["FL_FOOT", "HL_FOOT"]
    timer = timeit.Timer(lambda: sf.robots.from_pinocchio(robot, robot.data, q, feet, friction=0.8))  # fmt: skip
    # 0.15 ms on a quiet machine.
    assert min(timer.repeat(5, 200)) / 200 < 1e-3

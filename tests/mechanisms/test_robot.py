"""Robots from URDF files through Pinocchio beside chains: M, h and J, and the example with its thresholds.

Both sides measure the angle of a link from its parent's, standfast counterclockwise in the plane of x and the height, Pinocchio about
+y, which turns x to −z. So q of Pinocchio is that of standfast with the angles negated.
"""

import importlib.util
import math
import re
from importlib.metadata import files
from pathlib import Path

import numpy as np
import pytest
import standfast as sf

pin = pytest.importorskip("pinocchio")

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


ROBOT = example("robot")
#: Rounding errors of some hundred operations, relative to the largest entry.
CLOSE = 1e-12


def turn(angle):
    """The rotation of Pinocchio for a counterclockwise angle in the plane of x and z."""
    return pin.utils.rotate("y", -angle)


def shifted(along, angle=0.0):
    """Along the axis of a link, its +x."""
    return pin.SE3(turn(angle), np.array([along, 0.0, 0.0]))


def random_chain(rng):
    """A random tree of links with feet on random slopes, and the same tree as a model of Pinocchio; names of the feet's frames."""
    base = rng.choice(["floating", "pinned"])
    count = int(rng.integers(2, 7))
    links = [
        sf.Link(
            rng.uniform(0.1, 5),
            rng.uniform(0.01, 0.5),
            rng.uniform(0.2, 1),
            rng.uniform(-0.3, 0.8),
        )
        for _ in range(count)
    ]
    joints = []
    branch = [1]
    for number in range(2 if base == "floating" else 1, count + 1):
        place = {"angle": rng.uniform(-3, 3)}
        if number > 1:
            # One of the link before and its ancestors: `crba` needs subtrees whose coordinates follow each other.
            del branch[int(rng.integers(1, len(branch) + 1)) :]
            place["parent"] = branch[-1]
            branch.append(number)
            place["at"] = rng.uniform(-0.2, 1)
        joints.append(sf.Joint("torque", torque=rng.normal(), **place))
    # A foot that can move in both directions: on a pinned chain behind two joints.
    carried = [k for k in range(1, count + 1) if base == "floating" or k > 1]
    feet = [
        sf.Foot(
            int(rng.choice(carried)),
            at=rng.uniform(-0.5, 1),
            slope=rng.uniform(-3, 3),
        )
        for _ in range(3)
    ]
    # Ground and ceiling at one foot: no load pulls it off both, which a mechanism would refuse.
    under = feet[0].slope
    feet[1] = sf.Foot(
        feet[0].link, at=feet[0].at, slope=under - math.copysign(math.pi, under)
    )
    gravity = rng.uniform(0, 20)
    chain = sf.Chain(base, links, joints, feet, gravity=gravity)

    model = pin.Model()
    model.gravity.linear = np.array([0, 0, -gravity])
    ids = []
    if base == "floating":
        one = model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "x")
        two = model.addJoint(one, pin.JointModelPZ(), pin.SE3.Identity(), "z")
        ids.append(model.addJoint(two, pin.JointModelRY(), pin.SE3.Identity(), "pitch"))
    for k, joint in enumerate(joints, start=1):
        parent = 0 if joint.parent is None else ids[joint.parent - 1]
        place = shifted(joint.at or 0.0, joint.angle)
        ids.append(model.addJoint(parent, pin.JointModelRY(), place, f"joint {k}"))
    for link, number in zip(links, ids, strict=True):
        inertia = pin.Inertia(
            link.mass, np.array([link.center, 0, 0]), link.inertia * np.eye(3)
        )
        model.appendBodyToJoint(number, inertia, pin.SE3.Identity())
    frames = []
    for k, foot in enumerate(feet, start=1):
        frame = pin.Frame(
            f"foot {k}", ids[foot.link - 1], shifted(foot.at), pin.FrameType.OP_FRAME
        )
        frames.append(model.addFrame(frame))
    return chain, model, frames


def relative(found, expected):
    return np.abs(found - expected).max() / np.abs(expected).max()


def test_random_chains_have_the_dynamics_of_pinocchio():
    rng = np.random.default_rng(20_260_401)
    worst = dict.fromkeys(("M", "h", "J", "places"), 0.0)
    for _ in range(300):
        chain, model, frames = random_chain(rng)
        data = model.createData()
        q = rng.uniform(-3, 3, chain.dof)
        sign = -np.ones(chain.dof)
        if chain.base == "floating":
            sign[:2] = 1
        mechanism = chain.mechanism(q)
        theirs = sign * q
        M = sign[:, None] * pin.crba(model, data, theirs) * sign
        h = sign * pin.computeGeneralizedGravity(model, data, theirs)
        still = sign * pin.nonLinearEffects(model, data, theirs, np.zeros(model.nv))
        torques = np.zeros(chain.dof)
        if chain.joints:
            torques[-len(chain.joints) :] = [joint.torque for joint in chain.joints]
        pin.computeJointJacobians(model, data, theirs)
        pin.updateFramePlacements(model, data)
        errors = {"M": relative(mechanism.mass_matrix, M), "J": 0.0, "places": 0.0}
        errors["h"] = max(
            relative(torques - mechanism.load, h), relative(chain.bias(q), still)
        )
        feet = zip(chain.feet, mechanism.contacts, frames, strict=True)
        _, points = chain.points(q)
        for (foot, rows, frame), point in zip(feet, points, strict=True):
            J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
            J = J[[0, 2]] * sign
            t = np.array([math.cos(foot.slope), math.sin(foot.slope)])
            n = np.array([-t[1], t[0]])
            size = np.abs(J).max()
            for row, direction in ((rows.tangential, t), (rows.normal, n)):
                error = np.abs(row - direction @ J).max() / size
                errors["J"] = max(errors["J"], error)
            there = data.oMf[frame].translation[[0, 2]]
            errors["places"] = max(errors["places"], relative(point, there))
        worst = {name: max(worst[name], errors[name]) for name in worst}
    assert max(worst.values()) < CLOSE, worst


def chain_of_biped(kind="torque", armature=0.0):
    """The biped of the example without Pinocchio, and q."""
    leg = sf.Link(mass=1, inertia=1 / 12, length=1)
    hip = sf.Joint(kind, armature=armature, parent=1, at=0, angle=-math.pi / 2)
    feet = [
        sf.Foot(k, slope=slope, friction=0.667)
        for k, slope in ((2, -0.066), (3, -0.091))
    ]
    trunk = sf.Link(mass=10, inertia=0.4, length=1, center=0)
    return sf.Chain(links=[trunk, leg, leg], joints=[hip, hip], feet=feet)


def test_the_biped_of_the_example_is_the_chain():
    q = [0, 0, -0.166, -0.325, 0.841]
    for locked, armature in (("all", 0.0), ((), 0.0), ((), 1.0)):
        found = ROBOT.biped_that_jams(armature, locked)
        chain = chain_of_biped("locked" if locked else "torque", armature)
        expected = chain.mechanism(q).contact_space
        assert found.contact_space.rank == expected.rank
        assert relative(found.contact_space.W, expected.W) < CLOSE
    # Torques hold it: its feet can be fixed, and the torques are the middle of those that hold the chain. Joints of the file turn about +y.
    modes = sf.contact_modes(ROBOT.biped_that_jams())
    assert "FF" in modes.consistent
    held = chain_of_biped().holding_torques(q)
    torques = chain_of_biped().bias(q)[3:] - ROBOT.biped_that_jams().load[3:]
    assert torques == pytest.approx(held.torque_interval.mean(axis=1), rel=CLOSE)


def test_the_threshold_of_the_biped():
    """k = N M⁻¹(N + μT)ᵀ of its first foot has this zero: found in arbitrary precision with other code. A jam by less than 1e-10 is none."""
    ((armature, before, after),) = ROBOT.thresholds(ROBOT.biped_that_jams)
    assert armature == pytest.approx(1.602467664252, abs=1e-9)
    assert (before, after) == ("no-solution", "undecided")
    assert ROBOT.word(ROBOT.biped_that_jams(locked="all")) == "stable"


@pytest.fixture(scope="module")
def solo():
    robot = ROBOT.solo()
    if robot is None:
        pytest.skip("example-robot-data is not installed")
    return robot


@pytest.mark.usefixtures("solo")
def test_a_quadruped_in_the_plane_moves_like_the_one_in_space():
    """Reduced: M q̈ = −h + Jᵀf has the acceleration of the whole robot, on a free flyer, under the same forces."""
    solo = ROBOT.solo()
    model, data = solo.model, solo.data
    # Its upper legs have their centres 1.4e-5 m before the hip on the left, as much behind it on the right: here in the middle.
    for leg in ("FL", "FR", "HL", "HR"):
        inertia = model.inertias[model.getJointId(f"{leg}_HFE")]
        inertia.lever = inertia.lever * [0, 1, 1]
    rng = np.random.default_rng(20_260_402)
    for _ in range(20):
        whole = solo.q(*rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 4))
        plane = sf.robots.from_pinocchio(
            solo, data, whole, ["FL_FOOT", "HL_FOOT"], friction=1.0
        )
        forces = rng.normal(size=(2, 2))
        load = plane.load.copy()
        for foot, (along, up) in zip(plane.contacts, forces, strict=True):
            load += along * foot.tangential + up * foot.normal
        expected = np.linalg.solve(plane.mass_matrix, load)

        pin.computeJointJacobians(model, data, whole)
        pin.updateFramePlacements(model, data)
        load = -pin.computeGeneralizedGravity(model, data, whole)
        for side, (along, up) in zip("FH", forces, strict=True):
            for name in (f"{side}L_FOOT", f"{side}R_FOOT"):
                frame = model.getFrameId(name)
                J6 = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
                load += J6[:3].T @ [along / 2, 0, up / 2]
        found = np.linalg.solve(pin.crba(model, data, whole), load)
        # The velocity of the free flyer is in axes of the trunk; at rest, so is its acceleration.
        trunk = data.oMi[1].rotation @ found[:3]
        assert np.array([trunk[0], trunk[2], -found[4]]) == pytest.approx(
            expected[:3], rel=1e-9, abs=1e-9
        )
        assert found[6:] == pytest.approx((solo.S @ expected)[6:], rel=1e-9, abs=1e-9)
        assert [trunk[1], found[3], found[5]] == pytest.approx([0, 0, 0], abs=1e-9)


def pair_stiffness(mechanism):
    """k_11 + k_12 while both feet slide apart, k_ij = N_i M⁻¹(N_j − σ_j μ T_j)ᵀ, σ = (1, −1); M with its armature."""
    one, two = mechanism.contacts
    M = mechanism.mass_matrix
    if mechanism.armature is not None:
        M = M + np.diag(mechanism.armature)
    pulls = [
        foot.normal - side * foot.friction * foot.tangential
        for foot, side in ((one, 1), (two, -1))
    ]
    return one.normal @ np.linalg.solve(M, sum(pulls))


def test_the_threshold_of_the_quadruped(solo):
    """Its posture is its own mirror image. While both feet slide apart with equal normal forces f > 0, their normal acceleration is
    (k_11 + k_12) f − g: below the threshold no f stops it."""
    q = ROBOT.stance(solo, *ROBOT.PLACES["A"])

    def of(armature=0.0, locked=()):
        return ROBOT.standing(solo, q, ROBOT.FRICTION, locked, armature)

    assert ROBOT.word(of(locked="all")) == "stable"
    (armature, *words), (higher, *later) = ROBOT.thresholds(of)
    assert words == ["no-solution", "undecided"]
    assert armature == pytest.approx(0.000323795175, abs=1e-11)
    # Between both it is proved stable.
    assert later == ["stable", "undecided"]
    assert higher == pytest.approx(0.0113282153529, abs=1e-10)
    assert ROBOT.word(of(0.001)) == "stable"
    assert pair_stiffness(of(armature * (1 - 1e-6))) < 0
    assert pair_stiffness(of(armature * (1 + 1e-6))) > 0


def test_the_example_is_drawn(solo, tmp_path, capsys):
    path = tmp_path / "robot.png"
    ROBOT.main(path, points=8)
    assert path.stat().st_size > 20_000
    lines = capsys.readouterr().out
    assert "armature 1.602467664047 kg m²: no-solution -> undecided" in lines
    assert "Solo 8, 2.178 kg" in lines


@pytest.mark.parametrize("page", ["mechanisms.md", "robots.md"])
def test_the_code_of_the_pages_prints_what_it_says(page, solo, monkeypatch, capsys):
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    monkeypatch.chdir(ROOT)
    for block in re.findall(r"^```py\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        if "import mujoco" in block:
            pytest.importorskip("mujoco")
        code = re.sub(r'"(\w+\.urdf)"', lambda name: repr(robot_file(name[1])), block)
        exec(code, {"math": math, "pin": pin, "sf": sf, "urdf": robot_file("a1.urdf")})
        lines = capsys.readouterr().out.splitlines()
        assert lines == re.findall(r"# (<Verdict.*|\[.*)$", block, re.MULTILINE)


def robot_file(name):
    return next(str(f.locate()) for f in files("example-robot-data") if f.name == name)


def test_the_map_of_footholds(solo, tmp_path):
    """The page has the lines of the example that are about the robot."""
    page = (ROOT / "docs" / "robots.md").read_text(encoding="utf-8")
    code = (EXAMPLES / "footholds.py").read_text(encoding="utf-8")
    lines = code.partition("# the robot\n")[2].partition("# the map\n")[0]
    assert lines in page
    assert sum(bool(line.strip()) for line in lines.splitlines()) <= 15
    footholds = example("footholds")
    path = tmp_path / "footholds.png"
    footholds.main(path, points=16)
    assert path.stat().st_size > 20_000
    verdict = sf.stability(footholds.posture(0.4, 0.18))
    assert footholds.word(verdict) == "stable"
    # The front feet are where the map says.
    robot = footholds.robot
    pin.updateFramePlacements(robot.model, robot.data)
    foot = robot.data.oMf[robot.model.getFrameId("FR_foot")].translation
    assert foot[[0, 2]] == pytest.approx([0.4, 0.05 * math.sin(8)], abs=1e-12)


@pytest.mark.parametrize("order", ["urdf", "branches mixed"])
def test_crba_needs_joints_branch_by_branch(order):
    """As the page says: otherwise M is not that of the kinetic energy."""
    parents = (0, 1, 1, 2) if order == "branches mixed" else (0, 1, 2, 1)
    model = pin.Model()
    for k, parent in enumerate(parents, start=1):
        model.addJoint(parent, pin.JointModelRY(), shifted(1.0), f"joint {k}")
        model.appendBodyToJoint(
            k, pin.Inertia(1, np.array([0.5, 0, 0]), np.eye(3)), pin.SE3.Identity()
        )
    data, q, v = model.createData(), np.full(4, 0.3), np.arange(1.0, 5.0)
    M = pin.crba(model, data, q)
    energy = pin.computeKineticEnergy(model, model.createData(), q, v)
    right = 0.5 * v @ M @ v == pytest.approx(energy, rel=CLOSE)
    assert right == (order == "urdf")

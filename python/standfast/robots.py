"""Robots of Pinocchio and MuJoCo as mechanisms: M, h and the Jacobians of the feet in one posture, in the plane of x and the height.

The coordinates of the mechanism are (x, z, pitch, joints) of a robot with a floating base: place of the base and its pitch, counterclockwise in
the plane of x and the height, so with the opposite sign of a rotation about +y; (joints) of one whose base is fixed. Joints keep the signs
and the order of the library. Units are SI, angles are in rad.

`from_pinocchio` and `from_mujoco` compute a mechanism. `sagittal` reduces a robot in space with equal left and right to its plane of symmetry.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal
from weakref import ref

import numpy as np
import numpy.typing as npt

from standfast._core import ContactRows, HoldingTorques, Mechanism
from standfast.signatures import with_names_only
from standfast.suggest import nearest

__all__ = ["Sagittal", "from_mujoco", "from_pinocchio", "sagittal"]


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


# Types of Pinocchio and MuJoCo are `Any`: neither library says its own.
_Floats = npt.NDArray[np.float64]
_Bools = npt.NDArray[np.bool_]
_Ints = npt.NDArray[np.intp]
#: One foot: its name; of a robot in space the names of the left and the right one.
Foot = str | tuple[str, str]
#: Slope of the ground (rad) and friction.
Ground = tuple[float, float]

#: Angle (rad), or share of the size of the robot, by which axes may differ from those of a motion in the plane and from their mirror images.
#: A right angle written as 1.57 is off by 8e-4. The error in M and in the rows is its square.
AXIS = 1e-3
#: Angle (rad) by which a base may be tilted out of the plane, and left joints may differ from right ones: simulated robots at rest have some 1e-5.
TILT = 1e-3
#: Deviation from 1 of the length of a quaternion, and of the pair (cos, sin) of a joint without limits; numbers of six digits are allowed.
UNIT = 1e-5
#: Share by which left and right masses may differ; places of centres of mass by this share of the size of the robot, and inertias by this share
#: of mass times the square of this size. The trunk of the quadruped A1 has its centre 1.4 % of its size beside the middle.
MIRROR = 0.03
#: A larger angle (rad) is one in degrees.
TURN = 2 * math.pi
#: Masses (kg) below which a body counts as none.
MASSLESS = 1e-9
#: Share of gravity that may be across the plane: rounding.
ACROSS = 1e-9


class _Plane:
    """Indices of x, of the height and of the axis across; +1 where counterclockwise is a positive rotation about it."""

    def __init__(self, along: int, height: int, across: int, sign: float) -> None:
        self.along, self.height, self.across, self.sign = along, height, across, sign
        #: Of a velocity (linear, angular), those in the plane, and those that leave it.
        self.rows = np.array([along, height, 3 + across])
        self.out = np.array([across, 3 + along, 3 + height])


_PLANES = {"xz": _Plane(0, 2, 1, -1.0), "xy": _Plane(0, 1, 2, 1.0)}


def _unusable(name: str, value: object, allowed: str) -> ValueError:
    return ValueError(f"{name} = {value} cannot be used: {allowed}")


def _floats(name: str, values: Any) -> _Floats:
    try:
        array = np.asarray(values)
        if array.dtype != bool:
            return array.astype(float, copy=False)
    except (TypeError, ValueError):
        pass
    raise _unusable(name, repr(values), "numbers")


def _number(name: str, value: Any) -> float:
    array = _floats(name, value)
    if array.ndim:
        raise _unusable(name, repr(value), "a number")
    return float(array)


@dataclass
class _Bodies:
    """Origins (n, 3) of joints, and masses, centres (n, 3) and inertias about them (n, 3, 3) of what they carry, in axes of the base; the base last."""

    parents: list[int]
    screws: _Floats
    origins: _Floats
    masses: _Floats
    centers: _Floats
    inertias: _Floats

    @property
    def size(self) -> float:
        return max(float(np.linalg.norm(self.origins, axis=1).max()), 1e-3)


@dataclass
class _Terms:
    """M, h, velocity of the base (6, …) and of each point (3, nv) for its coordinates."""

    M: _Floats
    h: _Floats
    base: _Floats
    points: list[_Floats]


class _Library:
    """What is known of a model without a posture. The model itself is not kept: views of models live as long as these."""

    name: str
    #: Order of the entries of a quaternion.
    order: str
    nq: int
    nv: int
    base: Literal["free", "planar", "pinned"]
    base_name: str
    #: Numbers of q and of velocities of the base.
    base_nq: int
    base_nv: int
    #: Names of the joints but those of the base, and their places in q and in velocities.
    names: list[str]
    iq: _Ints
    iv: _Ints
    #: Hinges among them, and those whose q is (cos, sin).
    hinges: _Bools
    circles: list[int]
    #: q of the library for the robot at rest in its own zero, and the angles of its joints there.
    q0: _Floats
    reference: _Floats
    quaternion: slice | None
    #: First entries of (cos, sin) in q, and entries that are angles, with the names of their joints.
    units: list[int]
    angles: list[int]
    angle_names: list[str]

    def joint_values(self, q: _Floats) -> _Floats:
        values: _Floats = q[self.iq]
        for k in self.circles:
            cosine, sine = q[self.iq[k] : self.iq[k] + 2]
            values[k] = math.atan2(sine, cosine)
        return values

    def check_q(self, q: npt.ArrayLike, name: str) -> _Floats:
        values = _floats(name, q)
        if values.shape != (self.nq,):
            raise _unusable(
                name,
                f"array of shape {list(values.shape)}",
                f"{self.nq} numbers, the nq of the model",
            )
        # Lists: a map has ten thousand postures, and numpy takes a microsecond for each of its calls.
        numbers = values.tolist()
        if not math.isfinite(sum(numbers)):
            for k, number in enumerate(numbers):
                if not math.isfinite(number):
                    raise _unusable(f"{name}[{k}]", number, "finite numbers")
        if self.quaternion is not None:
            self._check_length(numbers, self.quaternion, name, "a quaternion")
        for start in self.units:
            place = slice(start, start + 2)
            self._check_length(numbers, place, name, "the cosine and sine of an angle")
        for k, joint in zip(self.angles, self.angle_names, strict=True):
            if abs(numbers[k]) > TURN:
                raise _unusable(
                    f"{name}[{k}]",
                    numbers[k],
                    f"an angle of at most 2π; joint {joint!r} in degrees? Angles are in rad",
                )
        return values

    def _check_length(self, numbers: list[float], place: slice, name: str, what: str) -> None:  # fmt: skip
        length = math.hypot(*numbers[place])
        if not abs(length - 1) <= UNIT:
            raise _unusable(
                f"{name}[{place.start}:{place.stop}]",
                numbers[place],
                f"{what}, of length 1; its length is {length:.6g}",
            )

    # What the libraries compute: of a model, its data and a posture.
    def new_data(self, model: Any) -> Any:
        raise NotImplementedError

    def origin(self, data: Any) -> _Floats:
        """Place of the base, after `terms`."""
        raise NotImplementedError

    def check_data(self, model: Any, data: Any) -> None:
        raise NotImplementedError

    def gravity(self, model: Any) -> _Floats:
        raise NotImplementedError

    def armature(self, model: Any) -> _Floats:
        raise NotImplementedError

    def terms(self, model: Any, data: Any, q: _Floats, points: Sequence[Any], plane: _Plane) -> _Terms:  # fmt: skip
        raise NotImplementedError

    def off(self, data: Any, free: _Ints, plane: _Plane) -> _Floats:
        """How far these joints are from moving in the plane, after `terms`: numbers (…, joints) that are 0 if they do."""
        raise NotImplementedError

    def point(self, model: Any, name: str) -> Any:
        """What names a foot for `terms`; ValueError with the nearest name."""
        raise NotImplementedError

    def bodies(self, model: Any) -> _Bodies:
        raise NotImplementedError

    def place(self, model: Any, point: Any) -> tuple[int, _Floats]:
        """Of a foot at `q0`: the joint that carries it, -1 for the base, and its place in axes of the base."""
        raise NotImplementedError

    def alike(self, model: Any, point: Any) -> list[tuple[str, Any]]:
        """Names and points of the same kind."""
        raise NotImplementedError

    def base_q(self, model: Any, x: float, z: float, pitch: float) -> _Floats:
        """q of a free base."""
        raise NotImplementedError


class _Pinocchio(_Library):
    name = "pinocchio"
    order = "(x, y, z, w)"

    def __init__(self, model: Any) -> None:
        import pinocchio

        self.pin = pinocchio
        self.frame = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        self.nq, self.nv, self.njoints = model.nq, model.nv, model.njoints
        if getattr(model, "nvExtended", model.nv) != model.nv:
            raise _unusable("model", model.name, "a model without mimic joints")
        kinds = [joint.shortname() for joint in model.joints]
        names, parents = list(model.names), [int(parent) for parent in model.parents]
        data = model.createData()
        self.no_base = np.zeros((6, 0))
        self.q0 = np.array(pinocchio.neutral(model))
        pinocchio.computeJointJacobians(model, data, self.q0)
        self._find_base(model, kinds, parents, np.array(data.J))
        first = self.base_joint + 1
        self.base_name = names[self.base_joint]
        for k in range(first, model.njoints):
            joint = model.joints[k]
            if joint.nv != 1 or joint.nq > 2:
                raise _unusable(
                    f"joint {names[k]!r}",
                    kinds[k],
                    "hinges and sliders; a floating base is the first joint: a free flyer, or PX, PZ and RY",
                )
            if self.base != "pinned" and parents[k] == 0:
                raise _unusable(
                    f"joint {names[k]!r}",
                    "a joint on the ground",
                    "joints that the floating base carries",
                )
        joints = [model.joints[k] for k in range(first, model.njoints)]
        self.names = names[first:]
        self.iq = np.array([joint.idx_q for joint in joints], dtype=np.intp)
        self.iv = np.array([joint.idx_v for joint in joints], dtype=np.intp)
        self.circles = [k for k, joint in enumerate(joints) if joint.nq == 2]
        self.units = [int(self.iq[k]) for k in self.circles]
        turns = np.abs(data.J[3:]).max(axis=0, initial=0.0) > 0.5
        self.hinges = turns[self.iv]
        self.reference = np.zeros(len(joints))
        self.quaternion = slice(3, 7) if self.base == "free" else None
        angles = [
            k for k, joint in enumerate(joints) if joint.nq == 1 and turns[joint.idx_v]
        ]
        self.angles = [int(self.iq[k]) for k in angles]
        self.angle_names = [self.names[k] for k in angles]
        if self.base == "planar" and self.base_nq == 3:
            self.angles = [*np.flatnonzero(turns[:3]).tolist(), *self.angles]
            self.angle_names = [self.base_name, *self.angle_names]
        elif self.base == "planar":
            self.units = [2, *self.units]

    def _find_base(self, model: Any, kinds: list[str], parents: list[int], J: _Floats) -> None:  # fmt: skip
        self.base, self.base_joint, self.base_nq, self.base_nv = "pinned", 0, 0, 0
        if model.njoints < 2:
            raise _unusable("model", model.name, "a model with joints")
        one = model.joints[1]
        if kinds[1] == "JointModelFreeFlyer":
            self.base, self.base_joint, self.base_nq, self.base_nv = "free", 1, 7, 6
        elif kinds[1] == "JointModelPlanar":
            self.base, self.base_joint, self.base_nq, self.base_nv = "planar", 1, 4, 3
        elif one.nq == one.nv == 3 and _is_planar(J[:, :3]):
            self.base, self.base_joint, self.base_nq, self.base_nv = "planar", 1, 3, 3
        elif model.njoints > 3:
            joints = [model.joints[k] for k in (1, 2, 3)]
            apart = all(joint.nq == joint.nv == 1 for joint in joints)
            light = max(model.inertias[1].mass, model.inertias[2].mass) < MASSLESS
            if apart and light and parents[1:4] == [0, 1, 2] and _is_planar(J[:, :3]):
                self.base, self.base_joint = "planar", 3
                self.base_nq, self.base_nv = 3, 3

    def new_data(self, model: Any) -> Any:
        return model.createData()

    def origin(self, data: Any) -> _Floats:
        return np.array(data.oMi[self.base_joint].translation)

    def check_data(self, model: Any, data: Any) -> None:
        if not isinstance(data, self.pin.Data):
            raise _unusable(
                "data", type(data).__name__, "model.createData() of the same model"
            )
        if not model.check(data):
            raise _unusable(
                "data", "data of another model", "model.createData() of the same model"
            )

    def gravity(self, model: Any) -> _Floats:
        return np.asarray(model.gravity.linear)

    def armature(self, model: Any) -> _Floats:
        return np.asarray(model.armature)

    def terms(self, model: Any, data: Any, q: _Floats, points: Sequence[Any], plane: _Plane) -> _Terms:  # fmt: skip
        pin, frame = self.pin, self.frame
        M = pin.crba(model, data, q)
        h = pin.computeGeneralizedGravity(model, data, q)
        pin.computeJointJacobians(model, data, q)
        get = pin.getFrameJacobian
        feet = [get(model, data, point, frame)[:3] for point in points]
        base = self.no_base
        if self.base_nv:
            base = pin.getJointJacobian(model, data, self.base_joint, frame)
            base = base[:, : self.base_nv]
        return _Terms(M, h, base, feet)

    def off(self, data: Any, free: _Ints, plane: _Plane) -> _Floats:
        found: _Floats = data.J[plane.out[:, None], self.iv[free]]
        return found

    def point(self, model: Any, name: str) -> int:
        index = int(model.getFrameId(name))
        if index >= model.nframes:
            frames = [frame.name for frame in model.frames]
            raise _unusable(
                "feet",
                repr(name),
                f"names of frames of the model{nearest(name, frames)}",
            )
        if model.frames[index].parentJoint == 0:
            raise _unusable("feet", repr(name), "frames on bodies that move")
        return index

    def bodies(self, model: Any) -> _Bodies:
        pin, first = self.pin, self.base_joint + 1
        data = model.createData()
        pin.computeJointJacobians(model, data, self.q0)
        world = data.oMi[self.base_joint].inverse()
        order = [*range(first, model.njoints), self.base_joint]
        places = [world * data.oMi[k] for k in order]
        bodies = [place.act(model.inertias[k]) for place, k in zip(places, order, strict=True)]  # fmt: skip
        screws = [world.act(pin.Motion(data.J[:, k])).vector for k in self.iv]
        return _Bodies(
            [int(model.parents[k]) - first for k in order[:-1]],
            np.array(screws).reshape(-1, 6),
            np.array([place.translation for place in places]),
            np.array([body.mass for body in bodies]),
            np.array([body.lever for body in bodies]),
            np.array([body.inertia for body in bodies]),
        )

    def place(self, model: Any, point: Any) -> tuple[int, _Floats]:
        data = model.createData()
        self.pin.forwardKinematics(model, data, self.q0)
        self.pin.updateFramePlacements(model, data)
        frame = model.frames[point]
        place = data.oMi[self.base_joint].actInv(data.oMf[point]).translation
        return int(frame.parentJoint) - self.base_joint - 1, np.array(place)

    def alike(self, model: Any, point: Any) -> list[tuple[str, Any]]:
        kind = model.frames[point].type
        return [(frame.name, k) for k, frame in enumerate(model.frames) if frame.type == kind and frame.parentJoint > 0]  # fmt: skip

    def base_q(self, model: Any, x: float, z: float, pitch: float) -> _Floats:
        turned = self.pin.SE3(self.pin.utils.rotate("y", -pitch), np.array([x, 0.0, z]))
        return np.asarray(
            self.pin.SE3ToXYZQUAT(model.jointPlacements[1].actInv(turned))
        )


def _is_planar(columns: _Floats) -> bool:
    """Two sliders and a hinge, across their plane."""
    turns = np.abs(columns[3:]).max(axis=0) > 0.5
    if turns.sum() != 1:
        return False
    axis = columns[3:, turns][:, 0]
    slides = columns[:3, ~turns]
    normal = np.cross(slides[:, 0], slides[:, 1])
    return bool(abs(np.linalg.norm(normal) * abs(normal @ axis) - 1) < AXIS)


class _Mujoco(_Library):
    name = "mujoco"
    order = "(w, x, y, z)"

    def __init__(self, model: Any) -> None:
        import mujoco

        self.mj = mujoco
        self.nq, self.nv = model.nq, model.nv
        kinds = [int(kind) for kind in model.jnt_type]
        free, hinge = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_HINGE)
        slide = int(mujoco.mjtJoint.mjJNT_SLIDE)
        names = [model.joint(k).name or f"joint {k}" for k in range(model.njnt)]
        if not kinds:
            raise _unusable("model", "a model without joints", "a model with joints")
        data = mujoco.MjData(model)
        if data.eq_active.any():
            raise _unusable(
                "model", "a model with active equalities", "open chains of bodies"
            )
        self.q0 = np.array(model.qpos0)
        if kinds[0] == free:
            self.q0[:7] = [0, 0, 0, 1, 0, 0, 0]
        data.qpos[:] = self.q0
        mujoco.mj_kinematics(model, data)
        self.base, self.base_joints, self.base_nq, self.base_nv = "pinned", 0, 0, 0
        if kinds[0] == free:
            self.base, self.base_joints, self.base_nq, self.base_nv = "free", 1, 7, 6
        elif (
            sorted(kinds[:3]) == [slide, slide, hinge]
            and _is_planar(self._screws(data, kinds, 3).T)
            and self._light(model)
        ):
            self.base, self.base_joints = "planar", 3
            self.base_nq, self.base_nv = 3, 3
        self.base_body = int(model.jnt_bodyid[max(self.base_joints - 1, 0)])
        self.base_name = names[max(self.base_joints - 1, 0)]
        first = self.base_joints
        for k in range(first, model.njnt):
            if kinds[k] not in (hinge, slide):
                kind = mujoco.mjtJoint(kinds[k]).name
                raise _unusable(
                    f"joint {names[k]!r}",
                    kind,
                    "hinges and sliders; a floating base is the first joint: free, or two slides and a hinge",
                )
            root = int(model.body_rootid[model.jnt_bodyid[k]])
            if self.base != "pinned" and root != model.body_rootid[self.base_body]:
                raise _unusable(
                    f"joint {names[k]!r}",
                    "a joint on the ground",
                    "joints that the floating base carries",
                )
        self.names = names[first:]
        self.iq = np.array(model.jnt_qposadr[first:], dtype=np.intp)
        self.iv = np.array(model.jnt_dofadr[first:], dtype=np.intp)
        self.hinges = np.array(kinds[first:]) == hinge
        self.circles, self.units = [], []
        self.reference = self.q0[self.iq]
        self.quaternion = slice(3, 7) if self.base == "free" else None
        angles = [k for k in range(model.njnt) if kinds[k] == hinge]
        self.angles = [int(model.jnt_qposadr[k]) for k in angles]
        self.angle_names = [names[k] for k in angles]

    def _screws(self, data: Any, kinds: list[int], count: int) -> _Floats:
        axes, anchors = np.array(data.xaxis), np.array(data.xanchor)
        turns = np.array(kinds) == int(self.mj.mjtJoint.mjJNT_HINGE)
        linear = np.where(turns[:, None], np.cross(anchors, axes), axes)
        return np.hstack([linear, np.where(turns[:, None], axes, 0.0)])[:count]

    def _light(self, model: Any) -> bool:
        """Joints of one body, or of bodies without mass within each other."""
        one, two, three = (int(body) for body in model.jnt_bodyid[:3])
        nested = [one, two, three]
        inner = {body for body in nested if body != three}
        chain = all(
            below == body or model.body_parentid[below] == body
            for body, below in ((one, two), (two, three))
        )
        light = sum(float(model.body_mass[body]) for body in inner) < MASSLESS
        return chain and light and model.body_parentid[one] == 0

    def new_data(self, model: Any) -> Any:
        return self.mj.MjData(model)

    def origin(self, data: Any) -> _Floats:
        return np.array(data.xpos[self.base_body])

    def check_data(self, model: Any, data: Any) -> None:
        if not isinstance(data, self.mj.MjData):
            raise _unusable("data", type(data).__name__, "MjData of the same model")
        # The number that each compiled model has of its own.
        mine, other = model.signature, data.signature
        if mine != other or data.qpos.shape != (self.nq,):
            raise _unusable("data", "data of another model", "MjData of the same model")

    def gravity(self, model: Any) -> _Floats:
        return np.asarray(model.opt.gravity)

    def armature(self, model: Any) -> _Floats:
        return np.asarray(model.dof_armature)

    def terms(self, model: Any, data: Any, q: _Floats, points: Sequence[Any], plane: _Plane) -> _Terms:  # fmt: skip
        mj, nv = self.mj, self.nv
        data.qpos[:] = q
        moving = np.array(data.qvel)
        data.qvel[:] = 0
        mj.mj_kinematics(model, data)
        mj.mj_comPos(model, data)
        if hasattr(mj, "mj_makeM"):
            mj.mj_makeM(model, data)
        else:
            mj.mj_crb(model, data)
        mj.mj_comVel(model, data)
        h = np.empty(nv)
        mj.mj_rne(model, data, 0, h)
        data.qvel[:] = moving
        M = np.zeros((nv, nv))
        self._full(model, data, M)
        feet = []
        for kind, index in points:
            jac = np.empty((3, nv))
            body, place = self._point(model, data, kind, index)
            mj.mj_jac(model, data, jac, None, place, body)
            feet.append(jac)
        base = np.zeros((6, nv))
        if self.base_nv:
            mj.mj_jacBody(model, data, base[:3], base[3:], self.base_body)
        return _Terms(M, h, base[:, : self.base_nv], feet)

    def off(self, data: Any, free: _Ints, plane: _Plane) -> _Floats:
        axes = data.xaxis[self.base_joints + free].T
        in_plane = axes[[plane.along, plane.height]]
        off: _Floats = np.where(self.hinges[free], in_plane, axes[[plane.across]])
        return off

    def _full(self, model: Any, data: Any, M: _Floats) -> None:
        """`mj_fullM`, whose arguments changed with MuJoCo 4."""
        try:
            self.mj.mj_fullM(model, data, M)
        except TypeError:
            self.mj.mj_fullM(model, M, data.qM)

    def _point(self, model: Any, data: Any, kind: str, index: int) -> tuple[int, Any]:
        if kind == "site":
            return int(model.site_bodyid[index]), data.site_xpos[index]
        if kind == "geom":
            return int(model.geom_bodyid[index]), data.geom_xpos[index]
        return index, data.xpos[index]

    def point(self, model: Any, name: str) -> tuple[str, int]:
        kinds = self.mj.mjtObj
        for kind, number in (("site", kinds.mjOBJ_SITE), ("geom", kinds.mjOBJ_GEOM), ("body", kinds.mjOBJ_BODY)):  # fmt: skip
            index = self.mj.mj_name2id(model, number, name)
            if index >= 0:
                body = self._body(model, kind, index)
                if model.body_weldid[body] == 0:
                    raise _unusable("feet", repr(name), "points of bodies that move")
                return kind, index
        every = [point for kind in ("site", "geom", "body") for point, _ in self._all(model, kind)]  # fmt: skip
        raise _unusable(
            "feet",
            repr(name),
            f"names of sites, geoms or bodies of the model{nearest(name, every)}",
        )

    def _body(self, model: Any, kind: str, index: int) -> int:
        if kind == "body":
            return index
        return int((model.site_bodyid if kind == "site" else model.geom_bodyid)[index])

    def _all(self, model: Any, kind: str) -> list[tuple[str, Any]]:
        count = {"site": model.nsite, "geom": model.ngeom, "body": model.nbody}[kind]
        names = [getattr(model, kind)(k).name for k in range(count)]
        return [(name, (kind, k)) for k, name in enumerate(names) if name]

    def _joint_of(self, model: Any, body: int) -> int:
        """The last joint that moves a body, -1 for the base."""
        body = int(model.body_weldid[body])
        last = int(model.body_jntadr[body] + model.body_jntnum[body]) - 1
        return max(last - self.base_joints, -1)

    def bodies(self, model: Any) -> _Bodies:
        data = self.mj.MjData(model)
        data.qpos[:] = self.q0
        self.mj.mj_kinematics(model, data)
        self.mj.mj_comPos(model, data)
        first, count = self.base_joints, len(self.names)
        R = data.xmat[self.base_body].reshape(3, 3)
        origin = np.array(data.xpos[self.base_body])
        parents = []
        for k in range(first, model.njnt):
            body = int(model.jnt_bodyid[k])
            before = k > model.body_jntadr[body]
            over = int(model.body_parentid[body])
            parents.append(k - 1 - first if before else self._joint_of(model, over))
        axes = data.xaxis[first:] @ R
        anchors = (data.xanchor[first:] - origin) @ R
        turns = self.hinges[:, None]
        screws = np.hstack([np.where(turns, np.cross(anchors, axes), axes), np.where(turns, axes, 0.0)])  # fmt: skip
        masses = np.zeros(count + 1)
        moments = np.zeros((count + 1, 3))
        about = np.zeros((count + 1, 3, 3))
        for body in range(1, model.nbody):
            if model.body_weldid[body] == 0:
                continue
            k = self._joint_of(model, body)
            mass = float(model.body_mass[body])
            center = R.T @ (data.xipos[body] - origin)
            axis = R.T @ data.ximat[body].reshape(3, 3)
            masses[k] += mass
            moments[k] += mass * center
            about[k] += axis @ np.diag(model.body_inertia[body]) @ axis.T
            about[k] += mass * _of_point(center)
        centers = moments / np.maximum(masses, 1e-300)[:, None]
        inertias = np.array([whole - mass * _of_point(c) for whole, mass, c in zip(about, masses, centers, strict=True)])  # fmt: skip
        return _Bodies(
            parents,
            screws,
            np.vstack([anchors, np.zeros(3)]),
            masses,
            centers,
            inertias,
        )

    def place(self, model: Any, point: Any) -> tuple[int, _Floats]:
        data = self.mj.MjData(model)
        data.qpos[:] = self.q0
        self.mj.mj_kinematics(model, data)
        body, place = self._point(model, data, *point)
        R = data.xmat[self.base_body].reshape(3, 3)
        return self._joint_of(model, body), (place - data.xpos[self.base_body]) @ R

    def alike(self, model: Any, point: Any) -> list[tuple[str, Any]]:
        return self._all(model, point[0])

    def base_q(self, model: Any, x: float, z: float, pitch: float) -> _Floats:
        half = -0.5 * pitch
        return np.array([x, 0, z, math.cos(half), 0, math.sin(half), 0])


def _of_point(c: _Floats) -> _Floats:
    """Inertia of a unit mass at c about the origin."""
    inertia: _Floats = float(c @ c) * np.eye(3) - np.outer(c, c)
    return inertia


@dataclass
class _Touching:
    """A foot: what it is called, and the points whose mean touches the ground."""

    name: Foot
    aliases: tuple[str, ...]
    points: list[Any]


class _View:
    """Coordinates of a mechanism of a model: q̇ = S (x, z, pitch, joints), with the base level."""

    def __init__(self, library: _Library) -> None:
        self.library = library
        self.base_dof = 0 if library.base == "pinned" else 3
        #: Names of the joint coordinates; every name that leads to one, with its number from 0 and the factor of its angle.
        self.joints = tuple(library.names)
        self.known = {name: (k, 1.0) for k, name in enumerate(library.names)}
        self.fixed: dict[str, str] = {}
        self.S = np.zeros((library.nv, self.base_dof + len(self.joints)))
        self.S[library.iv, self.base_dof + np.arange(len(self.joints))] = 1
        #: Number of joints in each coordinate.
        self.counts = np.ones(len(self.joints))
        self.moving = np.arange(len(library.names))
        self.coordinate = np.arange(len(library.names))
        self.last_base = b"", self.S
        self.feet_found: dict[Any, list[_Touching]] = {}
        self.locked_found: dict[Any, tuple[list[int], _Ints]] = {}

    def check_posture(self, q: _Floats, name: str) -> None:
        """That q is a posture of this view."""

    def columns(self, base: _Floats, plane: _Plane) -> _Floats:
        """S with this Jacobian of the base. That of a base of PX, PZ and RY never changes."""
        if not self.base_dof:
            return self.S
        key = base.tobytes()
        last, columns = self.last_base
        if key != last:
            columns = self.S.copy()
            columns[: self.library.base_nv, :3] = _base_block(base, plane)
            self.last_base = key, columns
        return columns

    def locked(self, locked: str | Iterable[str]) -> tuple[list[int], _Ints]:
        """Locked coordinates of the mechanism, and the joints of the library that still move."""
        if not isinstance(locked, Iterable):
            raise _unusable("locked", repr(locked), "names of joints, or 'all'")
        names = (locked,) if isinstance(locked, str) else tuple(locked)
        if names not in self.locked_found:
            self.locked_found[names] = self._locked(names)
        return self.locked_found[names]

    def _locked(self, names: tuple[str, ...]) -> tuple[list[int], _Ints]:
        if names == ("all",):
            numbers = set(range(len(self.joints)))
        else:
            numbers = set()
            for name in names:
                if name in self.fixed:
                    continue
                if name not in self.known:
                    every = [*self.known, *self.fixed]
                    raise _unusable(
                        "locked",
                        repr(name),
                        f"names of joints of the model, or 'all'{nearest(str(name), every)}",
                    )
                numbers.add(self.known[name][0])
        free = [k for k, number in zip(self.moving, self.coordinate, strict=True) if number not in numbers]  # fmt: skip
        return [self.base_dof + k for k in sorted(numbers)], np.array(free, dtype=np.intp)  # fmt: skip

    def feet(self, model: Any, feet: Foot | Iterable[Foot]) -> list[_Touching]:
        names = (feet,) if isinstance(feet, str) else tuple(feet)
        try:
            known = self.feet_found.get(names)
        except TypeError:
            # Lists of left and right cannot be keys.
            names = tuple(f if isinstance(f, str) else (f[0], f[1]) for f in names)
            known = self.feet_found.get(names)
        if known is None:
            if not names:
                raise _unusable("feet", "[]", "at least one name")
            known = [self.foot(model, name) for name in names]
            seen: list[tuple[Any, Foot]] = []
            for foot, typed in zip(known, names, strict=True):
                for point in foot.points:
                    if again := [name for other, name in seen if other == point]:
                        raise _unusable(
                            "feet",
                            repr(typed),
                            f"each foot once, and left and right are one; {again[0]!r} is the same one",
                        )
                seen += [(point, typed) for point in foot.points]
            self.feet_found[names] = known
        return known

    def foot(self, model: Any, name: Foot) -> _Touching:
        if not isinstance(name, str):
            raise _unusable(
                "feet",
                repr(name),
                "names; pairs of left and right need sf.robots.sagittal(model) in place of model",
            )
        return _Touching(name, (name,), [self.library.point(model, name)])


#: Views of models by id, as long as the models live.
_VIEWS: dict[int, tuple[Any, _View]] = {}


def _view_of(model: Any, library: Callable[[Any], _Library]) -> _View:
    key = id(model)
    found = _VIEWS.get(key)
    if found is not None and found[0]() is model:
        view = found[1]
        if view.library.nv == model.nv:
            return view
    view = _View(library(model))
    _VIEWS[key] = ref(model, lambda _: _VIEWS.pop(key, None)), view
    return view


class Sagittal(_View):
    """A robot in space that moves in its plane of symmetry, y = 0 of its base: left and right joints together. Made by `sagittal`.

    Attributes
    ----------
    model : pinocchio.Model or mujoco.MjModel
        The model of the library.
    data : pinocchio.Data or mujoco.MjData
        Made when it is first used.
    joints : tuple of str
        Names of the joint coordinates, of a pair that of the left joint; its angle is that of the left one.
    coordinates : tuple of str
        ("x", "z", "pitch", *joints).
    pairs : tuple
        For each of `joints` the names (left, right), or (name,).
    fixed : dict
        Joints that do not move, with their mirror images.
    S : (nv, dof) ndarray
        q̇ = S (ẋ, ż, pitch rate, joints) for a level base; for a free flyer of Pinocchio, whose velocity is in axes of the base, the
        rows of x and z turn with the pitch.
    mirrored : dict
        For each joint of the library, its mirror image and the factor of its angle.
    """

    def __init__(self, model: Any, library: _Library, pairs: Iterable[Sequence[str]] | None, tolerance: float) -> None:  # fmt: skip
        if library.base == "pinned":
            raise _unusable(
                "model",
                "a robot with a fixed base",
                "one with a floating base: a free flyer, or PX, PZ and RY",
            )
        super().__init__(library)
        self.model = model
        pairs = None if pairs is None else tuple(pairs)
        self._pairs_given, self._tolerance = pairs, tolerance
        self._data: Any = None
        self._bodies = library.bodies(model)
        partners, signs = _mirrored(library, self._bodies, pairs)
        _check_masses(library, self._bodies, partners, tolerance)
        self.mirrored = {
            name: (library.names[partner], sign)
            for name, partner, sign in zip(library.names, partners, signs, strict=True)
        }
        self._partners, self._signs = partners, np.array(signs)
        self._gather()
        self._start = self._base_line() if library.base == "planar" else None
        self.S[: library.base_nv, :3] = self._level_base()

    def _gather(self) -> None:
        library, bodies = self.library, self._bodies
        names, size = library.names, bodies.size
        self.known = {}
        chosen: list[tuple[int, int, float]] = []
        pairs: list[tuple[str, ...]] = []
        #: Left and right joint, and the factor and the constant that make the angle of the right one.
        self._mirrors: list[tuple[int, int, float, float]] = []
        for one, other in enumerate(self._partners):
            if other < one:
                continue
            left, right = one, other
            if bodies.origins[one, 1] + bodies.centers[one, 1] < 0:
                left, right = other, one
            sign = float(self._signs[left])
            if left != right or sign < 0:
                zero = library.reference
                offset = float(zero[right] - sign * zero[left])
                self._mirrors.append((left, right, sign, offset))
            screw = bodies.screws[left]
            if max(abs(screw[3]), abs(screw[5]), abs(screw[1]) / size) > AXIS:
                self.fixed[names[left]], self.fixed[names[right]] = names[right], names[left]  # fmt: skip
                continue
            self.known[names[left]] = len(chosen), 1.0
            self.known[names[right]] = len(chosen), sign
            chosen.append((left, right, sign))
            pairs.append((names[left], names[right]) if left != right else (names[left],))  # fmt: skip
        if names and not chosen:
            raise _unusable(
                "model",
                f"{len(names)} joints, none of which moves in the plane of x and z",
                "joints about y of the base: a robot that looks along x",
            )
        self.joints = tuple(pair[0] for pair in pairs)
        self.coordinates = ("x", "z", "pitch", *self.joints)
        self.pairs = tuple(pairs)
        self.S = np.zeros((library.nv, 3 + len(chosen)))
        moving = []
        for column, (left, right, sign) in enumerate(chosen):
            self.S[library.iv[right], 3 + column] = sign
            self.S[library.iv[left], 3 + column] = 1
            moving += [(k, column) for k in sorted({left, right})]
        self.counts = np.array([float(len(pair)) for pair in pairs])
        self.moving = np.array([k for k, _ in moving], dtype=np.intp)
        self.coordinate = np.array([column for _, column in moving], dtype=np.intp)

    def _base_at(self, q: _Floats) -> tuple[_Floats, list[float]]:
        """(x, z, pitch) rates of the base for each of its coordinates, and its (x, z, pitch) at q0."""
        plane = _PLANES["xz"]
        terms = self.library.terms(self.model, self.data, q, [], plane)
        rates = terms.base[plane.rows]
        rates[2] *= plane.sign
        place = self.library.origin(self.data)
        return rates, [float(place[0]), float(place[2]), 0.0]

    def _base_line(self) -> tuple[_Floats, _Floats]:
        """Of a base of two sliders and a hinge about its origin: base coordinates = A ((x, z, pitch) − those at q0) + q0."""
        library = self.library
        if library.base_nq != 3:
            raise _unusable(
                f"joint {library.base_name!r}",
                "JointModelPlanar",
                "a free flyer, or PX, PZ and RY",
            )
        rates, place = self._base_at(library.q0)
        turned = library.q0.copy()
        turned[:3] += 1
        again, _ = self._base_at(turned)
        if np.abs(rates - again).max() > AXIS or abs(np.linalg.det(rates)) < 0.5:
            raise _unusable(
                f"joint {library.base_name!r}",
                "a base whose hinge is before its sliders, or away from its origin, or not across x and z",
                "a free flyer, or PX, PZ and RY in the plane of x and z",
            )
        return np.linalg.inv(rates).astype(float), np.array(place)

    def _level_base(self) -> _Floats:
        if self._start is not None:
            return self._start[0]
        return _base_block(np.eye(6), _PLANES["xz"])

    @property
    def data(self) -> Any:
        """Working memory of the library, for `from_pinocchio` and `from_mujoco`."""
        if self._data is None:
            self._data = self.library.new_data(self.model)
        return self._data

    def q(self, x: float = 0.0, z: float = 0.0, pitch: float = 0.0, joints: Mapping[str, float] | npt.ArrayLike = ()) -> _Floats:  # fmt: skip
        """The configuration (nq,) of the library: place of the base (m), pitch counterclockwise in the plane of x and z (rad), and joints.

        Parameters
        ----------
        x, z : float, m, default 0.0
        pitch : float, rad, default 0.0
        joints : dict or (joints,) array_like, rad, default ()
            {name: angle}, with the sign of the library; its mirror image gets the angle that belongs to it; joints that are not named
            are at zero. Or angles in the order of `joints`.

        Raises
        ------
        ValueError
            Names the joint.
        """
        library = self.library
        values = library.reference.copy()
        if not isinstance(joints, Mapping):
            angles = _floats("joints", joints)
            if angles.shape != (len(self.joints),) and angles.size:
                raise _unusable(
                    "joints",
                    f"array of shape {list(angles.shape)}",
                    f"{len(self.joints)} angles, of {', '.join(self.joints)}",
                )
            joints = dict(zip(self.joints, angles.tolist(), strict=False))
        for name, angle in joints.items():
            if name not in self.mirrored:
                raise _unusable(
                    "joints",
                    repr(name),
                    f"names of joints of the model{nearest(str(name), self.mirrored)}",
                )
            k = self._numbers[name]
            partner = self._partners[k]
            values[k] = library.reference[k] + angle
            values[partner] = library.reference[partner] + self._signs[k] * angle
        q = library.q0.copy()
        if self._start is None:
            q[:7] = library.base_q(self.model, x, z, pitch)
        else:
            A, start = self._start
            q[:3] += A @ (np.array([x, z, pitch]) - start)
        q[library.iq] = values
        for k in library.circles:
            q[library.iq[k]] = math.cos(values[k])
            q[library.iq[k] + 1] = math.sin(values[k])
        return q

    @property
    def _numbers(self) -> dict[str, int]:
        if not hasattr(self, "_number_of"):
            self._number_of = {name: k for k, name in enumerate(self.library.names)}
        return self._number_of

    def check_posture(self, q: _Floats, name: str) -> None:
        values, names = self.library.joint_values(q).tolist(), self.library.names
        for left, right, sign, offset in self._mirrors:
            expected = sign * values[left] + offset
            if abs(values[right] - expected) <= TILT:
                continue
            if left == right:
                raise _unusable(
                    f"{name} of joint {names[left]!r}",
                    values[left],
                    f"{expected / 2}: it moves out of the plane of symmetry",
                )
            raise _unusable(
                f"{name} of joints {names[left]!r} and {names[right]!r}",
                f"{values[left]} and {values[right]}",
                f"mirror images: {expected} for {names[right]!r}",
            )

    def foot(self, model: Any, name: Foot) -> _Touching:
        library = self.library
        names = (name,) if isinstance(name, str) else tuple(name)
        if len(names) not in (1, 2):
            raise _unusable("feet", repr(name), "a name, or a pair (left, right)")
        points = [library.point(model, one) for one in names]
        joint, place = library.place(model, points[0])
        partner = self._partners[joint] if joint >= 0 else -1
        image, near = place * [1, -1, 1], AXIS * self._bodies.size
        if len(names) == 1:
            if partner == joint and abs(place[1]) <= near:
                return _Touching(name, names, points)
            for other, point in library.alike(model, points[0]):
                on, there = library.place(model, point)
                if on == partner and np.abs(there - image).max() <= near:
                    points.append(point)
                    names = (names[0], other)
                    break
            else:
                raise _unusable(
                    "feet",
                    repr(name),
                    "feet that have a mirror image on the other side, or a pair (left, right)",
                )
        else:
            on, there = library.place(model, points[1])
            if on != partner or np.abs(there - image).max() > near:
                raise _unusable(
                    "feet",
                    repr(name),
                    f"mirror images; {names[0]!r} is at {place.round(6).tolist()} in axes of the base, {names[1]!r} at {there.round(6).tolist()}",
                )
        if place[1] < 0:
            points, names = points[::-1], names[::-1]
        return _Touching((names[0], names[1]), names, points)

    def __reduce__(self) -> tuple[Any, ...]:
        return sagittal, (self.model, self._pairs_given, self._tolerance)

    def __repr__(self) -> str:
        return f"<Sagittal: {', '.join(self.coordinates)}>"


def _mirrored(library: _Library, bodies: _Bodies, pairs: Iterable[Sequence[str]] | None) -> tuple[list[int], list[float]]:  # fmt: skip
    """For each joint its mirror image and the factor of its angle."""
    names, size = library.names, bodies.size
    given: dict[int, int] = {}
    for pair in pairs or ():
        if isinstance(pair, str) or len(pair) != 2:
            raise _unusable("pairs", repr(pair), "pairs of names (left, right)")
        for name in pair:
            if name not in names:
                raise _unusable(
                    "pairs",
                    repr(name),
                    f"names of joints of the model{nearest(name, names)}",
                )
        one, other = (names.index(name) for name in pair)
        given[one], given[other] = other, one
    branches = _branch_centers(bodies)
    scale = np.array([size, size, size, 1, 1, 1])
    partners: list[int] = []
    signs: list[float] = []
    for k, name in enumerate(names):
        parent = bodies.parents[k]
        over = partners[parent] if parent >= 0 else -1
        image = bodies.screws[k] * [1, -1, 1, -1, 1, -1]
        found: list[tuple[float, int, float]] = []
        for other in [given[k]] if k in given else range(len(names)):
            if bodies.parents[other] != over or library.hinges[other] != library.hinges[k]:  # fmt: skip
                continue
            off = [np.abs((image - sign * bodies.screws[other]) / scale).max() for sign in (1, -1)]  # fmt: skip
            if min(off) > AXIS:
                continue
            apart = np.linalg.norm(bodies.origins[k] * [1, -1, 1] - bodies.origins[other])  # fmt: skip
            apart += np.linalg.norm(branches[k] * [1, -1, 1] - branches[other])
            # Joints in the plane of symmetry are their own images, also where several are at one place.
            own = -AXIS * size if other == k else 0.0
            sign = 1.0 if off[0] <= off[1] else -1.0
            found.append((float(apart) + own, other, sign))
        if not found:
            meant = f"{names[given[k]]!r}" if k in given else "a joint on the other side"  # fmt: skip
            raise _unusable(
                f"joint {name!r}",
                "not mirrored",
                f"joints with a mirror image at y -> -y of the base {library.base_name!r}: {meant} does not have its place and axis",
            )
        _, partner, sign = min(found)
        partners.append(partner)
        signs.append(sign)
    for k, partner in enumerate(partners):
        if partners[partner] != k:
            raise _unusable(
                f"joint {names[k]!r}",
                f"mirrored by {names[partner]!r}, which mirrors {names[partners[partner]]!r}",
                "joints in pairs; name them in pairs=[(left, right), …]",
            )
    return partners, signs


def _branch_centers(bodies: _Bodies) -> _Floats:
    """Centres (n, 3) of all that each joint carries."""
    masses = bodies.masses.copy()
    moments = bodies.masses[:, None] * bodies.centers
    for k in range(len(bodies.parents) - 1, -1, -1):
        masses[bodies.parents[k]] += masses[k]
        moments[bodies.parents[k]] += moments[k]
    carried: _Floats = np.where(masses[:, None] > MASSLESS, moments / np.maximum(masses, MASSLESS)[:, None], bodies.origins)  # fmt: skip
    return carried


def _check_masses(library: _Library, bodies: _Bodies, partners: list[int], tolerance: float) -> None:  # fmt: skip
    if not 0 <= tolerance < math.inf:
        raise _unusable("tolerance", tolerance, "a number >= 0")
    names, size = [*library.names, library.base_name], bodies.size
    flip = np.array([1, -1, 1])
    allowed = f"mirror images within tolerance={tolerance:g}"
    for k, other in [*enumerate(partners), (-1, -1)]:
        one, two = bodies.masses[k], bodies.masses[other]
        heavier = max(one, two)
        if 0 <= other < k or heavier < MASSLESS:
            continue
        own = 0.5 if k == other else 1.0
        who = f"joints {names[k]!r} and {names[other]!r}" if k != other else f"joint {names[k]!r}"  # fmt: skip
        if abs(one - two) > tolerance * heavier:
            raise _unusable(f"masses behind {who}", f"{one:.6g} and {two:.6g} kg", allowed)  # fmt: skip
        centers = bodies.centers[k] * flip, bodies.centers[other]
        shift = own * float(np.abs(centers[0] - centers[1]).max())
        if shift > tolerance * size:
            raise _unusable(f"centres of mass behind {who}", f"{shift:.3g} m apart when mirrored", f"{allowed} of the size {size:.3g} m")  # fmt: skip
        change = np.abs(bodies.inertias[k] * np.outer(flip, flip) - bodies.inertias[other])  # fmt: skip
        if own * float(change.max()) > tolerance * heavier * size**2:
            raise _unusable(f"inertias behind {who}", f"{own * change.max():.3g} kg m² apart when mirrored", f"{allowed} of {heavier * size**2:.3g} kg m²")  # fmt: skip


@with_names_only
def sagittal(
    model: Any,
    pairs: Iterable[Sequence[str]] | None = None,
    tolerance: float = MIRROR,
) -> Sagittal:
    """A robot in space with equal left and right, in its plane of symmetry y = 0; `from_pinocchio` and `from_mujoco` take it in place of `model`.

    q̇ = S (ẋ, ż, pitch rate, joints): a column for each pair of joints about ±y, and for each such joint in the plane of symmetry;
    sliders in the plane likewise. Other joints (abduction, yaw) do not move: they keep the angles they have in q. The force of a pair
    of feet is that of both together, torque and armature of a pair of joints, too. Motions out of the plane are left out, and a small
    asymmetry is averaged.

    Parameters
    ----------
    model : pinocchio.Model or mujoco.MjModel
        With a floating base: a free flyer (`JointModelFreeFlyer`, a free joint), or two sliders along x and z and a hinge about y.
    pairs : iterable of (str, str), or None, default None
        Names (left, right) of joints; None: found by their places and axes at zero.
    tolerance : float, default 0.03
        Share by which left and right may differ: masses, places of centres by this share of the size of the robot, inertias of mass
        times the square of the size.

    Returns
    -------
    Sagittal
        With `.S`, `.joints`, `.pairs` and `.q(x, z, pitch, {joint: angle})`.

    Raises
    ------
    ValueError
        Names the joint without a mirror image, or the body whose mass, centre or inertia does not mirror.
    """
    kind = type(model).__module__.partition(".")[0]
    library: _Library
    if kind == "pinocchio":
        library = _Pinocchio(model)
    elif kind == "mujoco":
        library = _Mujoco(model)
    else:
        raise _unusable("model", type(model).__name__, "pinocchio.Model or mujoco.MjModel")  # fmt: skip
    return Sagittal(model, library, pairs, tolerance)


@with_names_only
def from_pinocchio(
    model: "Any | Sagittal",
    data: Any,
    q: npt.ArrayLike,
    feet: Sequence[Foot],
    plane: Literal["xz", "xy"] = "xz",
    locked: str | Iterable[str] = (),
    torques: Literal["holding", "least"] | npt.ArrayLike | None = None,
    ground: Mapping[Foot, Ground] | Ground | None = None,
    friction: float | None = None,
    restitution: float = 0.0,
    armature: float | npt.ArrayLike | None = None,
) -> Mechanism:
    """The mechanism of a robot of Pinocchio in the posture q, at rest, on the ground below its feet.

    The coordinates are (x, z, pitch, joints) with a floating base, the pitch counterclockwise in the plane, and (joints) with a fixed
    one. With all joints locked the mechanism is a rigid body with q = (x, y, θ) in its base. Joint friction, damping and limits are
    left out.

    Parameters
    ----------
    model : pinocchio.Model or Sagittal
        It moves in the plane: its base is fixed, `JointModelPlanar`, or PX, PZ and RY in one composite joint or in three; or
        `sagittal(model)` for a robot in space.
    data : pinocchio.Data
        `model.createData()`, working memory.
    q : (nq,) array_like
        As Pinocchio counts it.
    feet : sequence of str or (str, str)
        Names of frames; of a robot in space one name of a pair, or the pair (left, right).
    plane : {"xz", "xy"}
        The height last.
    locked : str or iterable of str, default ()
        Names of joints, or "all".
    torques : {None, "holding", "least"} or (joints,) array_like, N m
        None: zero. An array is in the order of Pinocchio, or of `sagittal(model).joints`, there those of both joints of a pair
        together. "holding" or "least": those of `Mechanism.holding_torques`, its choice or the least ones. If none hold the robot, they
        are zero, and `stability` says "not-equilibrium".
    ground : dict, (float, float) or None, default None
        {foot: (slope in rad, friction)}, or one pair for all; feet without an entry are on level ground with `friction`.
    friction : float or None, default None
        Coefficient of friction μ of these feet.
    restitution : float, in [0, 1], default 0.0
    armature : float, (joints,) array_like or None, kg m², default None
        A number for each joint (a pair has it twice), or as for torques, in place of that of the model; None: that of the model.

    Returns
    -------
    Mechanism

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.
    """
    view, model = _robot(model, _Pinocchio, "pinocchio.Model")
    return _mechanism(view, model, data, q, "q", feet, plane, locked, torques, ground, friction, restitution, armature)  # fmt: skip


@with_names_only
def from_mujoco(
    model: "Any | Sagittal",
    data: Any,
    feet: Sequence[Foot],
    plane: Literal["xz", "xy"] = "xz",
    locked: str | Iterable[str] = (),
    torques: Literal["holding", "least"] | npt.ArrayLike | None = None,
    ground: Mapping[Foot, Ground] | Ground | None = None,
    friction: float | None = None,
    restitution: float = 0.0,
    armature: float | npt.ArrayLike | None = None,
) -> Mechanism:
    """The mechanism of a robot of MuJoCo in the posture `data.qpos`, at rest, on the ground below its feet.

    M is `mj_fullM`, with armature, and h is `qfrc_bias` at zero velocity. Actuators, springs, damping, friction and limits of joints, and the
    contacts of MuJoCo are left out; a model with active equalities is refused.

    Parameters
    ----------
    model : mujoco.MjModel or Sagittal
        It moves in the plane: its base is fixed, or two slides and a hinge; or `sagittal(model)` for a robot with a free joint.
    data : mujoco.MjData
        Fields that depend on positions are computed anew, qpos and qvel stay.
    feet : sequence of str or (str, str)
        Names of sites, else of geoms, else of bodies; the contact is the point of the site, or the centre of the geom, or the
        origin of the body.
    plane : {"xz", "xy"}
        The height last.
    locked : str or iterable of str, default ()
        Names of joints, or "all".
    torques : {None, "holding", "least"} or (joints,) array_like, N m
        None: zero. An array is in the order of MuJoCo, or of `sagittal(model).joints`, there those of both joints of a pair
        together. "holding" or "least": those of `Mechanism.holding_torques`, its choice or the least ones. If none hold the robot, they
        are zero, and `stability` says "not-equilibrium".
    ground : dict, (float, float) or None, default None
        {foot: (slope in rad, friction)}, or one pair for all; feet without an entry are on level ground with `friction`.
    friction : float or None, default None
        Coefficient of friction μ of these feet.
    restitution : float, in [0, 1], default 0.0
    armature : float, (joints,) array_like or None, kg m², default None
        A number for each joint (a pair has it twice), or as for torques, in place of that of the model; None: that of the model.

    Returns
    -------
    Mechanism

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.
    """
    view, model = _robot(model, _Mujoco, "mujoco.MjModel")
    view.library.check_data(model, data)
    return _mechanism(view, model, data, np.array(data.qpos), "data.qpos", feet, plane, locked, torques, ground, friction, restitution, armature)  # fmt: skip


def _robot(model: Any, library: type[_Library], kind: str) -> tuple[_View, Any]:
    """The view, and the model of this library."""
    if isinstance(model, Sagittal):
        if model.library.name != library.name:
            other = f"a robot of {model.library.name}"
            raise _unusable("model", other, f"{kind}; from_{model.library.name} takes this one")  # fmt: skip
        return model, model.model
    if type(model).__module__.partition(".")[0] != library.name:
        raise _unusable("model", type(model).__name__, f"{kind}, or sagittal(model)")
    return _view_of(model, library), model


def _mechanism(
    view: _View,
    model: Any,
    data: Any,
    q: npt.ArrayLike,
    q_name: str,
    feet: Any,
    plane: str,
    locked: str | Iterable[str],
    torques: Any,
    ground: Any,
    friction: float | None,
    restitution: float,
    armature: Any,
) -> Mechanism:
    library = view.library
    if plane not in _PLANES:
        raise _unusable("plane", repr(plane), "'xz' or 'xy', the height last")
    axes = _PLANES[plane]
    if isinstance(view, Sagittal):
        if plane != "xz":
            raise _unusable("plane", repr(plane), "'xz': the plane of symmetry of a robot in space")  # fmt: skip
    elif library.base == "free":
        raise _unusable(
            "model",
            f"a free base {library.base_name!r}, which moves out of the plane",
            "sf.robots.sagittal(model) in its place, or a base of PX, PZ and RY",
        )
    library.check_data(model, data)
    values = library.check_q(q, q_name)
    view.check_posture(values, q_name)
    held = isinstance(torques, str)
    if held and torques not in ("holding", "least"):
        raise _unusable("torques", repr(torques), "'holding', 'least', numbers, or None")  # fmt: skip
    _check_gravity(library.gravity(model).tolist(), axes, plane, held)
    touching = view.feet(model, feet)
    surfaces = _surfaces(touching, ground, friction)
    fixed, free = view.locked(locked)
    points = [point for foot in touching for point in foot.points]
    terms = library.terms(model, data, values, points, axes)
    if library.base == "free":
        tilt = terms.base[3 + axes.along, 4], terms.base[3 + axes.height, 4]
        across, up = terms.base[3 + axes.across, 4], terms.base[3 + axes.height, 5]
        # A robot that looks the other way has its axis y turned, too.
        if max(map(abs, tilt)) > TILT or (across < 0 and up < 0):
            _tilted(terms.base[3:, 3:], q_name, library.order)
    elif view.base_dof and np.abs(terms.base[axes.out]).max() > AXIS:
        raise _unusable("plane", repr(plane), f"the plane in which the base {library.base_name!r} moves")  # fmt: skip
    off = library.off(data, free, axes)
    # The sum of all squares, which is quick, is rarely larger than that of the largest.
    if (flat := off.ravel()) @ flat > AXIS**2 and np.abs(off).max() > AXIS:
        worst = int(np.abs(off).max(axis=0).argmax())
        _out_of_plane(view, int(free[worst]), plane)
    S = view.columns(terms.base, axes)
    # One product for all: M, h and the Jacobians of the points.
    nv, dof = S.shape
    product = np.concatenate([terms.M, terms.h[None], *terms.points]).dot(S)
    M = S.T.dot(product[:nv])
    load = -product[nv]
    velocities = product[nv + 1 :].reshape(-1, 3, dof)
    rotors = None
    if armature is not None:
        rotors = _armature(view, armature)
        given = library.armature(model)
        if given[library.iv].any():
            joints = np.zeros(library.nv)
            joints[library.iv] = given[library.iv]
            M -= (S.T * joints) @ S
    M = 0.5 * (M + M.T)
    rows = []
    start = 0
    for foot, (slope, mu) in zip(touching, surfaces, strict=True):
        count = len(foot.points)
        J = velocities[start]
        if count == 2:
            J = 0.5 * (J + velocities[start + 1])
        start += count
        along, up = J[axes.along], J[axes.height]
        if slope:
            c, s = math.cos(slope), math.sin(slope)
            along, up = c * along + s * up, c * up - s * along
        rows.append(ContactRows(up, along, friction=mu))
    if torques is not None and not held:
        load[view.base_dof :] += _torques(view, torques)

    def mechanism() -> Mechanism:
        try:
            return Mechanism(M, load, rows, restitution=restitution, locked=fixed, armature=rotors)  # fmt: skip
        except ValueError as error:
            _, _, rest = str(error).partition("contacts.")
            number = rest.partition(".")[0]
            if number.isdigit():
                name = touching[int(number) - 1].name
                raise ValueError(f"foot {name!r}: {error}") from None
            raise

    made = mechanism()
    under = [k for k in range(view.base_dof, dof) if k not in fixed]
    if not held or not under:
        return made
    choose: Literal["middle", "least"] = "least" if torques == "least" else "middle"
    holding = made.holding_torques(under, choose=choose)
    if holding is None:
        return made
    load[under] += holding.torques
    return mechanism()


def _base_block(base: _Floats, plane: _Plane) -> _Floats:
    """Velocities of the base for those of (x, z, pitch), from its Jacobian in axes of the world."""
    if base.shape[1] == 6:
        # Axes of the base, at its origin: orthogonal.
        block: _Floats = base[plane.rows].T.copy()
    else:
        block = np.linalg.inv(base[plane.rows])
    block[:, 2] *= plane.sign
    return block


def _check_gravity(gravity: list[float], axes: _Plane, plane: str, held: bool) -> None:
    size = math.hypot(*gravity)
    if abs(gravity[axes.across]) > ACROSS * size or (size and gravity[axes.height] >= 0):  # fmt: skip
        raise _unusable("gravity of the model", gravity, f"downwards in the plane {plane!r}: {'z' if plane == 'xz' else 'y'} below 0, and none across")  # fmt: skip
    if held and not size:
        raise _unusable("gravity of the model", gravity, "a gravity against which torques can hold the robot")  # fmt: skip


def _tilted(R: _Floats, name: str, order: str) -> None:
    roll, yaw = math.atan2(R[2, 1], R[2, 2]), math.atan2(R[1, 0], R[0, 0])
    raise _unusable(
        f"{name} of the base",
        f"roll {roll:.6g} and yaw {yaw:.6g} rad",
        f"a base whose axis y is across the plane of x and z: without roll and yaw; the order of its quaternion is {order}",
    )


def _out_of_plane(view: _View, joint: int, plane: str) -> None:
    name = view.library.names[joint]
    if isinstance(view, Sagittal):
        raise _unusable(
            f"joint {name!r}",
            "a joint that in this posture moves out of the plane 'xz'",
            "joints about y; lock it, or put the joints before it to zero",
        )
    raise _unusable(
        f"joint {name!r}",
        f"a joint that moves out of the plane {plane!r}",
        "joints that move in the plane; lock it, or use sf.robots.sagittal(model)",
    )


def _surfaces(feet: list[_Touching], ground: Any, friction: float | None) -> list[Ground]:  # fmt: skip
    """Slope and friction below each foot."""
    level = None if friction is None else (0.0, _number("friction", friction))
    if ground is None:
        pairs = [level] * len(feet)
    elif isinstance(ground, Mapping):
        pairs = [level] * len(feet)
        given: dict[int, Foot] = {}
        for name, surface in ground.items():
            names = {name} if isinstance(name, str) else set(name)
            found = [k for k, foot in enumerate(feet) if names <= set(foot.aliases)]
            if not found:
                every = [alias for foot in feet for alias in foot.aliases]
                raise _unusable("ground", repr(name), f"names in feet{nearest(str(name), every)}")  # fmt: skip
            if found[0] in given:
                raise _unusable("ground", repr(name), f"one entry for each foot; {given[found[0]]!r} is the same one")  # fmt: skip
            given[found[0]] = name
            pairs[found[0]] = _pair(f"ground[{name!r}]", surface)
    else:
        if friction is not None:
            raise _unusable("friction", friction, "None where ground has the friction of all feet")  # fmt: skip
        pairs = [_pair("ground", ground)] * len(feet)
    checked = []
    for foot, pair in zip(feet, pairs, strict=True):
        if pair is None:
            raise _unusable("friction", None, f"a number, or ground={{{foot.name!r}: (slope, friction)}}")  # fmt: skip
        slope, mu = pair
        if not abs(slope) <= math.pi:
            raise _unusable(f"slope at {foot.name!r}", slope, "an angle in rad, from -π to π; in degrees?")  # fmt: skip
        if not 0 <= mu < math.inf:
            raise _unusable(f"friction at {foot.name!r}", mu, "a finite number >= 0")
        checked.append((slope, mu))
    return checked


def _pair(name: str, surface: Any) -> Ground:
    try:
        slope, friction = surface
        return _number(name, slope), _number(name, friction)
    except (TypeError, ValueError):
        raise _unusable(name, repr(surface), "a pair (slope in rad, friction)") from None  # fmt: skip


def _per_joint(view: _View, name: str, values: Any) -> _Floats:
    each = f"one entry for each of {len(view.joints)} joints: {', '.join(view.joints)}"
    if isinstance(values, Mapping):
        raise _unusable(name, repr(values), f"an array, {each}")
    if isinstance(values, HoldingTorques):
        raise _unusable(name, repr(values), f"its array .torques, {each}")
    array = _floats(name, values)
    if array.shape != (len(view.joints),):
        shape = f"array of shape {list(array.shape)}"
        raise _unusable(name, shape, each)
    if not np.isfinite(array).all():
        k = int(np.flatnonzero(~np.isfinite(array))[0])
        raise _unusable(f"{name} of joint {view.joints[k]!r}", array[k], "finite numbers")  # fmt: skip
    return array


def _torques(view: _View, torques: Any) -> _Floats:
    return _per_joint(view, "torques", torques)


def _armature(view: _View, armature: Any) -> _Floats:
    if isinstance(armature, int | float | np.number):
        number = _number("armature", armature)
        if not 0 <= number < math.inf:
            raise _unusable("armature", armature, "a finite number >= 0, in kg m²")
        array = number * view.counts
    else:
        array = _per_joint(view, "armature", armature)
    if array.size and array.min() < 0:
        k = int(array.argmin())
        raise _unusable(f"armature of joint {view.joints[k]!r}", array[k], "numbers >= 0, in kg m²")  # fmt: skip
    return np.concatenate([np.zeros(view.base_dof), array])

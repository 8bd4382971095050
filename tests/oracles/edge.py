"""A side of a body on a convex corner V of the ground: the motion from event to event, apart from the library.

The library works with the rows of the contact. Here the equations are those of Lagrange in the coordinates (b, φ):

    t, n   unit vectors along the side, at the angle φ, and into the body; t is n turned by −90°
    b, d   V − centre of mass = b t − d n, so that the side is d away from the centre of mass
    λ, τ   normal and tangential force on the body per unit mass; τ = μλ sgn(ḃ) where the side slips, since v_t = −ḃ

With c = −d, the kinetic energy is T = ½((cω − ḃ)² + (b² + ρ²)ω²) per unit mass, and

    b̈ − c ω̇ − b ω² = g t_y − τ
    (ρ² + b² + c²) ω̇ − c b̈ + 2 b ḃ ω = g (b n_y − c t_y)
    λ = g n_y + c ω² − 2 ḃ ω − b ω̇                                    (Newton, along n)
"""

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

#: Relative tolerance of the integrator per step; scipy allows no less than 2.2e-14.
RTOL = 3e-14
#: Absolute tolerance: below the rounding errors of starts as small as 1e-9.
ATOL = 1e-22


@dataclass(frozen=True)
class Side:
    """A side of a body, and what acts on it. Angles in rad, lengths in m."""

    d: float  # distance of the centre of mass
    low: float  # the ends of the side along t, from the foot of the centre of mass
    high: float
    rho2: float  # square of the radius of gyration
    friction: float
    gravity: float = 9.81
    angle: float = 0.0  # of t at θ = 0

    @staticmethod
    def of_box(width, height, friction, gravity=9.81, index=1):
        """Side ``index`` of a uniform box, counted from the lower one counterclockwise."""
        along, across = (width, height) if index % 2 else (height, width)
        return Side(
            across / 2,
            -along / 2,
            along / 2,
            (width**2 + height**2) / 12,
            friction,
            gravity,
            (index - 1) * math.pi / 2,
        )

    def state(self, corner, z):
        """Centre of mass and rotation (x, y, θ), and their rates, of z = (b, φ, ḃ, ω)."""
        b, phi, rate, omega = z
        t, n = vectors(phi)
        place = np.asarray(corner) - b * t + self.d * n
        speed = (-self.d * omega - rate) * t - b * omega * n
        return np.array([*place, phi - self.angle]), np.array([*speed, omega])

    def coordinates(self, corner, place, speed):
        """z of a state that touches V and whose gap does not change."""
        phi = place[2] + self.angle
        t, _ = vectors(phi)
        arm = np.asarray(corner) - place[:2]
        return np.array([t @ arm, phi, -(t @ speed[:2]) - self.d * speed[2], speed[2]])

    def energy(self, z):
        """Per unit mass; the height is that over V."""
        b, phi, rate, omega = z
        t, n = vectors(phi)
        kinetic = (self.d * omega + rate) ** 2 + (b * b + self.rho2) * omega**2
        return kinetic / 2 + self.gravity * (self.d * n[1] - b * t[1])

    def momentum(self, z):
        """Angular momentum about V, per unit mass."""
        b, _, rate, omega = z
        return (self.rho2 + b * b + self.d**2) * omega + self.d * rate

    def pivots(self, z):
        """ω̇, λ and τ that keep b constant."""
        b, phi, _, omega = z
        t, n = vectors(phi)
        c, g = -self.d, self.gravity
        spin = g * (b * n[1] - c * t[1]) / (self.rho2 + b * b + c * c)
        normal = g * n[1] + c * omega**2 - b * spin
        return spin, normal, g * t[1] + c * spin + b * omega**2

    def slips(self, z, sense):
        """b̈, ω̇ and λ with τ = μλ sense."""
        b, phi, rate, omega = z
        t, n = vectors(phi)
        c, g = -self.d, self.gravity
        rows = [
            [1.0, -c, self.friction * sense],
            [-c, self.rho2 + b * b + c * c, 0.0],
            [0.0, b, 1.0],
        ]
        right = [
            g * t[1] + b * omega**2,
            g * (b * n[1] - c * t[1]) - 2 * b * rate * omega,
            g * n[1] + c * omega**2 - 2 * rate * omega,
        ]
        # Positive, or Painlevé's paradox: λ then no longer follows from the other forces.
        assert np.linalg.det(rows) > 0, z
        return np.linalg.solve(rows, right)


def vectors(phi):
    """t and n of a side at the angle φ."""
    cos, sin = math.cos(phi), math.sin(phi)
    return np.array([cos, sin]), np.array([-sin, cos])


@dataclass
class Part:
    """Motion of one kind from ``start`` to ``end``: "pivot", "slip" or "flight"."""

    kind: str
    sense: float  # sgn ḃ of a slip
    start: float
    end: float
    z: np.ndarray  # at the start; (place, speed) of a flight


@dataclass
class Motion:
    """Parts of a motion that starts on V, and why it left V: "lift-off" (λ = 0), "end" (of the side), "flush" (with a
    piece of the ground), or "time"."""

    side: Side
    corner: tuple
    parts: list[Part] = field(default_factory=list)
    left: str = "time"

    def at(self, t):
        """Centre of mass and rotation (x, y, θ), and their rates."""
        part = next(p for p in self.parts if t <= p.end)
        if part.kind == "flight":
            place, speed = part.z
            dt, down = t - part.start, np.array([0, -self.side.gravity, 0])
            return place + speed * dt + down * dt**2 / 2, speed + down * dt
        return self.side.state(self.corner, _follow(self.side, part, part.z, t))

    def places(self, times):
        """Places at increasing times, interpolated: to about 1e-10."""
        found = []
        for part in self.parts:
            first = part is self.parts[0]
            now = [t for t in times if (first or part.start < t) and t <= part.end]
            if not now:
                continue
            if part.kind == "flight":
                found += [self.at(t)[0] for t in now]
                continue
            span = part.start, max(part.end, now[-1])
            states = solve_ivp(
                _rates(self.side, part), span, part.z, "DOP853", t_eval=now, rtol=1e-11, atol=1e-14
            ).y.T  # fmt: skip
            found += [self.side.state(self.corner, z)[0] for z in states]
        return np.array(found)

    def word(self):
        """The kinds of the parts, as "pivot slip flight"."""
        return " ".join(part.kind for part in self.parts)


def _rates(side, part):
    if part.kind == "pivot":
        return lambda _t, z: [0.0, z[3], 0.0, side.pivots(z)[0]]

    def rates(_t, z):
        change, spin, _ = side.slips(z, part.sense)
        return [z[2], z[3], change, spin]

    return rates


def _solve(side, part, z, start, end, events=None):
    found = solve_ivp(
        _rates(side, part), (start, end), z, "DOP853", events=events, rtol=RTOL, atol=ATOL
    )  # fmt: skip
    assert found.status >= 0, found.message
    return found


def _follow(side, part, z, t, start=None):
    """z at t, at the end of a step: the interpolation within steps has larger errors."""
    start = part.start if start is None else start
    return z if t == start else _solve(side, part, z, start, t).y[:, -1]


def _tests(side, part, angles):
    """Functions of z that are positive while a part goes on, with the name of its end."""
    low, high = angles
    tests = {"flush below": lambda z: z[1] - low, "flush above": lambda z: high - z[1]}
    if part.kind == "pivot":
        mu = side.friction

        def margin(sense):
            def margin_of(z):
                _, normal, tangential = side.pivots(z)
                return mu * normal - sense * tangential

            return margin_of

        tests |= {"slips": margin(1.0), "slips back": margin(-1.0)}
        tests["lift-off"] = lambda z: side.pivots(z)[1]
        return tests
    tests |= {"low end": lambda z: z[0] - side.low, "high end": lambda z: side.high - z[0]}  # fmt: skip
    tests["lift-off"] = lambda z: side.slips(z, part.sense)[2]
    if side.friction > 0:
        tests["stops"] = lambda z: part.sense * z[2]
    return tests


def _refine(side, part, test, step, z, t):
    """Root of a test near t, by secants with states at the ends of steps."""
    start, before = step, z

    def value(t):
        return test(_follow(side, part, before, t, start))

    other = t + 1e-6 * max(t - start, 1e-9)
    now, then = value(t), value(other)
    for _ in range(6):
        if now == then:
            break
        other, t = t, t - now * (t - other) / (now - then)
        now, then = value(t), now
    return t


def _first_part(side, z, t, end):
    """What a contact does that touches V with this z, or None if it lifts off."""
    if side.friction == 0:
        part = Part("slip", 0.0, t, end, z)
        return part if side.slips(z, 0.0)[2] > 0 else None
    if z[2] != 0:
        return Part("slip", math.copysign(1.0, z[2]), t, end, z)
    _, normal, tangential = side.pivots(z)
    if normal > 0 and abs(tangential) <= side.friction * normal:
        return Part("pivot", 0.0, t, end, z)
    sense = math.copysign(1.0, tangential)
    return Part("slip", sense, t, end, z) if side.slips(z, sense)[2] > 0 else None


def follow(side, corner, z, end, angles=(-math.pi / 2, 0.0)):
    """The motion from z = (b, φ, ḃ, ω) at t = 0 until ``end``. The side may turn between the ``angles`` of φ at which it is
    flush with the pieces of the ground beside V; those of a table edge at its right end are the default."""
    motion, t, z = Motion(side, tuple(corner)), 0.0, np.array(z, dtype=float)
    part = _first_part(side, z, t, end)
    while part is not None:
        tests = _tests(side, part, angles)
        events = []
        for test in tests.values():

            def event(_t, z, test=test):
                return test(z)

            event.terminal, event.direction = True, -1
            events.append(event)
        found = _solve(side, part, z, t, end, events)
        motion.parts.append(part)
        if found.status == 0:
            return motion
        name = next(n for n, hit in zip(tests, found.t_events, strict=True) if len(hit))
        # The last steps are the one before the event and the event.
        step, before = found.t[-2], found.y[:, -2]
        t = part.end = _refine(side, part, tests[name], step, before, found.t[-1])
        z = _follow(side, part, before, t, step)
        if name.startswith("flush"):
            motion.left = "flush"
            return motion
        if name in ("low end", "high end", "lift-off"):
            motion.left = "lift-off" if name == "lift-off" else "end"
            part = None
        elif name == "stops":
            z[2] = 0.0
            part = _first_part(side, z, t, end)
            motion.left = "lift-off" if part is None else "time"
        else:
            part = Part("slip", 1.0 if name == "slips" else -1.0, t, end, z)
    motion.parts.append(Part("flight", 0.0, t, end, side.state(corner, z)))
    return motion


def tipping(side, outside, end):
    """A box at rest on a table edge V = (0, 0), with its centre of mass ``outside`` the edge."""
    return follow(side, (0.0, 0.0), (-outside, 0.0, 0.0, 0.0), end)


def slides_over(side, speed, end):
    """A box that slides flat to the right, with V = (0, 0) at its front corner at t = 0: the time at which it begins to tip, and
    the motion from then on.

    It is slowed down by μg. The moments of the forces at the rear corner and at V are in balance as long as the rear one has a
    positive force, λ_rear (b − low) = g (b − μ d): it lifts off at b = μ d, before the centre of mass is over the edge.
    """
    pull, way = side.friction * side.gravity, side.high - side.friction * side.d
    left = math.sqrt(speed**2 - 2 * pull * way)
    start = 2 * way / (speed + left)
    z = (side.friction * side.d, 0.0, -left, 0.0)
    return start, follow(side, (0.0, 0.0), z, end)


# The formulas of a side on a corner, as rows. Tests compare them with derivatives of any smooth motion.


def gap(place, corner, direction, d):
    """h = ν·(V − r) − d, with the outward normal ν of the side at the angle ``direction`` + θ."""
    x, y, theta = place
    nu = math.cos(direction + theta), math.sin(direction + theta)
    return nu[0] * (corner[0] - x) + nu[1] * (corner[1] - y) - d


def rates(place, speed, change, corner, direction, d):
    """ḣ, ḧ and v_t by the rows N = (n, b), T = (t, −c): ḧ = n·r̈ + b ω̇ − c ω² − 2 ω v_t."""
    theta, omega = place[2], speed[2]
    n = -np.array([math.cos(direction + theta), math.sin(direction + theta)])
    t = np.array([n[1], -n[0]])
    arm = np.asarray(corner) - place[:2]
    b, c = t @ arm, n @ arm
    slip = t @ speed[:2] - c * omega
    second = n @ change[:2] + b * change[2] - c * omega**2 - 2 * omega * slip
    return n @ speed[:2] + b * omega, second, slip


def second_in_body_axes(place, speed, change, corner, direction, d):
    """ḧ of V as a point that moves in the axes of the body against a line at rest there: its acceleration is −r̈, and those
    of Euler, Coriolis and the centrifugal one."""
    theta, omega = place[2], speed[2]
    cos, sin = math.cos(theta), math.sin(theta)
    into = np.array([[cos, sin], [-sin, cos]])
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    p = into @ (np.asarray(corner) - place[:2])
    velocity = -into @ speed[:2] - omega * turned @ p
    acceleration = (
        -into @ change[:2]
        - change[2] * turned @ p
        - 2 * omega * turned @ velocity
        + omega**2 * p
    )
    return np.array([math.cos(direction), math.sin(direction)]) @ acceleration

"""Frictionless two-contact motion in arbitrary precision, up to its Zeno point.

An oracle for the tests: event by event, in decimal numbers, without any step in double precision.
Inputs are exact doubles. Two models share one loop (notation: docs/notation.md):

* local: geometry frozen at the nominal posture, inputs ``e g1 g2 psi1 psi2 phi1 phi2`` and the state
  ``h1 h2 theta u1 u2 omega`` [Or & Rimon 2008, eqs. 5 and 6];
* full: finite rotation, inputs ``e g rho``, centre of mass ``x_x x_y``, points ``x1_x x1_y x2_x x2_y``,
  slopes ``alpha1 alpha2``, configuration ``r_x r_y theta`` and velocity ``v_x v_y omega``.

After every impact the remaining time is predicted from the geometry at that time; ``orbit``
stops when further impacts no longer change the predicted Zeno time.
"""

import math
from contextlib import contextmanager
from dataclasses import dataclass, field
from decimal import Decimal, localcontext
from fractions import Fraction
from types import SimpleNamespace

import decimals

LOCAL_INPUTS = (
    *("e", "g1", "g2", "psi1", "psi2", "phi1", "phi2"),
    *("h1", "h2", "theta", "u1", "u2", "omega"),
)
FULL_INPUTS = (
    *(
        "e",
        "g",
        "rho",
        "x_x",
        "x_y",
        "x1_x",
        "x1_y",
        "x2_x",
        "x2_y",
        "alpha1",
        "alpha2",
    ),
    *("r_x", "r_y", "theta", "v_x", "v_y", "omega"),
)
LOCAL_STATE = ("h1", "h2", "theta", "u1", "u2", "omega")
FULL_STATE = ("r_x", "r_y", "v_x", "v_y", *LOCAL_STATE)

LOCAL_DIGITS = 40  # relative accuracy of the Zeno time
FULL_DIGITS = 36
GUARD_DIGITS = 40  # additional digits in the computation
COLLISION_LIMIT = 200_000

#: Gap below zero, relative to the size of the body, that counts as touching.
TOUCH = 1e-12
#: A frozen one-contact tail is accepted only if the other gap ends above this part of its terms.
FROZEN_MARGIN = 1e-6
#: Sum of all later corrections of the Zeno time, in units of the largest of the last three. They shrink by at least e^(1/3)
#: each, so their sum is below 100 of them up to e = .97.
CORRECTION_SUM = 100


@dataclass
class Collision:
    """One impact: gap rates in m/s, gap of the other contact in m."""

    time: object
    contact: int
    before: tuple
    after: tuple
    other_gap: object


@dataclass
class Zeno:
    """Where the impacts accumulate: the time in s, an estimate of its error, the state there."""

    kind: str
    contact: int | None
    method: str
    certified: bool
    time: object
    error: object
    state: dict


@dataclass
class Orbit:
    """All impacts simulated one by one, and the Zeno point at their end."""

    zeno: Zeno
    collisions: list = field(default_factory=list)


@contextmanager
def arithmetic(digits):
    """Operations with this number of digits, for use inside of the ``with`` statement only."""
    with localcontext() as wide:  # prec= is new in Python 3.11
        wide.prec = digits
        yield SimpleNamespace(
            number=Decimal,
            sqrt=Decimal.sqrt,
            cos_sin=decimals.cos_sin,
            turn=decimals.turn,
            eps=Decimal(10) ** (1 - digits),
            inf=Decimal("Infinity"),
        )


def turn(x):
    """cos x, sin x, 1 − cos x and sin x − x, each to full relative accuracy, in doubles."""
    cos, sin = math.cos(x / 2), math.sin(x / 2)
    whole = 2 * sin * cos
    if abs(x) > 0.5:
        sin_less_x = whole - x
    else:
        term, k, sin_less_x = x, 1, 0.0
        while abs(term) > DOUBLE.eps * abs(sin_less_x):
            term *= -x * x / ((k + 1) * (k + 2))
            sin_less_x += term
            k += 2
    lost = 2 * sin * sin
    return 1 - lost, whole, lost, sin_less_x


#: The same operations in double precision, for derivatives only.
DOUBLE = SimpleNamespace(
    number=float,
    sqrt=math.sqrt,
    cos_sin=lambda x: (math.cos(x), math.sin(x)),
    turn=turn,
    eps=2.0**-52,
    inf=math.inf,
)


def bounce_time(motion, a, margin=0):
    """Duration of the bouncing at ``a`` alone, or None if the other contact lands before its end.

    T = 2 u_a/(g_a (1 − e)). After bounce j the gap of b is a quadratic in x = e^j. If ψ_a ≥ 0, every bounce pushes b down, so
    its gap is concave and only its end x = 0 matters. If ψ_a < 0, it is concave only between bounces, and every x = e^j is
    tested [docs/notation.md]. Where the other contact is accelerated away (fast spin), the gap must be larger than every
    possible fall.
    """
    e, b = motion.e, 1 - a
    psi, g_a, g_b = motion.psi(a), motion.gravity(a), motion.gravity(b)
    u_a, u_b, h_b = motion.u[a], motion.u[b], motion.h[b]
    if g_a <= 0:
        return None
    T = 2 * u_a / (g_a * (1 - e))
    kick = psi * u_a * T / (1 - e)

    def gap(x):
        y = 1 - x
        return (
            h_b
            + y * (u_b * T - g_b * T**2 * y / 2)
            - kick * (e * (1 - x * x) - (1 + e) * x * y)
        )

    end = gap(0)
    if end <= margin * (h_b + abs(u_b) * T + abs(g_b) * T**2):
        return None
    if g_b < 0 and h_b <= abs(u_b) * T - g_b * T**2 + 2 * abs(kick):
        return None
    if psi < 0:
        # |gap(x) − gap(0)| ≤ slope · x on [0, 1]
        slope = abs(u_b) * T + 2 * abs(g_b) * T**2 + 4 * abs(kick)
        x = e
        while slope * x > end:
            if gap(x) <= 0:
                return None
            x *= e
    return T


def clatter_time(motion, a):
    """Remaining time of the alternation after an impact at ``a``, without gravity, in s.

    An upper bound of the time with gravity, and equal to it in the limit. None outside the cone ψ_i > 0, P ≥ 2√e, √(ψ_a/ψ_b)
    u_a ≤ λ₊ |u_b|, u_b < 0. λ² − P λ + e = 0.
    """
    e, b = motion.e, 1 - a
    psi_a, psi_b, u_a, u_b = motion.psi(a), motion.psi(b), motion.u[a], motion.u[b]
    if not (psi_a > 0 and psi_b > 0 and u_b < 0):
        return None
    P = (1 + e) * motion.sqrt(psi_a * psi_b)
    if P * P < 4 * e:
        return None
    root = motion.sqrt(psi_a / psi_b)
    faster = (P + motion.sqrt(P * P - 4 * e)) / 2
    closing = -u_b - root * u_a / faster
    return motion.h[b] / closing if closing > 0 else None


def alternates_for_ever(motion, a):
    """Sufficient condition for endless alternation after an impact at ``a``, with gravity.

    With ϱ = √ψ_a u_a/(√ψ_b |u_b|) ≤ λ₊, ϱ* = max(ϱ, λ₋), κ = ϱ*³/e²: κ < 1, η < 1 [Or & Rimon 2008,
    eq. 8] and (g̃_b/g̃_a) κ η (1 − η) < 1, g̃_i = √ψ_i g_i.
    """
    e, b = motion.e, 1 - a
    psi_a, psi_b, u_a, u_b = motion.psi(a), motion.psi(b), motion.u[a], motion.u[b]
    g_a, g_b, h_b = motion.gravity(a), motion.gravity(b), motion.h[b]
    if not (
        e > 0 and psi_a > 0 and psi_b > 0 and u_b < 0 < u_a and g_a > 0 and g_b > 0
    ):
        return False
    P = (1 + e) * motion.sqrt(psi_a * psi_b)
    if P * P < 4 * e:
        return False
    faster = (P + motion.sqrt(P * P - 4 * e)) / 2
    ratio = -motion.sqrt(psi_a / psi_b) * u_a / u_b
    bound = max(ratio, e / faster)
    kappa = bound**3 / e**2
    eta = g_a * h_b / (u_a * (motion.sqrt(u_b * u_b + 2 * g_b * h_b) - u_b))
    grow = motion.sqrt(psi_b / psi_a) * g_b / g_a * kappa * eta * (1 - eta)
    return ratio <= faster and kappa < 1 and eta < 1 and grow < 1


def bounced(motion, a, T):
    """Gaps and rates at the end of the bouncing at ``a``, geometry frozen [docs/notation.md]."""
    e, b, zero = motion.e, 1 - a, motion.ctx.number(0)
    psi, g_a, g_b = motion.psi(a), motion.gravity(a), motion.gravity(b)
    h, u = [zero, zero], [zero, zero]
    h[b] = motion.h[b] + motion.u[b] * T - (g_b + e * psi * g_a) * T**2 / 2
    u[b] = motion.u[b] - g_b * T - (1 + e) * psi * motion.u[a] / (1 - e)
    return h, u


class LocalMotion:
    """The frozen model: gaps (h_1, h_2) and θ on exact parabolas [Or & Rimon 2008, eqs. 5, 6]."""

    exact_tails = True
    state_names = LOCAL_STATE

    def __init__(self, ctx, inputs):
        v = {name: ctx.number(inputs[name]) for name in LOCAL_INPUTS}
        self.ctx, self.sqrt = ctx, ctx.sqrt
        self.t, self.e = ctx.number(0), v["e"]
        self.h, self.u = [v["h1"], v["h2"]], [v["u1"], v["u2"]]
        self.theta, self.omega = v["theta"], v["omega"]
        self._psi, self._phi = (v["psi1"], v["psi2"]), (v["phi1"], v["phi2"])
        self._g = (v["g1"], v["g2"])

    def psi(self, i):
        return self._psi[i]

    def gravity(self, i):
        return self._g[i]

    def landing(self, i, limit):
        """Time to the landing of contact ``i``, in s: the positive root of h + u t − g t²/2."""
        return parabola_root(self.sqrt, self.h[i], self.u[i], self._g[i])

    def advance(self, dt, landed):
        for i in (0, 1):
            h, u, g = self.h[i], self.u[i], self._g[i]
            if i in landed:
                self.h[i] = self.ctx.number(0)
                self.u[i] = -self.sqrt(u * u + 2 * g * h)
            else:
                self.h[i] = max(h + dt * (u - g * dt / 2), self.ctx.number(0))
                self.u[i] = u - g * dt
        self.theta += self.omega * dt
        self.t += dt

    def strike(self, i):
        """Newton impact: u_i⁺ = −e w, u_j⁺ = u_j + (1 + e) ψ_i w, ω⁺ = ω + (1 + e) φ_i w [eq. 6]."""
        w = self.u[i]
        self.u[i] = -self.e * w
        self.u[1 - i] += (1 + self.e) * self._psi[i] * w
        self.omega += (1 + self.e) * self._phi[i] * w

    def settle_bounce(self, a, T):
        """State at the end of the bouncing at ``a`` [docs/notation.md]."""
        e, u_a, phi = self.e, self.u[a], self._phi[a]
        h, u = bounced(self, a, T)
        theta = self.theta + self.omega * T - phi * u_a * T * e / (1 - e)
        omega = self.omega - (1 + e) * phi * u_a / (1 - e)
        return dict(zip(LOCAL_STATE, (*h, theta, *u, omega), strict=True))

    def settle_both(self, T):
        """State when both contacts have come to rest after the time ``T``.

        No impact changes θ + a·h, a_1 = (φ_1 + ψ_1 φ_2)/(1 − ψ_1 ψ_2): it falls freely.
        """
        (psi1, psi2), (phi1, phi2) = self._psi, self._phi
        det = 1 - psi1 * psi2
        a = (phi1 + psi1 * phi2) / det, (phi2 + psi2 * phi1) / det
        height, speed, pull = (
            a[0] * v[0] + a[1] * v[1] for v in (self.h, self.u, self._g)
        )
        omega = self.omega + speed - pull * T
        theta = self.theta + height + (omega + pull * T / 2) * T
        zero = self.ctx.number(0)
        return dict(
            zip(LOCAL_STATE, (zero, zero, theta, zero, zero, omega), strict=True)
        )


class FullMotion:
    """Finite rotation, in gap coordinates: after the start no gap is a difference of positions.

    ``b[i]``, ``c[i]`` are ∂h_i/∂θ and its companion, db/dθ = −c, dc/dθ = b. Masses divided by m.
    """

    exact_tails = False
    state_names = FULL_STATE

    def __init__(self, ctx, inputs):
        v = {name: ctx.number(inputs[name]) for name in FULL_INPUTS}
        self.ctx, self.sqrt = ctx, ctx.sqrt
        self.t, self.e, self.g, self.rho2 = ctx.number(0), v["e"], v["g"], v["rho"] ** 2
        self.r, self.v = [v["r_x"], v["r_y"]], [v["v_x"], v["v_y"]]
        self.theta, self.omega = v["theta"], v["omega"]
        cos, sin = ctx.cos_sin(self.theta)
        self.n, self.b, self.c, self.h, self.u, self.size = [], [], [], [], [], v["rho"]
        for i in "12":
            tx, ty = ctx.cos_sin(v["alpha" + i])
            dx, dy = v[f"x{i}_x"] - v["x_x"], v[f"x{i}_y"] - v["x_y"]
            turned = cos * dx - sin * dy, sin * dx + cos * dy
            b = tx * turned[0] + ty * turned[1]
            c = tx * turned[1] - ty * turned[0]
            self.n.append((-ty, tx))
            self.b.append(b)
            self.c.append(c)
            self.h.append(tx * (self.r[1] - dy) - ty * (self.r[0] - dx) + c)
            self.u.append(tx * self.v[1] - ty * self.v[0] + b * self.omega)
            self.size = max(self.size, self.sqrt(dx * dx + dy * dy))
        for i in (0, 1):
            if self.h[i] < 0:
                if self.h[i] < -ctx.number(TOUCH) * self.size:
                    raise ValueError(
                        f"contact {i + 1} starts below the terrain: {self.h[i]}"
                    )
                self.h[i] = ctx.number(0)
        self.n_dot_n = self.n[0][0] * self.n[1][0] + self.n[0][1] * self.n[1][1]
        self._g = [self.g * n[1] for n in self.n]

    def psi(self, i):
        return -(self.b[0] * self.b[1] + self.rho2 * self.n_dot_n) / (
            self.b[i] ** 2 + self.rho2
        )

    def phi(self, i):
        return -self.b[i] / (self.b[i] ** 2 + self.rho2)

    def gravity(self, i):
        return self._g[i] + self.c[i] * self.omega**2

    def gap(self, i, dt):
        """Gap, its rate and −(its acceleration) after the flight ``dt``, without cancellation."""
        w, g, b, c = self.omega, self._g[i], self.b[i], self.c[i]
        cos, sin, one_less_cos, sin_less_x = self.ctx.turn(w * dt)
        return (
            self.h[i]
            + dt * (self.u[i] - g * dt / 2)
            - one_less_cos * c
            + sin_less_x * b,
            self.u[i] - g * dt - w * (sin * c + one_less_cos * b),
            g + w * w * (cos * c + sin * b),
        )

    def landing(self, i, limit):
        """Time to the first landing of contact ``i``, in s; infinity if it is later than ``limit``.

        A guaranteed march: from a time where the gap is h ≥ 0 and its rate u, the gap stays above
        h + u s − M s²/2 while −(acceleration) ≤ M, so the root of that parabola never oversteps the
        first landing. M is the global bound g + ω²|d|, or, over steps s ≤ L, the present value plus
        |ω|³|d| L. The march converges quadratically to a simple root.
        """
        w, size = abs(self.omega), self.sqrt(self.b[i] ** 2 + self.c[i] ** 2)
        always = self._g[i] + w * w * size
        drift = w**3 * size
        t, h, u, pull = self.ctx.number(0), self.h[i], self.u[i], self.gravity(i)
        while True:
            reach = (
                parabola_root(self.sqrt, h, u, pull) * 9 / 8
                if pull > 0
                else self.ctx.inf
            )
            bound = pull + drift * reach
            if bound < always:
                step = min(parabola_root(self.sqrt, h, u, bound), reach)
            else:
                step = parabola_root(self.sqrt, h, u, always)
            t += step
            if t > limit:
                return self.ctx.inf
            if step <= 4 * self.ctx.eps * t:
                return t
            h, u, pull = self.gap(i, t)
            if h <= 0:
                return t

    def advance(self, dt, landed):
        new = [self.gap(i, dt) for i in (0, 1)]
        zero = self.ctx.number(0)
        self.h = [zero if i in landed else max(new[i][0], zero) for i in (0, 1)]
        self.u = [new[i][1] for i in (0, 1)]
        cos, sin, _, _ = self.ctx.turn(self.omega * dt)
        self.b, self.c = (
            [b * cos - c * sin for b, c in zip(self.b, self.c, strict=True)],
            [c * cos + b * sin for b, c in zip(self.b, self.c, strict=True)],
        )
        self.theta += self.omega * dt
        self.r = [
            self.r[0] + self.v[0] * dt,
            self.r[1] + self.v[1] * dt - self.g * dt**2 / 2,
        ]
        self.v[1] -= self.g * dt
        self.t += dt

    def push(self, i, w):
        """Velocity change by the impulse that changes the rate of contact ``i`` by ``w``."""
        share = w * self.rho2 / (self.b[i] ** 2 + self.rho2)
        return self.n[i][0] * share, self.n[i][1] * share, -w * self.phi(i)

    def strike(self, i):
        """Newton impact at the current configuration [Or & Rimon 2008, eq. 4]."""
        w = self.u[i]
        self.u[i] = -self.e * w
        self.u[1 - i] += (1 + self.e) * self.psi(i) * w
        dx, dy, turn_rate = self.push(i, -(1 + self.e) * w)
        self.v[0] += dx
        self.v[1] += dy
        self.omega += turn_rate

    def settle_bounce(self, a, T):
        """State at the end of the bouncing at ``a``, geometry frozen for the short time ``T``."""
        e, u_a = self.e, self.u[a]
        h, u = bounced(self, a, T)
        jump = self.push(a, (1 + e) * u_a / (1 - e))
        shift = self.push(a, u_a * T * e / (1 - e))
        return self._state(T, jump, shift, h, u)

    def settle_both(self, T):
        """State when both contacts have come to rest after the short time ``T``: the free flight, moved back to h = 0 and u =
        0 along M⁻¹N_iᵀ, that is, orthogonally in the mass metric."""
        fall = [self.h[i] + self.u[i] * T - self.gravity(i) * T**2 / 2 for i in (0, 1)]
        speed = [self.u[i] - self.gravity(i) * T for i in (0, 1)]
        zero = self.ctx.number(0)
        jump, shift = self._cancel(speed), self._cancel(fall)
        return self._state(T, jump, shift, [zero, zero], [zero, zero])

    def _cancel(self, w):
        """The combination of impulses at both contacts that changes the rates by −w."""
        psi1, psi2 = self.psi(0), self.psi(1)
        det = 1 - psi1 * psi2
        first = self.push(0, -(w[0] + psi2 * w[1]) / det)
        second = self.push(1, -(w[1] + psi1 * w[0]) / det)
        return [x + y for x, y in zip(first, second, strict=True)]

    def _state(self, T, jump, shift, h, u):
        r_x = self.r[0] + self.v[0] * T + shift[0]
        r_y = self.r[1] + self.v[1] * T - self.g * T**2 / 2 + shift[1]
        theta = self.theta + self.omega * T + shift[2]
        v_x, v_y = self.v[0] + jump[0], self.v[1] - self.g * T + jump[1]
        values = (r_x, r_y, v_x, v_y, *h, theta, *u, self.omega + jump[2])
        return dict(zip(FULL_STATE, values, strict=True))


def parabola_root(sqrt, h, u, g):
    """Positive root of h + u t − g t²/2 for h ≥ 0, g > 0, in the form without cancellation."""
    s = sqrt(u * u + 2 * g * h)
    if u >= 0:
        return (u + s) / g
    return 2 * h / (s - u)


def orbit(inputs, digits=None, ctx=None, at_least=0):
    """Simulate the collisions until the Zeno time is known to ``digits`` digits.

    ``at_least``: least number of collisions, for a comparison one by one.
    """
    full = "rho" in inputs
    digits = digits or (FULL_DIGITS if full else LOCAL_DIGITS)
    if ctx is None:
        with arithmetic(digits + GUARD_DIGITS) as ctx:
            return orbit(inputs, digits, ctx, at_least)
    motion = (FullMotion if full else LocalMotion)(ctx, inputs)
    tolerance = max(ctx.number(10) ** -digits, ctx.eps)
    at_rest = [
        i for i in (0, 1) if motion.h[i] == motion.u[i] == 0 and motion.gravity(i) > 0
    ]
    if at_rest:
        return Orbit(_rest(motion, at_rest))
    collisions, ends = [], []
    while len(collisions) < COLLISION_LIMIT:
        a = collide(motion, collisions)
        found = _predict(motion, a)
        enough = len(collisions) >= at_least
        if found is None:
            if enough and _exhausted(collisions, tolerance):
                found = ("2-zeno", "self-similar", False, motion.ctx.number(0))
                return Orbit(
                    _arrive(motion, a, found, _geometric_tail(collisions)), collisions
                )
            ends.clear()
            continue
        ends.append((found[0], motion.t + found[3]))
        error = _correction(ends, motion.exact_tails)
        if enough and error is not None and error <= tolerance * motion.t:
            return Orbit(_arrive(motion, a, found, error), collisions)
    raise RuntimeError(f"no Zeno point within {COLLISION_LIMIT} collisions")


def _rest(motion, at_rest):
    zero = motion.ctx.number(0)
    if len(at_rest) == 2:
        return Zeno("2-zeno", None, "rest", True, zero, zero, motion.settle_both(zero))
    a = at_rest[0]
    return Zeno(
        "1-zeno", a + 1, "rest", True, zero, zero, motion.settle_bounce(a, zero)
    )


def collide(motion, collisions):
    """Advance to the next landing and apply its impact; of simultaneous ones the lowest contact is first. Return its index."""
    ctx = motion.ctx
    guess = [
        parabola_root(ctx.sqrt, motion.h[i], motion.u[i], abs(motion.gravity(i)))
        for i in (0, 1)
    ]
    first = 0 if guess[0] <= guess[1] else 1
    times = [None, None]
    times[first] = motion.landing(first, ctx.inf)
    same = 1 + 2**10 * ctx.eps
    times[1 - first] = motion.landing(1 - first, times[first] * same)
    dt = min(times)
    landed = [i for i in (0, 1) if times[i] <= dt * same]
    motion.advance(dt, landed)
    a = next((i for i in landed if motion.u[i] < 0), landed[0])
    before = tuple(motion.u)
    motion.strike(a)
    collisions.append(
        Collision(motion.t, a + 1, before, tuple(motion.u), motion.h[1 - a])
    )
    return a


def _predict(motion, a):
    """(kind, method, certified, remaining time) of the Zeno point ahead, or None if unknown."""
    margin = 0 if motion.exact_tails else motion.ctx.number(FROZEN_MARGIN)
    T = bounce_time(motion, a, margin)
    if T is not None:
        return "1-zeno", "bounce", True, T
    T = clatter_time(motion, a)
    if T is None:
        return None
    if motion.h[1 - a] == 0:
        return "2-zeno", "chatter", True, T
    if alternates_for_ever(motion, a):
        return "2-zeno", "clatter", True, T
    return None


def _correction(ends, exact_tails):
    """Estimate of the error of the last predicted Zeno time, or None while too few are known."""
    if exact_tails and ends[-1][0] == "1-zeno":
        return 0
    last = ends[-4:]
    if len(last) < 4 or len({kind for kind, _ in last}) > 1:
        return None
    steps = [abs(x[1] - y[1]) for x, y in zip(last[1:], last[:-1], strict=True)]
    return CORRECTION_SUM * max(steps)


def _window(collisions):
    """Durations of the last two groups of 16 collisions."""
    if len(collisions) < 33:
        return None
    now, mid, old = collisions[-1].time, collisions[-17].time, collisions[-33].time
    return now - mid, mid - old


def _exhausted(collisions, tolerance):
    """Whether the rest of an accumulation without a closed form is below the required accuracy."""
    window = _window(collisions)
    if window is None:
        return False
    return (
        2 * window[0] < window[1]
        and _geometric_tail(collisions) <= tolerance * collisions[-1].time
    )


def _geometric_tail(collisions):
    """Remaining time if the durations of the groups keep their ratio, doubled."""
    new, old = _window(collisions)
    return 2 * new * new / (old - new) if new else new


def _arrive(motion, a, found, error):
    kind, method, certified, T = found
    if kind == "1-zeno":
        return Zeno(
            kind,
            a + 1,
            method,
            certified,
            motion.t + T,
            error,
            motion.settle_bounce(a, T),
        )
    return Zeno(
        kind, None, method, certified, motion.t + T, error, motion.settle_both(T)
    )


#: Relative size of the changes of inputs whose effect is scaled to one ulp.
MOVE = 2.0**-28
DOUBLE_DIGITS = 17


@dataclass
class Sensitivity:
    """Changes {output: {input: change}} for one ulp; outputs are "time" and the state's names."""

    changes: dict
    verdict_stable: bool

    def largest(self, output):
        """Largest change of ``output`` when one input changes."""
        return max(self.changes[output].values())

    def total(self, output):
        """Largest change of ``output`` when every input changes."""
        return math.fsum(self.changes[output].values())


def sensitivity(inputs, solved=None):
    """Changes of the Zeno time and of the state there when each input changes by one ulp.

    Every input in turn is changed with both signs: by 2⁻²⁸ of itself in double precision, and where the two signs disagree,
    by one ulp in high precision. An input that is 0 is not changed. ``solved``: the orbit of the inputs, if it is known.
    """
    outputs = ("time", *(FULL_STATE if "rho" in inputs else LOCAL_STATE))
    changes = {name: {} for name in outputs}
    rough, exact, stable = _outcome(orbit(inputs, DOUBLE_DIGITS, DOUBLE)), None, True
    for name, value in inputs.items():
        ulp = math.ulp(value) if value else 0.0
        move = MOVE * abs(value)
        base, scale = rough, ulp / move if move else 0.0
        sides = [
            _outcome(orbit({**inputs, name: x}, DOUBLE_DIGITS, DOUBLE))
            for x in (value + move, value - move)
        ]
        with localcontext() as wide:
            wide.prec = FULL_DIGITS + GUARD_DIGITS
            if not _smooth(base, sides):
                exact = exact or _outcome(solved or orbit(inputs))
                base, scale = exact, 1.0
                sides = [
                    _outcome(orbit({**inputs, name: Decimal(value) + Decimal(step)}))
                    for step in (ulp, -ulp)
                ]
                stable = stable and all(side[0] == base[0] for side in sides)
            for out in outputs:
                steps = [abs(side[1][out] - base[1][out]) for side in sides]
                changes[out][name] = float(max(steps)) * scale
    return Sensitivity(changes, stable)


def _outcome(solved):
    zeno = solved.zeno
    return (zeno.kind, zeno.contact), {"time": zeno.time, **zeno.state}


def _smooth(base, sides):
    """Whether the verdict is the same and the changes of the Zeno time agree for both signs, to 5 %."""
    if any(side[0] != base[0] for side in sides):
        return False
    up, down = (side[1]["time"] - base[1]["time"] for side in sides)
    noise = 64 * DOUBLE.eps * base[1]["time"]
    return abs(up + down) <= 0.05 * max(abs(up), abs(down)) + noise


def conditioning(inputs):
    """Largest change of the Zeno time, in s, when one input changes by one ulp."""
    return sensitivity(inputs).largest("time")


@dataclass
class Answer:
    """Data of a case for a test: the verdict, the time exactly, its conditioning in s."""

    kind: str
    contact: int | None
    time: Fraction
    conditioning: float
    verdict_stable: bool
    collisions: int


def answer(inputs):
    """Solves one case and computes its conditioning."""
    result = orbit(inputs)
    change = sensitivity(inputs, result)
    return Answer(
        kind=result.zeno.kind,
        contact=result.zeno.contact,
        time=Fraction(result.zeno.time),
        conditioning=change.largest("time"),
        verdict_stable=change.verdict_stable,
        collisions=len(result.collisions),
    )

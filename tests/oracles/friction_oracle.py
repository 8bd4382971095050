"""Bodies on contacts with friction in 26 digits: Newton and Euler's equations, integrated by extrapolated steps.

An oracle for the tests. Accelerations and forces are the solution of one linear system, with positions and velocities of the
centre of mass as state. There are no reduced coordinates and no series; only the notation is that of the package
(docs/notation.md). Inputs are exact doubles. A state is the list (x, y, θ, ẋ, ẏ, ω) of decimal numbers. All functions must be
called inside of ``with precise():``.
"""

import math
from dataclasses import dataclass
from decimal import Decimal, localcontext

from decimals import cos_sin

DIGITS = 26
#: Numbers of substeps of the extrapolation.
SUBSTEPS = (2, 4, 6, 8, 10, 12, 14, 16, 18)
#: Duration of bouncing, in s, below which it is summed at once: its square is below the required accuracy.
BRIEF = Decimal("1e-13")
ZERO, ONE = Decimal(0), Decimal(1)


def precise():
    """The decimal context of the oracle."""
    return localcontext(prec=DIGITS + 2)


def solve(matrix, right):
    """Gaussian elimination with pivots, in place."""
    n = len(right)
    for k in range(n):
        p = max(range(k, n), key=lambda i: abs(matrix[i][k]))
        matrix[k], matrix[p] = matrix[p], matrix[k]
        right[k], right[p] = right[p], right[k]
        for i in range(k + 1, n):
            factor = matrix[i][k] / matrix[k][k]
            if factor:
                for j in range(k, n):
                    matrix[i][j] -= factor * matrix[k][j]
                right[i] -= factor * right[k]
    x = [ZERO] * n
    for k in reversed(range(n)):
        rest = sum((matrix[k][j] * x[j] for j in range(k + 1, n)), ZERO)
        x[k] = (right[k] - rest) / matrix[k][k]
    return x


def extrapolated(f, y, x, h):
    """One step by extrapolation of the modified midpoint rule (Gragg, Bulirsch, Stoer), with any type of numbers."""
    table = []
    start = f(x, y)
    for n in SUBSTEPS:
        s = h / n
        before, now = y, [a + s * b for a, b in zip(y, start, strict=True)]
        for k in range(1, n):
            slope = f(x + k * s, now)
            before, now = (
                now,
                [a + 2 * s * b for a, b in zip(before, slope, strict=True)],
            )
        slope = f(x + h, now)
        row = [
            [(a + b + s * c) / 2 for a, b, c in zip(now, before, slope, strict=True)]
        ]
        for j, m in enumerate(reversed(SUBSTEPS[: len(table)]), 1):
            part, whole = m * m, n * n - m * m
            old = table[-1][j - 1]
            row.append(
                [
                    a + (a - b) * part / whole
                    for a, b in zip(row[j - 1], old, strict=True)
                ]
            )
        table.append(row)
    return table[-1][-1]


def integrate(f, y, x, end, step):
    """The solution y at `end` of y′ = f, from y at `x`, in equal steps of at most the size `step`."""
    count = max(1, math.ceil(abs(end - x) / step))
    h = (end - x) / count
    for k in range(count):
        y = extrapolated(f, y, x + k * h, h)
    return y


@dataclass
class Body:
    """A posture with exact parameters."""

    posture: object

    def __post_init__(self):
        p = self.posture
        self.rho2 = Decimal(p.gyration_radius) ** 2
        self.g = Decimal(p.gravity)
        self.e = Decimal(p.restitution)
        self.mu = [Decimal(c.friction) for c in p.contacts]
        self.arms = [
            [Decimal(c.point[k]) - Decimal(p.center_of_mass[k]) for k in (0, 1)]
            for c in p.contacts
        ]
        self.t = [cos_sin(Decimal(c.slope)) for c in p.contacts]
        self.n = [(-sin, cos) for cos, sin in self.t]
        self.theta = None

    def arm(self, i, y):
        """Arm of contact i, world axes."""
        if y[2] is not self.theta:
            self.theta, self.cos_sin = y[2], cos_sin(y[2])
        c, s = self.cos_sin
        dx, dy = self.arms[i]
        return c * dx - s * dy, s * dx + c * dy

    def gap(self, i, y):
        dx, dy = self.arm(i, y)
        x0, y0 = self.arms[i]
        return self.n[i][0] * (y[0] + dx - x0) + self.n[i][1] * (y[1] + dy - y0)

    def speed(self, axis, i, y):
        """Velocity of contact point i along an axis."""
        dx, dy = self.arm(i, y)
        return axis[0] * (y[3] - y[5] * dy) + axis[1] * (y[4] + y[5] * dx)

    def rate(self, i, y):
        return self.speed(self.n[i], i, y)

    def slip(self, i, y):
        return self.speed(self.t[i], i, y)

    def motion(self, word, y):
        """Acceleration and, for each contact, (tangential, normal) force per unit mass."""
        forces, rows, right = [], [], []
        for i, letter in enumerate(word):
            if letter == "S":
                continue
            arm = self.arm(i, y)
            (tx, ty), (nx, ny) = self.t[i], self.n[i]
            axes = [(i, 1, self.n[i])]
            if letter == "F":
                axes.append((i, 0, self.t[i]))
                forces.append((i, 0, (tx, ty)))
                forces.append((i, 1, (nx, ny)))
            else:
                s = -self.mu[i] if letter == "R" else self.mu[i]
                forces.append((i, 1, (nx + s * tx, ny + s * ty)))
            for _, _, (ax, ay) in axes:
                # the acceleration of the point along the axis is zero
                rows.append([ax, ay, ax * -arm[1] + ay * arm[0]])
                right.append(y[5] ** 2 * (ax * arm[0] + ay * arm[1]))
        n = len(forces)
        matrix = [[ZERO] * (3 + n) for _ in range(3 + n)]
        side = [ZERO, -self.g, ZERO, *right]
        matrix[0][0] = matrix[1][1] = ONE
        matrix[2][2] = self.rho2
        for k, (i, _, (fx, fy)) in enumerate(forces):
            dx, dy = self.arm(i, y)
            matrix[0][3 + k], matrix[1][3 + k] = -fx, -fy
            matrix[2][3 + k] = -(dx * fy - dy * fx)
            matrix[3 + k][:3] = rows[k]
        x = solve(matrix, side)
        pairs = [[ZERO, ZERO] for _ in word]
        for k, (i, which, _) in enumerate(forces):
            pairs[i][which] += x[3 + k]
            if word[i] in "RL":
                pairs[i][0] = (-self.mu[i] if word[i] == "R" else self.mu[i]) * x[3 + k]
        return x[:3], pairs

    def flow(self, word):
        """Right-hand side of the equations of motion in a mode."""
        return lambda _t, y: [*y[3:], *self.motion(word, y)[0]]

    def events(self, word):
        """Functions that are positive until the mode ends, by name."""
        found = {}
        for i, letter in enumerate(word):
            if letter == "S":
                found["land", i] = lambda y, i=i: self.gap(i, y)
                continue
            found["lift", i] = lambda y, i=i: self.motion(word, y)[1][i][1]
            if letter == "F":
                for s in (1, -1):
                    found["slip", i, s] = lambda y, i=i, s=s: (
                        lambda f: self.mu[i] * f[1] + s * f[0]
                    )(self.motion(word, y)[1][i])
            elif self.mu[i]:
                s = 1 if letter == "R" else -1
                found["stop", i] = lambda y, i=i, s=s: s * self.slip(i, y)
        return found

    def until(self, word, y, step, steps=400):
        """Time, state and name of the first event in a mode. Events at the start do not count."""
        flow, events, t = self.flow(word), self.events(word), ZERO
        values = {name: f(y) for name, f in events.items()}
        for _ in range(steps):
            after = extrapolated(flow, y, t, step)
            later = {name: f(after) for name, f in events.items()}
            # A function that starts at zero is positive after the first step, or is no event.
            crossed = [k for k in events if later[k] <= 0 and values[k] > 0]
            if crossed:
                return min(
                    (
                        self.crossing(
                            flow, y, t, step, (values[k], later[k]), events[k], k
                        )
                        for k in crossed
                    ),
                    key=lambda end: end[0],
                )
            y, t, values = after, t + step, later
        raise AssertionError("no event")

    @staticmethod
    def crossing(flow, y, t, step, ends, event, name):
        """Secant steps to the root of an event within a step."""
        (a, fa), (b, fb) = (ZERO, ends[0]), (step, ends[1])
        for _ in range(60):
            h = b - fb * (b - a) / (fb - fa)
            state = extrapolated(flow, y, t, h)
            (a, fa), (b, fb) = (b, fb), (h, event(state))
            if abs(b - a) < Decimal(10) ** (4 - DIGITS) or fb == 0 or fb == fa:
                return t + b, state, name
        raise AssertionError("the root was not found")

    def hit(self, i, y, restitution=None):
        """Newton's impact without friction at contact i."""
        e = self.e if restitution is None else restitution
        (nx, ny), (dx, dy) = self.n[i], self.arm(i, y)
        b = dx * ny - dy * nx
        impulse = -(1 + e) * self.rate(i, y) / (1 + b * b / self.rho2)
        return [
            *y[:3],
            y[3] + nx * impulse,
            y[4] + ny * impulse,
            y[5] + b * impulse / self.rho2,
        ]

    def glide(self, y, t):
        """Free flight."""
        return [
            y[0] + y[3] * t,
            y[1] + y[4] * t - self.g * t * t / 2,
            y[2] + y[5] * t,
            y[3],
            y[4] - self.g * t,
            y[5],
        ]

    def bounce(self, i, y):
        """Bounces on contact i until it rests: duration and state. The other contact stays above the ground."""
        total = ZERO
        while True:
            (nx, ny), (dx, dy) = self.n[i], self.arm(i, y)
            pull = self.g * ny + (dx * nx + dy * ny) * y[5] ** 2
            left = 2 * self.rate(i, y) / (pull * (1 - self.e))
            if left < BRIEF:
                return total + left, self.hit(i, self.glide(y, left), ZERO)
            t = 2 * self.rate(i, y) / pull
            for _ in range(60):
                state = self.glide(y, t)
                change = self.gap(i, state) / self.rate(i, state)
                t -= change
                if abs(change) < Decimal(10) ** (6 - DIGITS) * t:
                    break
            y, total = self.hit(i, self.glide(y, t)), total + t
            other = 1 - i
            assert other >= len(self.mu) or self.gap(other, y) > 0

"""Postures that seem stable."""

import standfast as sf
from mpmath import mp, mpf

from . import modes
from .entry import Family, exact

FAMILY = Family("Stability")
entry = FAMILY.entry


def balanced(scene):
    words = modes.fraction_of_words(scene)["words"]
    return (
        f"the body is in equilibrium, and of all contact modes at rest only {', '.join(words)} is consistent: the method calls it stable",
        words == ("FF",),
    )


class Corners:
    """A body on two contacts, geometry frozen, from corner to corner: one contact rests or slides, the other lands."""

    def __init__(self, body):
        self.e, self.g = exact(body.restitution), exact(body.gravity)
        inverse = 1 / exact(body.gyration_radius) ** 2
        self.inverse = (mpf(1), mpf(1), inverse)
        self.friction = [exact(k.friction) for k in body.contacts]
        self.normal, self.tangent = [], []
        for k in body.contacts:
            c, s = mp.cos(exact(k.slope)), mp.sin(exact(k.slope))
            x, y = (
                exact(a) - exact(b)
                for a, b in zip(k.point, body.center_of_mass, strict=True)
            )
            self.tangent.append((c, s, x * s - y * c))
            self.normal.append((-s, c, x * c + y * s))

    def pushed(self, row):
        return [a * b for a, b in zip(self.inverse, row, strict=True)]

    def start(self, kept, slip):
        """Velocity with which the other contact lands with 1 m/s while the kept one slides."""
        rows = [self.normal[kept], self.normal[1 - kept], self.tangent[kept]]
        return list(mp.lu_solve(mp.matrix(rows), mp.matrix([0, -1, slip])))

    def struck(self, i, v):
        """Newton's law at one contact."""
        push = self.pushed(self.normal[i])
        kick = (1 + self.e) * dot(self.normal[i], v) / dot(self.normal[i], push)
        return [a - kick * b for a, b in zip(v, push, strict=True)]

    def bounce(self, landing, v):
        """Impacts, one by one, until the speed of a contact is 1e-35 of the first: that contact, the gap of the other, v."""
        h, first = [mpf(0), mpf(0)], -dot(self.normal[landing], v)
        g = [n[1] * self.g for n in self.normal]
        v = self.struck(landing, v)
        while True:
            u = [dot(n, v) for n in self.normal]
            flights = [
                mpf(0)
                if h[i] == 0 and u[i] < 0
                else (u[i] + mp.sqrt(u[i] ** 2 + 2 * g[i] * h[i])) / g[i]
                for i in (0, 1)
            ]
            i = int(flights[1] < flights[0])
            t = flights[i]
            h = [h[k] + t * (u[k] - g[k] * t / 2) for k in (0, 1)]
            h[i] = mpf(0)
            v[1] -= self.g * t
            if abs(dot(self.normal[i], v)) < mpf(10) ** -35 * first:
                assert h[1 - i] > mpf(10) ** -20 * first**2
                return i, h[1 - i], v
            v = self.struck(i, v)

    def slide(self, kept, h, v):
        """Slides until the other contact lands."""
        normal, tangent, other = (
            self.normal[kept],
            self.tangent[kept],
            self.normal[1 - kept],
        )
        way = mp.sign(dot(tangent, v))
        rub = way * self.friction[kept]
        force = self.pushed([n - rub * t for n, t in zip(normal, tangent, strict=True)])
        press = normal[1] * self.g / dot(normal, force)
        assert press > 0
        a = [press * f for f in force]
        a[1] -= self.g
        u, fall = dot(other, v), -dot(other, a)
        assert fall > 0
        t = (u + mp.sqrt(u * u + 2 * fall * h)) / fall
        after = [x + y * t for x, y in zip(v, a, strict=True)]
        assert way * dot(tangent, after) > 0
        return after


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


GROWTH = "ln of the growth of speeds in a cycle"
#: Difference of angles, in rad, at which a cycle counts as closed in the package.
COME_BACK = 1e-9
#: Number of corners after which later ones repeat to the required digits.
CORNERS = 130


@entry(
    name="strong_and_unstable",
    title="Kinematic-strong, but unstable, e = 0.26",
    breaks="Forces and modes at rest do not show that the body gains speed from corner to corner.",
    method="balance of forces, all words at rest in exact fractions",
    fails=balanced,
    source=f"{CORNERS} corners with 40 digits: impact by impact, then sliding with friction, then the landing of the other contact",
    answer=lambda scene: growth_told(sf.stability(scene.posture, width=0)),
    within=lambda _: {GROWTH: COME_BACK},
)
def _(scene):
    corners = Corners(scene.posture)
    kept, v = 1, corners.start(1, mpf(-1))
    growth, landed = [], []
    for _ in range(CORNERS):
        speed = mp.hypot(v[0], v[1])
        kept, h, v = corners.bounce(1 - kept, [x / speed for x in v])
        v = corners.slide(kept, h, v)
        growth.append(mp.log(mp.hypot(v[0], v[1])))
        landed.append(kept)
    assert landed[-4:] in ([0, 1, 0, 1], [1, 0, 1, 0])
    return {
        "verdict": "unstable",
        "kinematic-strong": True,
        "corners to a cycle": 2,
        GROWTH: growth[-1] + growth[-2],
    }


def growth_told(verdict):
    return {
        "verdict": verdict.frictional_stability,
        "kinematic-strong": verdict.kinematic_strong,
        "corners to a cycle": len(verdict.evidence),
        GROWTH: sum(corner["growth"] for corner in verdict.evidence),
    }

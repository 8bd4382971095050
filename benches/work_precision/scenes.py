"""The scenes of the chart and their exact answers, to 20 digits: computed with mpmath from the equations of motion, event
by event, without standfast. All given numbers are the doubles that the tools get, and exact.

`python scenes.py` writes scenes.json, which every tool reads. A scene has one or both of two tasks: *before*, the
state at the time `before.time`, before the impacts accumulate; and *rest*, the time at which all motion has ceased, and the position
then. SI units; contact points
with arms `arms` from the centre of mass, on a floor of slope `slope` through the point (0, 0) under gravity, or on the polyline
`terrain`, with the ground on its right; `q` and `v` are (x, y, θ) of the centre of mass and their rates, world axes.

A scene states its law of impact, `law`: "newton" (without friction), "moreau" (Newton's restitution, Coulomb's friction on the velocity
after the impact) or "poisson". Tools that have another law are compared with the state `before.moreau` or `before.late`, the answer by
this law."""

import itertools
import json
import math
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 60
G = mpf(9.81)
#: Speeds and times below it are none: some digits more than any tool has.
NEGLIGIBLE = mpf(10) ** -26
#: A gap below it is that of an end on the floor.
GROUND = mpf(10) ** -50


def ball():
    """Dropped from h: flights of u/g, 2eu/g, 2e²u/g, … with u = √(2gh)."""
    h, e, t = mpf(1), mpf(0.8), mpf(2)
    u = mp.sqrt(2 * G * h)
    start, speed = u / G, e * u
    while start + 2 * speed / G < t:
        start, speed = start + 2 * speed / G, e * speed
    height = speed * (t - start) - G * (t - start) ** 2 / 2
    rest = u / G * (1 + e) / (1 - e)
    return scene(
        "bouncing ball, e = 0.8",
        {"mass": 1, "gyration_radius": 0.4, "arms": [[0, -0.1]], "restitution": 0.8},
        {"q": [0, 1.1, 0], "v": [0, 0, 0]},
        (t, [height]),
        (rest, [0, mpf(0.1), 0]),
    )


class Rod:
    """A rod of half-length L on a frictionless floor: (y, θ) and their rates; ends 1 and 2 at y ∓ L sin θ."""

    def __init__(self, rho2, e, y, theta):
        self.length, self.rho2, self.e = mpf(0.5), rho2, e
        self.y, self.v, self.theta, self.omega, self.t = (
            y,
            mpf(0),
            theta,
            mpf(0),
            mpf(0),
        )

    def gap(self, end, t=0):
        side = 2 * end - 1
        turned = self.theta + self.omega * t
        return self.y + self.v * t - G * t * t / 2 + side * self.length * mp.sin(turned)

    def rate(self, end, t=0):
        side = 2 * end - 1
        turned = self.theta + self.omega * t
        return self.v - G * t + side * self.length * mp.cos(turned) * self.omega

    def touchdown(self, end):
        """The first root after 0: all arcs here are concave, for ω²L < g."""
        assert self.omega**2 * self.length < G
        h, u = self.gap(end), self.rate(end)
        if h < GROUND:
            h, u = mpf(0), max(u, mpf(0))
        t = (u + mp.sqrt(u * u + 2 * G * h)) / G
        for _ in range(60):
            step = self.gap(end, t) / self.rate(end, t)
            t -= step
            if abs(step) <= mpf(10) ** (6 - mp.dps) * t:
                break
        return t

    def fly(self, t):
        self.y += self.v * t - G * t * t / 2
        self.v -= G * t
        self.theta += self.omega * t
        self.t += t

    def hit(self, end):
        """Newton's law at one end, without friction: arm b = ±L cos θ."""
        b = (2 * end - 1) * self.length * mp.cos(self.theta)
        impulse = -(1 + self.e) * self.rate(end) / (1 + b * b / self.rho2)
        self.v += impulse
        self.omega += b * impulse / self.rho2

    def until(self, time):
        """Collision by collision to this time, before the impacts accumulate."""
        while self.t < time:
            self.collide(time)

    def collide(self, time=mp.inf):
        """The next collision and the end that is hit, or None if there is none before this time."""
        landings = [self.touchdown(end) for end in (0, 1)]
        end = int(landings[1] < landings[0])
        if self.t + landings[end] > time:
            self.fly(time - self.t)
            return None
        self.fly(landings[end])
        self.hit(end)
        return end

    def settle(self):
        """The motion to rest. An end whose bounces have become negligible is held while the other end falls and lands."""
        while True:
            end = self.collide()
            if abs(self.rate(end)) < NEGLIGIBLE:
                if self.gap(1 - end) + abs(self.rate(1 - end)) < 1000 * NEGLIGIBLE:
                    return self.t
                self.fall_about(end)
                self.corner(1 - end)

    def fall_about(self, held):
        """One end slides along the floor until the other lands. With φ = |θ|: y = L sin φ, ½(ρ² + L²cos²φ)φ'² + g L sin φ
        is constant, and quadrature gives the time from the highest point down, in u: φ = φ_m − (φ_m − φ_0) u²."""
        side = 1 - 2 * held

        def inertia(phi):
            return self.rho2 + (self.length * mp.cos(phi)) ** 2

        start, rate = side * self.theta, side * self.omega
        energy = inertia(start) * rate**2 / 2 + G * self.length * mp.sin(start)
        top = mp.asin(energy / (G * self.length))

        def speed(way):
            """φ' at φ_m − way, with sin φ_m − sin φ as a product."""
            drop = 2 * mp.cos(top - way / 2) * mp.sin(way / 2)
            return mp.sqrt(2 * G * self.length * drop / inertia(top - way))

        def fall(to):
            way = top - to
            return mp.quad(lambda u: 2 * way * u / speed(way * u * u), [0, 1])

        self.t += fall(mpf(0)) + (fall(start) if rate > 0 else -fall(start))
        self.theta, self.y = mpf(0), mpf(0)
        self.omega = -side * speed(top)
        self.v = side * self.length * self.omega

    def corner(self, landed):
        """The end that lands is hit first, then any end that approaches, all at one instant."""
        end = landed
        while min(self.rate(0), self.rate(1)) < 0:
            if self.rate(end) < 0:
                self.hit(end)
            end = 1 - end


def rod(name, rho, e, time):
    """Both ends a little above the floor, one higher than the other."""
    rho2 = mpf(rho) ** 2
    y, theta = mpf(0.011), mpf(float(mp.asin(mpf(0.002))))
    before = Rod(rho2, e, y, theta)
    before.until(mpf(time))
    after = Rod(rho2, e, y, theta)
    rest = after.settle()
    return scene(
        name,
        {
            "mass": 1,
            "gyration_radius": rho,
            "arms": [[-0.5, 0], [0.5, 0]],
            "restitution": float(e),
        },
        {"q": [0, 0.011, float(theta)], "v": [0, 0, 0]},
        (mpf(time), [before.gap(0), before.gap(1)]),
        (rest, [0, 0, 0]),
    )


def block():
    """Slides down to the right, until friction has stopped it after v/a: a = g (μ cos α + sin α), α < 0."""
    slope, mu = mpf(float(mpf(-10) * mp.pi / 180)), mpf(0.3)
    speed = [float(2 * x) for x in (mp.cos(slope), mp.sin(slope))]
    v = mpf(speed[0]) * mp.cos(slope) + mpf(speed[1]) * mp.sin(slope)
    a = G * (mu * mp.cos(slope) + mp.sin(slope))

    def way(t):
        return v * t - a * t * t / 2

    stop = v / a
    along, normal = (mp.cos(slope), mp.sin(slope)), (-mp.sin(slope), mp.cos(slope))

    def at(s):
        return [along[k] * s + normal[k] / 10 for k in (0, 1)]

    arms = [[float(along[k] * x - normal[k] / 10) for k in (0, 1)] for x in (-0.5, 0.5)]
    half = mpf(float(stop / 2))
    return scene(
        "sliding block with friction",
        {
            "mass": 1,
            "gyration_radius": 0.3,
            "arms": arms,
            "restitution": 0,
            "friction": 0.3,
            "slope": float(slope),
        },
        {
            "q": [float(x) for x in (*at(0), 0)],
            "v": [*speed, 0],
        },
        (half, at(way(half))),
        (stop, [*at(way(stop)), 0]),
    )


def rocking():
    """Housner's block. It turns about a corner, by quadrature. Each impact at the other corner keeps a constant share of its spin."""
    radius, alpha, omega = mpf(1.25), mpf(0.3), mpf(0.4)
    # The values as doubles.
    b, h = mpf(float(radius * mp.sin(alpha))), mpf(float(radius * mp.cos(alpha)))
    rho2 = mpf(float(radius / mp.sqrt(3))) ** 2
    diagonal2, angle = b * b + h * h, mp.atan(b / h)
    pull = G * mp.sqrt(diagonal2) / (rho2 + diagonal2)
    kept = (rho2 + h * h - b * b) / (rho2 + diagonal2)

    def swing(spin):
        top = angle - mp.acos(mp.cos(angle) + spin**2 / (2 * pull))

        def slowness(u):
            phi = top * (1 - u * u)
            rest = mp.sin(top * u * u / 2) * mp.sin(angle - (phi + top) / 2)
            return 2 * top * u / mp.sqrt(4 * pull * rest)

        return 2 * mp.quad(slowness, [0, 1])

    time, spin = mpf(0), omega
    mp.dps += 20
    while spin > mpf(10) ** -20:
        time, spin = time + swing(spin), spin * kept
    # The last swings are small: T = 2ω/(p² sin α), a geometric series.
    time += 2 * spin / (pull * mp.sin(angle)) / (1 - kept)
    mp.dps -= 20
    w = float(omega)
    return scene(
        "rocking block, to rest on two contacts",
        {
            "mass": 2,
            "gyration_radius": float(radius / mp.sqrt(3)),
            "arms": [[-float(b), -float(h)], [float(b), -float(h)]],
            "restitution": 0,
            "friction": 1,
            "rocks": True,
        },
        {"q": [0, float(h), 0], "v": [-float(h) * w, float(b) * w, w]},
        None,
        (time, [0, h, 0]),
        "moreau",
    )


def moreau(G, slip, approach, e, mu):
    """Impulses (tangential, normal) of one contact: u_n⁺ = −e u_n and u_t⁺ = 0 if friction can do that, else it slides on."""
    (tt, tn), (_, nn) = G
    rise = -(1 + e) * approach
    det = tt * nn - tn * tn
    stick = (-nn * slip - tn * rise) / det, (tt * rise + tn * slip) / det
    if abs(stick[0]) <= mu * stick[1]:
        return stick
    for way in (1, -1):
        normal = rise / (nn - way * mu * tn)
        after = slip + (tn - way * mu * tt) * normal
        if normal > 0 and way * after > 0:
            return -way * mu * normal, normal
    raise AssertionError("no sliding direction")


def late(G, slip, approach, e, mu):
    """The law of rapier and of Box2D 3: Moreau's without rebound, then a rebound without friction."""
    along, normal = moreau(G, slip, approach, mpf(0), mu)
    return along, normal - e * approach / G[1][1]


def poisson(G, slip, approach, e, mu):
    """Impulses (tangential, normal) of one contact, after Routh: friction follows the sliding speed during the impact, and the
    normal impulse of restitution is e times that of compression [Routh 1905, art. 179]."""
    (tt, tn), (_, nn) = G
    normal, along, goal, u, v = mpf(0), mpf(0), None, slip, approach
    while goal is None or normal < goal:
        sticks = u == 0 and abs(tn) <= mu * tt
        if sticks:
            share = -tn / tt
        else:
            way = mp.sign(u) if u != 0 else mp.sign(tn)
            share = -way * mu
        up, side = nn + share * tn, mpf(0) if sticks else tn + share * tt
        assert up > 0  # it does not jam
        end = -v / up if goal is None else goal - normal
        stop = -u / side if u * side < 0 else mp.inf
        part = min(end, stop)
        normal, along, v = normal + part, along + share * part, v + up * part
        u = mpf(0) if stop <= end else u + side * part
        if part == end and goal is None:
            goal, v = (1 + e) * normal, mpf(0)
        elif part == end:
            break
    return along, normal


class Thrown:
    """A body that flies and is hit at one corner at a time, over level treads: (from x, to x, height)."""

    #: Between these times, in s, the gaps are looked at; no rebound is shorter.
    LOOK = 2e-4
    #: Least gap of a corner that is not hit, and of a riser, in m: nothing is grazed.
    CLEAR = 1e-5

    def __init__(self, body, start, law, treads):
        self.arms = [[mpf(x) for x in arm] for arm in body["arms"]]
        self.rho2 = mpf(body["gyration_radius"]) ** 2
        self.e, self.mu = mpf(body["restitution"]), mpf(body["friction"])
        self.q, self.v = [mpf(x) for x in start["q"]], [mpf(x) for x in start["v"]]
        self.law, self.treads, self.t, self.hits = law, treads, mpf(0), 0

    def height(self, x):
        return next(z for low, high, z in self.treads if low <= x < high)

    def lever(self, arm, t=0, of=mp):
        """The arm, turned."""
        c, s = of.cos(self.q[2] + self.v[2] * t), of.sin(self.q[2] + self.v[2] * t)
        return c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]

    def place(self, arm, t):
        x, y = self.lever(arm, t)
        return (
            self.q[0] + self.v[0] * t + x,
            self.q[1] + self.v[1] * t - G * t * t / 2 + y,
        )

    def landing(self, limit):
        """The first corner that comes to the ground, and when; None before `limit`."""
        q, v = [float(x) for x in self.q], [float(x) for x in self.v]
        arms = [[float(x) for x in arm] for arm in self.arms]
        count = int(limit / self.LOOK) + 2
        least = [math.inf] * len(arms)
        for step in range(1, count):
            t = step * self.LOOK
            c, s = math.cos(q[2] + v[2] * t), math.sin(q[2] + v[2] * t)
            x0, y0 = q[0] + v[0] * t, q[1] + v[1] * t - float(G) * t * t / 2
            landed = []
            for i, (a, b) in enumerate(arms):
                x, y = x0 + c * a - s * b, y0 + s * a + c * b
                gap = y - self.height(x)
                if gap < 0:
                    landed.append(i)
                elif step > 1:
                    least[i] = min(least[i], gap)
            if landed:
                (i,) = landed
                t = self.refined(self.arms[i], mpf(t))
                return (i, t) if t <= limit else None
        return None

    def refined(self, arm, t):
        """The zero of a gap before `t`, by Newton's method."""
        level = self.height(float(self.place(arm, t)[0]))
        for _ in range(60):
            y = self.place(arm, t)[1]
            rate = self.v[1] - G * t + self.lever(arm, t)[0] * self.v[2]
            step = (y - level) / rate
            t -= step
            if abs(step) <= mpf(10) ** (6 - mp.dps):
                break
        low, high, _ = next(tread for tread in self.treads if tread[2] == level)
        assert low + self.CLEAR < self.place(arm, t)[0] < high - self.CLEAR
        return t

    def fly(self, t):
        self.q = [a + b * t for a, b in zip(self.q, self.v, strict=True)]
        self.q[1] -= G * t * t / 2
        self.v[1] -= G * t
        self.t += t

    def hit(self, i):
        x, y = self.lever(self.arms[i])
        slip, approach = self.v[0] - y * self.v[2], self.v[1] + x * self.v[2]
        tn = -x * y / self.rho2
        matrix = (1 + y * y / self.rho2, tn), (tn, 1 + x * x / self.rho2)
        along, normal = self.law(matrix, slip, approach, self.e, self.mu)
        self.v[0] += along
        self.v[1] += normal
        self.v[2] += (x * normal - y * along) / self.rho2
        self.hits += 1
        # The next contact is not missed between two looks.
        assert self.v[1] + x * self.v[2] > G * self.LOOK

    def until(self, time):
        while (found := self.landing(time - self.t)) is not None:
            self.fly(found[1])
            self.hit(found[0])
        self.fly(time - self.t)
        return self


FLOOR = [(-1e9, 1e9, 0.0)]


def thrown(title, law, body, start, time, treads=FLOOR, **more):
    """The gaps above the lowest level, and x of the centre of mass."""
    body = {"mass": 1, **body}

    def state(law):
        end = Thrown(body, start, law, treads).until(mpf(time))
        return [end.q[0], *(end.place(arm, 0)[1] for arm in end.arms)]

    found = scene(title, body, start, (mpf(time), state(law)), None, law.__name__)
    for other in (moreau, late):
        if other is not law:
            values = [mp.nstr(x, 20) for x in state(other)]
            found["before"][other.__name__] = values
    return found | more


def box_on_the_floor():
    return thrown(
        "thrown box, Poisson's law",
        poisson,
        box(0.3, 0.5),
        {"q": [0, 0.7, 0.4], "v": [1.5, 0.5, -3]},
        1.0,
    )


def box(w, h):
    """A uniform rectangle, ρ² = (w² + h²)/12, with contacts at its corners."""
    return {
        "gyration_radius": float(mp.sqrt((mpf(w) ** 2 + mpf(h) ** 2) / 12)),
        "arms": [
            [x * w / 2, y * h / 2] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ],
        "restitution": 0.5,
        "friction": 0.3,
    }


def octagon():
    angles = [mp.pi * (2 * k + 1) / 8 for k in range(8)]
    radius = mpf(0.25)
    # A uniform regular polygon: ρ² = R² (2 + cos(2π/n))/6
    rho = float(radius * mp.sqrt((2 + mp.cos(mp.pi / 4)) / 6))
    return thrown(
        "octagon, thrown",
        moreau,
        {
            "gyration_radius": rho,
            "arms": [
                [float(radius * mp.cos(a)), float(radius * mp.sin(a))] for a in angles
            ],
            "restitution": 0.6,
            "friction": 0.4,
        },
        {"q": [0, 0.8, 0.1], "v": [2, 0, -5]},
        1.4,
    )


def stairs():
    treads = [
        (-1e9, 0.5, 0.0),
        (0.5, 1.0, -0.25),
        (1.0, 1.5, -0.5),
        (1.5, 2.0, -0.75),
        (2.0, 1e9, -1.0),
    ]
    terrain = [[-5, 0]]
    for (_, x, high), (_, _, low) in itertools.pairwise(treads):
        terrain += [[x, high], [x, low]]
    return thrown(
        "box on stairs",
        moreau,
        box(0.2, 0.2),
        {"q": [0, 0.34, 0.1], "v": [1.7, 0, 2]},
        1.1,
        treads,
        terrain=[*terrain, [10, -1]],
    )


def feet():
    """Eight feet on an arc. The body rolls over them, pivoting about one foot until the next one lands, rolls back and comes to rest on
    two. A swing about a foot is that of an inverted pendulum, β'' = (g r/(ρ² + r²)) sin β; a landing keeps a constant share
    of the spin, (ρ² + r_i·r_j)/(ρ² + r_j²), for angular momentum about the foot that lands is kept."""
    rho, spacing, low = 0.3, mpf(0.3), mpf(0.4)
    angles = [(k - mpf(3.5)) * spacing for k in range(8)]
    arms = [[float(mp.sin(a)), float(low - mp.cos(a))] for a in angles]
    spin = mpf(-1.5)
    exact = [[mpf(x) for x in arm] for arm in arms]
    rho2 = mpf(rho) ** 2
    radius = [mp.hypot(*arm) for arm in exact]
    # The angle of the centre of mass from the vertical above its foot, with the body unturned, counterclockwise.
    lean = [mp.atan2(arm[0], -arm[1]) for arm in exact]
    # The turn of the body with which feet k and k + 1 are both on the floor.
    flat = [-mp.atan2(b[1] - a[1], b[0] - a[0]) for a, b in itertools.pairwise(exact)]

    def kept(i, j):
        inner = exact[i][0] * exact[j][0] + exact[i][1] * exact[j][1]
        return (rho2 + inner) / (rho2 + radius[j] ** 2)

    def swing(foot, turn, spin):
        """Time, turn and spin of the next landing."""
        pull = G * radius[foot] / (rho2 + radius[foot] ** 2)
        start, way = lean[foot] + turn, mp.sign(spin)
        goal = flat[foot - 1] if way > 0 else flat[foot]
        end = lean[foot] + goal
        over = start * end < 0
        cosine = mp.cos(start) + spin**2 / (2 * pull)
        passes = cosine > 1 if over else cosine > mp.cos(end) or abs(end) > abs(start)
        if passes:
            time = mp.quad(
                lambda b: 1 / mp.sqrt(2 * pull * (cosine - mp.cos(b))),
                [min(start, end), max(start, end)],
            )
            return time, goal, way * mp.sqrt(2 * pull * (cosine - mp.cos(end)))
        top = mp.sign(start) * mp.acos(cosine)
        half = top - start

        def slowness(u):
            rest = mp.sin(-half * u * u / 2) * mp.sin(top - half * u * u / 2)
            return 2 * abs(half) * u / mp.sqrt(4 * pull * rest)

        return 2 * mp.quad(slowness, [0, 1]), turn, -spin

    mp.dps += 20
    foot, turn, time, omega, x = 4, mpf(0), mpf(0), spin, exact[4][0]
    while True:
        t, turn, omega = swing(foot, turn, omega)
        other = foot + 1 if foot < 7 and turn == flat[foot] else foot - 1
        way = [b - a for a, b in zip(exact[foot], exact[other], strict=True)]
        x += mp.cos(turn) * way[0] - mp.sin(turn) * way[1]
        time, omega = time + t, omega * kept(foot, other)
        last, foot = foot, other
        if abs(omega) < mpf(10) ** -20:
            break
    # The last swings are small, about two feet in turn: each lasts 2ω/(p sin β).

    def brief(foot, omega):
        pull = G * radius[foot] / (rho2 + radius[foot] ** 2)
        return 2 * abs(omega) / (pull * abs(mp.sin(lean[foot] + turn)))

    share = kept(foot, last) * kept(last, foot)
    two = brief(foot, omega) + brief(last, omega * kept(foot, last))
    time += two / (1 - share)
    c, s, (a, b) = mp.cos(turn), mp.sin(turn), exact[foot]
    place = [x - (c * a - s * b), -(s * a + c * b), turn]
    mp.dps -= 20
    w, (a, b) = float(spin), arms[4]
    return scene(
        "eight feet, rolling to rest",
        {
            "mass": 1,
            "gyration_radius": rho,
            "arms": arms,
            "restitution": 0,
            "friction": 1,
            "rocks": True,
        },
        {"q": [0, -b, 0], "v": [w * b, -w * a, w]},
        None,
        (time, place),
        "moreau",
    )


def nearly_elastic():
    """A rod with e = .99, after some tens of impacts."""
    y, theta, time = mpf(0.011), mpf(float(mp.asin(mpf(0.002)))), mpf(0.5)
    end = Rod(mpf(0.2) ** 2, mpf(0.99), y, theta)
    end.until(time)
    return scene(
        "rod, e = 0.99",
        {
            "mass": 1,
            "gyration_radius": 0.2,
            "arms": [[-0.5, 0], [0.5, 0]],
            "restitution": 0.99,
        },
        {"q": [0, 0.011, float(theta)], "v": [0, 0, 0]},
        (time, [end.gap(0), end.gap(1)]),
        None,
    )


def scene(title, body, start, before, rest, law="newton"):
    def digits(value):
        return mp.nstr(mpf(value), 20)

    found = {
        "title": title,
        "law": law,
        "body": {"friction": 0, "slope": 0, **body},
        "start": start,
    }
    if rest is not None:
        found["rest"] = {"time": digits(rest[0]), "q": [digits(x) for x in rest[1]]}
    if before is not None:
        found["before"] = {
            "time": float(before[0]),
            "values": [digits(x) for x in before[1]],
        }
    return found


def scenes():
    return {
        "ball": ball(),
        "rod": rod("clattering rod, e = 0.1", 0.2, mpf(0.1), 0.0477),
        "nested": rod(
            "uniform rod, e = 0.5 (nested Zeno)",
            float(mp.sqrt(mpf(1) / 12)),
            mpf(0.5),
            0.06,
        ),
        "block": block(),
        "rocking": rocking(),
        "elastic": nearly_elastic(),
        "thrown": box_on_the_floor(),
        "octagon": octagon(),
        "stairs": stairs(),
        "feet": feet(),
    }


if __name__ == "__main__":
    path = Path(__file__).with_name("scenes.json")
    path.write_text(json.dumps({"gravity": 9.81, "scenes": scenes()}, indent=1) + "\n")

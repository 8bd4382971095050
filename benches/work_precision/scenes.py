"""The scenes of the chart and their exact answers, to 20 digits: computed with mpmath from the equations of motion, event
by event, without standfast. All given numbers are the doubles that the tools get, and exact.

`python scenes.py` writes scenes.json, which every tool reads. Each scene has two tasks: *before*, the
state at the time `before.time`, before the impacts accumulate; and *rest*, the time at which all motion has ceased, and the position
then. SI units; two contact points
with arms `arms` from the centre of mass, on a floor of slope `slope` through the point (0, 0) under gravity; `q` and `v` are
(x, y, θ) of the centre of mass and their rates, world axes."""

import json
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
    )


def scene(title, body, start, before, rest):
    def digits(value):
        return mp.nstr(mpf(value), 20)

    found = {
        "title": title,
        "body": {"friction": 0, "slope": 0, **body},
        "start": start,
        "rest": {"time": digits(rest[0]), "q": [digits(x) for x in rest[1]]},
    }
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
    }


if __name__ == "__main__":
    path = Path(__file__).with_name("scenes.json")
    path.write_text(json.dumps({"gravity": 9.81, "scenes": scenes()}, indent=1) + "\n")

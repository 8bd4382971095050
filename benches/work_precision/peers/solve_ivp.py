"""scipy.integrate.solve_ivp: a terminal event at every impact, Newton's law by hand, restart.

Model: the state is (x, y, θ) and its rates. A contact is either free, and the zero of its gap is an event; or it is held on the
floor, and the zero of its sliding speed is an event. The force of a held contact, with sliding friction, follows from zero normal
acceleration. A user has to add the following, which solve_ivp does not have:

- Restarts. After an impact the gap is 0, and solve_ivp would find this root again. The usual remedy, to lift the contact a little,
  costs accuracy. Here the first step ends before the apex of the flight, so that the gap is positive at every evaluation. Each flight
  starts at its own time 0, because roots are found to 4 ulp of 1.
- The end of an accumulation of impacts. A contact that rebounds more slowly than `stop` is held from then on. The body is at rest
  when two held contacts (for a ball one) do not slide; the time of rest is that time.
- Impacts at one instant. If a contact lands while another one is held, or sooner than the accuracy of a root (1e-14 s), the contacts
  are hit in turn until none approaches.

There is one tolerance tol: rtol = tol, atol = tol / 1000, and stop = tol in m/s. A free flight is a polynomial, exact for every method;
so the tolerance has an effect only in the held phases and at the end. Scenes with friction in impacts are left out."""

import math
import sys
from functools import partial

import harness

try:
    import numpy as np
    import scipy
    from scipy.integrate import solve_ivp
except ImportError:
    print("scipy is not installed: skipped", file=sys.stderr)
    sys.exit(0)

G = harness.GRAVITY
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-12, 1e-13)
#: Seconds to which a root is known.
ROOT = 1e-14


class Contacts:
    """A rigid body of mass 1 over the floor: gaps, rates, forces and impulses of its contact points."""

    def __init__(self, body):
        self.arms, self.e, self.mu = body["arms"], body["restitution"], body["friction"]
        self.rho2 = body["gyration_radius"] ** 2
        self.sin, self.cos = math.sin(body["slope"]), math.cos(body["slope"])
        self.all = range(len(self.arms))
        # The state is relative to the position of the centre at rest, so that small gaps keep their digits.
        self.height = 0.0
        self.height = -sum(self.lever(i, 0.0)[1] for i in self.all) / len(self.arms)

    def start(self, q, v):
        return np.array(
            [q[0] + self.sin * self.height, q[1] - self.cos * self.height, q[2], *v],
            dtype=float,
        )

    def position(self, z):
        x, y, theta = (float(u) for u in z[:3])
        return [x - self.sin * self.height, y + self.cos * self.height, theta]

    def lever(self, i, theta):
        """The arm in the axes of the floor: along it, and off it."""
        (a, b), c, s = self.arms[i], math.cos(theta), math.sin(theta)
        x, y = c * a - s * b, s * a + c * b
        return self.cos * x + self.sin * y, self.cos * y - self.sin * x

    def gap(self, i, z):
        return (
            self.cos * z[1] - self.sin * z[0] + (self.lever(i, z[2])[1] + self.height)
        )

    def ends(self, i, z, tol):
        """Whether the contact rebounds too slowly to be followed: its speed is below the tolerance, or its flight is
        not above the rounding error of the gap."""
        roundoff = 1e-15 * abs(self.lever(i, z[2])[1] + self.height)
        return self.rate(i, z) < max(tol, math.sqrt(2 * G * roundoff))

    def rate(self, i, z):
        return self.cos * z[4] - self.sin * z[3] + self.lever(i, z[2])[0] * z[5]

    def slip(self, i, z):
        return self.cos * z[3] + self.sin * z[4] - self.lever(i, z[2])[1] * z[5]

    def push(self, i, z, e):
        """The impulse that reverses the contact's rate, times e."""
        lever = self.lever(i, z[2])[0]
        impulse = -(1 + e) * self.rate(i, z) / (1 + lever * lever / self.rho2)
        z[3] -= self.sin * impulse
        z[4] += self.cos * impulse
        z[5] += lever * impulse / self.rho2

    def motion(self, held, sign):
        """The right-hand side with these contacts held, sliding in this direction."""
        if not held:
            return lambda t, z: (z[3], z[4], z[5], 0.0, -G, 0.0)
        friction = -self.mu * sign

        def accelerations(t, z):
            levers = [self.lever(i, z[2]) for i in held]
            turns = [a - friction * b for a, b in levers]
            matrix = [[1 + a * turn / self.rho2 for turn in turns] for a, _ in levers]
            wanted = [G * self.cos + z[5] ** 2 * b for _, b in levers]
            forces = (
                np.linalg.solve(matrix, wanted)
                if len(held) > 1
                else [wanted[0] / matrix[0][0]]
            )
            normal = sum(forces)
            along = friction * normal
            alpha = (
                sum(f * turn for f, turn in zip(forces, turns, strict=True)) / self.rho2
            )
            x, y = (
                self.cos * along - self.sin * normal,
                self.sin * along + self.cos * normal,
            )
            return (z[3], z[4], z[5], x, y - G, alpha)

        return accelerations


def event(function, i):
    def found(t, z):
        return function(i, z)

    found.terminal, found.direction = True, -1
    return found


def simulate(scene, method, tol, end):
    """The state at the end and the time of rest, None if that was not reached."""
    of = Contacts(scene["body"])
    z, time, first = of.start(**scene["start"]), 0.0, None
    held = [i for i in of.all if of.gap(i, z) < 1e-12 and of.ends(i, z, tol)]
    while True:
        free = [i for i in of.all if i not in held]
        events = [event(of.gap, i) for i in free]
        if held and of.mu:
            events.append(event(of.slip, held[0]))
        flight = solve_ivp(
            of.motion(held, 1.0),
            (0.0, end - time),
            z,
            method=method,
            rtol=max(tol, 2.3e-14),
            atol=tol / 1000,
            events=events,
            first_step=first if first and first < end - time else None,
        )
        time, z = time + float(flight.t[-1]), flight.y[:, -1].copy()
        if flight.status == 0:
            return of, z, None
        landed = next(k for k, hits in enumerate(flight.t_events) if len(hits))
        if landed >= len(free):  # it no longer slides
            return of, z, time
        # The contacts that are on the floor, or reach it within the error of a root. They are hit in turn while any approaches.
        near = [
            i
            for i in free
            if i != free[landed] and of.gap(i, z) < ROOT * abs(of.rate(i, z))
        ]
        touching = [free[landed], *held, *near]
        of.push(touching[0], z, of.e)
        while min(of.rate(i, z) for i in touching) < -tol:
            for i in touching:
                if of.rate(i, z) < 0:
                    of.push(i, z, of.e)
        held = [i for i in touching if of.ends(i, z, tol)]
        for i in held:
            of.push(i, z, 0.0)
        if len(held) == len(of.all):
            return of, z, time
        # At least half the time to the apex.
        first = min(
            (of.rate(i, z) / (2 * G) for i in touching if i not in held), default=None
        )


def main():
    for name, scene in harness.scenes(sys.argv[1]).items():
        if scene["law"] != "newton":
            continue
        for task in ("before", "rest"):
            if task not in scene:
                continue
            end = scene[task]["time"] * (1.5 if task == "rest" else 1.0)
            for method in ("RK23", "RK45", "DOP853"):
                for tol in TOLERANCES:
                    if method == "RK23" and tol < 1e-7:
                        continue
                    run = partial(simulate, scene, method, tol, end)
                    seconds, (of, z, time) = harness.median_time(run)
                    harness.report(
                        tool=f"scipy {scipy.__version__}",
                        scene=name,
                        task=task,
                        setting=f"{method}, tol = {tol:g}",
                        parameter=tol,
                        seconds=seconds,
                        **harness.answer(name, scene, task, of.position(z), time),
                    )


if __name__ == "__main__":
    main()

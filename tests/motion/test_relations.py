"""Every motion obeys Newton's and Coulomb's laws. The checks use only the body, its ground and `run.at`, and no details of how a
motion is computed.

Accelerations are differences of `run.at`. A force, or an impulse, is possible if it is a sum, with nonnegative weights, of
the edges of the friction cones of the touching contacts; its distance from such a sum is found by nonnegative least squares.
"""

import math
import os
from collections import Counter
from itertools import pairwise

import numpy as np
import standfast as sf
from scipy.optimize import nnls

#: Number of random motions.
RUNS = int(os.environ.get("STANDFAST_RELATIONS_RUNS", "400"))
#: Number of parts of one mode that are checked in a run, and the shortest one that differences can resolve, in s.
STRETCHES, SHORTEST = 12, 2e-3
#: Step of the differences in √(ρ/g), at which their error, about step⁴ times fifth derivatives plus 1e-16/step, is least.
STEP = 5e-5
#: Allowed error of quantities other than differences, relative to their terms, and time within which two events count as one,
#: in s.
ROUNDING = 1e-8
#: Allowed error of differences for bodies that rotate by up to 100 rad/s, and of extrapolated speeds before and after an
#: impact.
DIFFERENCE, JUMP = 1e-6, 1e-5


def draw(rng):
    """A body over level ground, slopes, a segment or a polyline: dropped, thrown, pushed or left alone."""
    count = rng.choice([1, 2, 2, 3, 4])
    size = rng.choice([0.1, 1.0, 3.0])
    low = rng.random() < 0.5  # all feet on one line
    wide = rng.choice([1.0, 1.0, 1e-2])  # or feet close together
    points = (
        size * wide * rng.uniform([-0.5, -0.3], [0.5, 0.3], (count, 2)) * (1, not low)
    )
    kind = rng.choice(["level", "slopes", "segment", "polyline"])
    terrain, slopes = None, np.zeros(count)
    segment = (-math.inf, math.inf)
    if kind == "slopes":
        slopes = rng.uniform(-1, 1, count)
    elif kind == "segment":
        slopes[:] = rng.uniform(-0.6, 0.6)
        segment = tuple(size * rng.uniform([-1, 0.1], [-0.1, 1]))
    elif kind == "polyline":
        x = size * np.linspace(-1, 1, rng.integers(2, 8))
        y = size * rng.uniform(-0.3, 0.3, len(x))
        low = points[:, 1] - np.interp(points[:, 0], x, y)
        terrain = np.column_stack([x, y + low.min()])  # directly below the body
    frictions = rng.choice([0.0, 0.2, 0.5, 1.0, rng.uniform(0, 2)], count)
    contacts = [
        sf.Contact(tuple(p), slope=b, friction=mu, segment=segment)
        if terrain is None
        else sf.Contact(tuple(p), friction=mu)
        for p, b, mu in zip(points, slopes, frictions, strict=True)
    ]
    posture = sf.Posture(
        mass=rng.choice([0.3, 1.0, 2.5]),
        gyration_radius=rng.uniform(0.1, 1) * size,
        center_of_mass=tuple(size * rng.uniform([-0.5, -0.2], [0.5, 1.0])),
        contacts=contacts,
        restitution=rng.choice([0.0, 0.3, 0.5, rng.uniform(0, 0.9)]),
        gravity=rng.choice([9.81, 1.62]),
        terrain=None if terrain is None else [tuple(p) for p in terrain.tolist()],
    )
    start = rng.choice(["drop", "spin", "push", "rest"])
    q, qdot = np.zeros(3), np.zeros(3)
    if start in ("drop", "spin"):
        q[2] = rng.uniform(-1, 1) * rng.choice([0.0, 0.3, 3.0])
        spin = {"spin": 10, "drop": 2 * (q[2] != 0)}[start]  # or it lands flat
        qdot = rng.normal(size=3) * (1, 1, spin)
    elif start == "push":
        qdot = rng.normal(size=3) * (1, 0, rng.choice([0, 1]))
    body = Body(posture)
    lift = 0.0 if start in ("push", "rest") else size * rng.choice([1e-3, 0.2])
    above = [
        gap / normal[1]
        for i, foot in enumerate(body.feet(q))
        for _, normal, gap in body.over(i, foot)
    ]
    q[1] = lift - min(above, default=0.0)
    law = rng.choice(["newton"] * 5 + ["poisson", "stronge", "chatterjee-ruina"])
    options = {
        "model": "full",
        "impact": str(law),
        "time_limit": float(rng.choice([1.0, 4.0])),
        "event_limit": 20_000,
    }
    if law != "newton" or rng.random() < 0.1:
        options["simultaneous"] = "first-contact-first"
    return posture, q, qdot, options


class Body:
    """Feet, ground and cones, from the inputs of the posture alone."""

    def __init__(self, posture):
        self.posture = posture
        self.center = np.array(posture.center_of_mass)
        self.arms = np.array([c.point for c in posture.contacts]) - self.center
        rho = posture.gyration_radius
        #: Step of the differences, in s.
        self.step = STEP * math.sqrt(rho / posture.gravity)
        #: Forces and moments per unit mass, (3,), scaled to lengths per s².
        self.scale = np.array([1, 1, 1 / rho])
        self.ground = [list(self.lines(i)) for i in range(len(posture.contacts))]

    def lines(self, i):
        """Pieces of ground of contact i: a point, the tangent, and both ends along x."""
        posture, contact = self.posture, self.posture.contacts[i]
        if posture.terrain is not None:
            for start, end in pairwise(np.array(posture.terrain)):
                way = end - start
                yield start, way / np.linalg.norm(way), (start[0], end[0])
        else:
            tangent = np.array([math.cos(contact.slope), math.sin(contact.slope)])
            point = np.array(contact.point)
            yield point, tangent, point[0] + np.array(contact.segment) * tangent[0]

    def feet(self, q):
        """Positions of all contacts, (n, 2)."""
        cos, sin = math.cos(q[2]), math.sin(q[2])
        turn = np.array([[cos, -sin], [sin, cos]])
        return self.center + np.array(q[:2]) + self.arms @ turn.T

    def over(self, i, foot, margin=0.0):
        """(t, n, height along n) for each piece of ground above or below foot i."""
        for origin, tangent, (low, high) in self.ground[i]:
            normal = np.array([-tangent[1], tangent[0]])
            if low - margin <= foot[0] <= high + margin:
                yield tangent, normal, (foot - origin) @ normal

    def frames(self, i, q):
        """Rows of the rates along t and along n, (2, 3), for each piece of ground that foot i touches."""
        foot = self.feet(q)[i]
        arm = foot - self.center - q[:2]
        margin = ROUNDING * (1 + np.abs(foot).max())
        for tangent, normal, gap in self.over(i, foot, margin):
            if abs(gap) <= margin:
                spin = np.array([-arm[1], arm[0]])
                yield [np.array([*d, d @ spin]) for d in (tangent, normal)]

    def cone(self, mode, q):
        """Edges of the forces that the contacts can have in this mode."""
        for i, letter in enumerate(mode):
            mu = self.posture.contacts[i].friction
            directions = {"S": (), "F": (-mu, mu), "R": (-mu,), "L": (mu,)}[letter]
            for t, n in self.frames(i, q):
                yield from (n + k * t for k in directions)

    def miss(self, edges, wanted):
        """Distance of (fx, fy, moment) per unit mass from the sums of edges."""
        wanted = wanted * self.scale
        edges = [e * self.scale for e in edges]
        if not edges:
            return np.abs(wanted).max()
        return nnls(np.array(edges).T, wanted)[1]

    def momentum(self, qdot):
        """Momentum and angular momentum per unit mass."""
        return qdot * (1, 1, self.posture.gyration_radius**2)


def slope_of(run, t, step):
    """Derivatives of q and of q̇ at t: differences of fourth order."""
    q, qdot = run.at(t + step * np.array([-2, -1, 1, 2]))
    weights = np.array([1, -8, 8, -1]) / (12 * step)
    return weights @ q, weights @ qdot


def flaws_between(body, run, mode, start, end, rng):
    """Violations of the laws within a part of one mode."""
    posture = body.posture
    weight = np.array([0, posture.gravity, 0])
    sums = any(abs(z.time - end) < ROUNDING for z in run.zeno_points)
    last = 0.5 if sums else 0.98  # collisions without end crowd before a limit
    for t in start + (end - start) * rng.uniform(0.02, last, 2):
        step = min(body.step / 10 if sums else body.step, (end - start) / 200)
        (q, qdot), (rate, acceleration) = run.at(t), slope_of(run, t, step)
        size, speed = 1 + np.abs(q).max(), 1 + np.abs(qdot).max()
        if np.abs(rate - qdot).max() > DIFFERENCE * (speed + size):
            yield f"{mode} at {t}: q̇ is not the derivative of q"
        for i, letter in enumerate(mode):
            frames = list(body.frames(i, q))
            if letter != "S" and not frames:
                yield f"{mode} at {t}: foot {i + 1} is not on the ground"
            for tangent, normal in frames if letter != "S" else ():
                slip = tangent @ qdot
                rubs = posture.contacts[i].friction > 0
                if len(frames) == 1 and abs(normal @ qdot) > ROUNDING * speed:
                    yield f"{mode} at {t}: foot {i + 1} leaves the ground"
                if rubs and letter == "F" and abs(slip) > ROUNDING * speed:
                    yield f"{mode} at {t}: foot {i + 1} slips"
                way = {"R": 1, "L": -1}.get(letter, 0)
                if rubs and way * slip < -ROUNDING * speed:
                    yield f"{mode} at {t}: foot {i + 1} slides the other way"
        needed = body.momentum(acceleration) + weight
        allowed = DIFFERENCE * (posture.gravity + speed**2 + np.abs(acceleration).max())
        if (miss := body.miss(body.cone(mode, q), needed)) > allowed:
            yield f"{mode} at {t}: no forces explain it, by {miss}"


def flaws_of_jump(body, run, t, step, options, impacts):
    """Violations at an impact: the change of velocity must be a sum of impulses in the cones."""
    offsets = step * np.arange(1, 5)
    weights = np.array([4, -6, 4, -1])  # extrapolates cubics
    (q_before, before), (q_after, after) = (
        [weights @ x for x in run.at(t + sign * offsets)] for sign in (-1, 1)
    )
    q, _ = run.at(t)
    speed = 1 + np.abs(before).max()
    if np.abs(q_before - q_after).max() > DIFFERENCE * (1 + np.abs(q).max()):
        yield f"impact at {t}: q jumps"
    law = options["impact"]
    if law == "newton":  # its impulses have no friction
        edges = [n for i in range(len(body.arms)) for _, n in body.frames(i, q)]
    else:
        edges = body.cone("F" * len(body.arms), q)
    if body.miss(edges, body.momentum(after - before)) > JUMP * speed:
        yield f"impact at {t}: no impulses explain it"
    frames = [list(body.frames(m["index"], q)) for m in impacts]
    if law == "newton" and "simultaneous" not in options:  # all that land have impulses
        rates, after_it = impacts[0]["rates_before"], impacts[0]["rates_after"]
        slow = after_it + body.posture.restitution * rates < -JUMP * speed
        for i in np.nonzero(slow & (rates < 0) & (run.gaps_at(t) == 0))[0]:
            yield f"impact at {t}: foot {i + 1} does not bounce"
    if law == "newton" and len(impacts) == 1 and len(frames[0]) == 1:
        ((_, normal),) = frames[0]
        e = body.posture.restitution
        if abs(normal @ after + e * (normal @ before)) > JUMP * speed:
            yield f"impact at {t}: Newton's law does not hold"


def flaws(posture, run, options, rng, seen):
    """Violations of the laws in a run."""
    body = Body(posture)
    end = min(run.time, options["time_limit"])
    limits, phases, impacts = [z.time for z in run.zeno_points], run.phases, run.impacts
    starts, struck = [p.start for p in phases], set(impacts["time"].tolist())
    events = np.unique([0.0, end, *starts, *struck, *limits])
    events = events[(events >= 0) & (events <= end)]
    # Before a Zeno point come bounces that are summed. The first of them lasts the share 1 - e of the time to it, or with friction more than half
    # of this share: a slide that sticks makes impacts on a slope rebound more.
    share = 0.5 * (1 - max(c.restitution or 0 for c in posture.contacts))
    share = min(share, 0.5 * (1 - posture.restitution))
    alone = np.where(np.isin(events[1:], limits), share, 1.0)
    first = events[:-1] + alone * np.diff(events)
    ends = np.where(alone < 1, first, events[1:])
    pairs = zip(events[:-1], ends, strict=True)
    # A nested sum has impacts and phases of contact from its start on: no part of it is of one mode.
    nested = {z.time for z in run.zeno_points if z.method == "nested"}
    stretches = [
        (a, b)
        for (a, b), event in zip(pairs, events[1:], strict=True)
        if b - a > SHORTEST and event not in nested
    ]
    rng.shuffle(stretches)
    for a, b in stretches[:STRETCHES]:
        (mode,) = {p.mode for p in phases if p.start <= a and p.end >= b}
        seen[mode] += 1
        yield from flaws_between(body, run, mode, a, b, rng)
    lengths = np.diff(events) * alone
    for k in range(1, len(events) - 1):
        t, step = events[k], min(lengths[k - 1 : k + 1].min() / 8, body.step)
        if step <= body.step / 20 or t not in struck:
            continue
        if not any(abs(z - t) < ROUNDING for z in limits):
            seen["impact"] += 1
            now = impacts[impacts["time"] == t]
            yield from flaws_of_jump(body, run, t, step, options, now)
    if run.outcome == "rest":
        q, qdot = run.at(run.time)
        if np.abs(qdot).max() > ROUNDING:
            yield "rest: it moves"
        edges = body.cone("F" * len(body.arms), q)
        if (miss := body.miss(edges, np.array([0, posture.gravity, 0]))) > ROUNDING:
            yield f"rest: nothing holds it, by {miss}"


def test_motions_obey_the_laws_of_newton_and_coulomb():
    """-s prints the numbers of checks of each mode, impact and outcome."""
    seen, outcomes, flawed = Counter(), Counter(), {}
    for seed in range(RUNS):
        rng = np.random.default_rng(seed)
        posture, q, qdot, options = draw(rng)
        run = sf.simulate(posture, q, qdot, **options)
        outcomes[run.outcome] += 1
        if found := list(flaws(posture, run, options, rng, seen)):
            flawed[seed] = found[:3]
    print(dict(outcomes), dict(seen))
    assert not flawed
    letters = Counter()
    for mode, count in seen.items():
        letters.update({letter: count for letter in mode if letter in "SFRL"})
    assert min(letters[x] for x in "SFRL") > RUNS / 4
    assert seen["impact"] > RUNS


def test_within_a_phase_at_gives_the_end_of_a_run_of_that_length():
    """Both advance the body from the start of the phase in one step: all bits agree as long as one step is sufficient."""
    alike, close = 0, 0
    for seed in range(150):
        posture, q, qdot, options = draw(np.random.default_rng([7, seed]))
        options |= {"impact": "newton", "stop": "time"}
        run = sf.simulate(posture, q, qdot, **options)
        held = [p for p in run.phases if set(p.mode) != {"S"} and p.end > p.start]
        for phase in held[:3]:
            t = phase.start + 0.375 * (phase.end - phase.start)
            end = sf.simulate(posture, q, qdot, **options | {"time_limit": t})
            state = np.array(run.at(t))
            wanted = np.array([end.q, end.qdot])
            assert np.allclose(state, wanted, rtol=1e-13, atol=1e-13), (seed, phase)
            alike += bool((state == wanted).all())
            close += 1
    assert close > 100
    assert alike > 0.75 * close

"""Falls of spinning bodies from great heights, compared with a search in 60 digits."""

from itertools import pairwise

import pytest
import standfast as sf
from mpmath import mp, mpf
from standfast import Contact, Posture


def landing(posture, q, qdot):
    """The first touchdown of a tumbling body in 60 digits, by a search of all the time within reach of the ground."""
    q, qdot = [mpf(x) for x in q], [mpf(x) for x in qdot]
    g = mpf(posture.gravity)
    arms = [
        [
            mpf(a) - mpf(b)
            for a, b in zip(contact.point, posture.center_of_mass, strict=True)
        ]
        for contact in posture.contacts
    ]
    reach = 2 * max(mp.hypot(*arm) for arm in arms)

    def gap(arm, t):
        turned = q[2] + qdot[2] * t
        height = mp.sin(turned) * arm[0] + mp.cos(turned) * arm[1] - arm[1]
        return q[1] + qdot[1] * t - g * t * t / 2 + height

    def falls_to(height):
        return (qdot[1] + mp.sqrt(qdot[1] ** 2 + 2 * g * (q[1] - height))) / g

    begin, end = falls_to(reach), falls_to(-reach)
    count = 200 + int(20 * (end - begin) * abs(qdot[2]))
    times = [begin + (end - begin) * k / count for k in range(count + 1)]
    found = []
    for i, arm in enumerate(arms):
        for before, after in pairwise(times):
            if gap(arm, before) > 0 >= gap(arm, after):
                root = mp.findroot(
                    lambda t, arm=arm: gap(arm, t), (before, after), solver="anderson"
                )
                found.append((root, i + 1))
                break
    return min(found)


@pytest.mark.parametrize("height", [1e4, 1e6, 1e8, 1e10, 9e11])
def test_a_long_fall_in_a_spin_lands_to_the_last_bit(height):
    contacts = [Contact((1.6821, 0.0)), Contact((1.7961, 0.0))]
    body = Posture(1.0, 0.97, (1.6849, -0.8078), contacts, 0.7, 9.81)
    for omega in (-0.93, -3.0, 2.6, -2.2, 3.1, 1.9, 0.1, 1e-5, 40.0):
        q, qdot = (0.95, height, 1e-9), (0.95, 0.95, omega)
        run = sf.simulate(body, q, qdot, model="full", event_limit=50)
        with mp.workdps(60):
            time, contact = landing(body, q, qdot)
            off = float(abs(mpf(float(run.impacts["elapsed"][0])) / time - 1))
        assert (int(run.impacts["contact"][0]), off < 3e-16) == (contact, True), (
            omega,
            off,
        )


def first_dip(posture, q, qdot):
    """As `landing`, for a body with many revolutions, by its lowest point in each revolution; and its landing speed."""
    q, qdot = [mpf(x) for x in q], [mpf(x) for x in qdot]
    g, omega = mpf(posture.gravity), qdot[2]
    turn = 2 * mp.pi / abs(omega)
    found = []
    for i, contact in enumerate(posture.contacts):
        x, y = (
            mpf(a) - mpf(b)
            for a, b in zip(contact.point, posture.center_of_mass, strict=True)
        )
        reach = mp.hypot(x, y)

        def gap(t, x=x, y=y):
            turned = q[2] + omega * t
            fall = q[1] + qdot[1] * t - g * t * t / 2
            return fall + mp.sin(turned) * x + mp.cos(turned) * y - y

        def lowest_of_turn(k, x=x, y=y, reach=reach):
            angle = k * 2 * mp.pi - mp.pi / 2 - mp.atan2(y, x)
            t = (angle - q[2]) / omega
            for _ in range(30):  # ḣ = 0: sine of the lead (gt − v)/(ω|d|)
                lead = mp.asin((g * t - qdot[1]) / (omega * reach))
                t = (angle + lead - q[2]) / omega
            return t

        # No earlier landing; from then on the contact points downwards once per revolution.
        begin = (qdot[1] + mp.sqrt(qdot[1] ** 2 + 2 * g * (q[1] - y - reach))) / g
        first = mp.floor((q[2] + omega * begin) / (2 * mp.pi))
        for k in range(-2, 1000):
            lowest = lowest_of_turn(first + k * mp.sign(omega))
            if lowest < begin:
                continue
            if gap(lowest) <= 0:
                start = max(begin, lowest - turn / 2)
                root = mp.findroot(gap, (start, lowest), solver="anderson")
                found.append((root, i + 1, -mp.diff(gap, root, h=turn * mpf(1e-20))))
                break
    return min(found)


@pytest.mark.parametrize("omega", [1e3, -1e5, 3e6, -1e8])
def test_a_fall_of_many_turns_lands_in_the_right_one(omega):
    contacts = [Contact((1.6821, 0.0)), Contact((1.7961, 0.0))]
    body = Posture(1.0, 0.97, (1.6849, 0.8078), contacts, 0.7, 9.81)
    for height in (2.0, 5.5, 30.0):
        run = sf.simulate(
            body, (0.0, height, 0.3), (0.0, 0.4, omega), model="full", event_limit=50
        )
        hit = run.impacts[0]
        with mp.workdps(60):
            time, contact, speed = first_dip(
                body, (0.0, height, 0.3), (0.0, 0.4, omega)
            )
            off = float(mpf(float(hit["elapsed"])) - time)
        # A rate with the rounding error of ω|d|, during the whole fall.
        rounding = 2**-52 * abs(omega) * float(time / speed)
        assert (int(hit["contact"]), abs(off) < 2 * rounding) == (contact, True), (
            height,
            off / rounding,
        )


def test_a_fall_too_long_for_the_place_of_the_body_is_refused():
    contacts = [Contact((1.6821, 0.0)), Contact((1.7961, 0.0))]
    body = Posture(1.0, 0.97, (1.6849, -0.8078), contacts, 0.7, 9.81)
    run = sf.simulate(body, (0.95, 1e13, 1e-9), (0.95, 0.95, -0.93), model="full")
    assert (run.outcome, run.collisions) == ("event-limit", 0)
    assert "farther than 1e12 times the size" in run.warnings[0]


def test_a_body_that_has_turned_1e10_rad_wins_no_energy():
    """Its arms are not computed from its rotation, whose rounding error is larger than theirs: energy never increases."""
    contacts = [Contact((-5.2314, 0.0)), Contact((0.4471, 0.0))]
    body = Posture(1.0, 0.4083, (-0.4998, 0.5569), contacts, 0.9921875, 9.81)
    q, qdot = (0.0, 8590770207.0, 0.0), (0.0, 0.0, 0.2627)
    run = sf.simulate(
        body,
        q,
        qdot,
        model="full",
        simultaneous="first-contact-first",
        event_limit=2000,
    )
    assert abs(run.theta) > 1e8
    energy = [float(run.energy(t)) for t in run.impacts["time"]]
    assert energy[-1] < 1e-6 * energy[0]
    assert all(
        after <= before + 1e-12 * energy[0] for before, after in pairwise(energy)
    )

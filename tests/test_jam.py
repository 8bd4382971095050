"""Where no contact mode is consistent: an impact without collision, for the laws of impact that know one."""

from fractions import Fraction

import numpy as np
import pytest
import standfast as sf


def painleve_rod(friction, restitution=0.0):
    """The rod of Painlevé with sides 3, 4, 5, on its lower end."""
    return sf.Posture(
        mass=2.0,
        gyration_radius=float(np.sqrt(1 / 3)),
        center_of_mass=(0.6, 0.8),
        contacts=[sf.Contact((0.0, 0.0), friction=friction)],
        restitution=restitution,
        gravity=1.0,
    )


@pytest.mark.parametrize("law", ["newton", "chatterjee-ruina", "moreau"])
def test_other_laws_have_no_answer(law):
    run = sf.simulate(painleve_rod(2), (0, 0, 0), (-1, 0, 0), impact=law)
    assert (run.outcome, run.time) == ("inconsistent", 0.0)
    assert sf.contact_modes(run.undecided).status == "none"


@pytest.mark.parametrize("restitution", [Fraction(0), Fraction(1, 2)])
def test_the_rod_of_painleve_jams(restitution):
    """Exact: sliding stops at p = 1/4.4 with v_n = −0.8 p, then the end sticks, and v_n rises by 2.08 − 1.44²/2.92 a p."""
    run = sf.simulate(
        painleve_rod(2, float(restitution)), (0, 0, 0), (-1, 0, 0), impact="poisson"
    )
    stop, rise = Fraction(10, 44), Fraction(208, 100) - Fraction(144**2, 29200)
    end = (stop + Fraction(8, 10) * stop / rise) * (1 + restitution)
    # Sticking from v_t = 0 on: P_t grows by −w_nt/w_tt = 1.44/2.92 a p, while it slid by μ.
    along = 2 * stop + Fraction(144, 292) * (end - stop)
    first = run.impacts[0]
    assert (first["time"], first["contact"]) == (0.0, 1)
    assert first["impulse"] == pytest.approx([2 * float(along), 2 * float(end)])
    after = rise * (end - end / (1 + restitution))
    assert first["rates_after"][0] == pytest.approx(float(after), abs=1e-15)
    assert "impact without collision" in run.warnings[0]
    assert run.phases[0].cause == ("impact" if restitution else "zeno")
    assert run.undecided is None


def test_jams_lose_energy_and_runs_go_on():
    random = np.random.default_rng(3)
    jams = 0
    for _ in range(400):
        arm = random.normal(0, 1, 2)
        arm[1] = abs(arm[1])
        posture = sf.Posture(
            1.0,
            float(random.uniform(0.2, 0.8)),
            arm,
            [sf.Contact((0, 0), friction=float(random.uniform(1, 4)))],
            float(random.choice([0.0, 0.3, 0.7])),
        )
        qdot = [random.normal(0, 2), 0.0, random.normal(0, 1)]
        qdot[1] = (
            -qdot[2] * -arm[0]
        )  # the contact slides along: u = ẏ − (x − x_1)·ω = 0
        law = str(random.choice(["poisson", "stronge"]))
        run = sf.simulate(
            posture,
            (0, 0, 0),
            qdot,
            impact=law,
            model="full",
            time_limit=2.0,
            event_limit=50_000,
        )
        jams += any("without collision" in warning for warning in run.warnings)
        assert run.outcome != "inconsistent"
        times = np.sort(np.concatenate([run.sample(60)[0], run.impacts["time"]]))
        energy = run.energy(times[times <= run.time])
        assert np.max(np.diff(energy)) <= 1e-13 * (energy[0] + 9.81 * arm[1] + 1.0)
    assert jams > 20


@pytest.mark.parametrize("power", [20, 40, 60, 240])
def test_a_jam_of_any_size(power):
    """Lengths times a power of two, gravity with them: the same motion to the last bit."""

    def slide(size):
        body = sf.Posture(
            1.0,
            0.0743 * size,
            (0.308 * size, 1.026 * size),
            [sf.Contact((-0.62 * size, 0), friction=0.5)],
            0.3,
            9.81 * size,
        )
        run = sf.simulate(body, (0, 0, 0), (0, 0, 0), event_limit=10_000)
        return run.outcome, run.time, *(run.q / (size, size, 1))

    one = slide(1.0)
    assert one[0] == "inconsistent"
    assert slide(2.0**power) == one

"""The laws of impact with friction, the warnings of runs with a law without it, and each law with several contacts."""

import math

import numpy as np
import pytest
import standfast as sf
from bodies import FRICTION_LAWS, LAWS, draw_contacts, lift, order_for

NO_FRICTION = "friction acts between impacts only"
#: Impacts up to which two computations of a motion agree to nine digits.
MANY = 20


def said(run):
    """The warnings about friction in impacts."""
    return [text for text in run.warnings if NO_FRICTION in text]


def housner(**options):
    """A block of 1 m by 3 m with plastic corners rocks from one to the other."""
    block = sf.Posture(
        mass=1.0,
        gyration_radius=math.sqrt((1 + 9) / 12),
        center_of_mass=(0.0, 1.5),
        contacts=[sf.Contact((x, 0.0), friction=0.6) for x in (-0.5, 0.5)],
        restitution=0.0,
    )
    # Start: upright, rotating about its left corner.
    return sf.simulate(
        block, (0, 0, 0), (-0.45, 0.15, 0.3), time_limit=3.0, stop="time", **options
    )


@pytest.mark.parametrize("law", LAWS)
def test_housners_block_is_told_that_newtons_law_has_no_friction(law):
    """With friction in the law ω is multiplied by 1 − (3/2) sin² α, tan α = 1/3."""
    run = housner(impact=law)
    new = run.impacts[0]
    left = -new["rates_after"][1 - new["index"]] / new["rates_before"][new["index"]]
    assert (left == pytest.approx(1 - 1.5 * 0.1, rel=1e-9)) == (law != "newton")
    texts = said(run)
    assert run.warnings == texts
    assert len(texts) == (law == "newton")
    for text in texts:
        assert all(f'"{law}"' in text for law in LAWS)


@pytest.mark.parametrize("model", ["full", "local"])
@pytest.mark.parametrize("feet", [2, 3])
@pytest.mark.parametrize("record", [True, False])
@pytest.mark.parametrize("hit", [0, 1])
def test_only_a_contact_that_is_hit_counts(model, feet, record, hit):
    """One foot lands and bounces while the other one stays in the air. Either of the two feet has friction; only
    friction at the foot that is hit causes a warning."""

    def run(rough):
        contacts = [
            sf.Contact((x, 0.0), friction=0.5 if i == rough else 0.0)
            for i, x in enumerate([-1.0, 1.0, 0.0][:feet])
        ]
        body = sf.Posture(1.0, 0.3, (0.0, 0.5), contacts, 0.5)
        tilt = 0.3 if hit == 0 else -0.3
        lift = {"full": math.sin(0.3) - 0.5 * (1 - math.cos(0.3)), "local": 0.3}[model]
        run = sf.simulate(
            body,
            (0, lift + 0.01, tilt),
            (0, 0, 0),
            model=model,
            impact="newton",
            stop="time",
            time_limit=0.06,
            record=record,
        )
        assert run.collisions >= 1
        if record:
            assert set(run.impacts["index"]) == {hit}
        return said(run)

    assert len(run(hit)) == 1
    assert run(1 - hit) == []


def test_many_runs_know_it():
    """A run of many also knows which of the contacts have been hit."""
    rng = np.random.default_rng(26)
    for rough in (0, 1):
        contacts = [
            sf.Contact((x, 0.0), friction=0.5 if i == rough else 0.0)
            for i, x in enumerate([-1.0, 1.0])
        ]
        body = sf.Posture(1.0, 0.9, (0.0, 0.0), contacts, 0.95)
        count = 200
        q = np.stack([np.zeros(count), np.full(count, 0.5), np.zeros(count)], -1)
        q[:, 2] = rng.uniform(-0.4, 0.4, count)
        for model in ("full", "local"):
            options = {"model": model, "stop": "time", "time_limit": 1.0}
            options["impact"] = "newton"
            runs = sf.simulate_many(body, q, (0, 0, 0), **options)
            for i in range(count):
                run = runs[i]
                struck = rough in run.impacts["index"]
                assert len(said(run)) == struck
                assert runs.warned[i] == bool(run.warnings)
            assert 0 < runs.warned.sum()


def test_a_run_that_ends_before_anything_is_hit_says_nothing():
    rod = sf.Posture.rod(0.5, 0.2, 0.1, friction=0.5)
    fall = sf.simulate(rod, (0, 1, 0.1), (0, 0, 0), stop="time", time_limit=0.1)
    rest = sf.simulate(rod, (0, 0, 0), (0, 0, 0))
    assert fall.warnings == rest.warnings == []


@pytest.mark.parametrize("count", [1, 2, 3, 8])
@pytest.mark.parametrize("law", LAWS)
def test_a_law_alone_is_asked_for(law, count):
    """`simultaneous` is the rule that the law allows, and the run states it."""
    xs = np.linspace(-0.5, 0.5, count) if count > 1 else [0.0]
    contacts = [sf.Contact((x, 0.0), friction=0.3) for x in xs]
    body = sf.Posture(1.0, 0.5, (0.0, 0.2), contacts, 0.4)
    policy = order_for(law)
    for q in [(0, 0.3, 0.05), (0, 0.3, 0.0)]:  # one after the other, and together
        start = {"q": q, "qdot": (0.5, 0, 0), "impact": law}
        run = sf.simulate(body, **start, time_limit=5.0)
        assert run.outcome in {"rest", "time-limit"}
        assert run.collisions > 0
        assert run.to_dict()["options"]["simultaneous"] == policy
        same = sf.simulate(body, **start, time_limit=5.0, simultaneous=policy) if (
            count > 1 or policy == "together"
        ) else run  # fmt: skip
        np.testing.assert_array_equal(run.q, same.q)
        many = sf.simulate_many(body, [q], (0.5, 0, 0), impact=law, time_limit=5.0)
        np.testing.assert_array_equal(many.q[0], run.q)


@pytest.mark.parametrize("law", ["poisson", "stronge", "chatterjee-ruina"])
def test_a_law_for_one_contact_is_not_for_several_together(law):
    rod = sf.Posture.rod(0.5, 0.2, 0.1, friction=0.5)
    with pytest.raises(ValueError, match="simultaneous"):
        sf.simulate(rod, (0, 1, 0), (0, 0, 0), impact=law, simultaneous="together")


def test_a_scene_file_leaves_it_out(tmp_path):
    text = """
gravity = 9.81
restitution = 0.3
[body]
mass = 1.0
gyration_radius = 0.3
center_of_mass = [0.0, 0.2]
[[contact]]
point = [-0.5, 0.0]
friction = 0.5
[[contact]]
point = [0.5, 0.0]
friction = 0.5
[start]
q = [0.0, 0.1, 0.0]
[run]
impact = "poisson"
"""
    path = tmp_path / "scene.toml"
    path.write_text(text)
    scene = sf.load(path)
    run = scene.simulate()
    assert run.to_dict()["options"]["simultaneous"] == "first-contact-first"
    scene.save(path)
    assert "simultaneous" not in path.read_text()
    newton = sf.load(path).simulate(impact="newton")
    assert newton.to_dict()["options"]["simultaneous"] == "together"


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_without_friction_every_law_is_newtons(law):
    """Impacts of one or two contacts without friction have the loops and sums of Newton's law. With friction of 1e-300 the same impacts
    are computed one by one with the law itself, up to the first Zeno point; they must come to the same place."""
    rng = np.random.default_rng(461)
    compared = 0
    for _ in range(40):
        level = rng.random() < 0.5
        rise, steep = (0, 0) if level else (0.2, 0.4)
        places = [-0.5, 0.4][: rng.integers(1, 3)]
        state = rng.bit_generator.state
        runs = []
        for friction in (0.0, 1e-300):
            rng.bit_generator.state = state
            contacts = draw_contacts(
                rng, places, rise, steep, friction=lambda f=friction: f
            )
            body = sf.Posture(
                1.0,
                rng.uniform(0.2, 0.6),
                (rng.uniform(-0.2, 0.2), rng.uniform(0.1, 0.6)),
                contacts,
                rng.uniform(0.0, 0.7),
            )
            q = np.array([0.0, 0.0, rng.uniform(-0.1, 0.1)])
            q[1] = lift(body, q) + rng.uniform(0.01, 0.5)
            qdot = rng.normal(size=3)
            model = rng.choice(["local", "full"])
            if model == "local":
                q[1] += max(0.0, lift(body, q, "local"))
            runs.append(
                sf.simulate(
                    body,
                    q,
                    qdot,
                    impact=law,
                    simultaneous=order_for(law),
                    model=model,
                    stop="zeno",
                    time_limit=2.0,
                )
            )
        newton, own = runs
        # Each impact multiplies the rounding errors before it; after many impacts they decide.
        first = min(len(newton.impacts), len(own.impacts), MANY)
        for name in ("elapsed", "index", "rates_after"):
            new, old = (run.impacts[name][:first] for run in runs)
            np.testing.assert_allclose(new, old, rtol=1e-9, atol=1e-9)
        if len(newton.impacts) >= MANY:
            continue
        assert newton.outcome == own.outcome
        assert newton.elapsed == pytest.approx(own.elapsed, rel=1e-11)
        np.testing.assert_allclose(newton.q, own.q, atol=1e-10)
        compared += newton.outcome == "zeno"
    assert compared > 20

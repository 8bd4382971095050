"""Contact modes: known answers, the Python interface, and the table."""

import math
import pickle
import re

import numpy as np
import pytest
import standfast as sf
from bodies import feet_on_slope, frame, with_defaults
from checks import assert_copies, assert_refused
from standfast.cli import main
from standfast.table import ROWS

resting = with_defaults(
    sf.Posture,
    mass=2.0,
    gyration_radius=0.5,
    center_of_mass=(0.0, 1.0),
    restitution=0.0,
    gravity=10.0,
)


def body(contacts, **change):
    return resting(contacts=contacts, **change)


def on_slope(slope, friction, height=1.0, **change):
    """A block with feet ±1 along a slope and its centre of mass this high above it."""
    feet = feet_on_slope(slope, (-1.0, 1.0), [friction] * 2)
    return body(feet, center_of_mass=height * frame(slope)[1], **change)


problem = with_defaults(
    sf.ContactProblem,
    mass=1.0,
    gyration_radius=0.5,
    arms=[(-1.0, -1.0), (1.0, -1.0)],
    tangents=[(1.0, 0.0), (1.0, 0.0)],
    friction=[1.5, 1.5],
    sliding=[1, 1],
    bias=[(0.0, 0.0), (0.0, 0.0)],
    free_acceleration=(0.0, -1.0, 0.0),
    level="acceleration",
)


def single(arm, friction, sliding, spin_squared=0.0, rho_squared=1 / 3):
    """One contact on a flat floor, m = g = 1, with the bias −(b, c) θ̇²: b = d_x, c = d_y."""
    x, y = arm
    return problem(
        gyration_radius=math.sqrt(rho_squared),
        arms=[arm],
        tangents=[(1, 0)],
        friction=[friction],
        sliding=[sliding],
        bias=[(-x * spin_squared, -y * spin_squared)],
    )


def consistent(of, *arguments, **keywords):
    return sf.contact_modes(of, *arguments, **keywords).consistent


# By hand.


def test_a_block_rests_on_a_slope():
    slope = 0.3
    modes = sf.contact_modes(on_slope(slope, friction=0.5))
    assert (modes.consistent, modes.status) == (["FF"], "unique")
    rest = modes["FF"]
    np.testing.assert_allclose(rest.acceleration, 0.0, atol=1e-14)
    along, into = 20 * math.sin(slope), 20 * math.cos(slope)
    np.testing.assert_allclose(rest.forces.sum(axis=0), [along, into], rtol=1e-13)
    # Moments about the centre of mass, height 1, feet at ∓1: the lower foot carries more.
    np.testing.assert_allclose(
        rest.forces[:, 1], [(into + along) / 2, (into - along) / 2], rtol=1e-13
    )
    assert (rest.determined, rest.violated) == ("family", [])


def test_a_block_slides_down_a_slope_that_is_too_steep():
    slope, mu = 0.3, 0.1
    modes = sf.contact_modes(on_slope(slope, mu))
    assert (modes.consistent, modes.status) == (["LL"], "unique")
    slide = modes["LL"]
    a = 10 * (math.sin(slope) - mu * math.cos(slope))
    np.testing.assert_allclose(
        slide.acceleration,
        [-a * math.cos(slope), -a * math.sin(slope), 0.0],
        rtol=1e-12,
        atol=1e-12,
    )
    np.testing.assert_allclose(slide.forces[:, 0], mu * slide.forces[:, 1], rtol=1e-12)
    assert not modes["FF"].consistent


def test_a_tall_block_tips_over_its_lower_foot():
    slope, height = 0.5, 4.0
    posture = on_slope(slope, friction=5.0, height=height)
    modes = sf.contact_modes(posture)
    assert "FS" in modes.consistent
    tip = modes["FS"]
    # A pendulum about the lower foot: I = m(ρ² + 1 + h²), torque m g (h sin − cos), counterclockwise.
    torque = 10 * (height * math.sin(slope) - math.cos(slope))
    assert tip.acceleration[2] == pytest.approx(torque / (0.25 + 1 + height**2))
    np.testing.assert_array_equal(tip.forces[1], 0.0)


def test_a_load_is_added_to_gravity():
    table = on_slope(0.0, friction=1.0, height=2.0)
    assert consistent(table) == ["FF"]
    assert consistent(table, wrench=(12, 0, 0)) == ["SF"]
    assert consistent(table, wrench=(0, 30, 0)) == ["SS"]
    assert consistent(table, wrench=(0, 0, -30)) == ["SF"]


def test_a_contact_in_the_air_or_leaving_is_separate():
    table = on_slope(0.0, friction=1.0)
    assert list(sf.contact_modes(table, q=(0, 1, 0))) == ["SS"]
    assert list(sf.contact_modes(table, qdot=(0, 1, 0))) == ["SS"]
    modes = sf.contact_modes(table, qdot=(1, 0, 0))
    assert modes.problem.sliding == [1, 1]
    assert set("".join(modes)) == set("SR")
    with pytest.raises(ValueError, match="impact is due"):
        sf.contact_modes(table, qdot=(0, -1, 0))
    with pytest.raises(ValueError, match="contact 1"):
        sf.contact_modes(table, q=(0, -1, 0))


# The examples of the theory: m = g = 1.


@pytest.mark.parametrize(
    ("friction", "spin_squared", "words"),
    [
        (1.444, 0.0, ["L"]),  # below 13/9
        (1.445, 0.0, []),
        (2.0, 0.0, []),
        (2.0, 2.5, ["S", "L"]),
    ],
)
def test_painleve_of_the_3_4_5_rod(friction, spin_squared, words):
    rod = single((-0.6, -0.8), friction, -1, spin_squared)
    assert consistent(rod) == words
    mirrored = single((0.6, -0.8), friction, 1, spin_squared)
    assert consistent(mirrored) == [word.replace("L", "R") for word in words]


@pytest.mark.parametrize(("friction", "count"), [(1.333, 1), (1.334, 0)])
def test_painleve_of_the_uniform_rod(friction, count):
    arm = (-1 / math.sqrt(5), -2 / math.sqrt(5))
    assert len(consistent(single(arm, friction, -1))) == count


@pytest.mark.parametrize("sign", [1, -1])
def test_two_sliding_contacts_without_a_mode(sign):
    modes = sf.contact_modes(problem(sliding=[sign, sign]))
    assert (modes.consistent, modes.status) == ([], "none")
    assert all(mode.violated for mode in map(modes.__getitem__, modes))


def test_three_modes_at_rest():
    modes = sf.contact_modes(
        problem(
            gyration_radius=math.sqrt(0.5),
            arms=[(-1, -3), (1, 0)],
            tangents=[(0.8, -0.6)] * 2,
            friction=[1, 1],
            sliding=[0, 0],
        )
    )
    assert set(modes.consistent) == {"SF", "FS", "FF"}
    assert modes.status == "ambiguous"


def test_newton_at_the_level_of_impulses():
    # A ball that falls with velocity −2 bounces with e = 1/4: bias e v⁻.
    ball = problem(
        arms=[(0, -1)],
        tangents=[(1, 0)],
        friction=[0],
        sliding=[0],
        bias=[(0, -0.5)],
        free_acceleration=(0, -2, 0),
        level="impulse",
    )
    modes = sf.contact_modes(ball)
    assert (modes.level, modes.consistent) == ("impulse", ["F"])
    np.testing.assert_allclose(modes["F"].acceleration, [0, 0.5, 0], atol=1e-15)
    np.testing.assert_allclose(modes["F"].forces, [[0, 2.5]], atol=1e-15)


# Sizes and coincidences.


@pytest.mark.parametrize("copies", [1, 2, 3])
def test_coincident_contacts_go_one_way(copies):
    modes = sf.contact_modes(
        problem(
            arms=[(0, -1)] * copies,
            tangents=[(1, 0)] * copies,
            friction=[1] * copies,
            sliding=[0] * copies,
            bias=[(0, 0)] * copies,
        )
    )
    assert list(modes) == ["S" * copies, "F" * copies, "R" * copies, "L" * copies]
    assert modes.consistent == ["F" * copies]
    assert modes["F" * copies].forces[:, 1].sum() == pytest.approx(1)


def many(n, **change):
    """Feet in a row on the flat, at rest."""
    feet = [
        sf.Contact(point=(x, 0.0), friction=0.5) for x in np.linspace(-1, 1, n).tolist()
    ]
    return body(feet, **change)


def test_sixteen_contacts_rest():
    word = "F" * 16
    modes = sf.contact_modes(many(16))
    assert modes.consistent == [word]
    rest = modes[word]
    assert rest.forces.shape == (16, 2)
    assert rest.forces[:, 1].sum() == pytest.approx(20)
    assert rest.determined == "family"


def test_words_of_sixty_four_contacts():
    modes = sf.contact_modes(many(64), method="enumerate")
    assert len(modes) == 196
    assert "F" * 64 in modes
    assert modes["S" * 64].acceleration.tolist() == [0, -10, 0]


def test_programmes_find_a_mode_of_many_contacts():
    modes = sf.contact_modes(many(16), method="qp")
    assert (modes.status, modes.consistent) == ("found", ["F" * 16])
    none = sf.contact_modes(problem(), method="qp")
    assert (none.status, none.consistent, len(none)) == ("not found", [], 0)
    assert repr(none) == "<not found (0 words)>"


def test_few_contacts_are_answered_in_full_and_more_by_a_search():
    few, more = sf.contact_modes(many(6)), sf.contact_modes(many(7))
    assert (few.status, few.consistent) == ("unique", ["F" * 6])
    assert (more.status, more.consistent) == ("found", ["F" * 7])
    # Where there is nothing to find, the search gives way to proof.
    floor = {"arms": [(0, -1)] * 7, "tangents": [(1, 0)] * 7, "bias": [(0, 0)] * 7}
    painleve = problem(
        **floor | {"arms": [(-0.6, -0.8)] * 7},
        friction=[2] * 7,
        sliding=[-1] * 7,
        gyration_radius=3**-0.5,
        free_acceleration=(0, -1, 0),
    )
    assert sf.contact_modes(painleve).status == "none"


@pytest.mark.parametrize("method", ["auto", "enumerate", "qp"])
def test_modes_pickle(method):
    modes = sf.contact_modes(on_slope(0.3, 0.5), method=method)
    assert pickle.loads(pickle.dumps(modes)) == modes
    for word in modes:
        assert pickle.loads(pickle.dumps(modes[word])) == modes[word]


def test_friction_that_depends_on_how_feet_share_their_load():
    feet = [
        sf.Contact((x, 0), friction=mu) for x, mu in ((-1, 0.1), (0, 0.6), (1, 0.1))
    ]
    modes = sf.contact_modes(body(feet), qdot=(1, 0, 0))
    assert (modes.status, modes.consistent) == ("ambiguous", ["RRR"])
    assert modes["RRR"].determined == "undetermined"
    assert "share" in str(modes)
    same = [sf.Contact((x, 0), friction=0.3) for x in (-1, 0, 1)]
    modes = sf.contact_modes(body(same), qdot=(1, 0, 0))
    assert (modes.status, modes["RRR"].determined) == ("unique", "family")
    assert modes["RRR"].acceleration[0] == pytest.approx(-3)


@pytest.mark.parametrize("turn", [0.0, 0.5, 1.0])
def test_a_vise_is_not_squeezed_more_than_the_load_asks(turn):
    def turned(x, y):
        cos, sin = math.cos(turn), math.sin(turn)
        return cos * x - sin * y, sin * x + cos * y

    for push in (0.0, 5.0):
        modes = sf.contact_modes(
            problem(
                arms=[turned(-1, 0), turned(1, 0)],
                tangents=[turned(0, -1), turned(0, 1)],
                friction=[0.5, 0.5],
                sliding=[1, -1],
                free_acceleration=(*turned(push, -10), 0),
            )
        )
        assert (modes.status, modes.consistent) == ("ambiguous", ["RL"])
        along = np.array(turned(0, 1)) @ modes["RL"].acceleration[:2]
        assert along == pytest.approx(-10 + 0.5 * push)


def test_the_smallest_of_many_forces():
    modes = sf.contact_modes(
        problem(
            arms=[
                (-1.0965641020568226, -1.1163116645244118),
                (-0.3250426830914077, -0.8926377217440296),
                (0.959295390014363, -0.8943521597365973),
            ],
            tangents=[
                (0.9861429014244679, 0.1658980951371415),
                (0.9972916855175777, 0.07354790274038223),
                (0.9479647572823056, 0.3183752800559419),
            ],
            friction=[0.38192760361483447, 0.0013969345360816988, 0.727107990237476],
            sliding=[0] * 3,
            bias=[(0, 0)] * 3,
            free_acceleration=(4.955596998089185, -9.81, 0.07064754978288326),
        )
    )
    assert (modes["FFF"].forces ** 2).sum() == pytest.approx(67.657040)


def test_a_tie_does_not_buy_a_motion():
    modes = sf.contact_modes(
        problem(
            gyration_radius=2,
            arms=[(-2, -2)],
            tangents=[(1, 0)],
            friction=[2],
            sliding=[0],
            bias=[(0, 1)],
        )
    )
    assert modes.consistent == ["F"]


@pytest.mark.parametrize("off", [-1e-11, -1e-12, 0.0, 1e-12, 1e-11])
def test_thresholds_of_painleve_are_flagged(off):
    x, y = math.cos(0.8), -math.sin(0.8)
    critical = -(1 + 3 * x * x) / (3 * x * y)
    modes = sf.contact_modes(single((x, y), critical * (1 + off), 1))
    assert modes["R"].near_degenerate


@pytest.mark.parametrize("slope", [0.0, 0.3])
def test_methods_agree(slope):
    posture = on_slope(slope, 0.2)
    auto, every = (sf.contact_modes(posture, method=m) for m in ("auto", "enumerate"))
    assert list(auto) == list(every)
    assert auto.consistent == every.consistent


# The face.


def test_modes_are_a_mapping_of_words():
    modes = sf.contact_modes(on_slope(0.0, 0.5))
    assert len(modes) == len(list(modes)) == 10
    assert "FF" in modes
    assert all(word not in modes for word in ("FR", "F", "", "xx", 1, None))
    for word in modes:
        mode = modes[word]
        assert mode.word == word
        assert (mode.acceleration.shape, mode.forces.shape) == ((3,), (2, 2))
        named = [f"contact {i}: {test}" for i, test, _ in mode.margins]
        assert set(mode.violated) <= set(named)
        assert mode.consistent == (
            not mode.violated and mode.determined != "impossible"
        )
    for word in ("FR", "", "S" * 1000):
        with pytest.raises(KeyError, match=r"the words are SS, SF, .*, LL"):
            modes[word]
    with pytest.raises(KeyError, match=r"and \d+ more"):
        sf.contact_modes(many(10), method="enumerate")["F"]
    with pytest.raises(TypeError, match="word = 1 cannot be used"):
        modes[1]
    assert repr(modes) == "<unique: FF (10 words)>"
    assert repr(modes["FF"]) == "<FF: consistent>"
    assert repr(modes["SS"]) == "<SS: fails at contact 1: a_n > 0>"
    assert modes == sf.contact_modes(modes.problem)
    assert modes["FF"] == modes["FF"] != modes["SS"]


def test_a_tie_is_said():
    clear = sf.contact_modes(single((0, -1), 1.0, 0))
    assert not clear["F"].near_degenerate
    assert "tie" not in str(clear)
    # A load along the floor: R asks for no force at all.
    grazing = sf.contact_modes(
        problem(
            arms=[(0, -1)],
            tangents=[(1, 0)],
            friction=[1],
            sliding=[0],
            bias=[(0, 0)],
            free_acceleration=(1, 0, 0),
        )
    )
    assert grazing["R"].near_degenerate
    assert "tie" in str(grazing)


@pytest.mark.parametrize("method", ["auto", "enumerate"])
@pytest.mark.parametrize(("tie", "word"), [(1e-11, "FR"), (-1e-11, "FL")])
def test_a_tie_that_no_force_decides_is_said(method, tie, word):
    """Two feet in line have the same a_t. Their biases differ by little, or by a rounding error."""

    def feet(bias):
        return sf.contact_modes(
            problem(
                arms=[(-1, -1), (1, -1)],
                tangents=[(1, 0)] * 2,
                friction=[1, 0.5],
                sliding=[0, 0],
                bias=[(0, 0.25), (bias, 0.25)],
                free_acceleration=(0, -10, 0),
            ),
            method=method,
        )

    static = feet(tie)["FF"]
    assert static.consistent
    assert static.near_degenerate
    [(contact, _, margin)] = [m for m in static.margins if m[1] == "a_t = 0"]
    assert contact == 2
    assert -1e-11 < margin < 0
    sliding = feet(tie)[word]
    assert not sliding.consistent
    assert sliding.near_degenerate
    assert word not in feet(1e-16)
    assert not feet(1e-16)["FF"].near_degenerate
    clear = feet(1000 * tie)
    assert "FF" not in clear
    assert clear[word].consistent


@pytest.mark.parametrize("method", ["auto", "enumerate"])
def test_contacts_that_hardly_wedge(method):
    """Walls that lean out by 1e-11 more or less than the angle of friction hold any body, or none."""

    def held(lean):
        angle = math.atan(0.5) + lean
        walls = [
            (-math.sin(angle), -math.cos(angle)),
            (-math.sin(angle), math.cos(angle)),
        ]
        return sf.contact_modes(
            problem(
                arms=[(-1, 0), (1, 0)],
                tangents=walls,
                friction=[0.5, 0.5],
                sliding=[0, 0],
                bias=[(0, 0)] * 2,
                free_acceleration=(0, -10, 0),
            ),
            method=method,
        )["FF"]

    assert held(-1e-11).consistent
    low, high = held(-1e-11).force_interval
    assert 1e11 < low < high == math.inf
    assert not held(1e-11).consistent


def test_problems_print_copy_and_compare():
    given = problem(sliding=[None, -1], level="impulse", friction=[0.1, 2])
    names = {"ContactProblem": sf.ContactProblem}
    assert eval(repr(given), names) == given
    assert_copies(given)
    assert given != problem()
    assert (given.mass, given.gyration_radius) == (1.0, 0.5)
    assert given.arms == [(-1.0, -1.0), (1.0, -1.0)]
    assert given.tangents == [(1.0, 0.0), (1.0, 0.0)]
    assert (given.friction, given.sliding) == ([0.1, 2.0], [None, -1])
    assert given.bias == [(0.0, 0.0), (0.0, 0.0)]
    assert (given.free_acceleration, given.level) == ((0.0, -1.0, 0.0), "impulse")
    with pytest.raises(AttributeError):
        given.mass = 2


def test_arrays_are_taken():
    fields = ("arms", "tangents", "friction", "sliding", "bias", "free_acceleration")
    arrays = {name: np.array(getattr(problem(), name)) for name in fields}
    assert problem(**arrays) == problem()
    assert problem(arms=((-1, -1), [1, np.float32(-1)])) == problem()


def ask(**keywords):
    return sf.contact_modes(on_slope(0.0, 0.5), **keywords)


@pytest.mark.parametrize(
    ("make", "kind", "words"),
    [
        (lambda: problem(mass=0), ValueError, "mass = 0.0 * > 0"),
        (lambda: problem(mass=True), TypeError, "mass = True * a number"),
        (lambda: problem(mass=10**400), ValueError, "mass = inf * finite"),
        (
            lambda: problem(gyration_radius=math.nan),
            ValueError,
            "gyration_radius = NaN",
        ),
        (lambda: problem(arms=[]), ValueError, "arms = [0 contacts] * 1 to 64"),
        (lambda: problem(arms=1), TypeError, "arms = 1 * a sequence"),
        (lambda: problem(arms="ab"), TypeError, "arms = 'ab' * a sequence"),
        (lambda: problem(arms=[(0, 0, 0)] * 2), ValueError, "arms.1 = * 2 numbers"),
        (lambda: problem(arms=[(0, 0), 1]), TypeError, "arms.2 = 1 * 2 numbers"),
        (
            lambda: problem(arms=[(0, 0), (0, math.inf)]),
            ValueError,
            "arms.2.y = inf * finite",
        ),
        (lambda: problem(arms=np.zeros(2)), TypeError, "arms.1 = * 2 numbers"),
        (
            lambda: problem(arms=[(0, 0)] * 65),
            ValueError,
            "arms = * at most 64 contacts, not 65",
        ),
        (
            lambda: problem(friction=range(10**9)),
            ValueError,
            "friction = range(0, 1000000000) * at most 64",
        ),
        (
            lambda: problem(tangents=[(1, 0), (1, 1)]),
            ValueError,
            "tangents.2 = (1.0, 1.0) * length 1",
        ),
        (
            lambda: problem(tangents=[(1, 0)]),
            ValueError,
            "tangents = [1 entries] * one for each of the 2",
        ),
        (
            lambda: problem(friction=[1]),
            ValueError,
            "friction = [1 entries] * one for each of the 2",
        ),
        (lambda: problem(friction=1), TypeError, "friction = 1 * a sequence"),
        (lambda: problem(friction=[1, -1]), ValueError, "friction.2 = -1.0 * >= 0"),
        (lambda: problem(friction=[1, None]), TypeError, "friction.2 = None * a num"),
        (lambda: problem(friction=[True, 1]), TypeError, "friction.1 = True * a num"),
        (lambda: problem(sliding=[1]), ValueError, "sliding = [1 entries] * one for"),
        (lambda: problem(sliding=[0, 2]), ValueError, "sliding.2 = 2 * 1, -1, 0, or N"),
        (lambda: problem(sliding=[0, 0.5]), ValueError, "sliding.2 = 0.5 * 1, -1, 0"),
        (lambda: problem(sliding=[math.nan, 0]), ValueError, "sliding.1 = nan * 1,"),
        (lambda: problem(sliding=[10**30, 0]), ValueError, "sliding.1 = 1000* 1, -1"),
        (lambda: problem(sliding=[True, 0]), TypeError, "sliding.1 = True * 1, -1"),
        (lambda: problem(sliding=["R", 0]), TypeError, "sliding.1 = 'R' * 1, -1"),
        (lambda: problem(bias=[(0, 0)]), ValueError, "bias = [1 entries] * one for"),
        (
            lambda: problem(bias=[(0, 0), (math.nan, 0)]),
            ValueError,
            "bias.2.tangential = NaN * finite",
        ),
        (
            lambda: problem(free_acceleration=(0, 0)),
            ValueError,
            "free_acceleration = (0, 0) * 3 numbers",
        ),
        (
            lambda: problem(free_acceleration=(0, math.nan, 0)),
            ValueError,
            "free_acceleration.y = NaN",
        ),
        (
            lambda: problem(level="jerk"),
            ValueError,
            'level = "jerk" * `acceleration` or `impulse`',
        ),
        (lambda: problem(level=1), TypeError, "level = 1 * a string"),
        (lambda: ask(method="guess"), ValueError, 'method = "guess" * `enumerate`'),
        (lambda: ask(method=None), TypeError, "method = None * a string"),
        (lambda: ask(wrench=(0, 0)), ValueError, "wrench = (0, 0) * 3 numbers"),
        (lambda: ask(wrench=(0, 0, math.inf)), ValueError, "wrench.torque = inf * f"),
        (
            lambda: sf.contact_modes(
                on_slope(0.0, 0.5, mass=1e-3), wrench=(0, 1e150, 0)
            ),
            ValueError,
            "wrench.y = 1e150 * 1e150",
        ),
        (lambda: ask(qdot=(0, 0, 1e80)), ValueError, "qdot.theta = 1e80 * 1e150"),
        (
            lambda: problem(gyration_radius=1e-5),
            ValueError,
            "arms.1 = 14142* at most 1e4",
        ),
        (lambda: ask(q=(0, math.nan, 0)), ValueError, "q.y = NaN"),
        (lambda: ask(qdot="abc"), TypeError, "qdot = 'abc' * 3 numbers"),
        (
            lambda: sf.contact_modes(problem(), qdot=(0, 1, 0)),
            ValueError,
            "qdot = [0.0, 1.0, 0.0] * of its own",
        ),
        (
            lambda: sf.contact_modes(problem(), wrench=(0, 1, 0)),
            ValueError,
            "wrench = * of its own",
        ),
        (
            lambda: sf.contact_modes(1),
            TypeError,
            "posture = 1 * a Posture, a ContactProblem",
        ),
    ],
)
def test_wrong_input_is_named(make, kind, words):
    assert_refused(make, kind, words)


# The table.


def printed(posture, tmp_path, capsys, q=(0, 0, 0), qdot=(0, 0, 0)):
    path = tmp_path / "scene.toml"
    sf.Scene(posture, q, qdot).save(path)
    assert main(["modes", str(path)]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out.splitlines()


def test_the_table_of_two_contacts(tmp_path, capsys):
    posture = on_slope(0.3, 0.1)
    lines = printed(posture, tmp_path, capsys)
    modes = sf.contact_modes(posture)
    assert lines == ["scene.toml", *str(modes).splitlines()]
    assert lines[-1] == "  status  unique: LL"
    words = [line.split()[0] for line in lines[3:-1]]
    assert words[0] == "LL"
    assert sorted(words) == sorted(modes)
    for line, word in zip(lines[3:-1], words, strict=True):
        mode = modes[word]
        assert ("  yes" in line) == mode.consistent
        if mode.violated:
            assert any(name in line for name in mode.violated)
    assert all(len(line) < 160 for line in lines)


def test_the_state_of_the_scene_is_asked(tmp_path, capsys):
    posture = on_slope(0.0, 0.5)
    lines = printed(posture, tmp_path, capsys, qdot=(1, 0, 0))
    assert lines[-1] == "  status  unique: RR"
    lines = printed(posture, tmp_path, capsys, q=(0, 1, 0))
    assert lines[-1] == "  status  unique: SS"


def test_the_table_of_many_contacts(tmp_path, capsys):
    lines = printed(many(10), tmp_path, capsys)
    offered = len(sf.contact_modes(many(10), method="enumerate"))
    assert offered > ROWS
    rows = lines[3:-2]
    assert len(rows) == ROWS
    assert rows[0].split()[:2] == ["F" * 10, "yes"]
    assert re.search(r"\d: \(.*\)  and \d+ more$", rows[0])
    assert lines[-2] == f"    ... and {offered - ROWS} more, none of them consistent"
    assert all(len(line) < 200 for line in lines)


def test_words_without_forces_and_problems_without_words():
    table = str(sf.contact_modes(problem()))
    # Slides to the right over its leading foot, (1, −1), ρ² = 1/4: P = 0 at μ = (ρ² + 1)/1.
    assert table.splitlines()[-2:] == [
        "  status  none",
        "  jams    contact 2 while it slides right: friction is above 1.25",
    ]
    table = str(sf.contact_modes(problem(level="impulse")))
    assert "velocity after" in table
    assert "N s" in table
    assert "status  not found" in str(sf.contact_modes(problem(), method="qp"))


def test_an_impact_that_is_due_is_refused(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    sf.Scene(on_slope(0.0, 0.5), (0, 0, 0), (0, -1, 0)).save(path)
    assert main(["modes", str(path)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"standfast: {path}: qdot = ")
    assert captured.err.count("\n") == 1


@pytest.mark.parametrize("angles", [(-0.5, 0.5), (1.5, 0.5), (-0.5, 2.5)])
def test_walls_that_face_each_other_hold_nothing_without_friction(angles):
    """With rounded cosines their normals are not exactly opposite; a balance would need forces of 1e16 times the weight."""
    tangents = [(math.cos(a * math.pi), math.sin(a * math.pi)) for a in angles]
    assert tangents[0][0] != 0.0
    problem = sf.ContactProblem(
        1.0,
        0.5,
        [(-1, 0), (1, 0)],
        tangents,
        [0, 0],
        [0, 0],
        [(0, 0), (0, 0)],
        (0, -9.81, 0),
    )
    modes = sf.contact_modes(problem)
    assert (modes.status, modes.consistent) == ("unique", ["RL"])

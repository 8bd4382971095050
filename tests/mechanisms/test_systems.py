"""Assemblies of bodies: contacts by hand, statics beside linear programmes of scipy, accelerations beside a solver of linear complementarity
problems of its own, arches and overhangs of known sizes."""

import copy
import pickle

import numpy as np
import pytest
import standfast as sf
from assemblies import (
    accelerations,
    arch,
    breach,
    equations,
    masses,
    programme,
    stack,
    wall,
)

G = 9.81


def stands(system):
    return sf.friction_margin(system) >= 0


# Contacts.


def places(system):
    return [(*c.bodies, *c.point.round(12).tolist()) for c in system.contacts]


def test_contacts_of_flush_sides_of_corners_and_of_the_ground():
    system = sf.System({"low": sf.Block(1, 1), "high": sf.Block(1, 1, at=(0.3, 1))})
    assert places(system) == [
        ("low", None, -0.5, 0),
        ("low", None, 0.5, 0),
        ("high", "low", -0.2, 1),
        ("high", "low", 0.5, 1),
    ]
    # Side by side: a vertical joint, pushed to the right on the later one.
    beside = sf.System([sf.Block(1, 1), sf.Block(1, 1, at=(1, 0))])
    assert places(beside)[2:4] == [("2", "1", 0.5, 1), ("2", "1", 0.5, 0)]
    assert beside.contacts[2].tangent == pytest.approx([0, -1])
    # On its corner, on a slope; a corner on a corner is no contact.
    corner = sf.System([sf.Block(1, 1, at=(0, np.sqrt(0.125)), turn=np.pi / 4)])
    assert places(corner)[0][1] is None
    assert len(corner.contacts) == 1
    slope = [(-5, -1), (5, 1)]
    block = sf.System([sf.Block(1, 1, turn=np.arctan(0.2))], ground=slope)
    assert [c.slope for c in block.contacts] == pytest.approx([np.arctan(0.2)] * 2)
    diagonal = sf.System([sf.Block(1, 1), sf.Block(1, 1, at=(1, 1))])
    assert len(diagonal.contacts) == 2
    # A body in a trough touches its three sides.
    trough = [(-1, 1), (-0.5, 1), (-0.5, 0), (0.5, 0), (0.5, 1), (1, 1)]
    assert len(sf.System([sf.Block(1, 1)], ground=trough).contacts) == 6
    assert sf.System([sf.Block(1, 1)], ground=None).contacts == []


def test_polygons_in_either_direction_and_their_inertia():
    corners = [(0, 0), (2, 0), (2, 1), (0, 1)]
    one, two = sf.Rigid.polygon(corners), sf.Rigid.polygon(corners[::-1])
    block = sf.Block(2, 1, at=(1, 0))
    for body in (one, two):
        assert body.mass == pytest.approx(block.mass)
        assert body.gyration_radius == pytest.approx(block.gyration_radius)
        assert body.center_of_mass == pytest.approx(block.center_of_mass)
    assert two.outline.tolist() == [[0, 0], [2, 0], [2, 1], [0, 1]]


def test_friction_of_bodies():
    low, high = sf.Block(1, 1, friction=0.3), sf.Block(1, 1, at=(0, 1), friction=0.2)
    system = sf.System([low, high, sf.Block(1, 1, at=(0, 2))], friction=0.7)
    assert [c.friction for c in system.contacts] == [0.3, 0.3, 0.2, 0.2, 0.2, 0.2]


def test_given_contacts_and_copies():
    found = sf.System({"a": sf.Block(1, 1), "b": sf.Block(1, 1, at=(0, 1))})
    given = sf.System(found.bodies, contacts=found.contacts)
    assert given.contacts == found.contacts
    assert given.mechanism == found.mechanism
    assert (
        given != found
    )  # those of the one are looked for again where its bodies change
    line = sf.System([sf.Block(1, 1)], ground=[(-2, 0), (2, 0)])
    for system in (found, given, line, sf.System([sf.Block(1, 1)], ground=None)):
        assert pickle.loads(pickle.dumps(system)) == system
        assert copy.deepcopy(system) == system
    for part in (found.bodies["a"], found.contacts[0]):
        assert pickle.loads(pickle.dumps(part)) == part


def test_a_system_is_its_mechanism_with_names():
    system = sf.System({"low": sf.Block(1, 1), "high": sf.Block(1, 1, at=(0.3, 1))})
    mechanism = system.mechanism
    assert mechanism.contact_names == system.contact_names
    assert mechanism.coordinate_names[3:] == ["high.x", "high.y", "high.theta"]
    assert sf.contact_modes(system).consistent == sf.contact_modes(mechanism).consistent
    assert sf.stability(system) == sf.stability(mechanism)
    assert sf.friction_margin([system, mechanism]).tolist() == [1, 1]
    columns, weights = equations(system)
    assert mechanism.load == pytest.approx(weights)
    rows = [row for c in mechanism.contacts for row in (c.tangential, c.normal)]
    assert np.array(rows).T == pytest.approx(columns)
    assert "high on low at (0.5, 1)" in str(sf.contact_modes(system))


# Statics and accelerations.


def test_random_stacks_stand_where_a_linear_programme_says_so():
    rng, held = np.random.default_rng(1), 0
    for _ in range(400):
        system = stack(rng)
        expected = programme(system).status == 0
        assert stands(system) == expected
        held += expected
    assert 150 < held < 390


def test_random_loads_reach_the_factor_of_a_linear_programme():
    rng, bounded = np.random.default_rng(2), 0
    for _ in range(400):
        system = stack(rng)
        name = str(rng.choice(list(system.bodies)))
        at = 3 * list(system.bodies).index(name)
        push = np.zeros(system.mechanism.dof)
        if rng.random() < 0.5:
            wrench = rng.normal(size=3)
            push[at : at + 3] = wrench
            found = sf.load_factor(system, {name: wrench})
        else:
            direction = rng.normal(size=2)
            push[0::3] = masses(system)[0::3] * direction[0]
            push[1::3] = masses(system)[1::3] * direction[1]
            found = sf.load_factor(system, acceleration=direction)
        expected = programme(system, push)
        if expected.status == 2:
            assert found is None
            continue
        if expected.status == 3:
            assert found.static == np.inf
            continue
        assert found.static == pytest.approx(-expected.fun, rel=1e-9, abs=1e-9)
        columns, weights = equations(system)
        left = columns @ found.forces.ravel() + weights + found.static * push
        assert np.abs(left).max() < 1e-9 * max(1, np.abs(weights).max(), found.static)
        bounded += 1
    assert bounded > 150


def test_random_stacks_accelerate_as_an_own_solver_says():
    rng, moving, ambiguous = np.random.default_rng(3), 0, 0
    for _ in range(300):
        system = stack(rng)
        push = np.zeros(system.mechanism.dof)
        push[0::3] = masses(system)[0::3] * rng.uniform(-1, 1) * G
        mechanism = system.mechanism
        pushed = sf.Mechanism(mechanism.mass_matrix, mechanism.load + push, mechanism.contacts)  # fmt: skip
        expected = accelerations(system, push)
        modes = sf.contact_modes(pushed)
        if expected is None:
            continue
        found = [modes[word].acceleration for word in modes.consistent]
        assert found
        nearest = min(np.abs(a - expected).max() for a in found)
        scale = max(1.0, np.abs(expected).max())
        if nearest > 1e-9 * scale:
            # Another solution than the one that was found: the problem is ambiguous. Enumeration has both.
            modes = sf.contact_modes(pushed, method="enumerate")
            found = [modes[word].acceleration for word in modes.consistent]
            assert min(np.abs(a - expected).max() for a in found) < 1e-9 * scale
            ambiguous += 1
        moving += bool(np.abs(expected).max() > 1e-6)
    assert moving > 150
    assert ambiguous < 10


def test_least_thickness_of_arches():
    """By bisection, beside that of the linear programme; 5, 9 and 15 voussoirs: .09498, .10153, .10607 of the radius."""
    for n, known in ((5, 0.09498), (9, 0.10153), (15, 0.10607)):
        found = []
        for test in (stands, lambda system: programme(system).status == 0):
            low, high = 0.05, 0.2
            while high - low > 1e-7:
                middle = 0.5 * (low + high)
                low, high = (low, middle) if test(arch(n, middle)) else (middle, high)
            found.append(high)
        assert found[0] == pytest.approx(found[1], abs=1e-6)
        assert found[0] == pytest.approx(known, abs=1e-5)


@pytest.mark.parametrize("count", [21, 25, 29, 31])
def test_large_arches_are_those_of_a_linear_programme(count):
    for thickness in (0.1, 0.12, 0.15):
        system = arch(count, thickness)
        expected = programme(system)
        assert (sf.static_forces(system) is not None) == (expected.status == 0)
        assert stands(system) == (expected.status == 0)
        push = np.zeros(system.mechanism.dof)
        push[::3] = masses(system)[::3]
        found, expected = sf.load_factor(system, acceleration=(1, 0)), programme(system, push)  # fmt: skip
        if expected.status == 2:
            assert found is None
        else:
            assert found.static == pytest.approx(-expected.fun, rel=1e-8)


def test_a_thin_arch_opens_five_hinges():
    for n in (5, 9, 15):
        system = arch(n, 0.08)
        modes = sf.contact_modes(system)
        (word,) = modes.consistent
        opening = [c for c, letter in zip(system.contacts, word, strict=True) if letter == "S"]  # fmt: skip
        assert set(word) == {"S", "F"}
        # The joints: of an even number of symmetric ones, the two beside the keystone are one hinge that is split.
        joints = {c.bodies for c in opening}
        assert len(joints) == len(opening) == 6


def test_overhang_of_books():
    """Each book as far as it goes: 1/2, 1/4, 1/6, … of its length over the one below it."""
    for count in (2, 5, 11, 31):
        reach = [0.5 / k for k in range(1, count)]
        for more, expected in ((-1e-9, True), (1e-9, False)):
            x = [0.0]
            for step in reversed(reach):
                x.append(x[-1] + step)
            x[1:] = [value + more * value / x[-1] for value in x[1:]]
            books = [sf.Block(1, 0.1, at=(at, 0.1 * k)) for k, at in enumerate(x)]
            assert stands(sf.System(books)) == expected


def test_overhang_of_many_books():
    """The same with as many contacts as a mechanism does not have: by the load that they hold."""
    for count in (33, 60):
        reach = [0.5 / k for k in range(1, count)]
        x = np.concatenate([[0.0], np.cumsum(reach[::-1])])
        held = []
        for more in (-1e-9, 1e-9, 1e-2):
            places = x * (1 + more / x[-1])
            books = [sf.Block(1, 0.1, at=(at, 0.1 * k)) for k, at in enumerate(places)]
            held.append(sf.load_factor(sf.System(books), acceleration=(1, 0)))
        assert held[0] is not None
        assert held[1:] == [None, None]
        # Well beyond, the joints above the lowest ones open: a mode in a dense tableau.
        books = [sf.Block(1, 0.1, at=(1.1 * at, 0.1 * k)) for k, at in enumerate(x)]
        mode = sf.onset(sf.System(books))
        assert breach(mode.system, mode) < 1e-8
        assert mode.word.count("S") > count / 2


def test_verdicts_of_stacks_of_known_answers():
    def cubes(count, friction, width=1.0):
        blocks = [sf.Block(width, 1, at=(0, k)) for k in range(count)]
        return repr(sf.stability(sf.System(blocks, friction=friction)))

    stable, jams = "<Verdict: stable by potential-well>", "<Verdict: unstable by no-solution>"  # fmt: skip
    # n boxes of width r and height 1 jam from (4r² + 1)/(3nr) on.
    for count, width, critical in ((2, 1, 5 / 6), (3, 0.5, 4 / 9), (3, 1, 5 / 9)):
        assert cubes(count, critical - 1e-3, width) == stable
        assert cubes(count, critical + 1e-3, width) == jams
    # A beam on two pillars; the common centre of mass over the edge, exactly and beyond; no friction below.
    beam = sf.System([sf.Block(0.4, 0.8), sf.Block(0.5, 0.8, at=(1.1, 0)), sf.Block(1.5, 0.25, at=(0.6, 0.8))], friction=0.3)  # fmt: skip
    verdict = sf.stability(beam)
    assert repr(verdict) == stable
    for tangential, answer in (
        (0.3, stable),
        (0.0, "<Verdict: undecided, reason law>"),
    ):
        bouncing = sf.System(beam.bodies, friction=0.3, restitution=0.3, tangential_restitution=tangential)  # fmt: skip
        assert repr(sf.stability(bouncing)) == answer
    largest = [3.179053125, 3.9687847826087, 4.7210625, 3.801375, 1.839375, 2.3991847826087, 2.7590625, 1.839375]  # fmt: skip
    assert verdict.evidence["largest"] == pytest.approx(largest, abs=1e-9)
    edge = sf.System([sf.Block(1, 0.5), sf.Block(1, 0.5, at=(0.5, 0.5))], friction=0.4)
    assert sf.stability(edge).reason == "boundary"
    assert sf.stability(edge, width=0).by == "accelerating-mode"
    over = sf.System([sf.Block(1, 0.5, at=(0.35 * k, 0.5 * k)) for k in range(3)])
    assert sf.stability(over).by == "not-equilibrium"
    smooth = sf.System([sf.Block(1, 1, friction=0), sf.Block(1, 1, at=(0, 1))])
    assert sf.stability(smooth).by == "accelerating-mode"


def test_a_load_that_tips_and_one_that_slides():
    for width, friction, expected in ((2, 0.5, 0.5), (0.5, 0.9, 0.5), (0.5, 0.3, 0.3)):
        brick = sf.System([sf.Block(width, 1)], friction=friction)
        found = sf.load_factor(brick, acceleration=(G, 0))
        assert found.static == pytest.approx(expected, abs=1e-12)
    # Downwards there is no bound; a body in the air is not held.
    assert sf.load_factor(brick, acceleration=(0, -1)).static == np.inf
    assert sf.load_factor(sf.System([sf.Block(1, 1, at=(0, 1))]), {"1": (1, 0, 0)}) is None  # fmt: skip


def test_dropped_stacks_come_to_rest():
    rng = np.random.default_rng(5)
    for law in ("newton", "moreau"):
        for _ in range(8):
            blocks = [sf.Block(1, 0.6, at=(rng.uniform(-0.1, 0.1), 0.6 * k)) for k in range(3)]  # fmt: skip
            system = sf.System(blocks, friction=0.4, restitution=0.3)
            q = np.zeros(9)
            q[1::3] = np.cumsum(rng.uniform(0, 1e-3, 3))
            run = sf.simulate(system, q=q, qdot=np.zeros(9), impact=law, event_limit=200_000)  # fmt: skip
            assert run.outcome == "rest"


# Large assemblies, and loads.


def hinges(mode):
    """The number of joints of an arch of which exactly one end opens."""
    pairs = zip(mode.word[::2], mode.word[1::2], strict=True)
    return sum((low == "S") != (high == "S") for low, high in pairs)


@pytest.mark.parametrize("count", [5, 31, 61, 301])
def test_least_thickness_of_arches_of_any_size(count):
    """To 1e-6 beside a linear programme of scipy, by whether forces hold some horizontal acceleration. Five hinges: with an odd number of voussoirs that of the crown is
    split onto the two joints beside the keystone."""
    low, high = 0.09, 0.11
    while high - low > 1e-6:
        middle = (low + high) / 2
        holds = sf.load_factor(arch(count, middle), acceleration=(1, 0)) is not None
        low, high = (low, middle) if holds else (middle, high)
    assert programme(arch(count, high)).status == 0
    assert programme(arch(count, low)).status == 2
    known = {5: (0.09498, 6e-6), 301: (0.1075, 5e-5)}
    if count in known:
        assert high == pytest.approx(known[count][0], abs=known[count][1])
    thin = arch(count, 0.99 * low)
    mode = sf.onset(thin)
    assert breach(thin, mode) < 1e-9
    assert hinges(mode) == 6


def test_a_mode_that_holds_but_for_rounding_says_so():
    mode = sf.onset(arch(9, 0.12))
    assert mode.acceleration.any()
    assert str(mode) == "20 contacts, none opens or slides: forces hold the system"


def test_bodies_with_accelerations_of_rounding_are_not_said_to_move():
    """Just above its static factor a wedge of the wall accelerates by 1e-3 m/s², and the bricks beside it by 1e-11."""
    mode = sf.load_factor(wall(6, 4, 0.75), acceleration=(9.81, 0)).mode
    sizes = np.abs(mode.acceleration)
    moves, rounding = sizes > 1e-3 * sizes.max(), sizes < 1e-6 * sizes.max()
    assert (moves | rounding).all()
    assert sizes[rounding].any()
    names = np.array(mode.system.coordinate_names)[moves].tolist()
    said = str(mode).splitlines()[-1].removeprefix("    accelerates   ").split("; ")
    count = len(said) - 1
    assert [text.split()[0] for text in said[:count]] == names[:count]
    assert said[-1] == f"and {len(names) - count} more"


def test_a_mode_of_hundreds_of_contacts_is_copied_and_pickled():
    mode = sf.onset(arch(301, 0.1))
    assert pickle.loads(pickle.dumps(mode)) == mode == copy.deepcopy(mode)


@pytest.mark.parametrize(
    ("rows", "columns", "friction", "push"),
    [
        (15, 20, 0.6, 0.4),
        (15, 20, 0.3, 0.5),
        (15, 20, 0.3, 2.0),
        (6, 8, 0.6, 1.0),
        (10, 10, 0.5, 0.0),
    ],
)
def test_walls_of_any_size_obey_coulombs_law(rows, columns, friction, push):
    system = wall(rows, columns, friction)
    load = masses(system) * np.tile([G, 0, 0], len(system.bodies))
    mode = sf.onset(system, acceleration=(G, 0), factor=push)
    assert breach(system, mode, push * load) < 1e-8
    held = programme(system, load)
    assert (np.abs(mode.acceleration).max() < 1e-6) == (held.x[-1] >= push)


def test_load_factors_of_large_systems_are_those_of_a_linear_programme():
    for system in (arch(61, 0.12), arch(301, 0.12), wall(8, 8, 0.6)):
        load = masses(system) * np.tile([G, 0, 0], len(system.bodies))
        factor = sf.load_factor(system, acceleration=(G, 0))
        assert factor.static == pytest.approx(programme(system, load).x[-1], abs=1e-8)
        assert factor.moves == pytest.approx(factor.static, abs=2e-3)
        columns, weights = equations(system)
        left = columns @ factor.forces.ravel() + weights + factor.static * load
        assert np.abs(left).max() < 1e-7 * np.abs(weights).max()


def test_a_block_between_walls_is_held_by_statics_and_may_fall():
    beside = [
        sf.SystemContact("block", None, (x, y), slope, 0.8)
        for x, slope in ((-0.5, -np.pi / 2), (0.5, np.pi / 2))
        for y in (0, 1)
    ]
    system = sf.System({"block": sf.Block(1, 1)}, contacts=beside, ground=None)
    factor = sf.load_factor(system, acceleration=(0, -1))
    assert (factor.static, factor.moves, factor.complete) == (np.inf, 0, True)
    assert factor.mode.word == "RRLL"
    assert factor.mode.acceleration == pytest.approx([0, -G, 0], abs=1e-9)
    assert sf.contact_modes(system).consistent == ["FFFF", "RRLL"]
    assert sf.onset(system).word == "FFFF"
    assert pickle.loads(pickle.dumps(factor)) == factor == copy.deepcopy(factor)


def test_the_least_multiple_that_moves_is_the_static_one_of_random_stacks():
    """Level stacks have one motion or rest for each load: where statics ends, they move."""
    rng = np.random.default_rng(12)
    seen = 0
    for _ in range(30):
        system = stack(rng)
        load = masses(system) * np.tile([1.0, 0, 0], len(system.bodies))
        factor = sf.load_factor(system, acceleration=(1, 0))
        if factor is None or not np.isfinite(factor.static):
            continue
        assert factor.moves <= factor.static + 1e-7
        mode = factor.mode
        assert breach(system, mode, mode.factor * load) < 1e-8
        assert np.abs(mode.acceleration).max() > 1e-7
        seen += factor.complete
    assert seen > 5


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sf.System([]), "bodies = .* one or more bodies"),
        (lambda: sf.System(sf.Block(1, 1)), "bodies = .* a dict"),
        (lambda: sf.System([1]), r"bodies\.1 = 1 .* a Rigid, or a Block"),
        (
            lambda: sf.System({"a": sf.Block(1, 1), "b": sf.Block(1, 1, at=(0.5, 0.5))}),
            'bodies = ."b" overlaps "a".',
        ),
        (lambda: sf.System([sf.Block(1, 1), sf.Block(1, 1)]), 'bodies = ."2" overlaps "1".'),
        (
            lambda: sf.System([sf.Block(1, 1, at=(0, -0.1))]),
            'bodies = ."1" overlaps "the ground".',
        ),
        (lambda: sf.Block(1, -1), "height = -1"),
        (lambda: sf.Block(1, 1, density=0), "density = 0"),
        (lambda: sf.Rigid.polygon([(0, 0), (1, 0)]), "vertices = .* 3 or more"),
        (lambda: sf.System([sf.Block(1, 1)], friction=-1), "friction = -1"),
        (lambda: sf.System([sf.Block(1, 1)], ground=[(0, 0)]), "ground = .* two or more"),
        (
            lambda: sf.System(
                [sf.Block(1, 1)], contacts=[sf.SystemContact("2", None, (0, 0))]
            ),
            r'contacts\.1\.body = "2" .* a body of the system: 1',
        ),
        (
            lambda: sf.System([sf.Block(1, 1)], contacts=["x"]),
            r"contacts\.1 = 'x' .* a SystemContact",
        ),
        (
            lambda: sf.contact_modes(sf.System([sf.Block(1, 1, at=(0, 2))])),
            "contacts = .0 contacts. .* 1 to 64 contacts",
        ),
        (
            lambda: sf.stability(
                sf.System([sf.Block(1, 1, at=(0, k)) for k in range(40)])
            ),
            "contacts = .80 contacts.",
        ),
        (lambda: sf.load_factor(sf.System([sf.Block(1, 1)])), "load = None .* either"),
        (
            lambda: sf.load_factor(sf.System([sf.Block(1, 1)]), {"2": (1, 0, 0)}),
            'load = "2" .* a body of the system: 1',
        ),
        (
            lambda: sf.results.SystemMode(sf.System([sf.Block(1, 1)]), "FF", [0] * 3, [(0, np.nan)] * 2),
            r"forces\.1\.normal = NaN .* finite",
        ),
        (
            lambda: sf.results.LoadFactor(sf.System([sf.Block(1, 1)]), 1, [(0, 1)], 1, None, True),
            "forces = .1 pairs. .* each of the 2 contacts",
        ),
        (
            lambda: sf.load_factor(sf.System([sf.Block(1, 1)]), {"1": (0, 0, 0)}),
            "load = zero",
        ),
    ],
)  # fmt: skip
def test_wrong_input_is_named(make, message):
    with pytest.raises((ValueError, TypeError), match=message):
        make()


def test_nested_accumulations_of_a_stack_end():
    """Contacts that are hit one after the other accumulate again and again; once all speeds are what rounding leaves, the stack rests."""
    stack = sf.System([sf.Block(0.5, 1), sf.Block(1, 0.5, at=(0.1, 1))])
    assert sf.stability(stack).by == "potential-well"
    start = (0, 0.002, 0.001, 0, 0.004, -0.001)
    run = sf.simulate(stack, start, impact="newton", record=False)
    assert run.outcome == "rest"
    assert run.collisions > 10_000
    # The same run a thousandth of the way before its end: its speeds are small, and not yet those of rounding.
    before = sf.simulate(
        stack, start, impact="newton", record=False, event_limit=25_000
    )
    fastest = np.sqrt(2 * G * 0.004)
    assert 1e-9 * fastest < np.abs(before.qdot).max() < 1e-6 * fastest
    assert run.time - before.time < 1e-5 * run.time

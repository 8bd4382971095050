"""Chains and mechanisms through Python: bipeds, wrong input, and copies."""

import math
import pickle

import numpy as np
import pytest
import standfast as sf

Q = [0, 0, 0.1, -0.5, 0.6]
CONTACTS = [0, 2], [1, 3]  # T_1, T_2 and N_1, N_2 in the order (tangential, normal)


def biped(kind="torque", torques=(0, 0), armature=0.0, slopes=(0.3, -0.25), mu=0.5):
    """A trunk of 10 kg on its hip and two uniform legs: q = (x, y, θ, a, b)."""
    leg = sf.Link(mass=1, inertia=1 / 12, length=1)
    joints = [
        sf.Joint(
            kind, torque=torque, armature=armature, parent=1, at=0, angle=-math.pi / 2
        )
        for torque in torques
    ]
    feet = [
        sf.Foot(k, slope=slope, friction=mu)
        for k, slope in zip((2, 3), slopes, strict=True)
    ]
    trunk = sf.Link(mass=10, inertia=0.4, length=1, center=0)
    return sf.Chain(links=[trunk, leg, leg], joints=joints, feet=feet)


def normal(mechanism, i, j):
    return mechanism.contact_space.W[2 * i - 1, 2 * j - 1]


def test_a_biped_with_locked_joints_is_a_rigid_body():
    mechanism = biped("locked").mechanism(Q)
    space = mechanism.contact_space
    assert (mechanism.dof, mechanism.locked, space.rank) == (5, [3, 4], 3)
    assert space.W.shape == (4, 4)
    assert (space.W == space.W.T).all()
    tangential, normals = CONTACTS
    expected = [-9.371850958, -9.505030857, -2.899053227, 2.42703284]
    assert space.b[[*normals, *tangential]] == pytest.approx(expected, abs=1e-9)
    assert mechanism.local().psi == pytest.approx((0.8785943811, 0.6080259568))
    assert normal(mechanism, 1, 2) == pytest.approx(-0.423789611, abs=1e-9)


def test_a_biped_under_the_torques_that_hold_it():
    chain = biped()
    # The least Σ τ² + Σ f² that satisfies the equations.
    rows = [r for c in chain.mechanism(Q).contacts for r in (c.tangential, c.normal)]
    equations = np.vstack([np.eye(5)[3:], rows]).T
    least = np.linalg.lstsq(equations, chain.bias(Q), rcond=None)[0][:2]
    torque = 16.148336405
    assert least == pytest.approx([torque, -torque], abs=1e-9)
    mechanism = chain.mechanism(Q, torques=least)
    assert mechanism == biped(torques=least).mechanism(Q)
    expected = [-39.524256935, -48.291975487, 35.790319262, -27.599756133]
    tangential, normals = CONTACTS
    found = mechanism.contact_space.b[[*normals, *tangential]]
    assert found == pytest.approx(expected, abs=1e-8)
    psi = pytest.approx((0.0217327815, 0.0139869638), abs=1e-9)
    assert mechanism.local().psi == psi
    geared = biped(armature=1.0).mechanism(Q)
    assert geared.armature.tolist() == [0, 0, 0, 1, 1]
    psi = pytest.approx((0.4372888897, 0.2928251793), abs=1e-9)
    assert geared.local().psi == psi


def test_the_forces_balance_the_bias():
    chain = biped(slopes=(0.1, -0.1), mu=0.9)
    held = chain.holding_torques(Q)
    mechanism = chain.mechanism(Q)
    balance = -chain.bias(Q)
    balance[3:] += held.torques
    for contact, (t, n) in zip(mechanism.contacts, held.forces, strict=True):
        balance += contact.tangential * t + contact.normal * n
        assert abs(t) <= contact.friction * n * (1 + 1e-12)
    assert np.abs(balance).max() < 1e-12 * np.abs(chain.bias(Q)).max()
    assert (held.joints, held.contacts, held.freedom) == ([1, 2], [1, 2], 1)
    low, high = held.internal_force
    assert low < high
    ends = [held.free_torques + s * held.internal_torques for s in (low, high)]
    assert np.sort(np.transpose(ends)) == pytest.approx(held.torque_interval)
    ends = [held.free_forces + s * held.internal_forces for s in (low, high)]
    assert np.min(ends, axis=0) == pytest.approx(held.force_low)
    assert np.max(ends, axis=0) == pytest.approx(held.force_high)
    assert chain.holding_torques(Q, contacts=[1]) is None


def test_the_torques_of_a_mechanism_are_asked_for_where_it_is_made():
    chain = biped(slopes=(0.1, -0.1), mu=0.9)
    for words in ({"choose": "middle"}, {"choose": "least"}, {"contacts": [2, 1]}):
        of_chain = chain.holding_torques(Q, **words)
        of_rows = chain.mechanism(Q).holding_torques([3, 4], **words)
        assert of_rows.joints == [3, 4]
        for name in ("torques", "forces", "torque_interval", "force_low", "contacts"):
            assert np.array_equal(getattr(of_rows, name), getattr(of_chain, name)), name
    middle = chain.holding_torques(Q)
    assert middle.torques == pytest.approx(np.mean(middle.torque_interval, axis=1))
    assert chain.mechanism(Q, torques="holding") == chain.mechanism(Q, middle.torques)
    # Less torque than in the middle; zero is outside of the cones, which bound the torques.
    least = chain.holding_torques(Q, choose="least")
    norm = np.linalg.norm
    assert 0 < norm(least.torques) < norm(middle.torques)
    line = least.torque_interval[0]
    assert least.torques[0] == pytest.approx(line[np.abs(line).argmin()], abs=1e-12)
    assert chain.mechanism(Q, torques="least") == chain.mechanism(Q, least.torques)
    rows = chain.mechanism(Q, torques="least").contacts
    spare = [
        c.friction * n - abs(t) for c, (t, n) in zip(rows, least.forces, strict=True)
    ]
    assert min(spare) == pytest.approx(0, abs=1e-9)
    # On ice no torques hold it: they are zero.
    ice = biped(mu=0.01, torques=(1, 2))
    assert ice.holding_torques(Q) is None
    assert ice.mechanism(Q, torques="holding") == ice.mechanism(Q, torques=[0, 0])
    verdict = sf.stability(ice.mechanism(Q, torques="holding"))
    assert verdict.by == "not-equilibrium"
    assert chain.mechanism(Q).holding_torques([3]) is None


def test_the_unit_of_length_does_not_decide():
    """Three feet have more internal forces than one."""
    shin = sf.Link(1, 1 / 12, 1)

    def made(scale):
        links = [sf.Link(10, 0.4 * scale**2, scale, center=0)]
        links += [sf.Link(1, scale**2 / 12, scale)] * 3
        hip = sf.Joint("torque", parent=1, at=0, angle=-math.pi / 2)
        feet = [
            sf.Foot(k, friction=0.5, slope=s) for k, s in ((2, 0.1), (3, 0), (4, -0.1))
        ]
        return sf.Chain(links=links, joints=[hip] * 3, feet=feet, gravity=9.81 * scale)

    assert made(1).links[1] == shin
    q = [0, 0, 0.1, -0.5, 0.05, 0.4]
    in_metres, in_millimetres = (made(s).holding_torques(q) for s in (1, 1000))
    assert in_metres.freedom == in_millimetres.freedom == 3
    scale = 1000**2
    torques = in_metres.torques
    assert in_millimetres.torques / scale == pytest.approx(torques, abs=1e-9)
    # A quadratic programme over the edges of the cones, by a method of its own: the least Σ τ².
    optimize = pytest.importorskip("scipy.optimize")
    chain = made(1)
    rows, h = chain.mechanism(q).contacts, chain.bias(q)
    edges = [c.normal + s * c.friction * c.tangential for c in rows for s in (1, -1)]
    edges = np.array(edges).T
    big = 1e6
    weights, _ = optimize.nnls(
        np.vstack([edges[3:], big * edges[:3]]), np.append(h[3:], big * h[:3])
    )
    assert h[3:] - edges[3:] @ weights == pytest.approx(torques, abs=1e-8)


def test_one_contact_that_carries_everything():
    """The other one has no force: four sides of two cones meet in one point. Forces stay in the cones, and torques in their intervals."""
    rng = np.random.default_rng(4)
    rows = [[3, 3, 0], [1, 3, -2]], [[2, 2, 1], [0, -1, -1]]
    cases = [(rows, [-35, -45, 10], [2])]
    while len(cases) < 2000:
        pairs = rng.integers(-3, 4, (2, 2, 3)).astype(float)
        force = np.array([rng.uniform(-0.5, 0.5), 1.0]) * 10
        n, t = pairs[0]
        cases.append((pairs, -(force[1] * n + force[0] * t), [2]))
    asked = 0
    for pairs, load, joints in cases:
        try:
            contacts = [sf.ContactRows(n, t, friction=0.5) for n, t in pairs]
            made = sf.Mechanism(np.eye(3), load, contacts)
        except ValueError:
            continue
        for choose in ("middle", "least"):
            held = made.holding_torques(joints, choose=choose)
            if held is None:
                continue
            asked += 1
            size = 1 + np.abs(held.forces).max()
            tangential, normal = held.forces.T
            assert (np.abs(tangential) <= 0.5 * normal + 1e-8 * size).all()
            balance = np.array(load, dtype=float)
            balance[joints] += held.torques
            for (n, t), (ft, fn) in zip(pairs, held.forces, strict=True):
                balance += np.multiply(n, fn) + np.multiply(t, ft)
            assert np.abs(balance).max() < 1e-9 * size
            (low, high), torque = held.torque_interval[0], held.torques[0]
            assert low - 1e-8 * size <= torque <= high + 1e-8 * size
    assert asked > 1000


def test_points_of_a_biped():
    links, feet = biped().points(Q)
    assert links.shape == (3, 2, 2)
    assert feet == pytest.approx(links[1:, 1])
    expected = [[math.sin(a), -math.cos(a)] for a in (-0.4, 0.7)]
    assert feet == pytest.approx(np.array(expected), abs=1e-15)
    x, y = biped().center_of_mass(Q)
    assert (x, y) == pytest.approx(feet.sum(axis=0) / 24, abs=1e-15)


def test_the_mechanism_of_a_rigid_body():
    feet = [sf.Contact(point=(x, 0), friction=0.5) for x in (-1, 1)]
    body = sf.Posture(
        mass=2,
        gyration_radius=0.5,
        center_of_mass=(0, 1),
        contacts=feet,
        restitution=0.1,
    )
    mechanism = sf.Mechanism.of_posture(body)
    assert mechanism.mass_matrix.tolist() == np.diag([2, 2, 0.5]).tolist()
    assert mechanism.load.tolist() == [0, -2 * 9.81, 0]
    assert mechanism.restitution == 0.1
    assert mechanism.local().psi == pytest.approx(body.psi, abs=1e-15)


MECHANISM = biped(armature=0.5).mechanism(Q)
THINGS = [
    sf.Link(1, 0.1, 0.5),
    sf.Link(1, 0.1, 0.5, center=0.2),
    sf.Joint("locked"),
    sf.Joint("torque", torque=1, armature=0.1, parent=2, at=0.3, angle=-1),
    sf.Foot(1),
    sf.Foot(
        2, at=0.1, slope=0.2, friction=0.5, restitution=0.1, tangential_restitution=0.2
    ),
    sf.ContactRows([0, 1.5], [1, 0], restitution=0.1, tangential_restitution=0.3),
    biped("locked"),
    sf.Chain("pinned", [sf.Link(1, 0.1, 0.5)], [sf.Joint("torque")], restitution=0.2),
    MECHANISM,
    sf.Mechanism(np.eye(2), [0, -1], [sf.ContactRows([0, 1], [1, 0.5])], locked=()),
]


@pytest.mark.parametrize("thing", THINGS, ids=lambda thing: type(thing).__name__)
def test_copies_are_equal_and_reprs_are_calls(thing):
    for copy in (pickle.loads(pickle.dumps(thing)), eval(repr(thing), vars(sf))):
        assert copy == thing
        assert repr(copy) == repr(thing)
    others = [other for other in THINGS if other is not thing]
    assert thing not in others
    assert thing != "text"


def test_answers_are_pickled():
    space = MECHANISM.contact_space
    assert pickle.loads(pickle.dumps(space)) == space
    held = biped().holding_torques(Q, contacts=[2, 1])
    copy = pickle.loads(pickle.dumps(held))
    assert (copy.forces == held.forces).all()
    assert copy.contacts == [2, 1]
    assert repr(copy) == repr(held)
    assert repr(held).startswith("<HoldingTorques: torques [41.6321, -41.6321] N m, f")
    of_rows = MECHANISM.holding_torques([3, 4], choose="least")
    assert repr(pickle.loads(pickle.dumps(of_rows))) == repr(of_rows)


ROWS = sf.ContactRows([0, 1], [1, 0])


def mechanism(matrix=((1, 0), (0, 1)), load=(0, -1), contacts=(ROWS,), **others):
    return sf.Mechanism(matrix, load, contacts, **others)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: mechanism([1, 0]), r"mass_matrix = array of shape \[2\] cannot be"),
        (lambda: mechanism(np.eye(3)), r"mass_matrix = \[shape \(3, 3\)\] cannot"),
        (lambda: mechanism([[1, 2], [2, 1]]), "mass_matrix = .*least eigenvalue is -1"),
        (lambda: mechanism([[1, 0.1], [0, 1]]), "mass_matrix.1.0 = 0.0 cannot"),
        (lambda: mechanism(load=[[0, -1]]), r"load = array of shape \[1, 2\] cannot"),
        (lambda: mechanism(load=[0, math.nan]), "load.1 = NaN is outside"),
        (lambda: mechanism(contacts=[]), r"contacts = \[0 contacts\] cannot"),
        (lambda: mechanism(locked=[2]), r"locked = \[2\] cannot be used: different"),
        (lambda: mechanism(armature=[1]), r"armature = array of shape \[1\] cannot"),
        (lambda: mechanism(armature=[]), r"armature = array of shape \[0\] cannot"),
        (lambda: mechanism(armature=[1, -1]), "armature.1 = -1.0 is outside"),
        (lambda: mechanism(restitution=1.5), "restitution = 1.5 is outside"),
        (
            lambda: mechanism(contacts=[sf.ContactRows([1], [0, 1])]),
            r"contacts.1.normal = \[1 entries\] cannot",
        ),
        (lambda: biped().mechanism([0, 0, 0]), r"q = \[3 entries\] cannot"),
        (lambda: biped().mechanism(np.eye(5)), r"q = array of shape \[5, 5\] cannot"),
        (
            lambda: biped().mechanism([0, 0, 0, 30, 0]),
            r"q.3 = 30.0 cannot .* did you mean math.radians\(30\)",
        ),
        (lambda: biped(slopes=(20, 0)), "feet.1.slope = 20.0 cannot"),
        (
            lambda: biped().holding_torques(Q, contacts=[3]),
            r"contacts = \[3\] cannot be used: different feet, from 1 to 2",
        ),
        (
            lambda: biped().mechanism(Q, torques="enough"),
            "torques = 'enough' cannot be used: None, 'holding', 'least' or an array",
        ),
        (
            lambda: biped().mechanism(Q, torques=[1, 2, 3]),
            r"torques = \[3 entries\] cannot be used: one entry for each of the 2",
        ),
        (
            lambda: biped().mechanism(Q, torques=[1, math.inf]),
            r"torques\.1 = inf",
        ),
        (
            lambda: biped().holding_torques(Q, choose="most"),
            'choose = "most" cannot .*`middle`',
        ),
        (
            lambda: biped().mechanism(Q).holding_torques([3, 3]),
            r"joints = \[3, 3\] cannot be used: different coordinates that are not",
        ),
        (
            lambda: biped("locked").mechanism(Q).holding_torques([3]),
            r"joints = \[3\] cannot",
        ),
        (
            lambda: biped().mechanism(Q).holding_torques([3], contacts=[0]),
            r"contacts = \[0\] cannot be used: different contacts, from 1 to 2",
        ),
        (
            lambda: sf.Chain(feet=[sf.Foot(1, radius=-1)], links=[sf.Link(1, 1, 1)]),
            "feet.1.radius = -1",
        ),
        (lambda: sf.Chain(links=[]), r"links = \[0 links\] cannot"),
        (lambda: sf.Chain("hanging", []), 'base = "hanging" cannot .*`floating`'),
        (lambda: sf.Joint("hinge"), 'kind = "hinge" cannot .*`locked`'),
        (lambda: sf.Foot(0), "link = 0 cannot be used: an integer from 1"),
        (
            lambda: sf.Chain(
                links=[sf.Link(1, 1, 1)] * 2, joints=[sf.Joint("locked", parent=2)]
            ),
            "joints.1.parent = 2 cannot be used: a link before link 2",
        ),
    ],
)
def test_wrong_values_are_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: mechanism(contacts=[1]), "contacts.1 = 1 cannot .*ContactRows are"),
        (lambda: sf.Chain(links=[1]), "links.1 = 1 cannot be used: a Link is needed"),
        (lambda: mechanism(locked=[0.5]), "locked.1 = 0.5 cannot"),
        (lambda: biped().mechanism("q"), "q = 'q' cannot"),
        (lambda: sf.Link(1, 1, "long"), "length = 'long' cannot"),
        (lambda: sf.Link(1, 1, 1, centre=0), "centre.*did you mean 'center'"),
        (lambda: sf.Joint("locked", armour=1), "'armour'"),
    ],
)
def test_wrong_types_are_named(make, message):
    with pytest.raises(TypeError, match=message):
        make()

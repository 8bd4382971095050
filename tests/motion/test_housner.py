"""A block that rocks from corner to corner [Housner 1963], with plastic corners: the factor of the angular velocity for each
law of impact, and the duration of every swing.

The block has half-diagonal R and angle α between diagonal and side: half-width B = R sin α, centre of mass at H = R cos α
above the floor, ρ² = R²/3. It rotates about one corner with ω; the other lands when the block is upright.
"""

import math
from functools import cache, partial

import pytest
import standfast as sf
from bodies import FRICTION_LAWS, order_for
from checks import close as within
from mpmath import mp, mpf

G = 9.81
R = 1.25


@pytest.fixture(autouse=True)
def digits():
    """Digits of the oracle."""
    with mp.workdps(25):
        yield


class Block:
    """A posture, and its numbers without further rounding."""

    def __init__(self, alpha, friction):
        self.posture = sf.Posture(
            mass=2.0,
            gyration_radius=R / math.sqrt(3),
            center_of_mass=(0.0, R * math.cos(alpha)),
            contacts=[
                sf.Contact(point=(side * R * math.sin(alpha), 0.0), friction=friction)
                for side in (-1, 1)
            ],
            restitution=0.0,
            gravity=G,
        )
        self.width = mpf(self.posture.contacts[1].point[0])
        self.height = mpf(self.posture.center_of_mass[1])
        self.rho2 = mpf(self.posture.gyration_radius) ** 2
        self.diagonal2 = self.width**2 + self.height**2
        self.alpha = mp.atan(self.width / self.height)
        #: p², of the physical pendulum about a corner: φ'' = −p² sin(α − φ)
        self.pull = mpf(G) * mp.sqrt(self.diagonal2) / (self.rho2 + self.diagonal2)

    def upright(self, omega):
        """Start: upright, rotating about corner 1; ω has few bits, so that the rate there is not rounded."""
        width, height = float(self.width), float(self.height)
        return (0, 0, 0), (-height * omega, width * omega, omega)

    def kept_by_sticking(self):
        """ω⁺/ω⁻ of an impact at the new corner alone, about which the angular momentum is conserved."""
        return (self.rho2 + self.height**2 - self.width**2) / (
            self.rho2 + self.diagonal2
        )

    def kept_by_slipping(self):
        """ω⁺/ω⁻ of a vertical impulse p: ω⁺ = ω + B p/(mρ²), v_y⁺ = −B ω + p/m, and v_y⁺ + B ω⁺ = 0 at the corner."""
        return (self.rho2 - self.width**2) / (self.rho2 + self.width**2)

    def apex(self, omega):
        """Angle at which the block reverses: ½ω² = p² (cos(α − φ) − cos α)."""
        cos = mp.cos(self.alpha) + omega**2 / (2 * self.pull)
        assert cos < 1, "the block topples"
        return self.alpha - mp.acos(cos)

    def swing(self, omega):
        """Time from upright to upright: 2 ∫ dφ/φ' with φ'² = 4p² sin((φ_m − φ)/2) sin(α − (φ + φ_m)/2), by quadrature in
        u: φ = φ_m (1 − u²)."""
        top = self.apex(omega)

        def integrand(u):
            phi = top * (1 - u * u)
            rest = mp.sin(top * u * u / 2) * mp.sin(self.alpha - (phi + top) / 2)
            return 2 * top * u / mp.sqrt(4 * self.pull * rest)

        return 2 * mp.quad(integrand, [0, 1], method="gauss-legendre")


close = partial(within, rel=1e-11)


def kept(impact):
    """ω⁺/ω⁻: before the impact the block rotates about the old corner, after it about the new one."""
    new = impact["index"]
    return -impact["rates_after"][1 - new] / impact["rates_before"][new]


def run(block, omega, law, **options):
    return sf.simulate(
        block.posture,
        *block.upright(omega),
        impact=law,
        simultaneous=order_for(law),
        event_limit=20_000,
        **options,
    )


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_housners_ratio_of_a_uniform_block(alpha):
    """Closed forms: 1 − (3/2) sin² α if the new corner sticks, (1 − 3 sin² α)/(1 + 3 sin² α) if it slips."""
    block, s = Block(alpha, 1.0), mp.sin(mpf(alpha))
    close(block.kept_by_sticking(), 1 - 3 * s**2 / 2, rel=1e-14)
    close(block.kept_by_slipping(), (1 - 3 * s**2) / (1 + 3 * s**2), rel=1e-14)


@pytest.mark.parametrize("law", FRICTION_LAWS)
@pytest.mark.parametrize(
    ("alpha", "friction", "omega"),
    [
        (0.15, 1.0, 0.25),
        (0.3, 1.0, 0.625),
        (0.5, 1.5, 0.875),
        (0.7, 2.0, 1.5),
        (0.9, 3.0, 1.0),
    ],
)
def test_a_rough_block_rocks_with_housners_ratio(law, alpha, friction, omega):
    """The impulse is within the friction cone: the new corner sticks, the old one lifts off, and the block rotates about the
    new one, as a physical pendulum, until it is upright again."""
    block = Block(alpha, friction)
    # Up to a time limit before the limit of the swings, these are followed one by one.
    rest = run(block, omega, law, model="full").time
    found = run(block, omega, law, model="full", time_limit=min(6.0, (1 - 1e-6) * rest))
    ratio, landings = block.kept_by_sticking(), 0
    now, spin = mpf(0), mpf(omega)
    phases = [p for p in found.phases if p.end > p.start]
    # With Poisson's and Stronge's laws the corners have a second impact at 1e-17 m/s.
    hits = [i for i in found.impacts if i["rates_before"].min() < -1e-12]
    for impact, phase in zip(hits, phases, strict=False):
        if landings == 8 or impact["time"] > 5.9:
            break
        held = landings % 2
        assert phase.mode == ("FS", "SF")[held]
        assert impact["index"] == 1 - held
        swing = block.swing(spin)
        q, qdot = found.at(float(now + swing / 2))
        close(abs(q[2]), block.apex(spin), scale=1e-4)  # rad, rounded like 1
        assert abs(qdot[2]) <= 1e-11 * omega
        now += swing
        close(impact["time"], now)
        close(-impact["rates_before"][1 - held], 2 * block.width * spin)
        close(kept(impact), ratio)
        tangential, normal = (mpf(float(x)) / 2 for x in impact["impulse"])
        side = -1 if held else 1
        close(normal, block.width * spin * (1 + ratio))
        close(-side * tangential, block.height * spin * (1 - ratio))
        spin *= ratio
        landings += 1
    assert landings >= 3


@pytest.mark.parametrize("law", FRICTION_LAWS)
@pytest.mark.parametrize(("alpha", "omega"), [(0.4, 0.5), (0.8, 0.75)])
def test_when_the_rocking_ends(law, alpha, omega):
    """Infinitely many swings, each with Housner's factor of the angular velocity: the sum of their durations is finite, and
    the block rests at its initial place."""
    block = Block(alpha, 2.0)
    ratio = block.kept_by_sticking()
    total, spin = mpf(0), mpf(omega)
    while spin > mpf("1e-5"):
        total += block.swing(spin)
        spin *= ratio
    # Small swings: 2ω/(p² sin α) (1 + x/3 cot α), x = ω²/(2 p² sin α)·2, and smaller.
    small = block.pull * mp.sin(block.alpha)
    total += 2 * spin / small / (1 - ratio)
    found = run(block, omega, law, model="full")
    assert found.outcome == "rest"
    close(found.time, total)
    assert max(abs(found.q)) <= 1e-14


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_rocking_of_the_local_model_is_a_geometric_series(law):
    """Constant deceleration p² sin α: swings of 2ω/(p² sin α), times the ratio from swing to swing."""
    block, omega = Block(0.4, 2.0), 0.5
    first = 2 * mpf(omega) / (block.pull * mp.sin(block.alpha))
    ratio = block.kept_by_sticking()
    found = run(block, omega, law, model="local")
    assert found.outcome == "rest"
    close(found.impacts["time"][0], first, rel=1e-15)
    close(found.time, first / (1 - ratio), rel=1e-12)


@pytest.mark.parametrize(("alpha", "friction"), [(0.15, 0.3), (0.3, 0.4), (0.5, 0.5)])
@pytest.mark.parametrize("model", ["full", "local"])
def test_a_smooth_impact_takes_more_of_the_rotation(model, alpha, friction):
    """Newton's law without friction: the impulse is vertical, the new corner slides with the remaining horizontal velocity,
    and friction stops it later."""
    block, omega = Block(alpha, friction), 0.25
    found = run(block, omega, "newton", model=model, time_limit=3.0)
    ratio = block.kept_by_slipping()
    impact = found.impacts[0]
    assert impact["index"] == 1
    close(kept(impact), ratio)
    swing = (
        block.swing(mpf(omega))
        if model == "full"
        else 2 * mpf(omega) / (block.pull * mp.sin(block.alpha))
    )
    close(impact["time"], swing)
    slide = next(p for p in found.phases if p.start >= impact["time"])
    assert slide.mode == "SR"
    _, qdot = found.at(slide.start)
    close(-qdot[2], ratio * omega)
    close(qdot[0] + qdot[2] * float(block.height), block.height * omega * (1 - ratio))


@pytest.mark.parametrize("model", ["full", "local"])
def test_a_wider_block_does_not_rock_without_friction(model):
    """ρ < B: the vertical impulse would press the old corner into the floor. Both stop at one instant, and the block slides
    with its horizontal velocity, with the resultant force between its corners: μH < B."""
    block, omega = Block(0.7, 0.7), 0.25
    assert block.kept_by_slipping() < 0 < block.kept_by_sticking()
    found = run(block, omega, "newton", model=model)
    assert found.outcome == "rest"
    zeno = found.zeno_points[-1]
    assert (zeno.kind, zeno.method) == ("2-zeno", "chatter")
    assert zeno.qdot[1:] == pytest.approx([0, 0], abs=1e-14)
    close(zeno.qdot[0], block.height * omega)
    assert [p.mode for p in found.phases[-2:]] == ["RR", "FF"]
    close(found.time - zeno.time, block.height * omega / (mpf(0.7) * mpf(G)))


@pytest.mark.parametrize("law", FRICTION_LAWS)
@pytest.mark.parametrize("model", ["full", "local"])
def test_a_flat_block_stops_when_its_other_corner_lands(law, model):
    """sin² α > 2/3: even a sticking corner cannot keep the old one from being pressed down."""
    block, omega = Block(1.05, 5.0), 0.25
    assert block.kept_by_sticking() < 0
    found = run(block, omega, law, model=model)
    assert found.outcome == "rest"
    swing = (
        block.swing(mpf(omega))
        if model == "full"
        else 2 * mpf(omega) / (block.pull * mp.sin(block.alpha))
    )
    close(found.time, swing)
    assert max(abs(found.q)) <= 1e-14


@cache
def time_to_rest(alpha, friction, omega):
    """Sum of all swings; the small ones last T = 2ω/(p² sin α), a geometric series."""
    block = Block(alpha, friction)
    kept, time, spin = block.kept_by_sticking(), mpf(0), mpf(omega)
    with mp.workdps(40):
        while spin > mpf(10) ** -18:
            time, spin = time + block.swing(spin), spin * kept
        return time + 2 * spin / (block.pull * mp.sin(block.alpha)) / (1 - kept)


@pytest.mark.parametrize("law", FRICTION_LAWS)
@pytest.mark.parametrize(("alpha", "omega"), [(0.3, 0.4), (0.7, 1.5)])
def test_a_block_that_rocks_comes_to_rest_in_a_sum_of_swings(law, alpha, omega):
    """Swings are summed from the first few on."""
    friction = 2.0
    block = Block(alpha, friction)
    found = run(block, omega, law, model="full", record=True)
    rest = found.zeno_points[-1]
    assert (found.outcome, rest.method) == ("rest", "nested")
    assert rest.contacts == (1, 2)
    exact = time_to_rest(alpha, friction, omega)
    close(found.time, exact, rel=4e-15)
    assert abs(found.time - float(exact)) <= 2 * rest.time_error
    # The state within the sum is computed swing by swing.
    summed = found.phases[-2]
    assert summed.end == rest.time
    last = summed.end - summed.start
    late = run(block, omega, law, model="full", record=True, time=8.0)
    # With the steep block a swing keeps a seventh of the speed: there are no more swings than a sum needs.
    assert last / rest.time > (0.5 if alpha < 0.5 else 1e-9)
    for share in (0.1, 0.5, 0.9, 0.99):
        t = summed.start + share * last
        stopped = run(block, omega, law, model="full", time_limit=t)
        q, qdot = found.at(t)[:2]
        assert q == pytest.approx(stopped.q, abs=1e-15)
        assert qdot == pytest.approx(stopped.qdot, abs=1e-13)
        assert late.at(8 + t)[0] == pytest.approx(stopped.q, abs=1e-15)


@pytest.mark.parametrize("restitution", [0.0, 0.2])
def test_rounds_of_two_engines_end_at_the_same_time(restitution):
    """Rocking with frictionless impacts, with a foot that slides between them: with a separate line for each contact the
    bounces have closed sums, on shared terrain they are simulated one by one."""
    block = Block(0.3, 1.0)
    line, shared = [
        sf.Posture(
            mass=block.posture.mass,
            gyration_radius=block.posture.gyration_radius,
            center_of_mass=block.posture.center_of_mass,
            contacts=block.posture.contacts,
            restitution=restitution,
            gravity=G,
            terrain=terrain,
        )
        for terrain in (None, [(-9.0, 0.0), (9.0, 0.0)])
    ]
    start = block.upright(0.4)
    one, other = [
        sf.simulate(posture, *start, model="full", simultaneous="newton")
        for posture in (line, shared)
    ]
    for found in (one, other):
        assert (found.outcome, found.zeno_points[-1].method) == ("rest", "nested")
    assert one.time == pytest.approx(other.time, rel=2e-14)
    # Speeds of contacts on shared terrain have the rounding error of the velocity of the whole body.
    assert one.q == pytest.approx(other.q, abs=1e-13)

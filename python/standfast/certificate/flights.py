"""From a corner to the next Zeno point: impacts without friction, until one contact or both come to rest.

A corner: contact i rests or slides on its ground, contact j lands with speed y. With z along which both slide, zᵀMz = 1, and the gap rates u,

    q̇ = s z + M⁻¹NᵀD⁻¹u     v_t,i = α_i s + Σ_j β_ij u_j     ξ = v_t,i/α_i = s − (β_ij/α_i) y

Impacts do not change s, so that what follows depends on ξ and y by its size and by ξ/y only.
"""

from dataclasses import dataclass
from functools import cached_property

from .intervals import ONE, UNIT, ZERO, Interval, known, require, solve
from .scene import Body
from .tails import Tails, fall, falls, landing, never_lands, not_below_zero
from .words import Pair

#: Largest number of impacts of one flight.
IMPACTS = 1024
#: Halvings of the share of the energy at one contact, in the search for a bound of the time.
SHARES = 60


@dataclass(frozen=True)
class Arc:
    """Accelerations while one contact, or both, stay on the ground: of ξ (or s), and of the gap of the other contact."""

    along: Interval
    normal: Interval


@dataclass(frozen=True)
class Flight:
    """From a corner with y = 1: contact `kept` comes to rest after t, the other one has gap h and rate u; `kept` None: both rest;
    `away`: neither lands again."""

    kept: int | None
    h: Interval
    u: Interval
    t: Interval
    away: bool = False


@dataclass(frozen=True)
class Lands:
    """The slide after a corner with y = 1 may end with a landing: its duration, and B and K of ξ' = ξ + B y, y' = K y. `never`: the other
    contact may also stay in the air."""

    t: Interval
    bend: Interval
    factor: Interval
    never: bool


@dataclass(frozen=True)
class Course:
    """What may follow the corners at a contact: the flight, and, for y = 1, the slide that begins at ξ + shift, for each sign of that: None if
    the other contact does not land during the slide."""

    flight: Flight
    shift: Interval
    lands: dict[int, Lands | None]


@dataclass(frozen=True)
class Energy:
    """E = ½u·D⁻¹u + λ·h never rises. `settles` √(2E) bounds the time until one contact rests."""

    inverse: list[list[Interval]]
    weights: list[Interval]
    settles: Interval


class Flights:
    """The flights of a body on two contacts, and the slides and rolls after them."""

    def __init__(self, body: Body) -> None:
        require(len(body.feet) == 2, "the body does not stand on two contacts")
        self.body: Body = body
        self.pair: Pair = Pair(body)
        self.g: list[Interval] = [body.pull(0), body.pull(1)]
        self.e: list[Interval] = [foot.restitution for foot in body.feet]
        self.psi: list[Interval] = self.pair.psi
        self.alpha: list[Interval] = self.pair.alpha
        nn = self.pair.coupling
        self.nn = nn
        self.tn: list[list[Interval]] = [
            [body.couple(one.tangent, two.normal) for two in body.feet]
            for one in body.feet
        ]
        self.tt: list[Interval] = [
            body.couple(foot.tangent, foot.tangent) for foot in body.feet
        ]
        self.down: list[Interval] = [
            -(body.gravity * foot.tangent[1]) for foot in body.feet
        ]
        self.drift: Interval = -(body.gravity * self.pair.along[1])
        det = nn[0][0] * nn[1][1] - nn[0][1] * nn[1][0]
        self.beta: list[list[Interval]] = [
            [
                (self.tn[i][j] * nn[1 - j][1 - j] - self.tn[i][1 - j] * nn[1 - j][j])
                / det
                for j in range(2)
            ]
            for i in range(2)
        ]
        self.slides: list[dict[int, Arc | None]] = [
            {way: self.slide(k, self.pair.side(k, way)) for way in (1, -1)}
            for k in range(2)
        ]
        self.jumps: list[dict[int, Interval | None]] = [
            {way: self.jump(k, way) for way in (1, -1)} for k in range(2)
        ]
        self.starts: list[tuple[int, Arc] | None] = [
            self.from_rest(k) for k in range(2)
        ]
        self.courses: dict[int, list[Course] | str] = {}

    def leaves_alone(self, k: int) -> bool:
        """Whether gravity pulls contact k off its ground: it has no motion there while the other one is in the air."""
        return self.g[k].hi < 0

    def slide(self, k: int, side: int) -> Arc | None:
        """Contact k slides in direction σ, the other one is in the air; None unless it is pressed onto its ground and does not jam."""
        m, body = 1 - k, self.body
        if self.g[k].lo < 0 or body.stiffness(k, side).lo <= 0:
            return None
        force = self.g[k] / body.stiffness(k, side)
        column = body.rubbing(k, side)
        pull = self.down[k] + force * body.couple(body.feet[k].tangent, column)
        lift = force * body.couple(body.feet[m].normal, column) - self.g[m]
        return Arc(pull / self.alpha[k], lift)

    def jump(self, k: int, way: int) -> Interval | None:
        """Contact k jams while it slides with this sign of ξ, the other one in the air, and the plastic impact that stops it ends the jam: the
        change of the gap rate of the other contact per unit ξ. None if contact k does not certainly jam, or if no impact ends a jam.

        The impulse P on contact k, tangential and normal, has W P = −(v_t, 0), W = ((T T, T N), (T N, N N)), and v_t = α ξ."""
        if not (self.body.resolves_jams and self.body.jams(k, self.pair.side(k, way))):
            return None
        m = 1 - k
        tangential, normal = solve(
            [[self.tt[k], self.tn[k][k]], [self.tn[k][k], self.nn[k][k]]],
            [-self.alpha[k], ZERO],
        )
        return tangential * self.tn[k][m] + normal * self.nn[m][k]

    def from_rest(self, k: int) -> tuple[int, Arc] | None:
        """The motion of contact k from rest, the other one in the air: the sign of its ξ, 0 if it stays, and its accelerations. None unless
        exactly one is certain."""
        if self.g[k].lo < 0:
            return None
        m = 1 - k
        normal, tangential = solve(
            [[self.nn[k][k], self.tn[k][k]], [self.tn[k][k], self.tt[k]]],
            [self.g[k], -self.down[k]],
        )
        most = self.body.feet[k].friction * normal
        sides = [most - tangential, most + tangential]
        found = []
        if all(part.lo > 0 for part in sides):
            lift = normal * self.nn[m][k] + tangential * self.tn[k][m] - self.g[m]
            found.append((0, Arc(ZERO, lift)))
        elif not any(part.hi < 0 for part in sides):
            return None
        for way in (1, -1):
            arc = self.slides[k][way]
            stiffness = self.body.stiffness(k, self.pair.side(k, way))
            if arc is None and stiffness.hi < 0 < self.g[k].lo:
                continue  # its normal force would be negative
            if arc is None or (sign := arc.along.times(way).sign()) is None:
                return None
            if sign == 1:
                found.append((way, arc))
        return found[0] if len(found) == 1 else None

    def hit(self, u: list[Interval], i: int) -> list[Interval]:
        """Rates after an impact at i: u_i' = −e u_i, u_j' = u_j + (1+e)ψ_i u_i."""
        after = list(u)
        after[i] = self.e[i] * -u[i]
        after[1 - i] = u[1 - i] + (ONE + self.e[i]) * self.psi[i] * u[i]
        return after

    def hit_line(self, u: list[Interval], a: int) -> list[Interval]:
        """Rates after an impact at a, with both contacts on the ground, and of the contacts between them that approach, by Newton's law for all
        of them: ξ = u⁺ + eu⁻ ≥ 0 ⊥ P ≥ 0, which is affine on the line.

        Only a and p, the one nearest to the other contact z that approaches, may have impulses: only a if D_pa s ≥ D_aa q, only p if D_pa q ≥ D_pp s,
        with the speeds s of a and q of p, and both otherwise: then ξ = 0 on the whole line."""
        z, one = 1 - a, ONE
        sign = self.psi[a].sign()
        require(
            sign is not None or not self.body.between, "the sign of ψ is not certain"
        )
        shares = [w if z == 0 else one - w for w in self.body.between]
        for w in sorted(shares, key=lambda share: share.lo) if sign == 1 else ():
            q = -((one - w) * u[z] + w * u[a])
            require(q.sign() is not None, "whether a contact approaches is not certain")
            if q.sign() == 1:
                break
        else:
            return self.hit(u, a)
        v, nn = one - w, self.nn
        pa, pz = v * nn[z][a] + w * nn[a][a], v * nn[z][z] + w * nn[z][a]
        pp = v * pz + w * pa
        of_a, of_p = (nn[a][a] * q + pa * u[a]).sign(), (-pp * u[a] - pa * q).sign()
        require(
            of_a is not None and of_p is not None,
            "which contacts are hit is not certain",
        )
        after = list(u)
        if of_a != 1:
            return self.hit(u, a)
        if of_p != 1:
            impulse = (one + self.e[a]) * q / pp
            after[a], after[z] = u[a] + pa * impulse, u[z] + pz * impulse
        else:
            after[a], after[z] = -(self.e[a] * u[a]), -(self.e[z] * u[z])
        return after

    def chatters(self) -> bool:
        """Whether the impacts of two closed contacts alternate for ever: ψ > 0 and Goyal's bound."""
        sign = self.psi[0].sign()
        require(sign is not None, "the sign of ψ is not certain")
        if sign != 1 or self.body.between:
            return False
        p = [(ONE + self.e[i]) * self.psi[i] for i in range(2)]
        room = p[0] * p[1] - (self.e[0].sqrt() + self.e[1].sqrt()).square()
        require(
            room.sign() is not None, "whether impacts alternate for ever is not certain"
        )
        return room.lo >= 0

    @cached_property
    def energy(self) -> Energy | None:
        """None unless λ > 0, g > 0 and a bound of the time is known.

        Impacts in a row at one contact are a block. Let y be the share of E in the contact j of a block, E_j = ½u_j²/D_jj, when it starts. The
        block lasts at most T √E, T = max_j 2√(2D_jj m_j)/(g_j(1 − e_j)) with E_j ≤ m_j E, and leaves at most (1 − (1 − e²)y) E. If y < y_0, then the
        share is at most 2y_0 after it, and the next block, at the other contact, has y ≥ Y(2y_0)² ≥ y_0 [theory page, *Amplification*]. So E falls by
        q² = 1 − (1 − e²)y_0 at least over two blocks, and the time is at most T √E (1 + 2/(1 − q))."""
        det = self.nn[0][0] * self.nn[1][1] - self.nn[0][1] * self.nn[1][0]
        weights = self.pair.weights
        alike = self.e[0].lo == self.e[1].lo and self.e[0].hi == self.e[1].hi
        if min(x.lo for x in [*weights, *self.g]) <= 0 or not (
            alike or self.psi[0].lo >= 0
        ):
            return None
        ratios = [self.g[i] / (self.nn[i][i] * weights[i]) for i in range(2)]
        most = Interval(*[max(UNIT, *(r.hi for r in ratios))] * 2)
        kappa = Interval(*[max(UNIT, *((ONE / r).hi for r in ratios))] * 2)
        e = Interval(*[max(e.hi for e in self.e)] * 2)
        square = self.psi[0] * self.psi[1]
        psi = Interval(0, max(square.hi, 0)).sqrt()
        share = ONE
        for _ in range(SHARES):
            share = share.half()
            twice = share.times(2)
            left = (ONE - square) * (ONE - kappa * twice)
            if left.lo > 0 and (left.sqrt() - psi * twice.sqrt()).lo >= share.sqrt().hi:
                break
        else:
            return None
        q = max((ONE - (ONE - e.square()) * share).sqrt().hi, e.hi)
        longest = max(
            (
                (self.nn[j][j] * most.times(2)).sqrt().times(2)
                / (self.g[j] * (ONE - self.e[j]))
            ).hi
            for j in range(2)
        )
        settles = Interval(longest, longest) * (
            ONE + ONE.times(2) / (ONE - Interval(q, q))
        )
        inverse = [
            [self.nn[1][1] / det, -self.nn[0][1] / det],
            [-self.nn[1][0] / det, self.nn[0][0] / det],
        ]
        return Energy(inverse, weights, settles)

    def flight(self, j: int) -> list[Flight]:
        """From a corner at j with y = 1, the other contact on its ground: all flights that may follow; none if the other contact does not stay."""
        if self.leaves_alone(1 - j):
            return []
        if self.chatters():
            return [Flight(None, ZERO, ZERO, ZERO)]
        u, last = [ZERO, ZERO], j
        u[j] = -ONE
        for _ in range(IMPACTS):
            u = self.hit_line(u, last)
            sign = u[1 - last].sign()
            require(sign is not None, "the order of impacts is not certain")
            if sign != -1:
                return self.fly(last, u)
            last = 1 - last
        raise ValueError(f"more than {IMPACTS} impacts at one instant")

    def fly(self, a: int, u: list[Interval]) -> list[Flight]:
        """From zero gaps, after an impact at a. A flight whose course is not certain to its end is cut where E is least."""
        cut = Cut(self.energy)
        try:
            return [self.follow_flight(a, u, cut)]
        except ValueError:
            if cut.energy is None or cut.least is None:
                raise
            return cut.flights(cut.energy)

    def follow_flight(self, a: int, u: list[Interval], cut: "Cut") -> Flight:
        """From zero gaps, after an impact at a. Speeds are in units of u_a after the last impact."""
        h, t, size = [ZERO, ZERO], ZERO, ONE
        tails = Tails(self.g, self.e, self.psi)
        for _ in range(IMPACTS):
            cut.take(h, u, size, t)
            b = 1 - a
            for kept, rests in (
                (a, u[a].sign() == 0),
                (b, h[b].sign() == 0 and u[b].sign() == 0),
            ):
                if rests and not self.leaves_alone(kept):
                    require(self.g[kept].lo >= 0, "the sign of g is not certain")
                    m = 1 - kept
                    return Flight(kept, h[m] * size.square(), u[m] * size, t)
            if u[a].lo > 0:
                size, shape = size * u[a], (u[b] / u[a], h[b] / u[a].square())
                u[a], (u[b], h[b]) = ONE, tails.narrowed(a, shape)
            if (last := self.bounces(a, h[b], u)) is not None:
                gap, rate, rest = last
                return Flight(a, gap * size.square(), rate * size, t + rest * size)
            tail = self.clatters(a, h[b], u)
            if tail is not None and 0 < (tail * size).hi <= t.hi >> 39:
                return Flight(None, ZERO, ZERO, t + Interval(0, (tail * size).hi))
            if (tail := tails.after(a, u[b], h[b])) is not None:
                return Flight(None, ZERO, ZERO, t + tail * size)
            own = self.g[a].sign()
            require(own is not None, "the sign of g is not certain")
            again = u[a].times(2) / self.g[a] if own == 1 else None
            lands = landing(h[b], u[b], -self.g[b])
            require(
                lands is not None or never_lands(h[b], u[b], -self.g[b]),
                "whether a contact lands is not certain",
            )
            if again is None:
                if lands is None:
                    return Flight(None, ZERO, ZERO, ZERO, away=True)
                next_hit, dt = b, lands
            elif lands is None:
                next_hit, dt = a, again
            else:
                order = (lands - again).sign()
                require(order in (1, -1), "the order of impacts is not certain")
                next_hit, dt = (b, lands) if order == -1 else (a, again)
            other = 1 - next_hit
            left = h[other] + u[other] * dt - (self.g[other] * dt.square()).half()
            rates = [ZERO, ZERO]
            rates[next_hit] = -u[a] if next_hit == a else -fall(h[b], u[b], -self.g[b])
            rates[other] = u[other] - self.g[other] * dt
            u = self.hit(rates, next_hit)
            h = [ZERO, ZERO]
            h[other] = not_below_zero(left, "a gap")
            t, a = t + dt * size, next_hit
        raise ValueError(f"a flight of more than {IMPACTS} impacts")

    def bounces(
        self, a: int, h: Interval, u: list[Interval]
    ) -> tuple[Interval, Interval, Interval] | None:
        """All bounces at a, if contact b is certainly above its ground until they end: gap and rate of b then, and the duration
        t = 2u_a/(g_a(1−e)). With p = y-linear and q = quadratic part, the gaps of b at the impacts are h + p y − q y², 0 < y < 1, if ψ < 0."""
        b, e, loss = 1 - a, self.e[a], ONE - self.e[a]
        if self.g[a].lo <= 0:
            return None
        t = u[a].times(2) / (self.g[a] * loss)

        def end(g_b: Interval) -> Interval:
            return h + t * (u[b] - (t * (g_b + e * self.psi[a] * self.g[a])).half())

        g_b = Interval(max(self.g[b].lo, 0), max(self.g[b].hi, 0))
        if end(g_b).lo <= 0:
            return None
        if self.psi[a].lo < 0:
            lift = (ONE + e) * self.psi[a] * u[a] * t / loss
            p = u[b] * t + lift * loss / (ONE + e)
            q = (g_b * t.square()).half() + lift / (ONE + e)
            least = p.square() + (q * h).times(4)
            if not (q.lo >= 0 or p.lo >= 0 or least.hi < 0):
                return None
        rate = u[b] - self.g[b] * t - (ONE + e) * self.psi[a] * u[a] / loss
        return end(self.g[b]), rate, t

    def clatters(self, a: int, h: Interval, u: list[Interval]) -> Interval | None:
        """A bound of the time until both contacts rest, by the certificate of clattering for e_1 = e_2 = e [theory page, *Zeno points*]."""
        b, e = 1 - a, self.e[0]
        equal = self.e[0].lo == self.e[1].lo and self.e[0].hi == self.e[1].hi
        if not (equal and e.lo > 0 and self.g[0].lo > 0 and self.g[1].lo > 0):
            return None
        if not (self.psi[0].lo > 0 and u[b].hi < 0 and u[a].lo > 0):
            return None
        p = (ONE + e) * (self.psi[0] * self.psi[1]).sqrt()
        root = p.square() - e.times(4)
        if root.lo < 0:
            return None
        large = (p + root.sqrt()).half()
        small = e / large
        scale = (self.psi[a] / self.psi[b]).sqrt()
        ratio = scale * u[a] / -u[b]
        if ratio.hi >= large.lo:
            return None
        top = max(ratio.hi, small.hi)
        most = Interval(top, top)
        kappa = most * most.square() / e.square()
        tau = landing(h, u[b], -self.g[b])
        if tau is None:
            return None
        eta = self.g[a] * tau / u[a].times(2)
        pull = (self.psi[b] / self.psi[a]).sqrt() * self.g[b] / self.g[a]
        shrinks = (pull * kappa * eta * (ONE - eta)).hi < UNIT
        if not (kappa.hi < UNIT and eta.hi < UNIT and shrinks):
            return None
        return h / (-u[b] - scale * u[a] / large)

    def course(self, j: int) -> list[Course]:
        """What may follow a corner at j; nothing if there is no such corner, because the other contact does not stay on its ground."""
        if j not in self.courses:
            try:
                self.courses[j] = self.follow(j)
            except ValueError as error:
                self.courses[j] = str(error)
        found = self.courses[j]
        if isinstance(found, str):
            raise ValueError(found)
        return found

    def follow(self, j: int) -> list[Course]:
        return [self.course_of(j, flight) for flight in self.flight(j)]

    def course_of(self, j: int, flight: Flight) -> Course:
        shift = self.beta[1 - j][j] / self.alpha[1 - j] + self.drift * flight.t
        k = flight.kept
        if k is None:
            return Course(flight, shift, {1: None, -1: None})
        shift = shift + self.beta[k][1 - k] / self.alpha[k] * flight.u
        lands: dict[int, Lands | None] = {}
        for side in (1, -1):
            arc = self.slides[k][side]
            found = None if arc is None else falls(flight.h, flight.u, arc.normal)
            lands[side] = None
            if arc is not None and found is not None and found.t is not None:
                bend = shift + arc.along * found.t
                lands[side] = Lands(found.t, bend, found.speed, found.never)
        return Course(flight, shift, lands)


@dataclass
class Cut:
    """Where a flight is best cut: 2E and the time there."""

    energy: Energy | None
    least: Interval | None = None
    time: Interval = ZERO

    def take(
        self, h: list[Interval], u: list[Interval], size: Interval, t: Interval
    ) -> None:
        if self.energy is None:
            return
        [[a, b], [_, c]] = self.energy.inverse
        kinetic = a * u[0].square() + (b * u[0] * u[1]).times(2) + c * u[1].square()
        heights = self.energy.weights[0] * h[0] + self.energy.weights[1] * h[1]
        twice = (kinetic + heights.times(2)) * size.square()
        if self.least is None or twice.hi < self.least.hi:
            self.least, self.time = Interval(0, max(twice.hi, 0)), t

    def flights(self, energy: Energy) -> list[Flight]:
        """All ends: contact k rests, and u² (D⁻¹)_mm + 2 λ_m h ≤ 2E of the other one; or both rest."""
        left = known(self.least, "a flight is cut before it starts")
        rest = (energy.settles * left.sqrt()).hi
        t = self.time + Interval(0, rest)
        found = [Flight(None, ZERO, ZERO, t)]
        for k in range(2):
            m = 1 - k
            rate = (left / energy.inverse[m][m]).sqrt().hi
            gap = (left / energy.weights[m].times(2)).hi
            found.append(Flight(k, Interval(0, gap), Interval(-rate, rate), t))
        return found

//! Flights of a body with any number of contacts, and the state at any time in a span of the record.

use nalgebra::Vector2;

use crate::body::contact::ContactValues;
use crate::body::posture::Posture;
use crate::body::terrain::Ground;
use crate::collisions::log::{Center, Spin};
use crate::flight::{GapArc, parabola_touchdown};
use crate::math::turn::{Turn, turned};
use crate::sustained::{BodyState, ContactState, Rounding};
use crate::tolerance::{LANDS_TOGETHER, LANDS_TOGETHER_SPEED, OVER_VERTEX, PULL_ROUNDINGS, TOUCH};

/// Number of ends of pieces of terrain, of all points together, that are passed in one flight; if there are fewer, each is an event. It
/// changes the cost, and rounding errors.
const PASSED: usize = 4;

/// Time to the next zero of an arc.
pub(super) fn next(arc: &GapArc) -> Option<f64> {
    if arc.omega == 0.0 {
        let t = parabola_touchdown(arc.h, arc.u, arc.g);
        return (t < f64::INFINITY).then_some(t);
    }
    arc.touchdown()
}

/// Centre of mass and rotation after a flight of `dt` with this acceleration of free fall.
pub(crate) fn flown(
    (mut center, mut spin): (Center, Spin),
    fall: Vector2<f64>,
    dt: f64,
) -> (Center, Spin) {
    spin.theta += spin.omega * dt;
    center.fall(fall, dt);
    (center, spin)
}

impl ContactState {
    /// Returns true if it lands together with `first`: its gap is closing, and is below its rounding error plus the distance by which it
    /// closes within δh/|u|, the uncertainty of the instant at which `first` lands.
    pub(crate) fn lands_with(&self, first: &Self) -> bool {
        let doubt = first.rounding.gap * (self.u / first.u).abs().min(LANDS_TOGETHER_SPEED);
        let known = self.rounding.gap + doubt;
        self.u < 0.0 && self.h <= LANDS_TOGETHER * known && self.h < f64::INFINITY
    }
}

impl ContactState {
    /// The point rises out of the terrain that it came under from the side.
    pub(crate) fn surfaces(&mut self) {
        (self.h, self.depth, self.u) = (0.0, 0.0, self.u.max(0.0));
    }
}

impl Rounding {
    /// At the start, from the size of the terms of a gap and of its rate.
    pub(crate) fn new(gap: f64, rate: f64) -> Self {
        Self { gap: f64::EPSILON * gap, rate: f64::EPSILON * rate }
    }

    /// After an arc of `dt` from a gap `h` on. `gap`, `rate`: sums of the sizes of the terms of the gap and its rate.
    pub(crate) fn after(self, dt: f64, h: f64, gap: f64, rate: f64) -> Self {
        if h == f64::INFINITY {
            return self; // no terrain below
        }
        let before = if h == 0.0 { 0.0 } else { self.gap };
        let own = Self::new(gap, rate);
        Self { gap: before + self.rate * dt + own.gap, rate: self.rate + own.rate }
    }
}

impl BodyState {
    /// Acceleration of the free body into the terrain of a contact, without rotation: −n·(acceleration of free fall).
    pub(crate) fn pull(&self, i: usize) -> f64 {
        let p = &self.points[i];
        -self.fall.dot(&p.normal) + self.coriolis(i)
    }

    /// Effective gravity of a point, in m/s²: zero where it is the rounding error of its terms, as that of a contact at a vertical wall is in a
    /// turned world.
    pub(crate) fn known_pull(&self, i: usize) -> f64 {
        let (arc, square) = (self.arc(i), self.spin.omega * self.spin.omega);
        let pull = arc.effective_gravity();
        let terms = self.gravity + arc.c.abs() * square + self.coriolis(i).abs();
        if pull.abs() <= PULL_ROUNDINGS * f64::EPSILON * terms { 0.0 } else { pull }
    }

    /// Distance of a point from the separating line at the start (0) or the end (1) of its piece of terrain, as an arc.
    pub(crate) fn side(&self, i: usize, side: usize) -> GapArc {
        let (p, spin) = (&self.points[i], self.spin.omega);
        if self.side_contact(i).is_some() {
            // Only its distance and rate: ḃ = −v_t.
            let way = self.slip(i) * if side == 0 { -1.0 } else { 1.0 };
            return GapArc { h: p.place.sides[side], u: way, g: 0.0, b: 0.0, c: 0.0, omega: 0.0 };
        }
        let axis = p.place.across[side] * if side == 0 { 1.0 } else { -1.0 };
        let arm = p.arm();
        let lever = axis.dot(&Vector2::new(-arm.y, arm.x));
        let u = axis.dot(&self.center.v) + lever * spin;
        let (b, c, omega) = (lever, axis.dot(&arm), spin);
        GapArc { h: p.place.sides[side], u, g: -self.fall.dot(&axis), b, c, omega }
    }

    /// When a point in flight comes to an end of the terrain under it, and to which end. If this is later than `limit` (s), there may be no
    /// answer.
    #[inline]
    pub(crate) fn crossing(&self, i: usize, limit: f64) -> Option<(f64, usize)> {
        // A corner of the ground that passes the end of a side is left alone there: it no longer lands on this side.
        if self.points[i].place.sides == [f64::INFINITY; 2] || self.side_contact(i).is_some() {
            return None;
        }
        self.crossing_of_ends(i, limit)
    }

    #[inline(never)]
    fn crossing_of_ends(&self, i: usize, limit: f64) -> Option<(f64, usize)> {
        let mut first: Option<(f64, usize)> = None;
        for side in 0..2 {
            if self.points[i].place.sides[side] == f64::INFINITY {
                continue;
            }
            let mut arc = self.side(i, side);
            // At the end itself a rounding error would move the point to and fro between two pieces, each of which has it over
            // the other.
            let size = libm::hypot(arc.b, arc.c);
            let along = self.points[i].place.across[side].dot(&self.center.v);
            let terms = along.abs() + size * self.spin.omega.abs();
            if arc.h <= f64::EPSILON * size && arc.u.abs() <= OVER_VERTEX * f64::EPSILON * terms {
                (arc.h, arc.u) = (0.0, 0.0);
            }
            // h = u t − (g + c ω²) t²/2 − b (ωt)³/6 + …
            let (pull, square) = (arc.effective_gravity(), arc.omega * arc.omega);
            let outwards = if arc.u != 0.0 {
                arc.u < 0.0
            } else if pull.abs() > f64::EPSILON * (arc.g.abs() + size * square) {
                pull > 0.0
            } else {
                arc.b * arc.omega > 0.0
            };
            let t = if arc.h == 0.0 && outwards {
                Some(0.0)
            } else if arc.stays_open(first.map_or(limit, |(earlier, _)| earlier)) {
                None
            } else {
                next(&arc)
            };
            if let Some(t) = t
                && first.is_none_or(|(earlier, _)| t < earlier)
            {
                first = Some((t, side));
            }
        }
        first
    }

    /// The ground of a point in flight over a polyline without walls.
    fn polyline<'a>(&self, i: usize, posture: &'a Posture) -> Option<&'a Ground> {
        let p = &self.points[i];
        let flies = self.side_contact(i).is_none() && p.depth == 0.0 && p.h < f64::INFINITY;
        let ground = posture.ground(p.place.contact).filter(|_| flies)?;
        (ground.is_polyline && !ground.has_walls && ground.raised == 0.0).then_some(ground)
    }

    /// A time up to `limit` (s) until which no point meets its ground, also beyond the ends of the piece under it: at the earliest it does when
    /// it comes down to the line of this piece, raised to the highest vertex within its reach. `None` if the points pass over few
    /// ends until then, or if this line is above a point.
    pub(crate) fn free(&self, posture: &Posture, limit: f64) -> Option<f64> {
        if limit == f64::INFINITY {
            return None;
        }
        let over_ends = |i: &usize| self.points[*i].place.sides != [f64::INFINITY; 2];
        let own =
            (0..self.points.len()).filter(|i| over_ends(i) && self.side_contact(*i).is_none());
        let passes = |t: f64| {
            let (center, turn) = (self.place_flown(t).0, Turn::by(self.spin.omega * t));
            let passed = own.clone().map(|i| {
                let at = posture.center() + center.r + turned(&turn, self.points[i].arm());
                let find = |ground: &Ground| ground.find(&at).abs_diff(self.points[i].place.piece);
                self.polyline(i, posture).map_or(0, find)
            });
            passed.sum::<usize>() >= PASSED
        };
        if !passes(limit) {
            return None;
        }
        let mut until = limit;
        for i in own.clone() {
            let (p, ground) = (&self.points[i], self.polyline(i, posture)?);
            let (piece, exists) = ground.nearest(p.place.piece);
            if !exists {
                return None;
            }
            let [speed, pull] = [self.center.v.x, self.fall.x].map(f64::abs);
            let turn = (self.spin.omega.abs() * until).min(2.0);
            let way = until * (speed + 0.5 * pull * until) + p.arm().norm() * turn;
            let x = self.position(i, posture).x;
            let rise = ground.rise(piece, [x - way, x + way], TOUCH * posture.size());
            let arc = GapArc { h: p.h - rise, ..self.arc(i) };
            if rise > 0.0 && arc.h <= 0.0 {
                return None;
            }
            if rise > 0.0 && !arc.stays_open(until) {
                until = next(&arc).map_or(until, |t| t.min(until));
            }
        }
        (until == limit || passes(until)).then_some(until)
    }

    /// Puts the points that have flown over ends of the pieces under them on the pieces that are under them now.
    pub(crate) fn look_below(&mut self, posture: &Posture) {
        for i in 0..self.points.len() {
            let old = self.points[i];
            let Some(ground) = self.polyline(i, posture) else { continue };
            let (at, arm, error) =
                (self.position(i, posture), old.arm(), self.position_error(i, posture));
            let over = ground.nearest(old.place.piece).0.sides(&at);
            if over.iter().all(|side| *side >= -error) {
                continue;
            }
            let velocity = old.tangent * self.along(i) + old.normal * old.u;
            let mut p = old;
            p.place = ground.place(old.place.contact, ground.find(&at), &at);
            let (piece, exists) = ground.nearest(p.place.piece);
            p.turns_to(posture, piece, &at);
            (p.b, p.c, p.held) = (p.tangent.dot(&arm), p.normal.dot(&arm), None);
            p.u = p.normal.dot(&velocity);
            p.h = if exists { piece.height(&at).max(0.0) } else { f64::INFINITY };
            let terms = self.center.r.norm() + p.b.abs() + p.c.abs() + posture.size();
            p.rounding = Rounding { gap: f64::EPSILON * terms, ..old.rounding };
            self.points[i] = p;
        }
    }

    pub(crate) fn arc(&self, i: usize) -> GapArc {
        let p = &self.points[i];
        GapArc { h: p.h, u: p.u, g: self.pull(i), b: p.b, c: p.c, omega: self.spin.omega }
    }

    /// Times to the next touchdowns of the contacts in flight. Those that are certainly later than another one may be left out, and those that
    /// land with others (`follows`).
    pub(crate) fn touchdowns(&self, follows: impl Fn(usize) -> bool) -> ContactValues<Option<f64>> {
        let n = self.points.len();
        let mut found = ContactValues::from_elem(None, n);
        // That of the lowest contact, often the one just hit, bounds the others.
        let own = (0..n).filter(|&i| !follows(i));
        let lowest = own.clone().min_by(|&i, &j| self.points[i].h.total_cmp(&self.points[j].h));
        let mut first = f64::INFINITY;
        for i in lowest.into_iter().chain(own.filter(|&i| Some(i) != lowest)) {
            let is_side = self.side_contact(i).is_some();
            if is_side || self.points[i].corner.is_some() {
                found[i] = match is_side {
                    true => self.side_touchdown(i, first),
                    false => self.touches_corner(i, first),
                };
                first = found[i].map_or(first, |t| first.min(t));
                continue;
            }
            let arc = self.arc(i);
            if !arc.stays_open(first) {
                found[i] = next(&arc);
                first = found[i].map_or(first, |t| first.min(t));
            }
        }
        found
    }

    /// When a point in flight rises out of the terrain that it came under from the side, if before `limit`, in s: its arc from
    /// below.
    #[inline]
    pub(crate) fn surfacing(&self, i: usize, limit: f64) -> Option<f64> {
        if self.points[i].depth == 0.0 {
            return None;
        }
        self.surfacing_from_below(i, limit)
    }

    #[inline(never)]
    fn surfacing_from_below(&self, i: usize, limit: f64) -> Option<f64> {
        let ContactState { depth, u, .. } = self.points[i];
        let GapArc { g, b, c, omega, .. } = self.arc(i);
        // It rises by less than (u + |ωb|) t − g t²/2 + 2|d|, which is negative from `last` on. Without gravity it rises within
        // one turn or by its mean rate.
        let (drift, arm) = (u + (omega * b).abs(), libm::hypot(b, c));
        let last = if g > 0.0 {
            (drift.max(0.0) + (drift * drift + 4.0 * g * arm).sqrt()) / g
        } else {
            let turn = if omega == 0.0 { 0.0 } else { std::f64::consts::TAU / omega.abs() };
            let mean = u - omega * b;
            turn + if mean > 0.0 { (depth + 2.0 * arm) / mean } else { turn }
        };
        let below = GapArc { h: depth, u: -u, g: -g, b: -b, c: -c, omega };
        below.touchdown_before(limit.min(last))
    }

    /// The centre of mass and the rotation.
    pub(crate) fn place(&self) -> (Center, Spin) {
        (self.center, self.spin)
    }

    /// The same after a flight of `dt`.
    pub(crate) fn place_flown(&self, dt: f64) -> (Center, Spin) {
        flown(self.place(), self.fall, dt)
    }

    /// The state after a flight of `dt`.
    pub(crate) fn flown(&self, dt: f64) -> Self {
        let mut after = self.clone();
        let turn = Turn::by(self.spin.omega * dt);
        for (i, p) in after.points.iter_mut().enumerate() {
            let (arc, was) = (self.arc(i), &self.points[i]);
            let [gap, rate] = arc.terms(dt, &turn);
            p.rounding = was.rounding.after(dt, was.h, gap, rate);
            for side in 0..2 {
                if p.place.sides[side] < f64::INFINITY {
                    p.place.sides[side] = self.side(i, side).gap_turned(dt, &turn).max(0.0);
                }
            }
            let below = GapArc { h: -was.depth, ..arc };
            if was.depth > 0.0 {
                p.depth = (-below.gap_turned(dt, &turn)).max(f64::MIN_POSITIVE);
            }
            p.h = arc.gap_turned(dt, &turn).max(0.0);
            p.u = arc.rate_turned(dt, &turn);
            (p.b, p.c) = was.turned(&turn);
        }
        (after.center, after.spin) = self.place_flown(dt);
        if !self.sides.is_empty() {
            after.fly_sides(self, dt);
        } else if self.turns() {
            after.fly_about(self, dt);
        }
        after
    }
}

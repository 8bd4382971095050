//! Pieces of terrain that a contact may hit although they do not adjoin its own piece: the walls of a channel, the roof of an overhang.
//!
//! A contact comes to the adjacent pieces by crossing the line that separates them. All other pieces are followed here, each with the
//! gap to its line: the contact hits it where the gap falls to zero between the two ends of the piece.

use nalgebra::Vector2;

use crate::body::posture::Posture;
use crate::body::terrain::{Ground, Piece, Place};
use crate::flight::{GapArc, parabola_touchdown};
use crate::math::extents::Extent;
use crate::math::roots::{ORDER, first_root};
use crate::math::series::{product, shifted};
use crate::modes::Mode;
use crate::sustained::flight::next;
use crate::sustained::{BodyState, ContactState, Rounding, Step};
use crate::tolerance::{PLACE, STRUCK_NEAR, TOUCH};

/// Largest number of crossings of the line of a piece, without a hit, that are followed.
const CROSSINGS: usize = 64;

/// The pieces of terrain within this box that are not adjacent to that of point `i`, with their numbers; none where the terrain has no walls.
fn facing<'p>(
    posture: &'p Posture,
    state: &BodyState,
    i: usize,
    limits: Extent,
) -> impl Iterator<Item = (isize, &'p Piece)> + use<'p> {
    let Place { contact, piece, across, .. } = state.points[i].place;
    let ground = posture.ground(contact).filter(|ground| ground.has_walls);
    // A point on the line that separates it from an adjacent piece is as near to that piece, unless two lines separate them.
    let separate = move |k: isize, other: &Piece| match k - piece {
        1 => other.ends[0].across != across[1],
        -1 => other.ends[1].across != across[0],
        _ => true,
    };
    // Its second point follows the piece that this one is on.
    let second = ground.and_then(|_| state.second(i)).map(|j| state.points[j].place.piece);
    let far = move |(k, other): &(isize, &Piece)| {
        *k != piece && Some(*k) != second && separate(*k, other)
    };
    let within = move |ground: &'p Ground| {
        ground.places.meeting(limits).map(|k| (k as isize, &ground.pieces[k]))
    };
    ground.into_iter().flat_map(within).filter(far)
}

/// Way of a disc, in units of its radius, after which it is looked at again while a corner is in it. It is so only where it comes from behind the
/// ground, which it then leaves or not.
const INSIDE: f64 = 1.0 / 64.0;

/// Returns true if the terrain of point `i` has walls: it faces no other pieces without.
#[inline]
fn has_walls(posture: &Posture, state: &BodyState, i: usize) -> bool {
    posture.ground(state.points[i].place.contact).is_some_and(|ground| ground.has_walls)
}

/// Returns true if a point on the line of a piece lies between its ends, up to the tolerance of touching.
fn is_between(piece: &Piece, at: &Vector2<f64>, size: f64) -> bool {
    piece.along(at).iter().all(|side| *side >= -TOUCH * size)
}

/// Whether a point at an end of a piece moves beyond it. `from_ends`: its distances along the piece from the start and from the end, in m.
/// `error`: of these, in m. `rate`: along the piece, of either unit.
fn passes_end([from, to]: [f64; 2], rate: f64, error: f64) -> bool {
    from <= error && rate < 0.0 || to <= error && rate > 0.0
}

impl BodyState {
    /// World position of point `i`, in m.
    pub(crate) fn position(&self, i: usize, posture: &Posture) -> Vector2<f64> {
        let arm = self.points[i].arm();
        Vector2::from(posture.fields().center_of_mass) + self.center.r + arm
    }

    /// The gap of point `i` to the line of a piece, as an arc. Over a corner it is that arc at this instant only.
    fn arc_over(&self, i: usize, posture: &Posture, piece: &Piece) -> GapArc {
        let (arm, spin, at) = (self.points[i].arm(), self.spin.omega, self.position(i, posture));
        let [tangent, normal] = piece.axes(&at);
        let (b, c) = (tangent.dot(&arm), normal.dot(&arm));
        GapArc {
            h: piece.height(&at),
            u: normal.dot(&self.center.v) + b * spin,
            g: -self.fall.dot(&normal),
            b,
            c,
            omega: spin,
        }
    }

    /// Point `i` over a piece of its ground, with its gap and its rate.
    fn over(&self, i: usize, posture: &Posture, piece: &Piece) -> ContactState {
        let GapArc { h, u, b, c, .. } = self.arc_over(i, posture, piece);
        let mut p = self.points[i];
        p.turns_to(posture, piece, &self.position(i, posture));
        (p.h, p.u, p.b, p.c) = (h, u, b, c);
        p
    }

    /// Returns true if the lines of all pieces that do not adjoin that of point `i` are farther away than `way`, in m.
    pub(crate) fn is_far_from_others(&self, i: usize, posture: &Posture, way: f64) -> bool {
        let limits = Extent::of([self.position(i, posture)]).grown(way + self.slack(i, posture));
        facing(posture, self, i, limits)
            .all(|(_, piece)| piece.height(&self.position(i, posture)).abs() > way)
    }

    /// More than all tolerances and rounding errors by which a point may be off a piece that it touches, in m.
    fn slack(&self, i: usize, posture: &Posture) -> f64 {
        2.0 * (self.position_error(i, posture) + TOUCH * posture.size())
    }

    /// Where point `i` may be within the time `t` (s) of a flight.
    fn whereabouts(&self, i: usize, posture: &Posture, t: f64) -> Extent {
        if !t.is_finite() {
            return Extent::PLANE;
        }
        let (center, fall) = (&self.center, self.fall);
        let at = |t: f64| center.r + center.v * t + fall * (0.5 * t * t);
        // The turning points of the parabola.
        let turns = [0, 1].map(|axis| (-center.v[axis] / fall[axis]).clamp(0.0, t));
        let [x, y] = turns.map(|turn| at(if turn.is_nan() { 0.0 } else { turn }));
        let path = [at(0.0), at(t), x, y].map(|r| posture.center() + r);
        Extent::of(path).grown(self.points[i].arm().norm() + self.slack(i, posture))
    }

    /// When a contact in flight hits a piece that does not adjoin its own, before `limit` (s), and the number of this piece.
    #[inline]
    pub(crate) fn strike(&self, i: usize, posture: &Posture, limit: f64) -> Option<(f64, isize)> {
        if !has_walls(posture, self, i) {
            return None;
        }
        self.strike_between_walls(i, posture, limit)
    }

    #[inline(never)]
    fn strike_between_walls(
        &self,
        i: usize,
        posture: &Posture,
        limit: f64,
    ) -> Option<(f64, isize)> {
        let hit = |(k, piece): (isize, &Piece)| Some((self.hit(i, posture, piece, limit)?, k));
        let others = facing(posture, self, i, self.whereabouts(i, posture, limit));
        others.filter_map(hit).min_by(|one, other| one.0.total_cmp(&other.0))
    }

    /// Rounding error of the position of point `i`, in m.
    pub(crate) fn position_error(&self, i: usize, posture: &Posture) -> f64 {
        PLACE * (self.center.r.norm() + self.points[i].arm().norm() + posture.size())
    }

    /// The end of its piece that point `i` reaches now. `comes`: whether a distance (m) with this rate (m/s) reaches zero now.
    pub(crate) fn end_reached(&self, i: usize, comes: impl Fn(f64, f64) -> bool) -> Option<usize> {
        let sides = self.points[i].place.sides;
        let reached =
            |&side: &usize| sides[side] < f64::INFINITY && comes(sides[side], self.side(i, side).u);
        [0, 1].into_iter().find(reached)
    }

    /// The piece that point `i` hits now and that does not adjoin its own piece. `comes`: as for `end_reached`.
    pub(crate) fn struck(
        &self,
        i: usize,
        posture: &Posture,
        comes: impl Fn(f64, f64) -> bool,
    ) -> Option<isize> {
        let now = |(k, piece): (isize, &Piece)| {
            let arc = self.arc_over(i, posture, piece);
            let hit = comes(arc.h, arc.u)
                && is_between(piece, &self.position(i, posture), posture.size());
            hit.then_some(k)
        };
        // What counts as now is far less than this.
        let now_reach = STRUCK_NEAR * posture.size() + self.slack(i, posture);
        let limits = Extent::of([self.position(i, posture)]).grown(now_reach);
        facing(posture, self, i, limits).find_map(now)
    }

    /// As `hit`, for a disc and a corner.
    fn hits_corner(&self, i: usize, posture: &Posture, piece: &Piece, limit: f64) -> Option<f64> {
        let is_here = |state: &Self| is_between(piece, &state.position(i, posture), posture.size());
        let (mut t, mut state) = (0.0, self.clone());
        state.points[i] = self.over(i, posture, piece);
        let error = self.position_error(i, posture);
        let p = &mut state.points[i];
        if p.h.abs() <= error {
            let ends = piece.along(&self.position(i, posture));
            if p.u < 0.0 && is_here(self) && !passes_end(ends, self.along_of(p), error) {
                return Some(0.0);
            }
            (p.h, p.u) = (0.0, p.u.max(0.0));
        }
        for _ in 0..CROSSINGS {
            let p = &state.points[i];
            // Where the disc is beside the corner, the corner may lie in it.
            let outside = p.h >= 0.0;
            let (v, turn) = (state.center.v.norm(), state.spin.omega.abs() * p.arm().norm());
            let speed = v + turn + (state.gravity * p.radius).sqrt();
            t += match outside {
                true => state.touches_corner(i, limit - t)?,
                false => INSIDE * p.radius / speed,
            };
            if !(t < limit) {
                return None;
            }
            state = self.flown(t);
            if outside && is_here(&state) {
                return Some(t);
            }
            state.points[i] = state.over(i, posture, piece);
            if outside {
                state.points[i].h = -f64::MIN_POSITIVE;
            }
        }
        None
    }

    fn hit(&self, i: usize, posture: &Posture, piece: &Piece, limit: f64) -> Option<f64> {
        if piece.corner().is_some() {
            return self.hits_corner(i, posture, piece, limit);
        }
        let (mut t, mut crossed) = (0.0, None);
        let at_once = self.arc_over(i, posture, piece);
        if at_once.h.abs() <= self.position_error(i, posture)
            && is_between(piece, &self.position(i, posture), posture.size())
        {
            let arm = self.points[i].arm();
            let v = self.center.v + Vector2::new(-arm.y, arm.x) * self.spin.omega;
            let (at, error) = (self.position(i, posture), self.position_error(i, posture));
            let passes = passes_end(piece.along(&at), piece.tangent.dot(&v), error);
            if at_once.u < 0.0 && !passes {
                return Some(0.0);
            }
            // It leaves the piece to its front, or below its line beyond its end.
            crossed = Some(at_once.u < 0.0);
        } else if at_once.h > 0.0 && at_once.stays_open(limit) {
            return None;
        }
        let mut state = self.clone();
        for _ in 0..CROSSINGS {
            let arc = state.arc_over(i, posture, piece);
            let behind = crossed.unwrap_or(arc.h < 0.0);
            let GapArc { h, u, g, b, c, omega } = arc;
            let arc =
                if behind { GapArc { h: -h, u: -u, g: -g, b: -b, c: -c, omega } } else { arc };
            // On the line that it has just crossed, the point moves away from it.
            let arc =
                if crossed.is_some() { GapArc { h: 0.0, u: arc.u.max(0.0), ..arc } } else { arc };
            if arc.stays_open(limit - t) {
                return None;
            }
            let dt = next(&arc)?;
            t += dt;
            if !(t < limit) {
                return None;
            }
            state = state.flown(dt);
            if !behind && is_between(piece, &state.position(i, posture), posture.size()) {
                return Some(t);
            }
            crossed = Some(!behind);
        }
        None
    }

    /// Places point `i`, which is off the terrain and was over the nearest piece, between separating lines.
    pub(crate) fn put_between_lines(&mut self, i: usize, posture: &Posture) {
        let (at, place) = (self.position(i, posture), self.points[i].place);
        let Some(ground) = posture.ground(place.contact).filter(|ground| ground.has_walls) else {
            return;
        };
        let k = ground.between_lines(place.piece, &at);
        if k == place.piece {
            return;
        }
        let (piece, exists) = ground.nearest(k);
        let arc = self.arc_over(i, posture, piece);
        let p = &mut self.points[i];
        p.place = ground.place(place.contact, k, &at);
        p.turns_to(posture, piece, &at);
        (p.b, p.c, p.u) = (arc.b, arc.c, arc.u);
        // On the line of a piece beyond its end it does not touch.
        (p.h, p.depth) = match (exists, arc.h > 0.0) {
            (true, true) => (arc.h, 0.0),
            (true, false) => (f64::INFINITY, (-arc.h).max(f64::MIN_POSITIVE)),
            (false, _) => (f64::INFINITY, 0.0),
        };
    }

    /// Puts point `i` on a piece that it has hit.
    pub(crate) fn put_on(&mut self, i: usize, posture: &Posture, k: isize) {
        let at = self.position(i, posture);
        let contact = self.points[i].place.contact;
        let (Some(ground), Some(piece)) = (posture.ground(contact), posture.piece(contact, k))
        else {
            return;
        };
        let arc = self.arc_over(i, posture, piece);
        let terms = self.center.r.norm() + arc.b.abs() + arc.c.abs() + posture.size();
        let speeds = self.center.v.norm() + (arc.b * self.spin.omega).abs();
        let p = &mut self.points[i];
        p.turns_to(posture, piece, &at);
        (p.b, p.c) = (arc.b, arc.c);
        (p.h, p.depth, p.u, p.held) = (0.0, 0.0, arc.u.min(0.0), None);
        p.place = ground.place(contact, k, &at);
        p.place.sides = p.place.sides.map(|side| side.max(0.0));
        p.rounding = Rounding::new(terms, speeds);
    }
}

impl Step {
    /// As [`BodyState::strike`], within the step.
    pub(crate) fn strike(
        &self,
        state: &BodyState,
        i: usize,
        posture: &Posture,
        limit: f64,
    ) -> Option<(f64, isize)> {
        let track = &self.tracks[i];
        if track.mode != Mode::Separate || track.pinned || !has_walls(posture, state, i) {
            return None;
        }
        let (at, error) = (state.position(i, posture), state.position_error(i, posture));
        let hit = |(k, piece): (isize, &Piece)| {
            if piece.corner().is_some() {
                return Some((self.hits_corner(state, i, posture, piece, limit)?, k));
            }
            let mut gap = self.way(i, state, piece.normal);
            let mut along = self.way(i, state, piece.tangent);
            (gap[0], along[0]) = (piece.height(&at), piece.along(&at)[0]);
            let length = piece.along(&at).iter().sum::<f64>();
            let slack = TOUCH * posture.size();
            let (mut t, end) = (0.0, limit / self.unit);
            let mut behind = gap[0] < 0.0;
            if gap[0].abs() <= error && along[0] >= -slack && along[0] <= length + slack {
                let passes = passes_end([along[0], length - along[0]], along[1], error);
                if gap[1] < 0.0 && !passes {
                    return Some((0.0, k));
                }
                // It leaves the piece to its front, or below its line beyond its end.
                (gap[0], behind) = (0.0, gap[1] < 0.0);
            }
            for _ in 0..CROSSINGS {
                let front = if behind { gap.map(|c| -c) } else { gap };
                let dt = if end < f64::INFINITY {
                    first_root(&front, self.order, end - t)?
                } else {
                    parabola_touchdown(front[0], front[1], -2.0 * front[2])
                };
                t += dt;
                if !(t < end) {
                    return None;
                }
                (gap, along) = (shifted(&gap, dt), shifted(&along, dt));
                if !behind && along[0] >= -slack && along[0] <= length + slack {
                    return Some((t * self.unit, k));
                }
                (gap[0], behind) = (0.0, !behind);
            }
            None
        };
        let limits = match limit < f64::INFINITY {
            true => self.whereabouts(state, i, posture, limit / self.unit),
            false => Extent::PLANE,
        };
        let others = facing(posture, state, i, limits);
        others.filter_map(hit).min_by(|one, other| one.0.total_cmp(&other.0))
    }

    /// Where point `i` may be within this time, in units.
    fn whereabouts(&self, state: &BodyState, i: usize, posture: &Posture, t: f64) -> Extent {
        let at = state.position(i, posture);
        let far = |axis: Vector2<f64>| {
            let way = self.way(i, state, axis);
            way[1..].iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * t)
        };
        let far = Vector2::new(far(Vector2::x()), far(Vector2::y()));
        Extent::of([at - far, at + far]).grown(state.slack(i, posture))
    }

    /// When a disc touches a corner within the step, before `limit` (s): (|P − V|² − R²)/(2R) is a polynomial, whose rate there is that of the
    /// gap.
    fn hits_corner(
        &self,
        state: &BodyState,
        i: usize,
        posture: &Posture,
        piece: &Piece,
        limit: f64,
    ) -> Option<f64> {
        let (at, corner, size) = (state.position(i, posture), piece.corner()?, posture.size());
        let ways = [Vector2::x(), Vector2::y()].map(|axis| self.way(i, state, axis));
        let position = |t: f64| {
            let way = ways.map(|way| way[1..].iter().rev().fold(0.0, |sum, c| (sum + c) * t));
            at + Vector2::from(way)
        };
        let p = state.over(i, posture, piece);
        let mut gap = [0.0; ORDER];
        for (axis, way) in ways.iter().enumerate() {
            let mut from = *way;
            from[0] = at[axis] - corner[axis];
            for (k, gap) in gap.iter_mut().enumerate().skip(1) {
                *gap += product(&from, &from, k) / (2.0 * p.radius);
            }
        }
        gap[0] = p.h * (1.0 + 0.5 * p.h / p.radius);
        let (mut t, end) = (0.0, limit / self.unit);
        let mut behind = gap[0] < 0.0;
        let error = state.position_error(i, posture);
        if gap[0].abs() <= error {
            if gap[1] < 0.0 && is_between(piece, &at, size) {
                let rate = state.along_of(&p);
                return (!passes_end(piece.along(&at), rate, error)).then_some(0.0);
            }
            (gap[0], behind) = (0.0, gap[1] < 0.0);
        }
        for _ in 0..CROSSINGS {
            let front = if behind { gap.map(|c| -c) } else { gap };
            // All roots of Σ c_k t^k are below 1 + max |c_k/c_n|.
            let highest = gap.iter().rev().find(|c| **c != 0.0)?;
            let last = gap.iter().map(|c| (c / highest).abs()).fold(1.0, f64::max) + 1.0;
            let dt = first_root(&front, ORDER, last.min(end - t))?;
            t += dt;
            if !(t < end) {
                return None;
            }
            if !behind && is_between(piece, &position(t), size) {
                return Some(t * self.unit);
            }
            gap = shifted(&gap, dt);
            (gap[0], behind) = (0.0, !behind);
        }
        None
    }
}

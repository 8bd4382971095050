//! Finds, during a run of a body with an outline, the corners of the ground that meet one of its sides. They become contacts (`side.rs`), or
//! pass through the body where they are to be ignored.
//!
//! In the axes of the body, with its centre of mass x + r as origin, a corner V of the ground moves as
//!
//! ```text
//! p = R(−θ)(V − x − r),   ṗ = −ω (−p_y, p_x) − R(−θ) ṙ
//! ```
//!
//! In an interval of time p(t) differs from the cubic with the same p and ṗ at both ends by at most an error that is measured at the
//! middle. The cubic stays in the hull of its four control points. An interval contains no entry if this hull, enlarged by the error, meets
//! no side of the body, or if the corner stays farther from the centre of mass than every point of the body. It contains one if the corner
//! lies in the body at its end, and the hull meets a single side, below which the corner comes deeper all the time. All other intervals are
//! halved. The time of an entry is the root of the depth of the corner below the side.

use std::cell::LazyCell;
use std::sync::Arc;

use nalgebra::Vector2;
use smallvec::{SmallVec, smallvec};

use crate::body::outline::{Outline, Side};
use crate::body::posture::{Corners, Posture};
use crate::collisions::log::{Center, Spin};
use crate::math::extents::Extent;
use crate::math::roots::bracketed;
use crate::math::turn::{Turn, turned};
use crate::options::{Edges, Options};
use crate::sustained::BodyState;
use crate::sustained::side::SideContact;
use crate::tolerance::{CUBIC_TURN, MEASURED_ERROR, PLACE, TOUCH};

/// Watches the corners of the ground.
#[derive(Debug, Clone)]
pub(crate) struct EdgeWatch {
    /// The convex corners of the ground and its ends, world axes, in m; a concave corner cannot enter before another one has. Without
    /// contacts, those that have not entered the body.
    corners: Arc<Corners>,
    /// Whether a corner that meets a side becomes a contact.
    touches: bool,
}

/// A smooth motion of the body.
#[derive(Clone, Copy)]
pub(crate) struct Path<'a> {
    posture: &'a Posture,
    /// The corners of the ground that are contacts on sides.
    sides: &'a [SideContact],
    /// The centre of mass and the rotation of the body a time after the start, in s.
    at: &'a dyn Fn(f64) -> (Center, Spin),
}

/// The control points of the depth of a point V below the line of a side, each as (n, d) with the depth n·V + d (m).
type Depths = [(Vector2<f64>, f64); 4];

/// A corner of the ground at an instant, in the axes of the body.
#[derive(Clone, Copy)]
struct Seen {
    /// Time since the start of the motion, in s.
    t: f64,
    p: Vector2<f64>,
    /// ṗ, in m/s.
    v: Vector2<f64>,
    /// Position of the centre of mass relative to the corner, world axes, in m, and its velocity.
    center: [Vector2<f64>; 2],
    /// In rad/s.
    omega: f64,
}

/// A corner of the ground enters the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Entry {
    /// Time since the start of the motion, in s.
    pub(crate) t: f64,
    pub(crate) corner: Vector2<f64>,
    /// The number of the side, from 0.
    pub(crate) side: usize,
    /// Whether it lies in the body at the start of the motion.
    pub(crate) inside: bool,
}

/// The control points of the cubic through two instants.
fn control_points(
    dt: f64,
    [p, v]: [Vector2<f64>; 2],
    [q, w]: [Vector2<f64>; 2],
) -> [Vector2<f64>; 4] {
    [p, p + v * (dt / 3.0), q - w * (dt / 3.0), q]
}

/// Bound of the error of a cubic with these control points, from the true value in its middle.
fn error(hull: &[Vector2<f64>; 4], middle: &Vector2<f64>) -> f64 {
    MEASURED_ERROR * (0.125 * (hull[0] + hull[3]) + 0.375 * (hull[1] + hull[2]) - middle).norm()
}

impl EdgeWatch {
    /// A new watch; most postures need none.
    pub(crate) fn new(posture: Option<&Posture>, options: &Options) -> Self {
        let none = || Arc::new(Corners::new(Vec::new()));
        let corners = posture.map_or_else(none, |posture| posture.ground_corners().clone());
        Self { corners, touches: options.edges == Edges::Contact }
    }

    /// Returns true if no corner meets this body if it moves so far at most: the way of a point of the body with this arm (m), in m.
    pub(crate) fn stay_off(
        &self,
        posture: &Posture,
        body: &BodyState,
        way: impl Fn(f64) -> f64,
    ) -> bool {
        let Some(outline) = posture.outline().filter(|_| !self.corners.all.is_empty()) else {
            return true;
        };
        let (at, way) = (|_| body.place(), way(outline.radius));
        let path = Path::standing(posture, &at);
        let center = posture.center() + body.center.r;
        self.corners.near(&center, outline.radius + way).all(|corner| {
            let p = path.see(corner, 0.0).p;
            p.norm() - outline.radius > way || outline.nearest_side(&p).distance(&p) > way
        })
    }

    /// Whether there are corners that may become contacts.
    pub(crate) fn has_contacts(&self) -> bool {
        self.touches && !self.corners.all.is_empty()
    }

    /// Whether this corner may become a contact.
    pub(crate) fn may_touch(&self, corner: &Vector2<f64>) -> bool {
        self.touches && self.corners.within(Extent::of([*corner])).any(|one| one == corner)
    }

    /// The first corner that meets a side of the body within `dt` of the start of this motion (s) and is no contact on this side yet.
    /// Where corners are ignored, none, with a warning for each corner. `free`: the acceleration of the centre of mass, if it is constant;
    /// the motion may then be endless. `time`: converts a time since the start to a time on the clock.
    pub(crate) fn entry(
        &mut self,
        path: Path<'_>,
        mut dt: f64,
        free: Option<Vector2<f64>>,
        time: impl Fn(f64) -> f64,
        warnings: &mut Vec<String>,
    ) -> Option<Entry> {
        let outline = path.posture.outline().filter(|_| !self.corners.all.is_empty())?;
        if let Some(acceleration) = free {
            dt = dt.min(path.passed(&self.corners, outline.radius, acceleration));
        }
        if !dt.is_finite() {
            return None;
        }
        let near = path.neighbourhood(dt, outline.radius);
        let corners = self.corners.clone();
        let held = path.sides;
        let origin = Vector2::from(path.posture.fields().center_of_mass);
        let is_at = |on: &&SideContact, corner: &Vector2<f64>| on.corner == corner - origin;
        // A corner that is a contact on a side stays in front of this side: it cannot lie in a convex body.
        let watched = |corner: &&Vector2<f64>| {
            !(outline.is_convex && held.iter().any(|on| is_at(&on, corner)))
        };
        let reached = LazyCell::new(|| path.reached(outline, dt));
        let near = corners.of_which(|place| near.meets(place) && reached(place)).filter(watched);
        let mut left: SmallVec<[(usize, Vector2<f64>); 8]> = near.copied().enumerate().collect();
        let mut entries = SmallVec::<[(usize, Entry); 2]>::new();
        // Where only the first entry counts, the corner that is deepest in the end is probably the first, and leaves few others that may be.
        if self.touches && left.len() > 1 {
            let depths = left.iter().map(|(_, corner)| path.depth(outline, corner, dt)).enumerate();
            let deepest = depths.max_by(|one, other| one.1.total_cmp(&other.1));
            let last = left.len() - 1;
            left.swap(deepest.map_or(last, |(k, _)| k), last);
        }
        while let Some((k, corner)) = left.pop() {
            let entry = path.entry(outline, &corner, dt).filter(|entry| {
                !held.iter().any(|on| is_at(&on, &entry.corner) && on.side == entry.side)
            });
            let Some(entry) = entry else { continue };
            entries.push((k, entry));
            if self.touches {
                let sooner = path.reached(outline, entry.t);
                left.retain(|(_, corner)| sooner(&Extent::of([*corner])));
            }
        }
        entries.sort_by(|(i, one), (j, other)| one.t.total_cmp(&other.t).then(i.cmp(j)));
        if self.touches {
            return entries.first().map(|(_, entry)| *entry);
        }
        for (_, entry) in &entries {
            let left = self.corners.all.iter().filter(|corner| **corner != entry.corner);
            self.corners = Arc::new(Corners::new(left.copied().collect()));
            warnings.push(entry.warning(time(entry.t)));
        }
        None
    }

    /// Returns true if a corner that has not entered it lies in this body.
    pub(crate) fn is_inside(&self, posture: &Posture, body: &BodyState) -> bool {
        let at = |_| body.place();
        let path = Path::standing(posture, &at);
        let center = posture.center() + body.center.r;
        let inside = |outline: &Outline| {
            let mut near = self.corners.near(&center, outline.radius);
            near.any(|v| outline.holds(&path.see(v, 0.0).p))
        };
        posture.outline().is_some_and(inside)
    }
}

impl Entry {
    fn warning(&self, t: f64) -> String {
        let Self { corner, side, inside, .. } = self;
        let what = if *inside {
            format!("lies in the body, nearest to side {} of its outline", side + 1)
        } else {
            format!("enters the body through side {} of its outline", side + 1)
        };
        format!(
            "edge-contact: at t = {t:?} s the corner of the ground at ({:?}, {:?}) m {what}, and passes through it: with edges = \"ignore\" \
             no corner of the ground is a contact",
            corner.x, corner.y,
        )
    }
}

impl<'a> Path<'a> {
    pub(crate) fn new(
        posture: &'a Posture,
        sides: &'a [SideContact],
        at: &'a dyn Fn(f64) -> (Center, Spin),
    ) -> Self {
        Self { posture, sides, at }
    }

    /// A body that does not move.
    fn standing(posture: &'a Posture, at: &'a dyn Fn(f64) -> (Center, Spin)) -> Self {
        Self { posture, sides: &[], at }
    }

    /// Whether things in a box may enter a convex body within this time: they do not if they stay outside the line of one side, farther
    /// from it than what counts as touching.
    ///
    /// The depth of a point V below this line, y = n·(V − x − r) + const, and its rate are affine in V at each instant. So are the control
    /// points of the cubic with the values and rates of y at both ends: if all four are negative at all corners of the box, by more than the
    /// error of the cubic, then so is y at all times.
    fn reached(&self, outline: &Outline, dt: f64) -> impl Fn(&Extent) -> bool + use<> {
        let seen = [0.0, 0.5 * dt, dt].map(|t| (self.at)(t));
        let turns = seen.map(|(_, spin)| Turn::by(spin.theta));
        let [start, middle, end] = seen.map(|(center, _)| center);
        let path = control_points(dt, [start.r, start.v], [end.r, end.v]);
        let moved =
            path.iter().map(|p| (p - start.r).norm()).fold(error(&path, &middle.r), f64::max);
        let center = self.posture.center() + start.r;
        // A corner that touches a side at the start enters at the start.
        let rounding = PLACE * (center.norm() + outline.radius);
        let (far, margin) = (outline.radius + moved, TOUCH * outline.radius + rounding);
        let turn = dt * seen.into_iter().map(|(_, spin)| spin.omega.abs()).fold(0.0, f64::max);
        let known = outline.is_convex && turn <= CUBIC_TURN;
        let lines: SmallVec<[Depths; 8]> = outline
            .sides()
            .iter()
            .filter(|_| known)
            .map(|side| {
                let at = |k: usize| {
                    let ((center, spin), along) = (seen[k], turned(&turns[k], side.along()));
                    let (inwards, moved) = (Vector2::new(-along.y, along.x), center.r - start.r);
                    let depth = -inwards.dot(&moved) - side.along().perp(&side.ends()[0]);
                    let turns = -along * spin.omega;
                    [(inwards, depth), (turns, -turns.dot(&moved) - inwards.dot(&center.v))]
                };
                let ([p, v], [q, w]) = (at(0), at(2));
                let (inwards, depth) = at(1)[0];
                let inwards_at = control_points(dt, [p.0, v.0], [q.0, w.0]);
                let depth_at = [p.1, p.1 + v.1 * dt / 3.0, q.1 - w.1 * dt / 3.0, q.1];
                let middle =
                    0.125 * (depth_at[0] + depth_at[3]) + 0.375 * (depth_at[1] + depth_at[2]);
                let off =
                    MEASURED_ERROR * (middle - depth).abs() + error(&inwards_at, &inwards) * far;
                let from = depth_at.map(|depth| depth + off + margin);
                std::array::from_fn(|k| (inwards_at[k], from[k] - inwards_at[k].dot(&center)))
            })
            .collect();
        move |place| {
            let outside = |(inwards, depth): &(Vector2<f64>, f64)| {
                place.farthest(inwards, &Vector2::zeros()) < -depth
            };
            !lines.iter().any(|line| line.iter().all(outside))
        }
    }

    /// Where the body is within this time.
    fn neighbourhood(&self, dt: f64, radius: f64) -> Extent {
        let [start, middle, end] = [0.0, 0.5 * dt, dt].map(|t| (self.at)(t).0);
        let hull = control_points(dt, [start.r, start.v], [end.r, end.v]);
        let margin = radius + error(&hull, &middle.r);
        let center = self.posture.center();
        let rounding = PLACE * (center.norm() + hull[0].norm() + hull[3].norm());
        Extent::of(hull.map(|p| center + p)).grown(margin + rounding)
    }

    /// The time from which on a body with this acceleration is beyond these corners for good; one turn for a body that only turns.
    fn passed(&self, corners: &Corners, radius: f64, acceleration: Vector2<f64>) -> f64 {
        let (center, spin) = (self.at)(0.0);
        let pull = acceleration.norm();
        let way = if pull > 0.0 { acceleration } else { center.v }.try_normalize(0.0);
        let Some(way) = way else {
            return if spin.omega == 0.0 { 0.0 } else { std::f64::consts::TAU / spin.omega.abs() };
        };
        let at = Vector2::from(self.posture.fields().center_of_mass) + center.r;
        let ahead = corners.places.farthest(&way, &at).max(0.0);
        let (ahead, speed) = (ahead + radius, way.dot(&center.v));
        let root = (speed * speed + 2.0 * pull * ahead).sqrt();
        if speed > 0.0 { 2.0 * ahead / (speed + root) } else { (root - speed) / pull }
    }

    fn see(&self, corner: &Vector2<f64>, t: f64) -> Seen {
        let (center, spin) = (self.at)(t);
        let turn = Turn::by(-spin.theta);
        let back = |v: Vector2<f64>| turned(&turn, v);
        let from = Vector2::from(self.posture.fields().center_of_mass) + center.r - corner;
        let p = back(-from);
        let v = -Vector2::new(-p.y, p.x) * spin.omega - back(center.v);
        Seen { t, p, v, center: [from, center.v], omega: spin.omega }
    }

    /// Depth of the corner below the nearest side at this time, in m; negative outside.
    fn depth(&self, outline: &Outline, corner: &Vector2<f64>, t: f64) -> f64 {
        let Seen { p, v, .. } = self.see(corner, t);
        outline.nearest_side(&p).depth(&p, &v)[0]
    }

    /// When and where the corner enters the body, if within this time.
    fn entry(&self, outline: &Outline, corner: &Vector2<f64>, dt: f64) -> Option<Entry> {
        let mut now = self.see(corner, 0.0);
        let entry = |t: f64, side: usize, inside: bool| Entry { t, corner: *corner, side, inside };
        if outline.holds(&now.p) {
            return Some(entry(0.0, outline.nearest_side(&now.p).index(), true));
        }
        let mut ends: SmallVec<[Seen; 8]> = smallvec![self.see(corner, dt)];
        while let Some(&end) = ends.last() {
            let span = end.t - now.t;
            let middle = self.see(corner, now.t + 0.5 * span);
            let hull = control_points(span, [now.p, now.v], [end.p, end.v]);
            let error = error(&hull, &middle.p);
            let turn = span * now.omega.abs().max(end.omega.abs());
            let inside = outline.holds(&end.p);
            let known = turn <= CUBIC_TURN;
            let mut met = outline.met(&hull, error);
            let first = if known { met.next() } else { None };
            let off = || known && first.is_none();
            if !inside && (off() || now.is_far_until(&end, &middle, outline.radius)) {
                now = end;
                ends.pop();
                continue;
            }
            let mut is_only =
                |side: &&Side| met.next().is_none() && side.is_only_entered(&hull, error);
            let only = first.filter(|side| inside && is_only(side));
            let extent = hull.iter().map(|p| (p - now.p).norm()).fold(error, f64::max);
            let divides = extent > outline.depth && middle.t > now.t && middle.t < end.t;
            if only.is_none() && divides {
                ends.push(middle);
                continue;
            }
            if inside {
                let side = only.unwrap_or_else(|| outline.nearest_side(&end.p));
                let t = self.crossing(corner, [now.t, end.t], TOUCH * outline.radius, |seen| {
                    side.depth(&seen.p, &seen.v)
                });
                return Some(entry(t, side.index(), false));
            }
            now = end;
            ends.pop();
        }
        None
    }

    /// When the depth of a corner below a side became positive, in s. It is positive at time `t`, after a short interval from `before` on.
    /// A depth of `-touch` (m) at the start counts as zero. `depth`: in m, and its rate in m/s.
    fn crossing(
        &self,
        corner: &Vector2<f64>,
        [before, t]: [f64; 2],
        touch: f64,
        depth: impl Fn(&Seen) -> [f64; 2],
    ) -> f64 {
        let mut back = t - before;
        loop {
            let from = (t - back).max(0.0);
            let [height, _] = depth(&self.see(corner, from));
            if height < -touch {
                let above = |t: f64| {
                    let [depth, rate] = depth(&self.see(corner, t));
                    (-depth, -rate)
                };
                return bracketed(from, t, above);
            }
            if from == 0.0 {
                return 0.0;
            }
            back *= 2.0;
        }
    }
}

impl Seen {
    /// Returns true if the centre of mass stays farther than `radius` from the corner until the instant of `end`. `middle`: halfway
    /// between.
    fn is_far_until(&self, end: &Self, middle: &Self, radius: f64) -> bool {
        let hull = control_points(end.t - self.t, self.center, end.center);
        let [from, _] = middle.center;
        let margin = (radius + error(&hull, &from)) * from.norm();
        hull.iter().all(|point| point.dot(&from) > margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Lamina;
    use crate::math::random::Random;
    use crate::sustained::flight::flown;

    /// Corners around a box that flies and turns: none of those that are ruled out within a time enters within it, and none lies in the
    /// box before it enters.
    #[test]
    fn corners_that_are_ruled_out_do_not_enter() {
        let (posture, mut random) =
            (Posture::block(1.0, 0.6, &Lamina::default()).unwrap(), Random(11));
        let outline = posture.outline().unwrap();
        let [mut out, mut entered] = [0, 0];
        for _ in 0..2000 {
            let mut vector =
                |most: f64| Vector2::new(random.between(-most, most), random.between(-most, most));
            let center = Center { r: vector(0.1), v: vector(2.0) };
            let (corner, fall) = (posture.center() + vector(0.8), Vector2::new(0.0, -9.81));
            let (theta, omega) = (random.between(-3.0, 3.0), random.between(-4.0, 4.0));
            let spin = Spin { theta, omega };
            let at = |t: f64| flown((center, spin), fall, t);
            let (path, dt) = (Path::new(&posture, &[], &at), random.between(0.0, 0.3));
            let entry = path.entry(outline, &corner, dt);
            entered += usize::from(entry.is_some());
            let until = entry.map_or(dt, |entry| entry.t);
            let place = |k: usize| path.see(&corner, until * k as f64 / 64.0).p;
            assert!(
                entry.is_some_and(|entry| entry.inside)
                    || (0..64).all(|k| !outline.holds(&place(k)))
            );
            if let Some(Entry { t, .. }) = entry.filter(|entry| entry.t > 0.0) {
                assert!(path.depth(outline, &corner, t).abs() < TOUCH);
            }
            if !path.reached(outline, dt)(&Extent::of([corner])) {
                out += 1;
                assert_eq!(entry, None);
            }
        }
        assert!(out > 500 && entered > 500, "{out} {entered}");
    }
}

//! Checks, during a run of a body with an outline, for corners of the ground that enter the body through one of its sides. Only contacts
//! meet the ground, so that such a motion is not that of the whole body.
//!
//! In the axes of the body, with its centre of mass x + r as origin, a corner V of the ground moves as
//!
//! ```text
//! p = R(−θ)(V − x − r),   ṗ = −ω (−p_y, p_x) − R(−θ) ṙ
//! ```
//!
//! In an interval of time it stays in the hull of the four control points of the cubic with p and ṗ of both ends, up to the error of this
//! cubic, which is measured in the middle. An interval whose hull lies off the sides of the body contains no entry; all others are halved.

use nalgebra::Vector2;

use crate::body::contact::PerContact;
use crate::body::outline::Outline;
use crate::body::posture::Posture;
use crate::math::clock::Clock;
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::sustained::BodyState;
use crate::tolerance::{CUBIC_TURN, MEASURED_ERROR};

/// Watches the corners of the ground, each until it has entered the body.
#[derive(Debug, Clone, Default)]
pub(crate) struct EdgeWatch {
    /// The corners that have not entered it, world axes, in m.
    corners: Vec<Vector2<f64>>,
    /// The motion since the last check.
    since: Option<(BodyState, PerContact<Mode>, Clock)>,
}

/// A corner of the ground at an instant, in the axes of the body.
#[derive(Clone, Copy)]
struct Seen {
    /// Time since the start of the motion, in s.
    t: f64,
    p: Vector2<f64>,
    /// ṗ, in m/s.
    v: Vector2<f64>,
    /// In rad/s.
    omega: f64,
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
    pub(crate) fn new(posture: Option<&Posture>) -> Self {
        let watched = posture.filter(|posture| posture.outline().is_some());
        let corners = watched.and_then(|posture| posture.ground(0)).map(|ground| ground.corners());
        Self { corners: corners.unwrap_or_default(), since: None }
    }

    /// Another motion begins in this state of the body. Checks the motion before it.
    pub(crate) fn begin(
        &mut self,
        posture: &Posture,
        body: &BodyState,
        word: &[Mode],
        clock: Clock,
        time: impl Fn(Clock) -> f64,
        warnings: &mut Vec<String>,
    ) {
        if self.corners.is_empty() {
            return;
        }
        self.end(posture, clock, time, warnings);
        self.since = Some((body.clone(), PerContact::from_slice(word), clock));
    }

    /// The motion ends now, and is checked.
    pub(crate) fn end(
        &mut self,
        posture: &Posture,
        clock: Clock,
        time: impl Fn(Clock) -> f64,
        warnings: &mut Vec<String>,
    ) {
        let (Some((body, word, start)), Some(outline)) = (self.since.take(), posture.outline())
        else {
            return;
        };
        let dt = clock.since(start).max(0.0);
        let motion = Path { body: &body, word: &word, center: posture.fields().center_of_mass };
        let near = motion.neighbourhood(dt, outline.radius);
        let mut entries: Vec<(f64, Vector2<f64>, usize)> = Vec::new();
        self.corners.retain(|corner| {
            let entry = near(corner).then(|| motion.entry(outline, corner, dt)).flatten();
            entries.extend(entry.map(|seen| (seen.t, *corner, outline.nearest_side(&seen.p))));
            entry.is_none()
        });
        entries.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (t, corner, side) in entries {
            warnings.push(format!(
                "edge-contact: at t = {:?} s the corner of the ground at ({:?}, {:?}) m enters the body through side {side} of its \
                 outline; only contacts meet the ground, so that the motion from then on is not that of the whole body",
                time(start.after(t)),
                corner.x,
                corner.y,
            ));
        }
    }
}

/// A smooth motion of the body.
struct Path<'a> {
    body: &'a BodyState,
    word: &'a [Mode],
    /// Nominal centre of mass.
    center: [f64; 2],
}

impl Path<'_> {
    /// Tells of a corner whether the body comes near it within this time.
    fn neighbourhood(&self, dt: f64, radius: f64) -> impl Fn(&Vector2<f64>) -> bool + use<> {
        let [start, middle, end] =
            [0.0, 0.5 * dt, dt].map(|t| self.body.moved(self.word, t).center);
        let hull = control_points(dt, [start.r, start.v], [end.r, end.v]);
        let margin = radius + error(&hull, &middle.r);
        let limits = |axis: usize| {
            let values = hull.map(|p| p[axis]);
            [
                values.into_iter().fold(f64::INFINITY, f64::min) - margin,
                values.into_iter().fold(f64::NEG_INFINITY, f64::max) + margin,
            ]
        };
        let (limits, center) = ([limits(0), limits(1)], Vector2::from(self.center));
        move |corner| {
            let from = corner - center;
            (0..2).all(|axis| from[axis] >= limits[axis][0] && from[axis] <= limits[axis][1])
        }
    }

    fn see(&self, corner: &Vector2<f64>, t: f64) -> Seen {
        let BodyState { center, spin, .. } = self.body.moved(self.word, t);
        let turn = Turn::by(-spin.theta);
        let back =
            |v: Vector2<f64>| v + Vector2::new(-v.y, v.x) * turn.sin - v * turn.one_minus_cos;
        let p = back(corner - Vector2::from(self.center) - center.r);
        let v = -Vector2::new(-p.y, p.x) * spin.omega - back(center.v);
        Seen { t, p, v, omega: spin.omega }
    }

    /// The corner when it enters the body, or in the body at the start; `None`: it does not within this time.
    fn entry(&self, outline: &Outline, corner: &Vector2<f64>, dt: f64) -> Option<Seen> {
        let mut now = self.see(corner, 0.0);
        if outline.holds(&now.p) {
            return Some(now);
        }
        let mut ends = vec![self.see(corner, dt)];
        while let Some(&end) = ends.last() {
            let span = end.t - now.t;
            let middle = self.see(corner, now.t + 0.5 * span);
            let hull = control_points(span, [now.p, now.v], [end.p, end.v]);
            let error = error(&hull, &middle.p);
            let turn = span * now.omega.abs().max(end.omega.abs());
            let inside = outline.holds(&end.p);
            if !inside && turn <= CUBIC_TURN && outline.is_off_sides(&hull, error) {
                now = end;
                ends.pop();
                continue;
            }
            let extent = hull.iter().map(|p| (p - now.p).norm()).fold(error, f64::max);
            if extent > outline.depth && middle.t > now.t && middle.t < end.t {
                ends.push(middle);
                continue;
            }
            if inside {
                return Some(end);
            }
            now = end;
            ends.pop();
        }
        None
    }
}

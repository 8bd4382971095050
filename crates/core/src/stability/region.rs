//! The equilibrium region: the positions of the centre of mass at which contact forces can hold the body.
//!
//! The edges of the friction cones, u = n_i ± μ_i t_i with moments m_u = x_i × u, balance a unit weight at the abscissa x of the centre of
//! mass if
//!
//! ```text
//! Σ a_u u = e_y,   Σ a_u m_u = x,   a_u ≥ 0.
//! ```
//!
//! The extreme x are the optima of a linear programme with two equations beside its objective. For any number of contacts two edges, or a
//! single vertical one, attain an optimum. The programme is unbounded towards +x (−x) if at most three edges have a combination a ≥ 0 with
//! zero force and a positive (negative) moment: the contacts can squeeze the body.

use nalgebra::{Vector2, Vector3};

use crate::body::geometry::ContactGeometry;
use crate::body::ground::Stance;
use crate::body::posture::Posture;
use crate::body::side::TouchedSide;
use crate::math::unsigned_zero::UnsignedZero;
use crate::tolerance::{PARALLEL_EDGES, SQUEEZE_MOMENT};

/// An edge of a friction cone: the vector u = n + f t and its moment about the nominal centre of mass.
#[derive(Debug, Clone, Copy)]
struct Edge {
    normal: Vector2<f64>,
    tangent: Vector2<f64>,
    /// ±μ
    f: f64,
    u: Vector2<f64>,
    /// The arm of the contact, from the nominal centre of mass, in m.
    arm: Vector2<f64>,
    moment: f64,
}

impl Edge {
    /// u × v = (n×n')(1 + f f') + (t·t')(f − f'). No terms cancel on ground of one slope, for any friction.
    fn cross(&self, other: &Self) -> f64 {
        let (sine, size) = (self.normal.perp(&other.normal), 1.0 + (self.f * other.f).abs());
        let cross =
            sine * (1.0 + self.f * other.f) + self.tangent.dot(&other.tangent) * (self.f - other.f);
        let rounding = if self.normal == other.normal { 0.0 } else { PARALLEL_EDGES * size };
        if cross.abs() <= rounding { 0.0 } else { cross }
    }
}

/// The abscissas of the centre of mass, in m, world axes, for which friction and normal forces at the contacts of the nominal posture can
/// balance gravity. An end is ±∞ if there is no bound; the result is `None` if no position is possible, or if a surface moves. Without gravity all abscissas are
/// possible.
///
/// Closed form over pairs of cone edges (and single vertical edges, and triples that squeeze the body), for any number of contacts [Or &
/// Rimon 2008, III]. Only contacts that touch in the nominal posture count, and sides that touch corners of the ground.
///
/// ```
/// use standfast::stability::equilibrium_region;
/// use standfast::{Lamina, Posture};
///
/// // On level ground the region is between the feet.
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
/// assert_eq!(equilibrium_region(&rod), Some([-0.5, 0.5]));
/// # Ok::<(), standfast::Error>(())
/// ```
#[must_use]
pub fn equilibrium_region(posture: &Posture) -> Option<[f64; 2]> {
    if posture.has_belts() {
        return None;
    }
    let x = posture.fields().center_of_mass[0];
    let regions = regions(posture, 1.0);
    // Regions of different pieces at a convex vertex nearly always overlap. If they do not, the one at the centre of mass counts.
    let away = |[low, high]: [f64; 2]| (low - x).max(x - high).max(0.0);
    let nearest = regions.iter().copied().min_by(|a, b| away(*a).total_cmp(&away(*b)))?;
    let mut whole = nearest;
    for _ in &regions {
        for [low, high] in &regions {
            if *low <= whole[1] && *high >= whole[0] {
                whole = [whole[0].min(*low), whole[1].max(*high)];
            }
        }
    }
    Some(whole).unsigned_zero()
}

/// The equilibrium regions with all coefficients of friction times `factor`, one region for each choice of the pieces: a contact in a
/// convex vertex can be on either of its two pieces.
pub(super) fn regions(posture: &Posture, factor: f64) -> Vec<[f64; 2]> {
    let stances = posture.stances(&Vector3::zeros());
    stances.iter().filter_map(|stance| region(posture, stance, factor)).collect()
}

fn region(posture: &Posture, stance: &Stance, factor: f64) -> Option<[f64; 2]> {
    if posture.fields().gravity == 0.0 {
        return Some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let edges = edges(posture, stance, factor);
    let mut region = [f64::INFINITY, f64::NEG_INFINITY];
    let mut take = |x: f64| region = [region[0].min(x), region[1].max(x)];
    for (k, u) in edges.iter().enumerate() {
        if u.u.x == 0.0 && u.u.y > 0.0 {
            take(u.moment / u.u.y);
        }
        for v in &edges[k + 1..] {
            let d = u.cross(v);
            if d != 0.0 {
                let (a, b) = (-v.u.x / d, u.u.x / d);
                if a >= 0.0 && b >= 0.0 {
                    // a m_u + b m_v with a u_x = −b v_x: only the difference of the heights has a moment.
                    let upright = a * u.arm.x * u.u.y + b * v.arm.x * v.u.y;
                    take(upright - a * u.u.x * (u.arm.y - v.arm.y));
                }
            }
        }
    }
    if region[0] > region[1] {
        return None; // no combination of cones has a vertical force
    }
    region = region.map(|x| x + posture.fields().center_of_mass[0]);
    let squeeze = squeeze(&edges);
    if squeeze[0] {
        region[0] = f64::NEG_INFINITY;
    }
    if squeeze[1] {
        region[1] = f64::INFINITY;
    }
    Some(region)
}

/// The edges of all friction cones; one edge for a contact without friction. Moments are taken about the nominal centre of mass, so that
/// their rounding errors do not depend on the origin; the abscissas are shifted back.
fn edges(posture: &Posture, stance: &Stance, factor: f64) -> Vec<Edge> {
    let mut edges = Vec::new();
    for (i, (contact, k)) in posture.contacts().iter().zip(posture.geometry()).enumerate() {
        if k.offset != 0.0 {
            continue;
        }
        let friction = factor * k.friction;
        let arm = Vector2::from(contact.point) - Vector2::from(posture.fields().center_of_mass);
        let sides: &[f64] = if friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
        // At a vertex both pieces carry forces.
        for &ContactGeometry { normal, tangent, .. } in &stance[i] {
            for side in sides {
                let f = side * friction;
                let u = normal + tangent * f;
                edges.push(Edge { normal, tangent, f, u, arm, moment: arm.perp(&u) });
            }
        }
    }
    for TouchedSide { geometry: k, .. } in posture.sides_touched(&Vector3::zeros()) {
        let (friction, arm) = (factor * k.friction, k.tangent * k.b + k.normal * k.c);
        let signs: &[f64] = if friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
        for sign in signs {
            let (normal, tangent, f) = (k.normal, k.tangent, sign * friction);
            let u = normal + tangent * f;
            edges.push(Edge { normal, tangent, f, u, arm, moment: arm.perp(&u) });
        }
    }
    edges
}

/// Whether some combination of edges with zero total force has a negative moment, and whether one has a positive moment.
fn squeeze(edges: &[Edge]) -> [bool; 2] {
    let mut found = [false; 2];
    let mut take = |moment: f64, size: f64| {
        found[0] |= moment < -SQUEEZE_MOMENT * size;
        found[1] |= moment > SQUEEZE_MOMENT * size;
    };
    for (i, u) in edges.iter().enumerate() {
        for (j, v) in edges.iter().enumerate().skip(i + 1) {
            let uv = u.cross(v);
            if uv == 0.0 {
                if u.u.dot(&v.u) < 0.0 {
                    // u/|u| + v/|v| = 0
                    let (a, b) = (u.moment / u.u.norm(), v.moment / v.u.norm());
                    take(a + b, a.abs() + b.abs());
                }
                continue;
            }
            for w in &edges[j + 1..] {
                // a u + b v + c w = 0 with a : b : c = v×w : w×u : u×v
                let (a, b) = (v.cross(w), w.cross(u));
                let sign = uv.signum();
                if a * sign > 0.0 && b * sign > 0.0 {
                    let parts = [a * u.moment, b * v.moment, uv * w.moment];
                    let moment: f64 = parts.iter().sum();
                    take(sign * moment, parts.iter().map(|part| part.abs()).sum());
                }
            }
        }
    }
    found
}

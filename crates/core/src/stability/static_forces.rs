//! The forces that can hold a body at rest. They are not unique where two contacts have friction.
//!
//! Contact forces are sums of the edges u = n ± μt of the friction cones with weights a ≥ 0. Those that balance gravity, Σ a_u
//! u = m g e_y and Σ a_u (x_u − r) × u = 0 about the centre of mass r, form a polyhedron; the extremes of each of their
//! components are linear programs.

use nalgebra::{Vector2, Vector3};
use serde::Serialize;

use crate::body::ground::Stance;
use crate::body::posture::Posture;
use crate::math::simplex::Polyhedron;
use crate::math::unsigned_zero::UnsignedZero;
use crate::stability::region::regions;
use crate::tolerance::{TOUCH, UNBOUNDED_DIRECTION};

/// The set of contact forces that hold a body at rest in its nominal posture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StaticForces {
    /// Least (tangential, normal) force of each contact, in N; −∞ where there is no bound.
    pub low: Vec<[f64; 2]>,
    /// Largest (tangential, normal) force of each contact, in N; ∞ where there is no bound.
    pub high: Vec<[f64; 2]>,
}

/// An edge of a friction cone: the contact; the force (tangential, normal); the direction; and the moment, in units of the size of the
/// body.
struct Edge {
    contact: usize,
    force: [f64; 2],
    u: Vector2<f64>,
    moment: f64,
}

/// The forces that can hold the body; `None` if there are none, or if a surface moves. Only contacts that touch in the nominal posture carry forces. After the
/// contacts of the posture come the sides that touch corners of the ground, in the axes of the sides, as in
/// [`Trajectory::contacts`](crate::Trajectory::contacts) of a run from this posture.
///
/// ```
/// use standfast::stability::static_forces;
/// use standfast::{Lamina, Posture};
///
/// // Without friction the forces are unique: each end of a rod carries half of its weight of 10 N.
/// let rod = Posture::rod(0.5, &Lamina { gravity: 10.0, ..Lamina::default() })?;
/// let forces = static_forces(&rod).expect("the rod stands");
/// assert_eq!((&forces.low, &forces.high), (&vec![[0.0, 5.0]; 2], &vec![[0.0, 5.0]; 2]));
/// # Ok::<(), standfast::Error>(())
/// ```
#[must_use]
pub fn static_forces(posture: &Posture) -> Option<StaticForces> {
    if posture.has_belts() {
        return None;
    }
    let stances = posture.stances(&Vector3::zeros());
    stances.iter().find_map(|stance| forces_of(posture, stance))
}

/// The forces for one choice of the pieces on which contacts in convex vertices stand.
fn forces_of(posture: &Posture, stance: &Stance) -> Option<StaticForces> {
    let fields = posture.fields();
    let weight = fields.mass * fields.gravity;
    let edges = edges(posture, stance);
    let row = |of: &dyn Fn(&Edge) -> f64| edges.iter().map(of).collect::<Vec<f64>>();
    let balance = [row(&|edge| edge.u.x), row(&|edge| edge.u.y), row(&|edge| edge.moment)];
    let loads = [0.0, if weight > 0.0 { 1.0 } else { 0.0 }, 0.0];
    let held: Vec<_> = balance.into_iter().zip(loads).collect();
    let count = posture.contacts().len() + posture.sides_touched(&Vector3::zeros()).len();
    let forces: Vec<(usize, [f64; 2])> =
        edges.iter().map(|edge| (edge.contact, edge.force)).collect();
    extremes(&held, &forces, count, weight)
}

/// The least and the largest forces of the contacts, from the balance of the weights of some edges of their cones: Σ a_u u = load, in units of
/// `weight`. `edges`: contact and force (tangential, normal). `None` if no weights balance the load.
pub(super) fn extremes(
    held: &[(Vec<f64>, f64)],
    edges: &[(usize, [f64; 2])],
    count: usize,
    weight: f64,
) -> Option<StaticForces> {
    let mut loaded = Polyhedron::of(held, edges.len())?;
    // Forces that balance each other, without load.
    let mut free: Vec<_> = held.iter().map(|(row, _)| (row.clone(), 0.0)).collect();
    free.push((vec![1.0; edges.len()], 1.0));
    let mut free = Polyhedron::of(&free, edges.len());
    let mut extreme = |contact: usize, axis: usize, sign: f64| {
        let of = |(owner, force): &(usize, [f64; 2])| {
            if *owner == contact { sign * force[axis] } else { 0.0 }
        };
        let objective: Vec<f64> = edges.iter().map(of).collect();
        let value = |x: &[f64]| x.iter().zip(&objective).map(|(a, c)| a * c).sum::<f64>();
        let apart = free.as_mut().and_then(|free| free.maximise(&objective));
        if apart.is_some_and(|x| value(&x) > UNBOUNDED_DIRECTION) {
            return sign * f64::INFINITY;
        }
        let unit = if weight > 0.0 { weight } else { 1.0 };
        loaded.maximise(&objective).map_or(f64::NAN, |x| sign * value(&x) * unit)
    };
    let mut all = |sign: f64| {
        (0..count)
            .map(|contact| [0, 1].map(|axis| extreme(contact, axis, sign)))
            .collect::<Vec<_>>()
    };
    Some(StaticForces { low: all(-1.0).unsigned_zero(), high: all(1.0).unsigned_zero() })
}

fn edges(posture: &Posture, stance: &Stance) -> Vec<Edge> {
    let size = posture.size();
    let mut edges = Vec::new();
    for (contact, k) in posture.geometry().iter().enumerate() {
        if k.offset != 0.0 {
            continue;
        }
        // At a vertex both pieces carry forces.
        for on in &stance[contact] {
            let sides: &[f64] = if on.friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
            for side in sides {
                let f = side * on.friction;
                let u = on.normal + on.tangent * f;
                let force = [k.tangent.dot(&u), k.normal.dot(&u)];
                // (t b + n c) × (t f + n) = b − c f
                edges.push(Edge { contact, force, u, moment: (on.b - on.touching_c() * f) / size });
            }
        }
    }
    let count = posture.contacts().len();
    for (k, side) in posture.sides_touched(&Vector3::zeros()).iter().enumerate() {
        let on = &side.geometry;
        let signs: &[f64] = if on.friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
        for sign in signs {
            let f = sign * on.friction;
            let u = on.normal + on.tangent * f;
            let moment = (on.b - on.c * f) / size;
            edges.push(Edge { contact: count + k, force: [f, 1.0], u, moment });
        }
    }
    edges
}

/// Largest factor on the coefficients of friction that is tried.
const MOST: f64 = 1e9;

/// Reserve of friction of a posture: 1 − κ. κ is the least factor on all coefficients of friction at which the centre of mass is over the
/// equilibrium region, or beyond its end by at most [`TOUCH`] of the size of the body. The reserve is 1 if the body stands without
/// friction, zero at the edge of the region, negative outside, and −∞ if no friction suffices, or if a surface moves.
///
/// ```
/// use standfast::stability::friction_margin;
/// use standfast::{Contact, Posture, PostureFields};
///
/// // Balanced on a slope of 1 in 4 with μ = 1/2: half of the friction would do.
/// let foot = Contact { friction: 0.5, ..Contact::at(0.0, 0.0).on_slope(0.25_f64.atan()) };
/// let posture = Posture::new(PostureFields {
///     gyration_radius: 0.5,
///     center_of_mass: [0.0, 1.0],
///     contacts: vec![foot],
///     ..PostureFields::default()
/// })?;
/// assert!((friction_margin(&posture) - 0.5).abs() < 1e-9);
/// # Ok::<(), standfast::Error>(())
/// ```
#[must_use]
pub fn friction_margin(posture: &Posture) -> f64 {
    let x = posture.fields().center_of_mass[0];
    let slack = TOUCH * posture.size();
    // The region grows monotonically with friction.
    let stands = |factor| {
        let holds = |[low, high]: &[f64; 2]| low - slack <= x && x <= high + slack;
        regions(posture, factor).iter().any(holds)
    };
    if posture.has_belts() {
        return f64::NEG_INFINITY;
    }
    spare_friction(stands)
}

/// 1 − κ with the least factor κ on the friction for which `stands` is true; where it is true for a factor, it is true for larger ones.
pub(super) fn spare_friction(stands: impl Fn(f64) -> bool) -> f64 {
    if stands(0.0) {
        return 1.0;
    }
    let (mut fails, mut holds) = (0.0, 1.0);
    while !stands(holds) {
        (fails, holds) = (holds, 2.0 * holds);
        if holds > MOST {
            return f64::NEG_INFINITY;
        }
    }
    loop {
        let middle = 0.5 * (fails + holds);
        if middle <= fails || middle >= holds {
            return 1.0 - holds;
        }
        *(if stands(middle) { &mut holds } else { &mut fails }) = middle;
    }
}

//! Random flights of a rotating body against a conservative checker: no touchdown is missed.
//!
//! The checker shares no code with the solver. It advances along the arc in steps so short that the gap cannot become
//! zero within one: over a step dt the gap decreases by at most |ḣ| dt + ½A dt², where A = g + |d|ω² bounds |ḧ|. A gap
//! below zero, by more than the rounding error of the checker, before the touchdown of the solver is a missed
//! collision.

use std::f64::consts::{PI, TAU};

use random::Random;
use standfast::flight::GapArc;

#[path = "../src/math/random.rs"]
mod random;

impl Random {
    /// 10^x for x uniform in [low, high].
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(self.between(low, high))
    }

    fn sign(&mut self) -> f64 {
        if self.next() < 0.5 { -1.0 } else { 1.0 }
    }
}

/// A gap in flight, near the ground or leaving it. The spin is from zero to hundreds of times the concave limit.
fn draw(random: &mut Random) -> GapArc {
    let angle = if random.next() < 0.1 {
        // Contact right above or below the centre of mass.
        random.sign() * random.decades(-17.0, -1.0) + PI * random.between(0.0, 2.0).floor()
    } else {
        random.between(0.0, TAU)
    };
    let arm = random.decades(-1.0, 1.0);
    let g = if random.next() < 0.02 { 0.0 } else { random.decades(-1.0, 1.5) };
    // Angular velocity in units of the concave limit √(g/|d|).
    let limit = (g.max(0.1) / arm).sqrt();
    let omega = random.sign() * limit * random.decades(-2.0, 2.5);
    let (h, u) = if random.next() < 0.2 {
        // High above the ground: many revolutions until touchdown.
        (arm * random.decades(0.0, 4.0), random.sign() * random.decades(-2.0, 2.0))
    } else if random.next() < 0.3 {
        (0.0, random.decades(-6.0, 1.0))
    } else {
        (arm * random.decades(-16.0, 0.5), random.sign() * random.decades(-4.0, 1.5))
    };
    GapArc { h, u, g, b: arm * angle.sin(), c: arm * angle.cos(), omega }
}

/// Gap and rate by the definition n·R(ωt)d, not by the solver's differences.
fn gap(arc: &GapArc, t: f64) -> (f64, f64) {
    let (sin, cos) = (arc.omega * t).sin_cos();
    let swing = arc.c * cos + arc.b * sin; // n·R d
    let lever = arc.b * cos - arc.c * sin; // d(n·R d)/dθ
    let climb = arc.u - arc.omega * arc.b;
    (arc.h - arc.c + climb * t - 0.5 * arc.g * t * t + swing, climb - arc.g * t + arc.omega * lever)
}

/// Rounding error of `gap` at time `t`.
fn rounding(arc: &GapArc, t: f64) -> f64 {
    let arm = arc.b.hypot(arc.c);
    let climb = (arc.u - arc.omega * arc.b).abs();
    8.0 * f64::EPSILON
        * (arc.h + arm * (2.0 + (arc.omega * t).abs()) + climb * t + 0.5 * arc.g * t * t)
}

/// The error in the touchdown of this arc, if any.
fn fault(arc: &GapArc) -> Option<String> {
    let found = arc.touchdown();
    let bound = arc.g + arc.b.hypot(arc.c) * arc.omega * arc.omega;
    let end = match found {
        Some(t) if !(t > 0.0 && t.is_finite()) => return Some(format!("touchdown at {t}")),
        Some(t) => {
            let (h, rate) = gap(arc, t);
            let room = rounding(arc, t);
            if h.abs() > room + rate.abs() * t * 4.0 * f64::EPSILON {
                return Some(format!("gap {h} at the touchdown {t}, rounding {room}"));
            }
            t
        }
        None if arc.g > 0.0 => return Some("a falling body never lands".into()),
        // Without gravity the gap grows, or it is periodic.
        None => 3.0 * TAU / arc.omega.abs(),
    };
    let mut t = 0.0;
    if arc.h == 0.0 {
        // The contact leaves the ground: u t − ½A t² > 0 on (0, 2u/A).
        t = arc.u / bound;
        if found.is_some() && end <= 2.0 * t * (1.0 - 1e-12) {
            return Some(format!("lands at {end}, while it certainly rises until {}", 2.0 * t));
        }
    }
    while t < end {
        let (h, rate) = gap(arc, t);
        let floor = rounding(arc, t);
        if h < -floor {
            return Some(format!("gap {h} at {t}, before the touchdown {found:?}"));
        }
        // The largest dt with h − |ḣ⁻| dt − ½A dt² ≥ 0, or a step in which the gap stays above minus its rounding error.
        let (h, fall) = (h.max(floor), (-rate).max(0.0));
        let step = 2.0 * h / (fall + (fall * fall + 2.0 * bound * h).sqrt());
        t += step.max(t * f64::EPSILON);
    }
    None
}

fn campaign(count: u64, seed: u64) {
    let mut random = Random(seed);
    let mut faults = Vec::new();
    for k in 0..count {
        let arc = draw(&mut random);
        if let Some(what) = fault(&arc) {
            faults.push(format!("flight {k}: {what}: {arc:?}"));
        }
    }
    let listed = faults[..faults.len().min(8)].join("\n");
    assert!(faults.is_empty(), "{} of {count}\n{listed}", faults.len());
}

#[test]
fn no_collision_is_missed_in_1e6_flights() {
    campaign(1_000_000, 2008);
}

#[test]
#[ignore = "long campaign: make long"]
fn no_collision_is_missed_in_1e7_flights() {
    for seed in 0..100 {
        campaign(100_000, 1_000 + seed);
    }
}

//! A bound of the size of the motion after a small kick (a change of q and q̇ at rest), divided by the size of the kick.
//!
//! The size of a motion is ‖q̇‖ = √(ẋ² + ẏ² + ρ²θ̇²). Let s be the speed along the direction in which both contacts slide, u the gap rates,
//! h the gaps, N the rows of the normals, λ the weights of the energy (see `corner.rs`), and D = NM⁻¹Nᵀ per unit mass. Then ‖q̇‖² = s² +
//! u·D⁻¹u. The bound has four parts; docs/theory.md derives them.
//!
//! 1. *Before the first Zeno point* gravity changes s at a constant rate, frictionless impacts do not change s, and E = ½u·D⁻¹u + λ·h never
//!    increases. The duration is at most C√(2E), see [`settling`].
//! 2. *From the first Zeno point to the first corner* one or both contacts are on the terrain, and stick or slide. (At a corner one contact
//!    is on the terrain, and the other one lands.) Accelerations are constant, so the largest landing speed and sliding speed follow from
//!    the largest ones at the start, see [`first_corners`].
//! 3. *From corner to corner* the growths multiply. Stability is proved with a graph of cells (intervals of directions of the velocity). No
//!    cycle of this graph grows, so the largest product along a chain of cells is finite.
//! 4. *Between two corners* ‖q̇‖ is at most a constant times r of the first or of the next corner, see [`between`].
//!
//! Constants are upper ends of intervals with outward rounding. Results that are computed in doubles are enlarged by `BOUND_MARGIN`.

use serde::{Deserialize, Serialize};

use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::stability::cells::{Attraction, CELLS, Graph, Grid, SlideEnd};
use crate::stability::corner::{Cell, CornerMap, Form, Image};
use crate::stability::local::{Arc, FromRest, Local};
use crate::stability::settling::settling;
use crate::tolerance::BOUND_MARGIN;

type I = Interval;

/// Why there is no bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum NoBound {
    /// The verdict is not "stable".
    NotStable,
    /// λ > 0 fails: energy does not bound the speeds of frictionless motion.
    Energy,
    /// It is not certain that gravity points into the terrain of each contact (g_i > 0).
    Falls,
    /// A motion after a slide or a landing does not certainly end with a landing.
    Modes,
    /// The corner map does not bound the growth, not even with its finest cells.
    Cells,
    /// The bound is above 1e300, rounding decides whether it is finite, or the iteration for it did not converge.
    Rounding,
    /// A body on three and more contacts: the bound of one pair of them does not hold for the whole.
    Pairs,
    /// A mechanism whose contacts slide independently: only that its contacts come to rest is proved.
    Joints,
}

impl NoBound {
    /// Its name in files.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::NotStable => "not-stable",
            Self::Energy => "energy",
            Self::Falls => "falls",
            Self::Modes => "modes",
            Self::Cells => "cells",
            Self::Rounding => "rounding",
            Self::Pairs => "pairs",
            Self::Joints => "joints",
        }
    }
}

/// Largest bound that is reported.
const LARGEST: f64 = 1e300;

/// The bound for a stable posture.
pub(super) fn bound(map: &CornerMap) -> Result<f64, NoBound> {
    let l = map.local();
    let weights = l.weights();
    if !weights.iter().all(|weight| weight.is_positive()) {
        return Err(NoBound::Energy);
    }
    if !l.g.iter().all(|g| g.is_positive()) {
        return Err(NoBound::Falls);
    }
    let times = [0, 1].map(|j| map.flight_time(j));
    let certain = map.returns() && !map.has_jumps();
    let ([Some(first), Some(second)], true) = (times, certain) else {
        return Err(NoBound::Modes);
    };
    let metric = Metric::new(l);
    // Change of s until the first Zeno point, for 2E = 1.
    let time = settling(l, weights);
    if !time.is_finite() {
        return Err(NoBound::Rounding);
    }
    let drift = (l.drift * I::new(0.0, time)).magnitude();
    // Largest value of s² + 2E with |s| ≤ s_0 + drift √(2E) and s_0² + 2E = 1 before.
    let half = drift.times(0.5);
    let mut most = (half + (I::ONE + half.square()).sqrt()).hi;
    let corners = first_corners(map, &metric, weights, drift)?;
    if !corners.is_empty() {
        let growths = growths(map, &metric, [first, second])?;
        for corner in &corners {
            if !(corner.xi.is_finite() && corner.y.is_finite()) {
                return Err(NoBound::Rounding);
            }
            let values = &growths.values[corner.contact];
            for (cell, value) in growths.grid.cells.iter().zip(values) {
                let size = corner.largest_in(cell);
                most = most.max(size * libm::exp(*value) * (1.0 + BOUND_MARGIN));
            }
        }
    }
    if most <= LARGEST { Ok(most) } else { Err(NoBound::Rounding) }
}

/// ‖q̇‖² = s² + u·D⁻¹u in the coordinates of the corners.
struct Metric {
    /// Diagonal of D⁻¹
    inverse: [I; 2],
    /// At a corner at j, s = ξ + `shift[j]` y. The other contact is on the terrain.
    shift: [I; 2],
}

impl Metric {
    fn new(l: &Local) -> Self {
        let det = l.nn[0][0] * l.nn[1][1] - l.nn[0][1] * l.nn[1][0];
        Self {
            inverse: [0, 1].map(|j| l.nn[1 - j][1 - j] / det),
            shift: [0, 1].map(|j| l.beta[1 - j][j] / l.alpha[1 - j]),
        }
    }

    /// The form ‖q̇‖² at a corner at j, with `change` y added to s.
    fn at(&self, j: usize, change: I) -> Form {
        let shift = self.shift[j] + change;
        Form { xx: I::ONE, xy: shift, yy: shift.square() + self.inverse[j] }
    }
}

/// Bounds on the first corner at a contact after a kick of size one.
struct FirstCorner {
    contact: usize,
    /// Upper bounds on |ξ| and y.
    xi: f64,
    y: f64,
}

impl FirstCorner {
    /// Bound on r in a cell.
    fn largest_in(&self, cell: &Cell) -> f64 {
        let least =
            if cell.xi.contains_zero() { 0.0 } else { cell.xi.lo.abs().min(cell.xi.hi.abs()) };
        let along = |most: f64, share: f64| {
            if most == 0.0 { if share > 0.0 { 0.0 } else { f64::INFINITY } } else { most / share }
        };
        along(self.xi, least).min(along(self.y, cell.y.lo)).next_up()
    }
}

/// The first corners after a kick, for each contact that is held on the terrain and each of its sliding directions. `drift`: the change of
/// s until then, for 2E = 1.
fn first_corners(
    map: &CornerMap,
    metric: &Metric,
    weights: [I; 2],
    drift: I,
) -> Result<Vec<FirstCorner>, NoBound> {
    let mut corners = Vec::new();
    for kept in 0..2 {
        let m = 1 - kept;
        // u² D⁻¹_mm + 2λ_m h ≤ 1: largest |u|, h, and |ξ| by Cauchy and Schwarz from s_0 and √(2E).
        let rate = I::ONE / metric.inverse[m].sqrt();
        let gap = I::ONE / weights[m].times(2.0);
        let slip = (I::ONE + (drift + metric.shift[m].magnitude() * rate).square()).sqrt();
        let start = Start { m, rate, gap, slip, weight: weights[m], still: map.from_rest[kept] };
        for (arc, side) in map.slides[kept].iter().zip([-1.0, 1.0]) {
            let arc = arc.as_ref().ok_or(NoBound::Modes)?;
            start.slides(arc, arc.along.times(side), &mut corners)?;
        }
        // The held contact does not slide at the start.
        start.turns(rate, gap, |pull| rate.max((pull / weights[m]).sqrt()), &mut corners)?;
    }
    // Both contacts rest: |s| is at most the norm of (1, drift).
    let speed = (I::ONE + drift.square()).sqrt();
    for right in [false, true] {
        for image in map.sliding_together(right).iter() {
            match image {
                Image::Rest => {}
                Image::Corner { contact, xi, y, .. } => corners.push(FirstCorner {
                    contact: *contact,
                    xi: (xi.magnitude() * speed).hi,
                    y: (y.magnitude() * speed).hi,
                }),
                Image::Escape | Image::Unknown => return Err(NoBound::Modes),
            }
        }
    }
    Ok(corners)
}

/// Contact m is in the air after a kick, the other one is on the terrain.
struct Start {
    m: usize,
    /// Upper bounds on |u_m|, h_m and |ξ|.
    rate: I,
    gap: I,
    slip: I,
    /// λ_m
    weight: I,
    /// Motion of the contact on the terrain from rest.
    still: FromRest,
}

impl Start {
    /// The contact slides. `gains`: the rate of change of its sliding speed.
    fn slides(&self, arc: &Arc, gains: I, corners: &mut Vec<FirstCorner>) -> Result<(), NoBound> {
        let contact = self.m;
        let pull = I::new((-arc.normal.hi).max(0.0), (-arc.normal.lo).max(0.0));
        // The landing speed is √(u² + 2 pull h), and u²/rate² + 2λ_m h ≤ 1.
        let y = self.rate.max((pull / self.weight).sqrt());
        if gains.sign().is_none() {
            return Err(NoBound::Modes);
        }
        if gains.is_negative() {
            corners.push(FirstCorner { contact, xi: self.slip.hi, y: y.hi });
            // State when the slide ends: bounded by its duration and, where m falls, by √(u² + 2 pull h), which is constant.
            let time = self.slip / -gains;
            let lift = I::new(0.0, arc.normal.hi.max(0.0));
            let mut rate = self.rate + arc.normal.magnitude() * time;
            let mut gap = self.gap + time * (self.rate + (lift * time).times(0.5));
            let falls = arc.normal.is_negative();
            if falls {
                rate = I::from(rate.hi.min(y.hi));
                gap = I::from(gap.hi.min((y.square() / pull.times(2.0)).hi));
            }
            let landing = |other: I| {
                if falls { y * I::ONE.max(other / pull).sqrt() } else { I::from(f64::INFINITY) }
            };
            return self.turns(I::from(rate.hi), I::from(gap.hi), landing, corners);
        }
        if !arc.normal.is_negative() {
            return Err(NoBound::Modes);
        }
        let time = (self.rate + y) / -arc.normal;
        let xi = self.slip + I::from(gains.hi.max(0.0)) * time;
        corners.push(FirstCorner { contact, xi: xi.hi, y: y.hi });
        Ok(())
    }

    /// The contact on the terrain is at rest; the other contact has at most this gap rate and this gap. `landing`: a bound of the landing
    /// speed, given the acceleration at which the other contact falls.
    fn turns(
        &self,
        rate: I,
        gap: I,
        landing: impl Fn(I) -> I,
        corners: &mut Vec<FirstCorner>,
    ) -> Result<(), NoBound> {
        let (FromRest::Fixed(arc) | FromRest::Slides(_, arc)) = self.still else {
            return Err(NoBound::Modes);
        };
        if !arc.normal.is_negative() {
            return Err(NoBound::Modes);
        }
        let apart = (rate.square() + (-arc.normal * gap).times(2.0)).sqrt();
        let y = I::from(apart.hi.min(landing(-arc.normal).hi));
        let xi = arc.along.magnitude() * (rate + y) / -arc.normal;
        corners.push(FirstCorner { contact: self.m, xi: xi.hi, y: y.hi });
        Ok(())
    }
}

/// For each landing contact and each cell: the logarithm of the largest later ‖q̇‖ after a corner with r = 1.
struct Growths {
    grid: &'static Grid,
    values: [Vec<f64>; 2],
}

fn growths(map: &CornerMap, metric: &Metric, times: [I; 2]) -> Result<Growths, NoBound> {
    let drift = map.local().drift;
    let forms = [0, 1].map(|j| between(metric, j, drift * times[j]));
    let base = |j: usize, cell: &Cell, end: SlideEnd| {
        let square = match end {
            // Corners follow each other at both contacts.
            SlideEnd::Attracts(Attraction { speed, wide, .. }) => {
                let all = forms.iter().flatten().map(Form::largest).fold(0.0, f64::max);
                let r = speed.magnitude().square() * (I::ONE + I::from(wide).square());
                (r * I::from(all)).hi
            }
            _ => forms[j].iter().map(|form| form.most(cell)).fold(0.0, f64::max),
        };
        0.5 * libm::log(square.max(f64::MIN_POSITIVE))
    };
    for level in 0..CELLS.len() {
        let grid = Grid::of(level);
        let values = Graph::new(map, grid).and_then(|graph| graph.longest(base));
        if let Ok(values) = values {
            return Ok(Growths { grid, values });
        }
    }
    Err(NoBound::Cells)
}

/// Bounds on ‖q̇‖² at three instants between corners: at the start of the flight after a corner at j, at its end (s has
/// changed by `drift` y), and at the end of a slide before the corner, where ξ = 0 and the rate is at most y.
fn between(metric: &Metric, j: usize, drift: I) -> [Form; 3] {
    let stop = Form { xx: I::ZERO, xy: I::ZERO, yy: metric.shift[j].square() + metric.inverse[j] };
    [metric.at(j, I::ZERO), metric.at(j, drift), stop]
}

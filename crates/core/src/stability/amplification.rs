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
use crate::stability::certify::{CELLS, Graph, Grid, SlideEnd};
use crate::stability::corner::{Arc, Cell, CornerMap, Form, FromRest, Image, Local};
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
        }
    }
}

/// Number of cells into which √x is divided, x being the part of the energy at one contact, see [`settling`].
const SHARES: usize = 32;

/// Blocks (impacts in a row at one contact) of up to this number of impacts are treated one by one, longer ones together.
const IMPACTS: usize = 4;

/// The iteration for W in [`settling`]: the largest number of rounds of eight steps, and the factor by which W is enlarged before each
/// check.
const ROUNDS: usize = 500;
const SLACK: f64 = 1.01;

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
    let time = settling(l, &metric, weights);
    if !time.is_finite() {
        return Err(NoBound::Rounding);
    }
    let drift = upper(l.drift * I::new(0.0, time));
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

/// The largest absolute value.
fn upper(x: I) -> I {
    I::from(x.lo.abs().max(x.hi.abs()))
}

fn larger(x: I, y: I) -> I {
    I::new(x.lo.max(y.lo), x.hi.max(y.hi))
}

/// ‖q̇‖² = s² + u·D⁻¹u in the coordinates of the corners.
struct Metric {
    /// det D and diagonal of D⁻¹
    det: I,
    inverse: [I; 2],
    /// At a corner at j, s = ξ + `shift[j]` y. The other contact is on the terrain.
    shift: [I; 2],
}

impl Metric {
    fn new(l: &Local) -> Self {
        let det = l.nn[0][0] * l.nn[1][1] - l.nn[0][1] * l.nn[1][0];
        Self {
            det,
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

/// C: the time from a start to the first Zeno point is at most C√(2E), with E = ½u·D⁻¹u + λ·h at the start. The result is infinite if no C
/// is found.
///
/// Consecutive impacts at one contact are a *block*. Let E_j = (½u_j² + g_j h_j)/D_jj, which changes at impacts only. A block of n impacts
/// at j starts with the energies E and E_j = y E. With w = e_jⁿ it takes the time T_j √y √E (1 − w), and it leaves E' = E (1 − (1 − w²) y)
/// and E_j' = w² E_j. After a block at i with E_i = x E the next block, at j, has y ≥ Y(x)². W_i(x) √E is a bound of the remaining time if
/// for all y and n
///
/// ```text
/// W_i(x) ≥ T_j √y (1 − w) + √(E'/E) W_j(x'),   x' = E_j'/E'
/// ```
///
/// W is computed by iteration on cells of √x and √y, and the inequality is checked at the end.
fn settling(l: &Local, metric: &Metric, weights: [I; 2]) -> f64 {
    // E_i is at most `most` times E; and E_i κ + (√E_j + |ψ|√E_i)²/(1 − ψ²) is at least E at an impact at j, κ = `kappa`.
    let ratio = [0, 1].map(|i| l.g[i] / (l.nn[i][i] * weights[i]));
    let most = ratio.map(|ratio| ratio.hi.max(1.0));
    let kappa = ratio.map(|ratio| larger(I::ONE, I::ONE / ratio).hi);
    let coupling = (l.psi[0] * l.psi[1]).non_negative().map_or(I::ZERO, I::sqrt);
    let across = (metric.det / (l.nn[0][0] * l.nn[1][1])).lo;
    let time =
        |i: usize| ((l.nn[i][i].times(2.0)).sqrt().times(2.0) / (l.g[i] * (I::ONE - l.e[i]))).hi;
    let times = [time(0), time(1)];
    // Limits of the cells of √x, or √y.
    let limits = most.map(|most| {
        let end = most.sqrt() * (1.0 + BOUND_MARGIN);
        std::array::from_fn::<f64, { SHARES + 1 }, _>(|k| {
            end * (k as f64 / SHARES as f64) * (k as f64 / SHARES as f64)
        })
    });
    // For x up to limit k: the first cell that may contain √y.
    let first: [[usize; SHARES + 1]; 2] = std::array::from_fn(|i| {
        std::array::from_fn(|k| {
            let root = limits[i][k];
            let rest = (across * (1.0 - kappa[i] * root * root)).max(0.0).sqrt();
            let least = (rest - coupling.hi * root) * (1.0 - BOUND_MARGIN) - BOUND_MARGIN;
            limits[1 - i][1..SHARES].partition_point(|&limit| limit <= least)
        })
    });
    // Blocks at j by cell and number of impacts (the last entry: that many or more): time, √(E'/E), and the limit of x'.
    let blocks: [[[Block; IMPACTS]; SHARES]; 2] = std::array::from_fn(|j| {
        std::array::from_fn(|cell| {
            let (low, high) = (limits[j][cell], limits[j][cell + 1]);
            std::array::from_fn(|n| {
                let power = (0..=n).fold(I::ONE, |w, _| w * l.e[j]);
                let w = power.hi;
                let shorter = if n + 1 == IMPACTS { 0.0 } else { power.lo };
                let left = |root: f64| 1.0 - (1.0 - w * w) * root * root;
                let next =
                    if left(high) > 0.0 { w * high / left(high).sqrt() } else { f64::INFINITY };
                let next = limits[j][..SHARES]
                    .partition_point(|&limit| limit < next * (1.0 + BOUND_MARGIN));
                Block {
                    time: times[j] * high * (1.0 - shorter) * (1.0 + BOUND_MARGIN),
                    left: (left(low) + BOUND_MARGIN).max(0.0).sqrt(),
                    next,
                }
            })
        })
    });
    let together = tie(l.e, l.psi, coupling).sqrt() * (1.0 + BOUND_MARGIN);
    let wait = (0..2).map(|j| times[j] * (1.0 - l.e[j].lo) * limits[j][SHARES]).fold(0.0, f64::max)
        * (1.0 + BOUND_MARGIN);
    // Bound from a start with a block at either contact, and W after a block at i.
    let round = |after: &[[f64; SHARES + 1]; 2]| {
        let longest: [[f64; SHARES]; 2] = std::array::from_fn(|j| {
            let mut longest = [0.0_f64; SHARES];
            let mut most = 0.0_f64;
            for cell in (0..SHARES).rev() {
                for block in &blocks[j][cell] {
                    most = most.max(block.time + block.left * after[j][block.next]);
                }
                longest[cell] = most;
            }
            longest
        });
        // After a tie the motion is as from a start, with less energy.
        let start = longest[0][0].max(longest[1][0]).max(wait / (1.0 - together).max(0.0));
        let tied = wait + together * start;
        let next: [[f64; SHARES + 1]; 2] =
            std::array::from_fn(|i| std::array::from_fn(|k| longest[1 - i][first[i][k]].max(tied)));
        (start, next)
    };
    let mut after = [[0.0; SHARES + 1]; 2];
    for _ in 0..ROUNDS {
        for _ in 0..8 {
            after = round(&after).1;
        }
        let wider = after.map(|row| row.map(|time| time * SLACK));
        let (start, again) = round(&wider);
        let holds = |i: usize| {
            wider[i].iter().zip(&again[i]).all(|(w, next)| next * (1.0 + BOUND_MARGIN) <= *w)
        };
        if holds(0) && holds(1) {
            return start * std::f64::consts::FRAC_1_SQRT_2 * (1.0 + BOUND_MARGIN);
        }
    }
    f64::INFINITY
}

/// Consecutive impacts at one contact.
#[derive(Clone, Copy)]
struct Block {
    /// Duration, for E = 1 at the start.
    time: f64,
    /// √(E'/E)
    left: f64,
    /// Index of a cell limit above x'.
    next: usize,
}

/// Largest part of the energy that remains after both contacts land at one instant and their impacts are solved together.
fn tie(e: [I; 2], psi: [I; 2], coupling: I) -> f64 {
    if e[0] == e[1] || psi[0].lo >= 0.0 {
        // u_i⁺ = −e_i u_i⁻. Either both e_i are equal, or no term of u·D⁻¹u is negative.
        let most = e[0].hi.max(e[1].hi);
        return most * most * (1.0 + BOUND_MARGIN);
    }
    // The smaller of two bounds: the largest u⁺·D⁻¹u⁺ for u·D⁻¹u = 1, and one less the least loss ½Δu·D⁻¹Δu (1 − e)/(1 + e).
    let square = coupling.square();
    let across = I::ONE - square;
    let product = e[0] * e[1];
    let sum = e[0].square() + e[1].square() - (square * product).times(2.0);
    let root = (sum.square() - (product * across).square().times(4.0)).non_negative();
    let stretched = (sum + root.map_or(I::ZERO, I::sqrt)) / across.times(2.0);
    let [one, two] = e.map(|e| ((I::ONE - e) / (I::ONE + e)).lo);
    let kept = I::ONE - I::from(one.min(two)) * (I::ONE - coupling) / (I::ONE + coupling);
    stretched.hi.min(kept.hi)
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
        let slip = (I::ONE + (drift + upper(metric.shift[m]) * rate).square()).sqrt();
        let start = Start { m, rate, gap, slip, weight: weights[m], still: map.from_rest[kept] };
        for (arc, side) in map.slides[kept].iter().zip([-1.0, 1.0]) {
            let arc = arc.as_ref().ok_or(NoBound::Modes)?;
            start.slides(arc, arc.along.times(side), &mut corners)?;
        }
        // The held contact does not slide at the start.
        start.turns(rate, gap, |pull| larger(rate, (pull / weights[m]).sqrt()), &mut corners)?;
    }
    // Both contacts rest: |s| is at most the norm of (1, drift).
    let speed = (I::ONE + drift.square()).sqrt();
    for right in [false, true] {
        for image in map.sliding_together(right).iter() {
            match image {
                Image::Rest => {}
                Image::Corner { contact, xi, y, .. } => corners.push(FirstCorner {
                    contact: *contact,
                    xi: (upper(*xi) * speed).hi,
                    y: (upper(*y) * speed).hi,
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
        let y = larger(self.rate, (pull / self.weight).sqrt());
        if gains.sign().is_none() {
            return Err(NoBound::Modes);
        }
        if gains.is_negative() {
            corners.push(FirstCorner { contact, xi: self.slip.hi, y: y.hi });
            // State when the slide ends: bounded by its duration and, where m falls, by √(u² + 2 pull h), which is constant.
            let time = self.slip / -gains;
            let lift = I::new(0.0, arc.normal.hi.max(0.0));
            let mut rate = self.rate + upper(arc.normal) * time;
            let mut gap = self.gap + time * (self.rate + (lift * time).times(0.5));
            let falls = arc.normal.is_negative();
            if falls {
                rate = I::from(rate.hi.min(y.hi));
                gap = I::from(gap.hi.min((y.square() / pull.times(2.0)).hi));
            }
            let landing = |other: I| {
                if falls { y * larger(I::ONE, other / pull).sqrt() } else { I::from(f64::INFINITY) }
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
        let xi = upper(arc.along) * (rate + y) / -arc.normal;
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
            SlideEnd::Attracts { speed, wide } => {
                let all = forms.iter().flatten().map(Form::largest).fold(0.0, f64::max);
                let r = upper(speed).square() * (I::ONE + I::from(wide).square());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::contact::Contact;
    use crate::body::fields::PostureFields;
    use crate::body::posture::Posture;
    use crate::body::state::State;
    use crate::options::{Model, Options, Stop};
    use crate::simulate::simulate;

    /// Numbers in [0, 1), evenly distributed.
    fn share(k: usize, factor: f64) -> f64 {
        (k as f64 * factor).fract()
    }

    fn posture(k: usize) -> Posture {
        let at = |factor, low: f64, high: f64| low + (high - low) * share(k, factor);
        let contact = |x: f64, y: f64, slope: f64, e: f64| Contact {
            restitution: Some(e),
            ..Contact::at(x, y).on_slope(slope)
        };
        let e = at(0.618_033_988, 0.0, 0.9);
        let other = if k.is_multiple_of(3) { at(0.302_775_637, 0.0, 0.9) } else { e };
        Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: at(0.414_213_562, 0.2, 1.5),
            center_of_mass: [at(0.732_050_807, -1.0, 1.0), at(0.236_067_977, -1.0, 2.0)],
            contacts: vec![
                contact(-1.0, 0.0, at(0.645_751_311, -0.9, 0.9), e),
                contact(1.0, 0.0, at(0.316_624_790, -0.9, 0.9), other),
            ],
            restitution: 0.0,
            gravity: 1.0,
            ..PostureFields::default()
        })
        .unwrap()
    }

    #[test]
    fn no_motion_takes_longer_to_its_first_zeno_point() {
        let (mut postures, mut largest) = (0, 0.0_f64);
        for k in 0..400 {
            let posture = posture(k);
            let Some(l) = Local::new(&posture) else { continue };
            let weights = l.weights();
            if !weights.iter().chain(&l.g).all(|x| x.is_positive()) {
                continue;
            }
            postures += 1;
            let time = settling(&l, &Metric::new(&l), weights);
            for n in 0..25 {
                let j = 25 * k + n;
                let rate = |factor| 1e-3 * (2.0 * share(j, factor) - 1.0);
                let qdot = [rate(0.123_105_625), rate(0.358_898_943), rate(0.795_831_523)];
                let mut q = [0.0; 3];
                if n % 2 == 1 {
                    q[1] = 1e-6 * share(j, 0.567_764_362);
                }
                let start = State::new(q, qdot);
                let options =
                    Options { model: Model::Local, stop: Stop::Zeno, ..Options::default() };
                let run = simulate(&posture, &start, &options).unwrap();
                let zeno = &run.zeno_points()[0];
                // 2E from the rows of the geometry.
                let rows = posture.geometry();
                let u = [0, 1].map(|i| rows[i].local_gap(&qdot.into()));
                let h = [0, 1].map(|i| rows[i].local_gap(&q.into()));
                let nn = l.nn.map(|row| row.map(I::middle));
                let det = nn[0][0] * nn[1][1] - nn[0][1] * nn[1][0];
                let kinetic = (nn[1][1] * u[0] * u[0] - 2.0 * nn[0][1] * u[0] * u[1]
                    + nn[0][0] * u[1] * u[1])
                    / det;
                let twice: f64 =
                    kinetic + 2.0 * (weights[0].middle() * h[0] + weights[1].middle() * h[1]);
                let part = zeno.elapsed / (time * twice.sqrt());
                largest = largest.max(part);
                assert!(part <= 1.0, "{posture:?} {qdot:?}: {part}");
            }
        }
        assert!(postures > 200, "{postures}");
        // The bound is not needlessly large: it is reached within a factor of three.
        assert!(largest > 1.0 / 3.0, "{largest}");
    }
}

//! From the corner map to a decision.
//!
//! *Stable*: the angles φ of the corners at each contact are divided into cells. From each cell there is an edge to every cell that its
//! image meets, with an upper bound of the growth ln G. No chain of cells grows for ever if there is a potential V ≥ 0 with
//!
//! ```text
//! V(cell) ≥ ln G(cell) + ε + V(next)     for all next cells.
//! ```
//!
//! Then every sequence of corners shrinks, or ends at rest. The fast-slide ends φ = ±π/2 are treated separately, because r does not change
//! there. Each cycle of corners multiplies the landing speeds by a constant κ. If κ < 1, impacts accumulate, and both contacts slide
//! together afterwards. If κ > 1, the corners leave the end, and a geometric sum bounds the growth until then.
//!
//! *Unstable*: an enclosed cycle of corners certainly grows, or after some corner the body certainly moves away.

use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::stability::cells::{CELLS, Graph, Grid, Open, SlideEnd, fast_cycle, round, size};
use crate::stability::corner::{Away, Cell, CornerMap, Image, Images};
use crate::stability::trap::{self, TrapCell};
use crate::tolerance::{ORBIT_CLOSED, SLIDE_END, TRIGONOMETRIC_ERROR};
use serde::{Deserialize, Serialize};

type I = Interval;

/// Number of steps of an orbit in the search for a cycle, and length of the longest cycle.
const ORBIT: usize = 240;
const LONGEST_CYCLE: usize = 24;

/// Half-widths of the intervals of φ around a cycle, tried in turn.
const AROUND: [f64; 3] = [1e-10, 1e-8, 1e-6];

/// Number of times that an interval around a cycle is replaced by the part of it in which its image lies, too.
const NARROWINGS: usize = 16;

/// A corner of a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// The contact that lands.
    pub(crate) contact: usize,
    /// φ = atan(ξ/y)
    pub(crate) phi: f64,
    /// ln r'/r to the next corner, r² = ξ² + y². In a growing cycle that is proved: a lower bound, or so that their sum is one.
    pub(crate) growth: f64,
}

/// Cells of the ratio ξ/y of a corner, and a potential V for each cell: V(cell) ≥ ln G + 1e-9 + V(next), so no sequence of corners grows
/// for ever. y is the landing speed. ξ is the sliding velocity of the other contact, divided by the velocity of this contact per unit speed
/// of the body when both contacts slide (length in the mass metric). r² = ξ² + y², and G is the growth of r.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Potential {
    /// Limits between the cells, increasing.
    pub limits: Vec<f64>,
    /// V for each contact that lands, in the order of the cells.
    #[serde(rename = "potential")]
    pub values: [Vec<f64>; 2],
    /// For each landing contact two ratios ξ/y: below the first and above the second one, a corner is in a fast-slide end. There, corners
    /// follow each other until both contacts slide together or the corners leave the end; V holds for this sequence as a whole.
    pub ends: [[Option<f64>; 2]; 2],
}

/// Decision of the corner map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Decision {
    Stable(Potential),
    /// A growing cycle.
    Grows(Vec<Corner>),
    /// Corners in which all motions grow.
    Trap(Vec<TrapCell>),
    /// A corner after which the body moves away.
    Escapes(Corner),
    /// A motion with contacts on the terrain in which the body moves away.
    Leaves(Away),
    /// The reason, the number of cells per contact, and the undecided cells: (contact, φ from, φ to).
    Undecided {
        reason: WhyUndecided,
        cells: usize,
        left: Vec<(usize, [f64; 2])>,
    },
}

/// Why a posture is undecided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum WhyUndecided {
    /// The contacts hold the body in some scenes within the width, and in others they do not.
    Boundary,
    /// Several words are consistent at rest.
    Ambiguous,
    /// The contacts depend on each other, or nearly so, or the signs that decide are not certain.
    Degenerate,
    /// A contact that slides jams, or may jam: no mode is consistent (Painlevé).
    Jam,
    /// After a slide or a landing several modes are consistent, or the intervals do not decide.
    Modes,
    /// Frictionless motion need not come to rest: λ > 0 fails, and so does the drift that can replace it.
    Energy,
    /// The impacts after a corner cannot be followed to their end with certainty.
    Flight,
    /// Some cells remain undecided.
    Cells,
    /// Three and more contacts: several pairs of contacts let the body descend, or the only one is undecided itself.
    Pairs,
    /// No theorem here decides about the mechanism, which is no rigid body: only friction holds its load.
    Joints,
    /// A mechanism: a slide on a level is perhaps not resisted, because forces may shift to contacts that do not resist it.
    Slides,
    /// A mechanism: friction may hold it away from its posture, above it.
    Held,
    /// A mechanism that slides on a level: rest is proved for Moreau's law with one restitution for all contacts, also in tangential direction.
    Law,
    /// A mechanism of too many contacts or slides to try all of them.
    Many,
}

impl WhyUndecided {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::Boundary,
        Self::Ambiguous,
        Self::Degenerate,
        Self::Jam,
        Self::Modes,
        Self::Energy,
        Self::Flight,
        Self::Cells,
        Self::Pairs,
        Self::Joints,
        Self::Slides,
        Self::Held,
        Self::Law,
        Self::Many,
    ];

    /// Its name in files.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Boundary => "boundary",
            Self::Ambiguous => "ambiguous",
            Self::Degenerate => "degenerate",
            Self::Jam => "jam",
            Self::Modes => "modes",
            Self::Energy => "energy",
            Self::Flight => "flight",
            Self::Cells => "cells",
            Self::Pairs => "pairs",
            Self::Joints => "joints",
            Self::Slides => "slides",
            Self::Held => "held",
            Self::Law => "law",
            Self::Many => "many",
        }
    }

    /// The same in words, as reports and pages have it.
    #[must_use]
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::Boundary => {
                "the centre of mass is on the boundary of the equilibrium region, up to the width of the numbers"
            }
            Self::Ambiguous => {
                "several contact modes are consistent at rest; rigid-body mechanics does not say which one follows"
            }
            Self::Degenerate => {
                "the contacts depend on each other, or nearly so, or rounding decides a sign"
            }
            Self::Jam => {
                "a contact that slides jams, or may jam: no contact mode is consistent (Painlevé)"
            }
            Self::Modes => {
                "after a slide or a landing several contact modes are consistent, or rounding decides"
            }
            Self::Energy => {
                "frictionless motion need not come to rest on the contacts: neither its energy nor a drift bounds it"
            }
            Self::Flight => {
                "the impacts after a corner cannot be followed to their end with certainty"
            }
            Self::Cells => "some directions of motion remain open: the evidence lists them",
            Self::Pairs => {
                "the body descends on several pairs of contacts, or on one that is undecided itself"
            }
            Self::Joints => {
                "no theorem here decides about this mechanism: without friction its contacts do not hold the load"
            }
            Self::Slides => {
                "a slide on a level is perhaps not resisted: the load may shift to contacts that do not resist it"
            }
            Self::Held => "friction may hold the bodies away from the posture, above it",
            Self::Law => {
                "that friction ends slides on a level is proved for Moreau's law only, with one restitution for all contacts, the same in tangential direction"
            }
            Self::Many => "there are too many contacts or slides to try all of them",
        }
    }
}

/// The decision of the corner map. It includes motions with contacts on the terrain and the frictionless energy argument.
pub(crate) fn decide(map: &CornerMap) -> Decision {
    if let Some(away) = map.leaves() {
        return Decision::Leaves(away);
    }
    let slides = [false, true].map(|right| map.sliding_together(right));
    let unknown = |images: &Images| images.iter().any(|image| *image == Image::Unknown);
    let reason = if map.jams() {
        Some(WhyUndecided::Jam)
    } else if !map.returns() || slides.iter().any(unknown) {
        Some(WhyUndecided::Modes)
    } else if map.local().flights_end().is_none() {
        Some(WhyUndecided::Energy)
    } else if map.flies_unknown() {
        Some(WhyUndecided::Flight)
    } else {
        None
    };
    // The coarse grid is cheaper than any orbit.
    // Where a flight is cut early its images are wide, and the finest cells hardly decide more.
    let levels = match reason {
        Some(_) => 0,
        None if map.flies_far() => CELLS.len() - 1,
        None => CELLS.len(),
    };
    let mut left = Vec::new();
    for level in 0..levels.max(1) {
        if level < levels {
            match stable(map, Grid::of(level)) {
                Ok(potential) => return Decision::Stable(potential),
                Err(open) => left = open,
            }
        }
        if level == 0
            && let Some(found) = follow(map)
        {
            return found;
        }
        // Where a contact jams, a start without a motion decides.
        if level == 0
            && reason != Some(WhyUndecided::Jam)
            && let Some(trap) = trap::find(map)
        {
            return Decision::Trap(trap);
        }
    }
    let cells = if levels == 0 { 0 } else { Grid::of(levels - 1).cells.len() };
    let open = if map.flies_far() { WhyUndecided::Flight } else { WhyUndecided::Cells };
    Decision::Undecided { reason: reason.unwrap_or(open), cells, left }
}

/// A potential over the cells, or the cells that prevent one.
fn stable(map: &CornerMap, grid: &Grid) -> Result<Potential, Open> {
    let graph = Graph::new(map, grid)?;
    let values = graph.longest(|_, _, _| 0.0)?;
    let limits = &grid.limits;
    let ends = graph.zones.map(|[left, right]| {
        let found = |end: (SlideEnd, usize)| end.0 != SlideEnd::Ordinary;
        [
            found(left).then(|| grid.zone_limit(false, left.1)),
            found(right).then(|| grid.zone_limit(true, right.1)),
        ]
    });
    Ok(Potential { limits: limits.clone(), values, ends })
}

/// A cycle of two corners in a fast slide that certainly grows: κ > 1, and the ratio ξ/y = a/(κ − 1) that one round keeps is in the domain of
/// the fast slide. The landing speeds and the sliding speed are multiplied by κ once around.
fn fast_slide_grows(map: &CornerMap) -> Option<Decision> {
    for (j, right) in [(0, false), (0, true), (1, false), (1, true)] {
        let Some((cycle, other)) = fast_cycle(map, j, right) else { continue };
        let (kappa, a) = round(cycle);
        let slope = a / (kappa - I::ONE);
        let next = (slope + cycle[0].b) / cycle[0].k;
        let side = if right { 1.0 } else { -1.0 };
        let ours = |slope: I| slope.times(side).is_positive();
        if !(kappa.lo > 1.0 && ours(slope) && ours(next) && cycle[0].k.is_positive()) {
            continue;
        }
        let leads = |from: usize, slope: I, to: usize| {
            let [low, high] = [(slope.lo, -1.0), (slope.hi, 1.0)]
                .map(|(slope, way)| libm::atan(slope) + way * TRIGONOMETRIC_ERROR);
            let image = only(&map.images(from, &Cell::new(low, high)));
            matches!(image, Some(Image::Corner { contact, slope, .. }) if contact == to && ours(slope))
        };
        if leads(j, slope, other) && leads(other, next, j) {
            let [one, two] = [slope, next].map(I::middle);
            let growth = libm::log(cycle[0].k.middle())
                + 0.5 * libm::log((1.0 + two * two) / (1.0 + one * one));
            let first = Corner { contact: j, phi: libm::atan(one), growth };
            // The sum of both growths is proved.
            let growth = kappa.ln().lo - growth;
            let second = Corner { contact: other, phi: libm::atan(two), growth };
            return Some(Decision::Grows(vec![first, second]));
        }
    }
    None
}

/// The image of a corner, if it has exactly one.
fn only(images: &Images) -> Option<Image> {
    let mut list = images.iter();
    match (list.next(), list.next()) {
        (Some(image), None) => Some(*image),
        _ => None,
    }
}

/// Follows orbits of single corners to a growing cycle or until the body moves away.
fn follow(map: &CornerMap) -> Option<Decision> {
    for start in [0.0, 1.2, -1.2] {
        for j in 0..2 {
            if let Some(found) = orbit(map, j, start) {
                return Some(found);
            }
        }
    }
    fast_slide_grows(map)
}

fn orbit(map: &CornerMap, contact: usize, phi: f64) -> Option<Decision> {
    let (mut j, mut phi) = (contact, phi);
    let mut way: Vec<Corner> = Vec::new();
    for step in 0..ORBIT {
        if step % LONGEST_CYCLE == 0
            && let Some(found) = back(map, &way)
        {
            return found;
        }
        let images = map.images(j, &Cell::point(phi));
        match only(&images)? {
            Image::Escape => {
                return Some(Decision::Escapes(Corner { contact: j, phi, growth: 0.0 }));
            }
            Image::Corner { contact, xi, y, .. } => {
                let (xi, y) = (xi.middle(), y.middle());
                let r = libm::hypot(xi, y);
                if !(r > 0.0 && y > SLIDE_END * r) {
                    return None; // at rest, or at a fast-slide end
                }
                way.push(Corner { contact: j, phi, growth: libm::log(r) });
                (j, phi) = (contact, libm::atan2(xi, y));
            }
            Image::Rest | Image::Unknown => return None,
        }
    }
    None
}

/// The cycle that an orbit has reached, if the cycle certainly grows. `Some(None)`: the orbit has reached a cycle that does not certainly
/// grow.
#[allow(clippy::option_option, reason = "none yet, or one that does not grow")]
fn back(map: &CornerMap, way: &[Corner]) -> Option<Option<Decision>> {
    let last = way.len().checked_sub(1)?;
    let period = (1..=LONGEST_CYCLE.min(last)).find(|p| {
        let (one, two) = (&way[last], &way[last - p]);
        one.contact == two.contact && (one.phi - two.phi).abs() <= ORBIT_CLOSED
    })?;
    let cycle = &way[last + 1 - period..];
    let growth: f64 = cycle.iter().map(|corner| corner.growth).sum();
    let proved = if growth > 0.0 { verified(map, cycle) } else { None };
    Some(proved.map(|growths| {
        let with = |(corner, growth): (&Corner, f64)| Corner { growth, ..*corner };
        Decision::Grows(cycle.iter().zip(growths).map(with).collect())
    }))
}

/// Lower bounds of the growths at the corners of a cycle close to this one, if that exists and certainly grows. It exists if the angle of the
/// image less the angle itself has opposite signs at the two ends of an interval of angles around the first corner.
fn verified(map: &CornerMap, cycle: &[Corner]) -> Option<Vec<f64>> {
    // Starts at a corner with ξ = 0 exactly, if there is one: its cell is a point.
    let first = cycle.iter().position(|corner| corner.phi == 0.0).unwrap_or(0);
    let Corner { contact, phi, .. } = cycle[first];
    let turn = |phi: I| -> Option<(I, Vec<f64>)> {
        let (mut j, mut growths, mut phi) = (contact, Vec::with_capacity(cycle.len()), phi);
        for _ in cycle {
            let images = map.images(j, &Cell::new(phi.lo, phi.hi));
            let Some(Image::Corner { contact, xi, y, slope, .. }) = only(&images) else {
                return None;
            };
            growths.push(size(xi, y).lo);
            phi = if slope == I::ZERO {
                I::ZERO
            } else {
                I::new(
                    libm::atan(slope.lo) - TRIGONOMETRIC_ERROR,
                    libm::atan(slope.hi) + TRIGONOMETRIC_ERROR,
                )
            };
            j = contact;
        }
        (j == contact).then_some((phi, growths))
    };
    let grows = |growths: &[f64]| {
        growths.iter().fold(I::ZERO, |sum, growth| sum + I::from(*growth)).lo > 0.0
    };
    // In the order of the cycle that is given.
    let in_order = |mut growths: Vec<f64>| {
        growths.rotate_right(first);
        growths
    };
    if phi == 0.0 {
        let (angle, growths) = turn(I::ZERO)?;
        return (angle == I::ZERO && grows(&growths)).then(|| in_order(growths));
    }
    AROUND.iter().find_map(|&half| {
        let around = I::new(phi - half, phi + half);
        let (_, growths) = turn(around)?;
        if !grows(&growths) {
            return None;
        }
        // With exactly one image over the interval the map is continuous, so image less angle has a zero.
        let side =
            |end: f64| turn(I::from(end)).and_then(|(image, _)| (image - I::from(end)).sign());
        match (side(around.lo), side(around.hi)) {
            (Some(low), Some(high)) if low * high < 0 => {}
            _ => return None,
        }
        // The angle of the cycle is in its own image. If the cycle attracts, this narrows the interval.
        let mut inside = around;
        for _ in 0..NARROWINGS {
            let (image, _) = turn(inside)?;
            inside = I::new(image.lo.max(inside.lo), image.hi.min(inside.hi));
        }
        Some(in_order(turn(inside)?.1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Jams;
    use crate::stability::local::Local;
    use crate::stability::tests::odd;

    #[test]
    fn a_growing_cycle_comes_back_to_its_first_corner_and_grows() {
        let map = CornerMap::of(Local::new(&odd(0.26), 0.0).expect("two contacts"), Jams::None);
        let Decision::Grows(cycle) = decide(&map) else { panic!("no growing cycle") };
        let (mut at, mut growth) = ((cycle[0].contact, cycle[0].phi), 0.0);
        for corner in cycle.iter().chain([&cycle[0]]) {
            assert!(at.0 == corner.contact && (at.1 - corner.phi).abs() < 1e-8, "{at:?}");
            let images = map.images(at.0, &Cell::point(at.1));
            let Some(Image::Corner { contact, xi, y, .. }) = only(&images) else { panic!() };
            at = (contact, libm::atan2(xi.middle(), y.middle()));
            growth += libm::log(libm::hypot(xi.middle(), y.middle()));
        }
        assert!((growth - cycle[0].growth - 0.744834).abs() < 2e-6, "{growth}");
    }
}

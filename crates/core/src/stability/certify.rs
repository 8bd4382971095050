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

use std::sync::OnceLock;

use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::stability::corner::{Away, Cell, CornerMap, Image, Images};
use crate::tolerance::{
    CELL_LIMIT_ROUNDING, ORBIT_CLOSED, SLIDE_END, STRICT_DECREASE, TRIGONOMETRIC_ERROR,
};
use serde::{Deserialize, Serialize};

type I = Interval;

/// Number of equal cells with |ξ| ≤ y for each contact. The grids are tried from coarse to fine.
pub(super) const CELLS: [usize; 3] = [24, 96, 384];

/// Ratio y/|ξ| at the limit of the outermost cells.
const NEAREST: f64 = 1e-4;

/// Largest change of ξ, relative to ξ, that the corners of a zone around a fast-slide end may cause.
const BEND: f64 = 0.5;

/// Largest relative increase of the sliding speed |ξ| in an attracting fast-slide end.
const LONGER: f64 = 1000.0;

/// Largest growth ln r on the way out of the zone of a repelling fast-slide end. If the growth is larger, a smaller zone is better.
const TRANSIT: f64 = 0.05;

/// Number of steps of an orbit in the search for a cycle, and length of the longest cycle.
const ORBIT: usize = 240;
const LONGEST_CYCLE: usize = 24;

/// Half-widths of the intervals of φ around a cycle, tried in turn.
const AROUND: [f64; 3] = [1e-10, 1e-8, 1e-6];

/// A corner of a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// The contact that lands.
    pub(crate) contact: usize,
    /// φ = atan(ξ/y)
    pub(crate) phi: f64,
    /// ln r'/r to the next corner, r² = ξ² + y².
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
    /// No theorem here covers the mechanism: more than three coordinates are free, or it has not two contacts and is no rigid body.
    Joints,
}

impl WhyUndecided {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Ambiguous,
        Self::Degenerate,
        Self::Jam,
        Self::Modes,
        Self::Energy,
        Self::Flight,
        Self::Cells,
        Self::Pairs,
        Self::Joints,
    ];

    /// Its name in files.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Ambiguous => "ambiguous",
            Self::Degenerate => "degenerate",
            Self::Jam => "jam",
            Self::Modes => "modes",
            Self::Energy => "energy",
            Self::Flight => "flight",
            Self::Cells => "cells",
            Self::Pairs => "pairs",
            Self::Joints => "joints",
        }
    }

    /// The same in words, as reports and pages have it.
    #[must_use]
    pub const fn in_words(self) -> &'static str {
        match self {
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
                "no theorem here covers this mechanism: they are for rigid bodies, and for two contacts of three free coordinates"
            }
        }
    }
}

/// The cells of the angles φ: the limits between them, and the tangents of these limits.
pub(super) struct Grid {
    pub(super) cells: Vec<Cell>,
    limits: Vec<f64>,
}

impl Grid {
    fn new(n: usize) -> Self {
        // Equal cells for |ξ| ≤ y. Outside, y/|ξ| shrinks by a constant ratio from cell to cell.
        let quarter = std::f64::consts::FRAC_PI_4;
        let ratio = 1.0 - 2.0 * quarter / n as f64 * 2.0;
        let count = (libm::log(NEAREST) / libm::log(ratio)).ceil() as usize;
        let outer = (1..=count).map(|k| {
            let angle = libm::atan(libm::pow(ratio, k as f64));
            2.0 * quarter - angle
        });
        let outer: Vec<f64> = outer.collect();
        let inner = (0..=n).map(|k| quarter * (2.0 * k as f64 / n as f64 - 1.0));
        let mut angles = vec![-2.0 * quarter];
        angles.extend(outer.iter().rev().map(|angle| -angle));
        angles.extend(inner);
        angles.extend(outer.iter());
        angles.push(2.0 * quarter);
        Self {
            cells: angles.windows(2).map(|pair| Cell::new(pair[0], pair[1])).collect(),
            limits: angles[1..angles.len() - 1].iter().map(|&angle| libm::tan(angle)).collect(),
        }
    }

    /// The grid of `CELLS[level]`.
    pub(super) fn of(level: usize) -> &'static Self {
        static GRIDS: [OnceLock<Grid>; CELLS.len()] = [const { OnceLock::new() }; CELLS.len()];
        GRIDS[level].get_or_init(|| Self::new(CELLS[level]))
    }

    /// First and last cell that may contain a direction.
    fn range(&self, slope: I) -> (usize, usize) {
        // The limits have the rounding error of a tangent.
        let slack = |x: f64, side: f64| x + side * CELL_LIMIT_ROUNDING * (1.0 + x.abs());
        let (low, high) = (slack(slope.lo, -1.0), slack(slope.hi, 1.0));
        (
            self.limits.partition_point(|&limit| limit < low),
            self.limits.partition_point(|&limit| limit <= high),
        )
    }
}

/// ln r, r² = ξ² + y².
fn size(xi: I, y: I) -> I {
    let square = xi.square() + y.square();
    if square.lo > 0.0 {
        square.ln().times(0.5)
    } else {
        I::new(f64::NEG_INFINITY, I::from(square.hi.max(f64::MIN_POSITIVE)).ln().hi * 0.5)
    }
}

/// An edge of the graph: to the cells `from..=to` of a contact.
#[derive(Debug, Clone, Copy)]
struct Edge {
    contact: usize,
    from: usize,
    to: usize,
    growth: f64,
}

/// Behaviour at a fast-slide end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SlideEnd {
    /// Not a fast-slide end.
    Ordinary,
    /// Both contacts finally slide together. Until then, if ξ = 1 at the start, ξ stays in `speed`, and y ≤ `wide` |ξ|.
    Attracts {
        speed: I,
        wide: f64,
    },
    /// The corners leave the end. The number is a bound of the growth ln r until then.
    Repels(f64),
    Unknown,
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
    let levels = if reason.is_some() { 0 } else { CELLS.len() };
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
    }
    let cells = if levels == 0 { 0 } else { Grid::of(levels - 1).cells.len() };
    Decision::Undecided { reason: reason.unwrap_or(WhyUndecided::Cells), cells, left }
}

/// A potential over the cells, or the cells that prevent one.
fn stable(map: &CornerMap, grid: &Grid) -> Result<Potential, Open> {
    let graph = Graph::new(map, grid)?;
    let values = graph.longest(|_, _, _| 0.0)?;
    let limits = &grid.limits;
    let ends = graph.zones.map(|[left, right]| {
        let found = |end: (SlideEnd, usize)| end.0 != SlideEnd::Ordinary;
        [
            found(left).then(|| limits[left.1 - 1]),
            found(right).then(|| limits[limits.len() - right.1]),
        ]
    });
    Ok(Potential { limits: limits.clone(), values, ends })
}

/// Undecided cells: the contact, and the limits of φ.
type Open = Vec<(usize, [f64; 2])>;

/// The cells of a grid and the cells that their images meet, with bounds on the growth.
pub(super) struct Graph<'g> {
    grid: &'g Grid,
    /// Edges of all cells. Those of cell k at contact j are `starts[j * n + k]..starts[j * n + k + 1]`, n cells per contact.
    edges: Vec<Edge>,
    starts: Vec<usize>,
    /// The fast-slide ends of each contact, left and right, and their sizes in cells.
    zones: [[(SlideEnd, usize); 2]; 2],
}

impl<'g> Graph<'g> {
    /// The graph, or the cells without a certain image.
    pub(super) fn new(map: &CornerMap, grid: &'g Grid) -> Result<Self, Open> {
        let n = grid.cells.len();
        let zones = [0, 1].map(|j| [false, true].map(|right| zone(map, grid, j, right)));
        let (edges, starts) = (Vec::with_capacity(4 * n), Vec::with_capacity(2 * n + 1));
        let mut graph = Self { grid, edges, starts, zones };
        let mut left = Vec::new();
        for j in 0..2 {
            for (k, cell) in grid.cells.iter().enumerate() {
                graph.starts.push(graph.edges.len());
                let (what, right) = graph.kind(j, k);
                let images = match what {
                    SlideEnd::Unknown => {
                        left.push((j, cell.phi));
                        continue;
                    }
                    SlideEnd::Attracts { speed, .. } => {
                        let mut images = Images::none();
                        map.together(if right { speed } else { -speed }, &mut images);
                        images
                    }
                    _ => map.images(j, cell),
                };
                for image in images.iter() {
                    match *image {
                        Image::Rest => {}
                        Image::Corner { contact, slope, most, .. } => {
                            let (from, to) = grid.range(slope);
                            let growth = libm::log(most.max(f64::MIN_POSITIVE)) + STRICT_DECREASE;
                            graph.edges.push(Edge { contact, from, to, growth });
                        }
                        Image::Escape | Image::Unknown => {
                            left.push((j, cell.phi));
                        }
                    }
                }
            }
        }
        graph.starts.push(graph.edges.len());
        if left.is_empty() {
            Ok(graph)
        } else {
            left.dedup();
            Err(left)
        }
    }

    /// The fast-slide end in which cell k at contact j is, and whether it is the right one.
    fn kind(&self, j: usize, k: usize) -> (SlideEnd, bool) {
        let ([left, right], back) = (self.zones[j], self.grid.cells.len() - 1 - k);
        if k < left.1 {
            (left.0, false)
        } else if back < right.1 {
            (right.0, true)
        } else {
            (SlideEnd::Ordinary, false)
        }
    }

    /// For a cell in a repelling end: whether it is the right end, and the growth until the corners leave it.
    fn repels(&self, contact: usize, cell: usize) -> Option<(bool, f64)> {
        match self.kind(contact, cell) {
            (SlideEnd::Repels(_), right) => {
                let transit = |j: usize| match self.zones[j][usize::from(right)].0 {
                    SlideEnd::Repels(transit) => transit,
                    _ => 0.0,
                };
                Some((right, transit(0).max(transit(1))))
            }
            _ => None,
        }
    }

    /// For every cell, by contact and in the order of the cells: the largest value, over all chains of cells from this cell on, of the sum
    /// of the growths plus `base` of the last cell. If some cycle of cells grows, the result is that cycle. Arguments of `base`: contact,
    /// cell, its fast-slide end.
    pub(super) fn longest(
        &self,
        base: impl Fn(usize, &Cell, SlideEnd) -> f64,
    ) -> Result<[Vec<f64>; 2], Open> {
        let (grid, edges, starts) = (self.grid, &self.edges, &self.starts);
        let n = grid.cells.len();
        let at = |contact: usize, cell: usize| contact * n + cell;
        let bases: Vec<f64> = (0..2 * n)
            .map(|c| base(c / n, &grid.cells[c % n], self.kind(c / n, c % n).0))
            .collect();
        // The growth of chains within a repelling end is in its transit.
        let mut potential = bases.clone();
        let mut pools = [(f64::NEG_INFINITY, NONE); 2];
        // The successor of each cell on the chain that gives its potential.
        let mut next = vec![NONE; 2 * n];
        loop {
            let mut changed = false;
            for j in 0..2 {
                for k in 0..n {
                    let own = self.repels(j, k);
                    let (mut value, mut to) = (bases[at(j, k)], NONE);
                    for edge in &edges[starts[at(j, k)]..starts[at(j, k) + 1]] {
                        for cell in edge.from..=edge.to.min(n - 1) {
                            let inside = own.is_some_and(|(right, _)| {
                                self.repels(edge.contact, cell)
                                    .is_some_and(|(other, _)| other == right)
                            });
                            let then = at(edge.contact, cell);
                            if !inside && edge.growth + potential[then] > value {
                                (value, to) = (edge.growth + potential[then], then);
                            }
                        }
                    }
                    if let Some((right, transit)) = own {
                        // A sequence in a repelling zone may leave it from any of its cells.
                        value += transit;
                        let pool = &mut pools[usize::from(right)];
                        if value > pool.0 {
                            *pool = (value, to);
                        }
                        (value, to) = *pool;
                    }
                    if value > potential[at(j, k)] {
                        (potential[at(j, k)], next[at(j, k)]) = (value, to);
                        changed = true;
                    }
                }
            }
            if !changed {
                let second = potential.split_off(n);
                return Ok([potential, second]);
            }
            // A cell that contributes to its own potential lies on a growing cycle. By the method of Bellman and Ford, such a
            // cell appears within n rounds if and only if the graph has a growing cycle.
            if let Some(cycle) = circle(&next) {
                return Err(cycle
                    .iter()
                    .map(|cell| (cell / n, grid.cells[cell % n].phi))
                    .collect());
            }
        }
    }
}

const NONE: usize = usize::MAX;

/// A cycle of a graph in which every node has at most one successor.
fn circle(next: &[usize]) -> Option<Vec<usize>> {
    // The walk that reached each node first.
    let mut seen = vec![NONE; next.len()];
    for start in 0..next.len() {
        let mut node = start;
        while node != NONE && seen[node] == NONE {
            seen[node] = start;
            node = next[node];
        }
        if node != NONE && seen[node] == start {
            let mut cycle = vec![node];
            while next[cycle[cycle.len() - 1]] != node {
                cycle.push(next[cycle[cycle.len() - 1]]);
            }
            cycle.sort_unstable();
            return Some(cycle);
        }
    }
    None
}

/// A corner of a fast slide: ξ' = ξ + B y, y' = K y. The slide begins at ξ + `from` y.
#[derive(Debug, Clone, Copy)]
struct Fast {
    b: I,
    k: I,
    from: I,
}

/// The two corners that follow each other at a fast-slide end, starting with contact j; the contact of the other one comes with them.
fn fast_cycle(map: &CornerMap, j: usize, right: bool) -> Option<([Fast; 2], usize)> {
    let fast =
        |j: usize| map.fast(j, right).map(|(contact, from, b, k)| (contact, Fast { b, k, from }));
    let (other, own) = fast(j)?;
    let (next, back) = fast(other)?;
    // Else the corners enter or leave the end of the other contact.
    (next == j).then_some(([own, back], other))
}

/// One round at a fast-slide end: y'' = κ y and ξ'' = ξ + a y, starting from the first corner. So ξ − x y keeps its value, with x = a/(κ − 1).
fn round([one, two]: [Fast; 2]) -> (I, I) {
    (one.k * two.k, one.b + two.b * one.k)
}

/// The fast-slide end of the corners at j: the largest zone around it, in cells, in which its kind is certain.
fn zone(map: &CornerMap, grid: &Grid, j: usize, right: bool) -> (SlideEnd, usize) {
    let Some((cycle, _)) = fast_cycle(map, j, right) else { return (SlideEnd::Ordinary, 0) };
    let n = grid.limits.len();
    let mut cells = (0..n).rev().map(|k| {
        // y/|ξ| beyond this limit
        let limit = if right { grid.limits[n - 1 - k] } else { grid.limits[k] };
        (k + 1, (1.0 / limit.abs()).next_up(), limit)
    });
    let found = cells.find_map(|(cells, width, limit)| {
        let kind = if (limit > 0.0) == right && width <= BEND {
            end(cycle, right, width)
        } else {
            SlideEnd::Unknown
        };
        (kind != SlideEnd::Unknown).then_some((kind, cells))
    });
    found.unwrap_or((SlideEnd::Unknown, 1))
}

/// Behaviour of the corners with w = y/|ξ| ≤ `width` at a fast-slide end. In one round w'' = κ w/(1 + a w), with the sign of ξ in a.
///
/// κ < 1: while 1 + a w stays positive, ξ approaches ξ + a y/(1 − κ), and w falls, or rises to at most w/(1 + a w/(1 − κ)).
///
/// κ > 1: ξ − x y keeps its value, x = a/(κ − 1). So from a corner with w to a later one with w' > w, |ξ| grows by (1 − x w)/(1 − x w'):
/// by less than 1 if x ≤ 0, and by at most 1/(1 − x `width`) if x > 0, as long as that is positive.
fn end(cycle: [Fast; 2], right: bool, width: f64) -> SlideEnd {
    let side = if right { 1.0 } else { -1.0 };
    let inside = I::new(0.0, width);
    // Change of ξ in one step, and until its slide begins.
    let bent = |corner: &Fast, w: I| {
        let bend = corner.b.hull(corner.from).hull(I::ZERO).times(side) * w;
        (bend.lo > -BEND && bend.hi < BEND).then_some(bend)
    };
    let (mut kappa, mut a) = round(cycle);
    let (other, b) = round([cycle[1], cycle[0]]);
    (kappa, a) = (kappa.hull(other), a.hull(b).times(side));
    let [Some(one), Some(two)] = [0, 1].map(|k| bent(&cycle[k], inside)) else {
        return SlideEnd::Unknown;
    };
    let half = one.hull(two);
    if kappa.hi < 1.0 {
        // The sum over all rounds, and half a round.
        let sum = inside * (a.hull(I::ZERO) / (I::ONE - I::from(kappa.hi))) + half;
        // The largest w on the way, half a round after the start, or a whole one.
        let stretch = cycle[0].k.hi.max(cycle[1].k.hi).max(1.0);
        let wide = (I::from(width) * I::from(stretch) / (I::ONE + sum)).hi;
        let follows = [0, 1].map(|k| bent(&cycle[k], I::new(0.0, wide)));
        if sum.lo > -BEND && sum.hi < LONGER && follows.iter().all(Option::is_some) {
            SlideEnd::Attracts { speed: I::ONE + sum, wide }
        } else {
            SlideEnd::Unknown
        }
    } else if kappa.lo > 1.0 {
        let x = a / (kappa - I::ONE);
        let left = I::ONE - I::from(x.hi.max(0.0)) * inside;
        let most = (I::ONE + half) / left * (I::ONE + inside.square()).sqrt();
        let transit = most.ln().hi + STRICT_DECREASE;
        if left.lo > 0.0 && transit < TRANSIT {
            SlideEnd::Repels(transit)
        } else {
            SlideEnd::Unknown
        }
    } else {
        SlideEnd::Unknown
    }
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
            let growth = libm::log(kappa.middle()) - growth;
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
    let grows = growth > 0.0 && verified(map, cycle);
    Some(grows.then(|| Decision::Grows(cycle.to_vec())))
}

/// Returns true if a growing cycle exists close to this one. It does if the angle of the image less the angle itself has opposite signs at
/// the two ends of an interval of angles around the first corner.
fn verified(map: &CornerMap, cycle: &[Corner]) -> bool {
    // Starts at a corner with ξ = 0 exactly, if there is one: its cell is a point.
    let first = cycle.iter().position(|corner| corner.phi == 0.0).unwrap_or(0);
    let Corner { contact, phi, .. } = cycle[first];
    let turn = |phi: I| -> Option<(I, I)> {
        let (mut j, mut growth, mut phi) = (contact, I::ZERO, phi);
        for _ in cycle {
            let images = map.images(j, &Cell::new(phi.lo, phi.hi));
            let Some(Image::Corner { contact, xi, y, slope, .. }) = only(&images) else {
                return None;
            };
            growth = growth + size(xi, y);
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
        (j == contact).then_some((phi, growth))
    };
    if phi == 0.0 {
        return turn(I::ZERO).is_some_and(|(angle, growth)| angle == I::ZERO && growth.lo > 0.0);
    }
    AROUND.iter().any(|&half| {
        let around = I::new(phi - half, phi + half);
        let Some((_, growth)) = turn(around) else { return false };
        if growth.lo <= 0.0 {
            return false;
        }
        // With exactly one image over the interval the map is continuous, so image less angle has a zero.
        let side =
            |end: f64| turn(I::from(end)).and_then(|(image, _)| (image - I::from(end)).sign());
        match (side(around.lo), side(around.hi)) {
            (Some(low), Some(high)) => low * high < 0,
            _ => false,
        }
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::fixed;
    use crate::options::Jams;
    use crate::stability::tests::odd;

    #[test]
    fn a_growing_cycle_comes_back_to_its_first_corner_and_grows() {
        let map = CornerMap::new(&odd(0.26), Jams::None).expect("a corner map");
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

    proptest! {
        #![proptest_config(fixed(9))]

        #[test]
        fn the_cells_of_a_direction_contain_its_angle(phi in -1.57..1.57, level in 0..3_usize) {
            let grid = Grid::of(level);
            let (from, to) = grid.range(I::near(libm::tan(phi)));
            let contains = |k: usize| grid.cells[k].phi[0] <= phi && phi <= grid.cells[k].phi[1];
            prop_assert!(to - from <= 1 && (from..=to).any(contains));
        }

        /// ξ' = ξ + B y, y' = K y at every corner: ξ_∞ = ξ + B y/(1 − K).
        #[test]
        fn an_end_that_attracts_contains_the_limit_of_the_sliding_speed(
            k in 0.0..0.9, b in -0.1..0.1, y in 0.0..0.1, right in any::<bool>(),
        ) {
            let fast = Fast { b: I::from(b), k: I::from(k), from: I::ZERO };
            let found = end([fast; 2], right, 0.1);
            let SlideEnd::Attracts { speed, .. } = found else { panic!("{found:?}") };
            let side = if right { 1.0 } else { -1.0 };
            let limit = 1.0 + side * b * y / (1.0 - k);
            prop_assert!(speed.lo <= limit && limit <= speed.hi, "{speed:?} {limit}");
        }
    }
}

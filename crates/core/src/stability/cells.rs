//! The directions of corners in cells, and the graph of the cells that follow each other.
//!
//! The angles φ of the corners at each contact are divided into cells. From each cell there is an edge to every cell that its image meets, with
//! an upper bound of the growth ln G. The fast-slide ends φ = ±π/2 are treated separately, because r does not change there: corners follow each
//! other, with landing speeds that change by constant factors at most.

use std::sync::OnceLock;

use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::stability::corner::{Cell, CornerMap, Fast, FastSlides, Image, Images};
use crate::tolerance::{CELL_LIMIT_ROUNDING, STRICT_DECREASE, TRIGONOMETRIC_ERROR};

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

/// Number of rounds in which the sum of the landing speeds in a fast slide is found.
const SUM_ROUNDS: usize = 64;

/// The cells of the angles φ: the limits between them, and the tangents of these limits.
pub(super) struct Grid {
    pub(super) cells: Vec<Cell>,
    pub(super) limits: Vec<f64>,
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

    /// The ratio ξ/y at the inner limit of a zone of this many cells around a fast-slide end.
    pub(super) fn zone_limit(&self, right: bool, cells: usize) -> f64 {
        if right { self.limits[self.limits.len() - cells] } else { self.limits[cells - 1] }
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
pub(super) fn size(xi: I, y: I) -> I {
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

/// An attracting fast-slide end: what follows its corners, with w = y/|ξ| ≤ `wide` at all of them, for |ξ| = 1 at the first one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Attraction {
    /// All |ξ| that follow, and the largest w that follows, for all corners of the end.
    pub(super) speed: I,
    pub(super) wide: f64,
    /// |ξ| is in the end 1 + `limit` w.
    limit: I,
    /// If corners may leave the end, |ξ| is until then 1 + w times a number between 0 and this.
    change: I,
    /// The largest factor by which y grows from the first corner on.
    stretch: f64,
    /// The contacts whose corners may also leave the end, when the other contact lifts off.
    leaves: [bool; 2],
}

impl Attraction {
    /// The images after the corners of the end with these w and with r = 1, that is |ξ| = 1/√(1 + w²).
    pub(super) fn images(&self, map: &CornerMap, right: bool, w: I) -> Images {
        let mut images = Images::none();
        let start = I::ONE / (I::ONE + w.square()).sqrt();
        let speed = (I::ONE + w * self.limit) * start;
        map.together(if right { speed } else { -speed }, &mut images);
        if self.leaves == [false; 2] {
            return images;
        }
        let speed = I::ONE + w * self.change.hull(I::ZERO);
        let wide = (I::from(w.hi) * I::from(self.stretch) / I::from(speed.lo)).hi.min(self.wide);
        let root = (I::ONE + I::from(wide).square()).sqrt();
        let speed = speed * start;
        let sizes = I::new(speed.lo.max(0.0), (speed * root).hi);
        let half = std::f64::consts::FRAC_PI_2;
        let angle = libm::atan(1.0 / wide) - TRIGONOMETRIC_ERROR;
        let end = if right { Cell::new(angle, half) } else { Cell::new(-half, -angle) };
        for contact in (0..2).filter(|contact| self.leaves[*contact]) {
            let mut after = Images::none();
            map.leaving(contact, &end, right, &mut after);
            images.add(&after, sizes);
        }
        images
    }
}

/// The ratios w = y/|ξ| of corners in a fast-slide end.
pub(super) fn ratios(slope: I) -> I {
    let [near, far] = [slope.lo.abs().min(slope.hi.abs()), slope.lo.abs().max(slope.hi.abs())];
    I::new((1.0 / far).next_down().max(0.0), (1.0 / near).next_up())
}

/// Behaviour at a fast-slide end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SlideEnd {
    /// Not a fast-slide end.
    Ordinary,
    /// Both contacts finally slide together.
    Attracts(Attraction),
    /// The corners leave the end. The number is a bound of the growth ln r until then.
    Repels(f64),
    Unknown,
}

/// Undecided cells: the contact, and the limits of φ.
pub(super) type Open = Vec<(usize, [f64; 2])>;

/// The cells of a grid and the cells that their images meet, with bounds on the growth.
pub(super) struct Graph<'g> {
    grid: &'g Grid,
    /// Edges of all cells. Those of cell k at contact j are `starts[j * n + k]..starts[j * n + k + 1]`, n cells per contact.
    edges: Vec<Edge>,
    starts: Vec<usize>,
    /// The fast-slide ends of each contact, left and right, and their sizes in cells.
    pub(super) zones: [[(SlideEnd, usize); 2]; 2],
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
                    SlideEnd::Attracts(end) => end.images(map, right, ratios(cell.slope)),
                    _ => map.images(j, cell),
                };
                for image in images.iter() {
                    match *image {
                        Image::Rest => {}
                        Image::Corner { contact, slope, most, .. } => {
                            if !(most < f64::INFINITY) {
                                left.push((j, cell.phi));
                                continue;
                            }
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
        let mut blocks = Blocks::of(&potential);
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
                        let last = edge.to.min(n - 1);
                        let mut take = |then: usize| {
                            if edge.growth + potential[then] > value {
                                (value, to) = (edge.growth + potential[then], then);
                            }
                        };
                        let Some((right, _)) = own else {
                            blocks.each(at(edge.contact, edge.from), at(edge.contact, last), take);
                            continue;
                        };
                        for cell in edge.from..=last {
                            let other = self.repels(edge.contact, cell);
                            if other.is_none_or(|(other, _)| other != right) {
                                take(at(edge.contact, cell));
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
                        blocks.raise(&potential, at(j, k));
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

/// The cell with the highest potential in each block of cells.
struct Blocks(Vec<usize>);

impl Blocks {
    /// Number of cells in a block.
    const SIZE: usize = 32;

    fn of(potential: &[f64]) -> Self {
        let highest = |(block, values): (usize, &[f64])| {
            let best = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]));
            block * Self::SIZE + best.unwrap_or(0)
        };
        Self(potential.chunks(Self::SIZE).enumerate().map(highest).collect())
    }

    /// The potential of a cell has risen.
    fn raise(&mut self, potential: &[f64], cell: usize) {
        let highest = &mut self.0[cell / Self::SIZE];
        if potential[cell] > potential[*highest] {
            *highest = cell;
        }
    }

    /// Calls `take` with cells of a range, among them one with the highest potential.
    fn each(&self, from: usize, last: usize, mut take: impl FnMut(usize)) {
        let mut cell = from;
        while cell <= last {
            if cell.is_multiple_of(Self::SIZE) && cell + Self::SIZE <= last + 1 {
                take(self.0[cell / Self::SIZE]);
                cell += Self::SIZE;
            } else {
                take(cell);
                cell += 1;
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

/// The two corners that follow each other at a fast-slide end, starting with contact j; the contact of the other one comes with them.
pub(super) fn fast_cycle(map: &CornerMap, j: usize, right: bool) -> Option<([Fast; 2], usize)> {
    let fast = |j: usize| map.fast(j, right)?.only();
    let (other, own) = fast(j)?;
    let (next, back) = fast(other)?;
    // Else the corners enter or leave the end of the other contact.
    (next == j).then_some(([own, back], other))
}

/// One round at a fast-slide end: y'' = κ y and ξ'' = ξ + a y, starting from the first corner. So ξ − x y keeps its value, with x = a/(κ − 1).
pub(super) fn round([one, two]: [Fast; 2]) -> (I, I) {
    (one.k * two.k, one.b + two.b * one.k)
}

/// The fast-slide end of the corners at j: the largest zone around it, in cells, in which its kind is certain.
pub(super) fn zone(map: &CornerMap, grid: &Grid, j: usize, right: bool) -> (SlideEnd, usize) {
    let Some(slides) = map.fast(j, right) else { return (SlideEnd::Ordinary, 0) };
    if slides.next.iter().all(Option::is_none) {
        return (SlideEnd::Ordinary, 0);
    }
    let n = grid.limits.len();
    let cycle = fast_cycle(map, j, right);
    let several = match (&cycle, Several::of(map, j, right)) {
        (Some(_), _) => None,
        (None, Some(several)) if several.repeats => Some(several),
        (None, _) => return (SlideEnd::Ordinary, 0),
    };
    let mut cells = (0..n).rev().map(|k| {
        // y/|ξ| beyond this limit
        let limit = if right { grid.limits[n - 1 - k] } else { grid.limits[k] };
        (k + 1, (1.0 / limit.abs()).next_up(), limit)
    });
    let found = cells.find_map(|(cells, width, limit)| {
        let kind = match (&cycle, &several) {
            _ if (limit > 0.0) != right || width > BEND => SlideEnd::Unknown,
            (Some((cycle, _)), _) => end(*cycle, right, width),
            (None, Some(several)) => several.end(right, width),
            (None, None) => SlideEnd::Unknown,
        };
        (kind != SlideEnd::Unknown).then_some((kind, cells))
    });
    found.unwrap_or(if cycle.is_some() { (SlideEnd::Unknown, 1) } else { (SlideEnd::Ordinary, 0) })
}

/// The corners at a fast-slide end, if there may be several after one.
struct Several {
    /// The contacts whose corners may follow.
    reached: [bool; 2],
    /// Whether corners may follow each other without end, or both contacts may rest.
    repeats: bool,
    /// Change of ξ per unit y from a corner to the next one, and until the slide begins.
    bend: I,
    /// Bound of Σy over all corners that follow, from the first one on, for y = 1 there; and of each y.
    sum: f64,
    stretch: f64,
}

impl Several {
    /// Let K_jm be the largest y' after a corner at j if m lands next. Σy ≤ S_j y with S_j ≥ 1 + max_m K_jm S_m. `None` if no such S is found.
    fn of(map: &CornerMap, j: usize, right: bool) -> Option<Self> {
        let mut reached = [false; 2];
        let mut factors = [[0.0_f64; 2]; 2];
        let (mut bend, mut rests) = (I::ZERO, false);
        let mut open = vec![j];
        while let Some(from) = open.pop() {
            if std::mem::replace(&mut reached[from], true) {
                continue;
            }
            let FastSlides { next, ends, .. } = map.fast(from, right)?;
            rests |= ends;
            for (to, fast) in next.iter().enumerate() {
                if let Some(fast) = fast {
                    factors[from][to] = fast.k.hi;
                    bend = bend.hull(fast.b).hull(fast.from);
                    open.push(to);
                }
            }
        }
        let follows = |from: usize, to: usize| factors[from][to] > 0.0;
        let repeats = rests || follows(0, 0) || follows(1, 1) || follows(0, 1) && follows(1, 0);
        let next = |sums: [f64; 2]| {
            [0, 1].map(|from| {
                let after = |to: usize| I::ONE + I::from(factors[from][to]) * I::from(sums[to]);
                after(0).hi.max(after(1).hi)
            })
        };
        let found = (0..SUM_ROUNDS).fold([1.0; 2], |sums, _| next(sums));
        let larger = found.map(|sum| sum * 1.01);
        let holds = next(larger).iter().zip(larger).all(|(next, sum)| *next <= sum);
        let stretch = factors[j].iter().copied().fold(1.0, f64::max);
        holds.then_some(Self { reached, repeats, bend, sum: larger[j], stretch })
    }

    /// The kind of the end for corners with y/|ξ| ≤ `width`.
    fn end(&self, right: bool, width: f64) -> SlideEnd {
        let side = if right { 1.0 } else { -1.0 };
        let change = self.bend.times(side) * I::new(0.0, width) * I::from(self.sum);
        let wide = (I::from(width) * I::from(self.stretch) / (I::ONE + change)).hi;
        if change.lo > -BEND && change.hi < LONGER && wide <= BEND {
            SlideEnd::Attracts(Attraction {
                speed: I::ONE + change,
                wide,
                limit: self.bend.times(side) * I::from(self.sum),
                change: self.bend.times(side) * I::from(self.sum),
                stretch: self.stretch,
                leaves: self.reached,
            })
        } else {
            SlideEnd::Unknown
        }
    }
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
    let limit = a.times(side) / (I::ONE - kappa);
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
            let stretch = stretch.next_up();
            let (speed, leaves) = (I::ONE + sum, [false; 2]);
            SlideEnd::Attracts(Attraction { speed, wide, limit, change: limit, stretch, leaves })
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::fixed;

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
            let SlideEnd::Attracts(Attraction { speed, .. }) = found else { panic!("{found:?}") };
            let side = if right { 1.0 } else { -1.0 };
            let limit = 1.0 + side * b * y / (1.0 - k);
            prop_assert!(speed.lo <= limit && limit <= speed.hi, "{speed:?} {limit}");
        }
    }
}

//! Unstable: a set of corners that no motion leaves, and in which all motions grow.
//!
//! A corner may have several images, for example after a flight that is cut. Then no single cycle need exist. Instead a *trap* is sought: a
//! finite set of cells of directions φ, at both contacts, such that each image of a cell lies in a cell of the set, or moves away for ever.
//! With a lower bound of the growth ln G on each such step, and numbers W with
//!
//! ```text
//! W(cell) ≤ ln G(cell) − ε + W(next)     for all next cells,
//! ```
//!
//! the size of every motion from the trap grows without bound, whichever outcomes occur.

use std::collections::VecDeque;

use crate::stability::cells::{Grid, SlideEnd, ratios, size, zone};
use crate::stability::corner::{Cell, CornerMap, Image, Images};
use crate::tolerance::{STRICT_DECREASE, TRIGONOMETRIC_ERROR};

/// Number of corners that are followed before a trap is sought, and starting angles.
const APPROACH: usize = 60;
const STARTS: [f64; 3] = [0.0, 1.2, -1.2];
/// Largest number of cells of a trap, and number of times that their images are computed.
const MOST_CELLS: usize = 64;
const MOST_IMAGES: usize = 400;
/// A new cell is wider than the image that it contains: by this share of its width, and by this angle in rad.
const SHARE: f64 = 0.5;
const ANGLE: f64 = 1e-7;
/// Cells that are closer than this, in rad, become one.
const CLOSE: f64 = 1e-3;

/// A cell of a trap.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TrapCell {
    /// The contact that lands.
    pub(super) contact: usize,
    /// Limits of φ = atan(ξ/y).
    pub(super) phi: [f64; 2],
    /// W
    pub(super) weight: f64,
    /// A lower bound of ln r'/r on the way to the next cell.
    pub(super) growth: f64,
}

/// An image: the contact, the limits of φ, and a lower bound of ln r'/r.
type Step = (usize, [f64; 2], f64);

/// The map with its fast-slide ends.
struct Ends<'m> {
    map: &'m CornerMap,
    grid: &'static Grid,
    zones: [[(SlideEnd, usize); 2]; 2],
}

impl<'m> Ends<'m> {
    fn new(map: &'m CornerMap) -> Self {
        let grid = Grid::of(0);
        let zones = [0, 1].map(|j| [false, true].map(|right| zone(map, grid, j, right)));
        Self { map, grid, zones }
    }

    /// The images of a cell. Those of a cell in an attracting end are the images after the whole sequence of corners there.
    fn images(&self, contact: usize, phi: [f64; 2]) -> Images {
        for right in [false, true] {
            let (end, cells) = self.zones[contact][usize::from(right)];
            let SlideEnd::Attracts(end) = end else { continue };
            let limit = self.grid.zone_limit(right, cells);
            let inside = if right {
                phi[0] >= libm::atan(limit) + TRIGONOMETRIC_ERROR
            } else {
                phi[1] <= libm::atan(limit) - TRIGONOMETRIC_ERROR
            };
            if inside {
                let slope = Cell::new(phi[0], phi[1]).slope;
                return end.images(self.map, right, ratios(slope));
            }
        }
        self.map.images(contact, &Cell::new(phi[0], phi[1]))
    }

    /// The corners that follow those of a cell; none after motions that move away. `None` if one may come to rest or is not known.
    fn steps(&self, contact: usize, phi: [f64; 2]) -> Option<Vec<Step>> {
        let mut steps = Vec::new();
        let images = self.images(contact, phi);
        images.iter().next()?; // no such corner
        for image in images.iter() {
            match *image {
                Image::Escape => {}
                Image::Corner { contact, xi, y, slope, .. } => {
                    let half = std::f64::consts::FRAC_PI_2;
                    let low = (libm::atan(slope.lo) - TRIGONOMETRIC_ERROR).max(-half);
                    let high = (libm::atan(slope.hi) + TRIGONOMETRIC_ERROR).min(half);
                    let growth = size(xi, y).lo;
                    if growth == f64::NEG_INFINITY {
                        return None; // it may come to rest
                    }
                    steps.push((contact, [low, high], growth));
                }
                Image::Rest | Image::Unknown => return None,
            }
        }
        Some(steps)
    }
}

/// A trap, if one is found.
pub(super) fn find(map: &CornerMap) -> Option<Vec<TrapCell>> {
    let ends = Ends::new(map);
    STARTS.iter().find_map(|&phi| (0..2).find_map(|j| ends.from(j, phi)))
}

impl Ends<'_> {
    /// A trap that an orbit of single corners has reached after some time. Of several images the one that grows most is followed.
    fn from(&self, mut contact: usize, phi: f64) -> Option<Vec<TrapCell>> {
        let mut phi = [phi; 2];
        for _ in 0..APPROACH {
            let steps = self.steps(contact, phi)?;
            let most = steps.iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
            let middle = 0.5 * (most.1[0] + most.1[1]);
            (contact, phi) =
                (most.0, if most.1[1] - most.1[0] < CLOSE { [middle; 2] } else { most.1 });
        }
        self.around(contact, phi)
    }

    /// The trap that contains these corners.
    fn around(&self, contact: usize, phi: [f64; 2]) -> Option<Vec<TrapCell>> {
        let half = std::f64::consts::FRAC_PI_2;
        let wider = |[low, high]: [f64; 2]| {
            let more = SHARE * (high - low) + ANGLE;
            [(low - more).max(-half), (high + more).min(half)]
        };
        let mut cells = vec![(contact, wider(phi))];
        let mut steps: Vec<Vec<Step>> = vec![Vec::new()];
        let mut open = VecDeque::from([0]);
        let mut count = 0;
        while let Some(k) = open.pop_front() {
            count += 1;
            if count > MOST_IMAGES {
                return None;
            }
            let (contact, phi) = cells[k];
            steps[k] = self.steps(contact, phi)?;
            for (contact, [low, high], _) in steps[k].clone() {
                let inside =
                    |(j, phi): &(usize, [f64; 2])| *j == contact && phi[0] <= low && high <= phi[1];
                if cells.iter().any(inside) {
                    continue;
                }
                let near = |(j, phi): &(usize, [f64; 2])| {
                    *j == contact && phi[0] <= high + CLOSE && low <= phi[1] + CLOSE
                };
                let place = match cells.iter().position(near) {
                    Some(place) => {
                        let [from, to] = cells[place].1;
                        cells[place].1 = wider([from.min(low), to.max(high)]);
                        place
                    }
                    None if cells.len() == MOST_CELLS => return None,
                    None => {
                        cells.push((contact, wider([low, high])));
                        steps.push(Vec::new());
                        cells.len() - 1
                    }
                };
                if !open.contains(&place) {
                    open.push_back(place);
                }
            }
        }
        weighted(&cells, &steps)
    }
}

/// The cells of a closed set with their weights, if all motions in it grow.
fn weighted(cells: &[(usize, [f64; 2])], steps: &[Vec<Step>]) -> Option<Vec<TrapCell>> {
    let target = |(contact, [low, high], _): &Step| {
        cells.iter().position(|(j, phi)| j == contact && phi[0] <= *low && *high <= phi[1])
    };
    let mut edges = Vec::new();
    for (k, steps) in steps.iter().enumerate() {
        for step in steps {
            edges.push((k, target(step)?, step.2 - STRICT_DECREASE));
        }
    }
    // W falls until all inequalities hold. With n cells this takes at most n rounds, unless a cycle does not grow [Bellman and Ford].
    let mut weights = vec![0.0_f64; cells.len()];
    for _ in 0..=cells.len() {
        let mut changed = false;
        for &(from, to, growth) in &edges {
            if growth + weights[to] < weights[from] {
                weights[from] = growth + weights[to];
                changed = true;
            }
        }
        if !changed {
            let least = |k: usize| {
                let own = edges.iter().filter(|edge| edge.0 == k);
                own.map(|edge| edge.2).fold(f64::INFINITY, f64::min)
            };
            let cell = |(k, &(contact, phi)): (usize, &(usize, [f64; 2]))| TrapCell {
                contact,
                phi,
                weight: weights[k],
                growth: least(k),
            };
            return Some(cells.iter().enumerate().map(cell).collect());
        }
    }
    None
}

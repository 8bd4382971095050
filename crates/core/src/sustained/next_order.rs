//! The choice of a mode by the next order of the motion where accelerations do not decide.
//!
//! The rows that a word keeps at zero may be dependent at an instant and independent as the body moves: contacts whose normals meet
//! in one point, or a contact on the normal of another one that is fixed. A body that starts from rest then has the same
//! accelerations in several words, and the contact-mode problem, which has accelerations only, holds all the contacts that it can.
//! The next order of the motion distinguishes the words: with too many contacts held, a row that follows from the others at the
//! start is not zero after it. Words that release contacts, or let them slide, are then tried, those with the fewest changes first.
//! A word is accepted if it keeps its rows, its forces lie in their cones, and the released contacts move as their letters say.

use crate::body::contact::ContactLetters;
use crate::math::roots::ORDER;
use crate::math::series::{Series, product};
use crate::modes::Mode;
use crate::sustained::rows::{Row, Unknown};
use crate::sustained::step::Track;
use crate::sustained::{BodyState, Step};
use crate::tolerance::{FORCE_OUTSIDE_CONE, RATE_COEFFICIENT};

/// Index of the Taylor coefficient of the rate of a row that is its acceleration, and of the next coefficient, which the contact-mode
/// problem does not use.
const FIRST: usize = 1;
const NEXT: usize = 2;

/// Number of coefficients that exclude most words.
const FEW: usize = 5;

/// Most contacts that are released: three rows hold a body.
const DEEPEST: usize = 3;

const TRIES: usize = 4096;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Onward {
    pub(crate) word: ContactLetters<Mode>,
    /// The contacts whose letters were changed by the next order of the motion.
    pub(crate) changed: ContactLetters<bool>,
    /// q̈ of the word before these changes.
    pub(crate) acceleration: [f64; 3],
}

impl Onward {
    /// A word without changes.
    pub(crate) fn same(word: ContactLetters<Mode>, acceleration: [f64; 3]) -> Self {
        let changed = word.iter().map(|_| false).collect();
        Self { word, changed, acceleration }
    }
}

/// The words found, and how many more may be tried.
pub(crate) struct Search {
    pub(crate) found: Vec<Onward>,
    tries: usize,
}

impl Default for Search {
    fn default() -> Self {
        Self { found: Vec::new(), tries: TRIES }
    }
}

impl Search {
    pub(crate) fn add(&mut self, one: Onward) {
        if self.found.iter().all(|other| other.word != one.word) {
            self.found.push(one);
        }
    }
}

impl BodyState {
    /// Returns true if rows of a word depend on others and leave the body a motion.
    fn is_dependent(&self, word: &[Mode]) -> bool {
        if !self.has_rows_of_two(word) {
            return false;
        }
        let rank = self.independent(word).len();
        rank < 3 && self.rows(word).len() > rank
    }

    /// Returns true if the next order of the motion may change a word: its rows depend on each other, or a contact is fixed without
    /// friction and outside a vertex.
    pub(crate) fn is_open(&self, word: &[Mode]) -> bool {
        let idle = |i: usize| word[i] == Mode::Fixed && !self.sticks(i, word);
        self.is_dependent(word) || (0..word.len()).any(idle)
    }

    /// Adds the words in which a body continues that begins to move in the word `from`. `ways`: the signs of sliding of its contacts,
    /// `None` for separate contacts.
    pub(crate) fn next_order(&self, from: &Onward, ways: &[Option<i8>], search: &mut Search) {
        let mut found = Vec::new();
        if self.is_dependent(&from.word) {
            for deep in 0..=DEEPEST {
                self.release(from, ways, deep, &mut found, &mut search.tries);
                if !found.is_empty() {
                    break;
                }
            }
        } else {
            found.push(from.clone());
        }
        for mut one in found {
            self.slide_off(&mut one);
            search.add(one);
        }
    }

    /// Contacts without friction are fixed only for an instant: at an instant centre they slide.
    fn slide_off(&self, Onward { word, changed, .. }: &mut Onward) {
        let Some(step) = Step::new(self, word, ORDER) else { return };
        for i in 0..word.len() {
            if word[i] == Mode::Fixed
                && !self.sticks(i, word)
                && let Some((_, rate)) = step.departs(self, i, true, FIRST)
            {
                (word[i], changed[i]) = (if rate > 0.0 { Mode::Right } else { Mode::Left }, true);
            }
        }
    }

    /// Releases `deep` more contacts, in all ways, and collects the words in which the motion continues.
    fn release(
        &self,
        from: &Onward,
        ways: &[Option<i8>],
        deep: usize,
        found: &mut Vec<Onward>,
        tries: &mut usize,
    ) {
        if *tries == 0 {
            return;
        }
        if deep == 0 {
            *tries -= 1;
            let continues = |order: usize| {
                let step = Step::new(self, &from.word, order);
                step.is_some_and(|step| step.continues(self, from, ways, order == ORDER))
            };
            if continues(FEW) && continues(ORDER) {
                found.push(from.clone());
            }
            return;
        }
        for i in (0..from.word.len()).filter(|&i| !from.changed[i]) {
            let slides = self.sticks(i, &from.word) && self.partner(i, &from.word).is_none();
            for mode in [Mode::Separate, Mode::Right, Mode::Left] {
                if from.word[i] == Mode::Separate || mode != Mode::Separate && !slides {
                    continue;
                }
                let mut to = from.clone();
                (to.word[i], to.changed[i]) = (mode, true);
                self.release(&to, ways, deep - 1, found, tries);
            }
        }
    }
}

impl Step {
    /// The first coefficient of the rate of a row, n·v + b ω or t·v − c ω, with index `from` or higher, that exceeds its
    /// rounding error; and its power of time.
    fn departs(
        &self,
        state: &BodyState,
        i: usize,
        tangential: bool,
        from: usize,
    ) -> Option<(usize, f64)> {
        let (p, [b, mut c]) = (&state.points[i], self.arm(i));
        c[0] -= p.radius;
        let (axis, lever, side) =
            if tangential { (p.tangent, c, -1.0) } else { (p.normal, b, 1.0) };
        let turning = self.turning(i);
        // Rounding errors of the axis count, too: a velocity counts with its size, not with its part along the axis.
        let length = |one: &[Series; 2], k: usize| libm::hypot(one[0][k], one[1][k]);
        let mut size = 0.0_f64;
        (0..self.order).find_map(|k| {
            let turned = (0..=k).map(|j| side * lever[j] * self.omega[k - j]);
            let (pushed, speed) = match turning {
                None => (axis.x * self.v[0][k] + axis.y * self.v[1][k], length(&self.v, k)),
                Some(point) => {
                    let axis = &if tangential { point.tangent() } else { point.normal };
                    let pushed =
                        product(&axis[0], &self.v[0], k) + product(&axis[1], &self.v[1], k);
                    let speeds = (0..=k).map(|j| length(axis, j) * length(&self.v, k - j));
                    (pushed, speeds.sum())
                }
            };
            size = size.max(turned.clone().fold(speed, |sum, term| sum + term.abs()));
            let rate = turned.fold(pushed, |sum, term| sum + term);
            (k >= from && rate.abs() > RATE_COEFFICIENT * size).then_some((k, rate))
        })
    }

    /// Returns true if a row that the word keeps at zero becomes non-zero: one of those that follow from the others at the start.
    fn parts(&self, state: &BodyState, word: &[Mode]) -> bool {
        let departs = |row: &Row| {
            let Unknown { contact, tangential } = row.unknown;
            self.departs(state, contact, tangential, NEXT).is_some()
        };
        state.rows(word).iter().any(departs)
    }

    /// Returns true if the motion continues in this word: its rows stay zero, contacts released or no longer fixed move as their letters
    /// say (off the terrain, or along it in that direction), and the forces lie in their cones. `all`: the step has all coefficients;
    /// otherwise it may also continue where further coefficients decide.
    fn continues(&self, state: &BodyState, to: &Onward, ways: &[Option<i8>], all: bool) -> bool {
        let moves = |i: usize| {
            let (off, way) = match (to.word[i], ways[i]) {
                (_, None) | (Mode::Fixed, _) => return true,
                (Mode::Separate, _) => (true, 1.0),
                (mode, Some(0)) => (false, mode.direction()),
                _ => return true,
            };
            self.departs(state, i, !off, FIRST).map_or(!all, |(_, rate)| rate * way > 0.0)
        };
        let unchanged = !to.changed.contains(&true);
        !self.parts(state, &to.word)
            && (unchanged || (0..ways.len()).all(moves) && self.presses(state))
    }

    /// Returns true if all forces at the start lie in their cones.
    fn presses(&self, state: &BodyState) -> bool {
        let force = |track: &Track| (track.normal[0], track.tangential[0].abs());
        let most = self.tracks.iter().map(force).map(|(n, t)| n.abs().max(t)).fold(0.0, f64::max);
        let slack = FORCE_OUTSIDE_CONE * most;
        self.tracks.iter().enumerate().all(|(i, track)| {
            if track.partner.is_some() {
                return self.vertex_edges(state, i).iter().all(|(edge, _)| edge[0] >= -slack);
            }
            let (normal, tangential) = force(track);
            normal >= -slack && tangential <= track.friction * normal.max(0.0) + slack
        })
    }

    /// Clears the rounding error of a contact that the word has released: all coefficients of its rate below the first significant
    /// one.
    pub(crate) fn emerges(&mut self, state: &BodyState, i: usize) {
        let off = self.tracks[i].mode == Mode::Separate;
        let Some((k, _)) = self.departs(state, i, !off, FIRST) else { return };
        let track = &mut self.tracks[i];
        if off {
            track.h[..=k].fill(0.0);
            track.u[..k].fill(0.0);
        } else {
            track.slip[..k].fill(0.0);
        }
    }
}

//! The choice of a mode where accelerations do not decide: by the next order of the motion.
//!
//! The rows that a word makes vanish may depend on each other at an instant and part as the body moves: feet whose normals
//! meet in one point, a foot on the normal of another one that is fixed. A body that starts from rest then has the same
//! accelerations in several words, and the contact-mode problem, which sees no further, holds all the contacts that it
//! can. What tells them apart is the next order of the motion: with too many contacts held, one of the rows that follow
//! from the others at the start does not vanish after it. The words that let a contact off, or slide, are then tried, the
//! fewest first: the one that goes on keeps what it holds, its forces lie in their cones, and what it has let go moves
//! as its letters say.

use crate::body::contact::PerContact;
use crate::math::roots::ORDER;
use crate::modes::Mode;
use crate::sustained::rows::{Row, Unknown};
use crate::sustained::step::Track;
use crate::sustained::{BodyState, Step};
use crate::tolerance::{FORCE_OUTSIDE_CONE, RATE_COEFFICIENT};

/// Coefficient of the rate of a row that is its acceleration, and the first that the choice of a word has not seen.
const FIRST: usize = 1;
const NEXT: usize = 2;

/// Most contacts that are let go: three rows hold a body.
const DEEPEST: usize = 3;

/// Most words that are tried.
const TRIES: usize = 4096;

/// A word in which a body goes on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Onward {
    pub(crate) word: PerContact<Mode>,
    /// The contacts whose letters the next order of the motion has changed.
    pub(crate) changed: PerContact<bool>,
    /// q̈ of the word before they were.
    pub(crate) acceleration: [f64; 3],
}

impl Onward {
    /// A word as it is.
    pub(crate) fn same(word: PerContact<Mode>, acceleration: [f64; 3]) -> Self {
        let changed = word.iter().map(|_| false).collect();
        Self { word, changed, acceleration }
    }
}

/// The words that are found, and how many more may be tried.
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
    /// One more word, if it is not there yet.
    pub(crate) fn add(&mut self, one: Onward) {
        if self.found.iter().all(|other| other.word != one.word) {
            self.found.push(one);
        }
    }
}

impl BodyState {
    /// Whether rows of a word follow from others, and leave the body a motion.
    fn is_dependent(&self, word: &[Mode]) -> bool {
        let rank = self.independent(word).len();
        self.frozen.is_none() && rank < 3 && self.rows(word).len() > rank
    }

    /// Whether the next order of the motion may say more of a word than its accelerations: its rows depend on each other, or
    /// a contact is fixed by nothing.
    pub(crate) fn is_open(&self, word: &[Mode]) -> bool {
        let idle = |i: usize| word[i] == Mode::Fixed && !self.sticks(i, word);
        self.is_dependent(word) || (0..word.len()).any(idle)
    }

    /// Adds the words in which a body goes on that begins to move in this one. `ways`: the signs of sliding of its contacts,
    /// `None` of those that are off.
    pub(crate) fn next_order(&self, from: &Onward, ways: &[Option<i8>], search: &mut Search) {
        let mut found = Vec::new();
        if self.is_dependent(&from.word) {
            for deep in 0..=DEEPEST {
                self.let_go(from, ways, deep, &mut found, &mut search.tries);
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

    /// Without friction nothing is fixed but for an instant: an instant centre slides off.
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

    /// Lets `deep` more contacts go, in all ways, and collects the words that go on.
    fn let_go(
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
            let goes_on = |step: Step| step.goes_on(self, from, ways);
            if Step::new(self, &from.word, ORDER).is_some_and(goes_on) {
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
                self.let_go(&to, ways, deep - 1, found, tries);
            }
        }
    }
}

impl Step {
    /// The first coefficient, this one or a later one, of the rate of a row, n·v + b ω or t·v − c ω, that is more than
    /// rounding, and its power of time.
    fn departs(
        &self,
        state: &BodyState,
        i: usize,
        tangential: bool,
        from: usize,
    ) -> Option<(usize, f64)> {
        let (p, track) = (&state.points[i], &self.tracks[i]);
        let (axis, lever, side) =
            if tangential { (p.tangent, &track.c, -1.0) } else { (p.normal, &track.b, 1.0) };
        let mut size = 0.0_f64;
        (FIRST..self.order).find_map(|k| {
            let pushed = [axis.x * self.v[0][k], axis.y * self.v[1][k]];
            let turned = (0..=k).map(|j| side * lever[j] * self.omega[k - j]);
            let rate = pushed.into_iter().chain(turned.clone()).sum::<f64>();
            size = size.max(pushed.into_iter().chain(turned).map(f64::abs).sum());
            (k >= from && rate.abs() > RATE_COEFFICIENT * size).then_some((k, rate))
        })
    }

    /// Whether a row does not vanish that the word says does: one of those that followed from the others.
    fn parts(&self, state: &BodyState, word: &[Mode]) -> bool {
        let departs = |row: &Row| {
            let Unknown { contact, tangential } = row.unknown;
            self.departs(state, contact, tangential, NEXT).is_some()
        };
        state.rows(word).iter().any(departs)
    }

    /// Whether the body goes on in this word: it keeps what it holds, and what it does not hold, or no more, moves as its
    /// letter says, off the terrain or along it that way, with forces in their cones.
    fn goes_on(&self, state: &BodyState, to: &Onward, ways: &[Option<i8>]) -> bool {
        let moves = |i: usize| {
            let (off, way) = match (to.word[i], ways[i]) {
                (_, None) | (Mode::Fixed, _) => return true,
                (Mode::Separate, _) => (true, 1.0),
                (mode, Some(0)) => (false, mode.direction()),
                _ => return true,
            };
            self.departs(state, i, !off, FIRST).is_some_and(|(_, rate)| rate * way > 0.0)
        };
        let unchanged = !to.changed.contains(&true);
        !self.parts(state, &to.word)
            && (unchanged || (0..ways.len()).all(moves) && self.presses(state))
    }

    /// Whether all forces at the start lie in their cones.
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

    /// A contact that its word has let go, from an instant at which nothing tells that it goes: what there is of its rate
    /// below the first coefficient that says so is rounding.
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

//! The least multiple of a load at which an assembly moves.
//!
//! With the word of a contact mode given, everything is linear in the multiple α ≥ 0 and the contact forces, so the least α of a word is a linear programme.
//! A mode moves if a contact opens or slides; the α at which a word moves are those of a convex set, without the points at which it does not, so their
//! infimum is that of the whole set if it has one point that moves.
//!
//! The least α over all words: for each contact, and each way in which it can move, the programme in which that contact moves by
//! [`LEAST_MOTION`], and the other contacts press and part without Coulomb's law. Where its solution breaks the law, one of the contacts that break
//! it gets each of its letters in turn: branch and bound. All letters given, the word counts with its own infimum.

use crate::assembly::scaled::Scaled;
use crate::math::Sparse;
use crate::math::linear::{Failure, maximise};
use crate::modes::Mode;
use crate::tolerance::{BROKEN_LAW, LEAST_MOTION, SHOWN_MOTION};

/// Largest number of contacts of assemblies of which all words are tried.
const CONTACTS: usize = 8;
/// Largest number of programmes.
const PROGRAMMES: usize = 20_000;

/// The least multiple at which a mode moves.
pub(super) struct Least {
    /// In units of the load; ∞ if no word moves.
    pub(super) multiple: f64,
    pub(super) mode: Option<Moving>,
    /// Whether all words were tried.
    pub(super) complete: bool,
}

/// A mode that moves.
pub(super) struct Moving {
    pub(super) word: Vec<Mode>,
    /// In units of the load.
    pub(super) multiple: f64,
    pub(super) forces: Vec<[f64; 2]>,
}

/// A contact that moves: it opens, or slides to one side.
type Mover = (usize, Mode);

struct Point {
    multiple: f64,
    forces: Vec<[f64; 2]>,
    y: Vec<f64>,
}

/// The least multiple at which a mode moves. `known`: the word of a mode, its y, and its multiple.
pub(super) fn least(scaled: &Scaled, known: Option<(&[Mode], &[f64], f64)>) -> Least {
    let mut search = Search { scaled, left: PROGRAMMES, best: None };
    if let Some((word, y, multiple)) = known {
        let moves = |(i, letter): (usize, &Mode)| match letter {
            Mode::Fixed => (0.0, (i, *letter)),
            Mode::Separate => (scaled.along(i, 1, y), (i, *letter)),
            Mode::Right | Mode::Left => (scaled.along(i, 0, y).abs(), (i, *letter)),
        };
        let fastest = word.iter().enumerate().map(moves).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((speed, mover)) = fastest
            && speed > BROKEN_LAW
        {
            search.note(word.to_vec(), mover, multiple);
        }
    }
    let mut complete = scaled.count() <= CONTACTS;
    if complete {
        for i in 0..scaled.count() {
            for way in [Mode::Separate, Mode::Right, Mode::Left] {
                let mut letters = vec![None; scaled.count()];
                letters[i] = Some(way);
                complete &= search.branch(&mut letters, (i, way));
            }
        }
    }
    let Some((multiple, word, mover)) = search.best.take() else {
        return Least { multiple: f64::INFINITY, mode: None, complete };
    };
    let mode = search.shown(word, mover);
    Least { multiple, mode, complete }
}

struct Search<'a> {
    scaled: &'a Scaled,
    left: usize,
    best: Option<(f64, Vec<Mode>, Mover)>,
}

impl Search<'_> {
    /// Tries all words with these letters; false if there are too many, or a programme does not converge.
    fn branch(&mut self, letters: &mut Vec<Option<Mode>>, mover: Mover) -> bool {
        if self.left == 0 {
            return false;
        }
        self.left -= 1;
        let point = match self.programme(letters, mover, LEAST_MOTION, None) {
            Ok(point) => point,
            Err(failure) => return failure == Failure::Empty,
        };
        if self.best.as_ref().is_some_and(|(best, ..)| point.multiple >= *best) {
            return true;
        }
        let (worst, word) = self.law(letters, &point);
        let Some(i) = worst else {
            self.note(word, mover, point.multiple);
            return true;
        };
        let ways = [Mode::Separate, Mode::Fixed, Mode::Right, Mode::Left];
        let smooth = self.scaled.friction[i] == 0.0;
        let mut complete = true;
        for way in ways.into_iter().filter(|way| !(smooth && *way == Mode::Fixed)) {
            letters[i] = Some(way);
            complete &= self.branch(letters, mover);
        }
        letters[i] = None;
        complete
    }

    /// Takes a word that moves at this multiple, if its infimum is the least.
    fn note(&mut self, word: Vec<Mode>, mover: Mover, multiple: f64) {
        let letters: Vec<Option<Mode>> = word.iter().copied().map(Some).collect();
        let infimum = self.programme(&letters, mover, 0.0, None);
        let least = infimum.map_or(multiple, |point| point.multiple.min(multiple));
        if self.best.as_ref().is_none_or(|(best, ..)| least < *best) {
            self.best = Some((least, word, mover));
        }
    }

    /// A mode of this word with a motion that can be seen, at the least multiple that has one, with the least normal forces.
    fn shown(&self, word: Vec<Mode>, mover: Mover) -> Option<Moving> {
        let letters: Vec<Option<Mode>> = word.iter().copied().map(Some).collect();
        let (motion, first) = [SHOWN_MOTION, LEAST_MOTION].into_iter().find_map(|motion| {
            let point = self.programme(&letters, mover, motion, None);
            point.ok().map(|point| (motion, point))
        })?;
        let point = self.programme(&letters, mover, motion, Some(first.multiple)).unwrap_or(first);
        Some(Moving { word, multiple: point.multiple, forces: point.forces })
    }

    /// The contact without a letter that breaks Coulomb's law most, if one does, and the word of this point.
    fn law(&self, letters: &[Option<Mode>], point: &Point) -> (Option<usize>, Vec<Mode>) {
        let mut worst = (BROKEN_LAW, None);
        let word = letters.iter().enumerate().map(|(i, letter)| {
            if let Some(letter) = letter {
                return *letter;
            }
            let [tangential, normal] = [0, 1].map(|axis| self.scaled.along(i, axis, &point.y));
            let [f_t, f_n] = point.forces[i];
            let slip = f_t + self.scaled.friction[i] * f_n * tangential.signum();
            let breach = f_n.min(normal).max(tangential.abs().min(slip.abs()));
            if breach > worst.0 {
                worst = (breach, Some(i));
            }
            if normal > BROKEN_LAW {
                Mode::Separate
            } else if tangential.abs() <= BROKEN_LAW {
                Mode::Fixed
            } else if tangential > 0.0 {
                Mode::Right
            } else {
                Mode::Left
            }
        });
        let word = word.collect();
        (worst.1, word)
    }

    /// The point with the least multiple, with these letters and this motion of a contact; or, at this multiple `at`, that with the least normal forces.
    fn programme(
        &self,
        letters: &[Option<Mode>],
        (mover, way): Mover,
        motion: f64,
        at: Option<f64>,
    ) -> Result<Point, Failure> {
        let scaled = self.scaled;
        let n = scaled.count();
        // Unknowns ≥ 0: α, forces along the edges of the cones, accelerations of contacts.
        let mut edges: Vec<(usize, [f64; 2])> = Vec::new();
        let mut first = vec![0; n + 1];
        for (i, letter) in letters.iter().enumerate() {
            first[i] = edges.len();
            let mu = scaled.friction[i];
            match letter {
                Some(Mode::Separate) => {}
                Some(Mode::Right) => edges.push((i, [-mu, 1.0])),
                Some(Mode::Left) => edges.push((i, [mu, 1.0])),
                None | Some(Mode::Fixed) if mu == 0.0 => edges.push((i, [0.0, 1.0])),
                None | Some(Mode::Fixed) => edges.extend([(i, [mu, 1.0]), (i, [-mu, 1.0])]),
            }
        }
        first[n] = edges.len();
        // An acceleration along an axis: its sign, and whether it may be positive.
        let mut asked: Vec<(usize, usize, f64, bool)> = Vec::new();
        for (i, letter) in letters.iter().enumerate() {
            asked.push((i, 1, 1.0, matches!(letter, None | Some(Mode::Separate))));
            match letter {
                Some(Mode::Fixed) => asked.push((i, 0, 1.0, false)),
                Some(Mode::Right) => asked.push((i, 0, 1.0, true)),
                Some(Mode::Left) => asked.push((i, 0, -1.0, true)),
                None | Some(Mode::Separate) => {}
            }
        }
        let slacks = asked.iter().filter(|(.., free)| *free).count();
        let count = 1 + edges.len() + slacks;
        let mut slack = 1 + edges.len();
        let mut rows = Vec::with_capacity(asked.len() + 1);
        for (i, axis, sign, free) in asked {
            let [gravity, load] = scaled.pulls(i, axis);
            let mut row: Sparse = vec![(0, sign * load)];
            for (j, effect) in scaled.effects(i, axis) {
                for k in first[j]..first[j + 1] {
                    let [t, n] = edges[k].1;
                    row.push((1 + k, sign * (effect[0] * t + effect[1] * n)));
                }
            }
            let mut right = -sign * gravity;
            if free {
                row.push((slack, -1.0));
                slack += 1;
                let along = if way == Mode::Separate { 1 } else { 0 };
                if i == mover && axis == along {
                    right += motion;
                }
            }
            rows.push((row, right));
        }
        let mut objective = vec![0.0; count];
        objective[0] = -1.0;
        if let Some(multiple) = at {
            rows.push((vec![(0, 1.0)], multiple));
            objective[0] = 0.0;
            objective[1..=edges.len()].fill(-1.0);
        }
        let x = maximise(&rows, &objective)?;
        let forces = scaled.sum(&edges, &x[1..]);
        let y = scaled.motion(x[0], &forces);
        Ok(Point { multiple: x[0], forces, y })
    }
}

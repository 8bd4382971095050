//! The solution of one word: its motion, its forces, and the margin of each test.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::math::mass_vector::MassVector;
use crate::modes::rows::Row;
use crate::modes::words::{Mode, Word};
use crate::outcome::ContactNumber;
use crate::serial::numbers::AnyNumber;
use crate::tolerance::{FIXED_ACCELERATION, TIE};

/// Returns true if an acceleration that no force can change counts as a tie although it is above the rounding error of an exact zero.
pub(super) fn is_doubtful(value: f64) -> bool {
    value.abs() > FIXED_ACCELERATION && value.abs() <= TIE
}

/// A test of Table I.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Condition {
    /// S: a_n > 0.
    Opens,
    /// F, R, L: f_n ≥ 0.
    Presses,
    /// F: |f_t| ≤ μ f_n.
    InCone,
    /// R at v_t = 0: a_t > 0.
    SlidesRight,
    /// L at v_t = 0: a_t < 0.
    SlidesLeft,
    /// F, R, L: a_n = 0, where the other closed contacts determine a_n; the margin is −|a_n|. The test is left out if |a_n| is below its
    /// rounding error.
    Touches,
    /// F: a_t = 0, likewise.
    Sticks,
}

impl Condition {
    /// Returns true if equality fails the test.
    #[must_use]
    pub fn is_strict(self) -> bool {
        matches!(self, Self::Opens | Self::SlidesRight | Self::SlidesLeft)
    }

    pub(super) fn holds(self, margin: f64) -> bool {
        if self.is_strict() { margin > TIE } else { margin >= -TIE }
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Opens => "a_n > 0",
            Self::Presses => "f_n >= 0",
            Self::InCone => "|f_t| <= mu f_n",
            Self::SlidesRight => "a_t > 0",
            Self::SlidesLeft => "a_t < 0",
            Self::Touches => "a_n = 0",
            Self::Sticks => "a_t = 0",
        })
    }
}

/// The margin of a test: positive where the test holds, negative where it fails. Dimensionless: relative to the load, in the
/// mass metric.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// The contact.
    pub contact: ContactNumber,
    /// The test.
    pub condition: Condition,
    /// The margin.
    pub value: f64,
}

impl Margin {
    /// Returns true if the test holds; a tie counts for the closed word.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.condition.holds(self.value)
    }

    /// Returns true if the test holds, or fails by no more than a tie.
    #[must_use]
    pub fn is_tie(&self) -> bool {
        self.value.abs() <= TIE
    }
}

/// The tests of a contact in a mode with their margins, for its scaled acceleration (tangential, normal) and its scaled force.
#[inline(always)]
pub(super) fn test<V: MassVector>(
    row: &Row<V>,
    mode: Mode,
    tangential: impl FnOnce() -> f64,
    normal: impl FnOnce() -> f64,
    force: [f64; 2],
    mut says: impl FnMut(Condition, f64),
) {
    let [f_t, f_n] = force;
    match (mode, row.sliding) {
        (_, None) => {}
        (Mode::Separate, _) => says(Condition::Opens, normal()),
        (Mode::Fixed, _) => {
            says(Condition::Presses, f_n);
            says(Condition::InCone, (row.friction * f_n - f_t.abs()) / (1.0 + row.friction));
        }
        (Mode::Right, sliding) => {
            says(Condition::Presses, f_n);
            if sliding == Some(0) {
                says(Condition::SlidesRight, tangential());
            }
        }
        (Mode::Left, sliding) => {
            says(Condition::Presses, f_n);
            if sliding == Some(0) {
                says(Condition::SlidesLeft, -tangential());
            }
        }
    }
}

/// How the equations of a word determine its forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Forces {
    /// The equations determine the forces.
    Unique,
    /// The word is hyperstatic: the forces form a family, and one of its members is given.
    Family,
    /// The friction matrix is singular: there is no force, or a family of forces.
    Singular,
    /// The forces form a family, and with sliding friction the motion depends on the choice in it, which the law does not determine. The
    /// motion with the smallest forces is given.
    Undetermined,
    /// The accelerations of the word contradict each other, or no force causes them: there is no motion and no margin.
    Impossible,
}

/// One word, solved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Written", into = "Written")]
pub struct ModeAnswer {
    /// The word.
    pub word: Word,
    /// q̈: of a body (ẍ, ÿ, θ̈), in m/s² and rad/s² (impulse level: the velocity after, in m/s and rad/s); of a mechanism those of all its
    /// coordinates.
    pub acceleration: Vec<f64>,
    /// (f_t, f_n) by contact, in N (impulse level: N s). For a consistent word with a family of forces: the one with
    /// the smallest Σ|f|² (without the feature `qp` and with three or more contacts: any of the family).
    pub forces: Vec<[f64; 2]>,
    /// How the forces are determined.
    pub determined: Forces,
    /// Two fixed contacts: the range of the internal force (f_1 − f_2)·e/2, e the unit vector from contact 1 to
    /// contact 2, in N; ±∞ where friction allows any. Adding τ(e, −e) to the forces of the contacts does not
    /// change the motion. Of a mechanism, where there is an internal force: the range of τ, with (e, −e) the forces that cause no motion,
    /// (f_t,1, f_n,1, f_t,2, f_n,2), of which the sum of squares is 2 and the first that is not zero is positive.
    pub force_interval: Option<[f64; 2]>,
    /// All tests, contact by contact; for a family of forces, with the forces of the largest margins.
    pub margins: Vec<Margin>,
    /// Whether all tests hold.
    pub consistent: bool,
    /// Whether the friction matrix of the word is singular within its rounding error.
    pub(super) singular: bool,
}

impl ModeAnswer {
    /// The tests that fail. If a word is inconsistent only because of ties: the tests that hold by a tie. Empty for a consistent word.
    pub fn violated(&self) -> impl Iterator<Item = &Margin> {
        let fails = self.margins.iter().any(|margin| !margin.holds());
        let stands =
            move |margin: &Margin| if fails { margin.holds() } else { margin.value >= 0.0 };
        self.margins.iter().filter(move |margin| !self.consistent && !stands(margin))
    }

    /// Returns true if rounding may decide: a test holds or fails by no more than [`TIE`], or the friction matrix is singular (at a
    /// threshold of Painlevé).
    #[must_use]
    pub fn near_degenerate(&self) -> bool {
        self.singular || self.margins.iter().any(Margin::is_tie)
    }

    /// Returns true if the word is inconsistent at most because of ties: each test holds, or would hold without [`TIE`].
    pub(super) fn holds_but_for_ties(&self) -> bool {
        let holds = |margin: &Margin| margin.holds() || margin.value > 0.0;
        self.determined != Forces::Impossible && self.margins.iter().all(holds)
    }

    /// The smallest margin; ∞ where there is no test.
    #[must_use]
    pub fn margin(&self) -> f64 {
        self.margins.iter().map(|margin| margin.value).fold(f64::INFINITY, f64::min)
    }
}

/// A [`ModeAnswer`] in files: forces may be infinite, or absent.
#[derive(Serialize, Deserialize)]
struct Written {
    word: Word,
    acceleration: Vec<AnyNumber>,
    forces: Vec<[AnyNumber; 2]>,
    determined: Forces,
    force_interval: Option<[AnyNumber; 2]>,
    margins: Vec<Margin>,
    consistent: bool,
    singular: bool,
}

impl From<ModeAnswer> for Written {
    fn from(a: ModeAnswer) -> Self {
        Self {
            word: a.word,
            acceleration: a.acceleration.into_iter().map(Into::into).collect(),
            forces: a.forces.into_iter().map(|force| force.map(Into::into)).collect(),
            determined: a.determined,
            force_interval: a.force_interval.map(|ends| ends.map(Into::into)),
            margins: a.margins,
            consistent: a.consistent,
            singular: a.singular,
        }
    }
}

impl From<Written> for ModeAnswer {
    fn from(w: Written) -> Self {
        Self {
            word: w.word,
            acceleration: w.acceleration.into_iter().map(Into::into).collect(),
            forces: w.forces.into_iter().map(|force| force.map(Into::into)).collect(),
            determined: w.determined,
            force_interval: w.force_interval.map(|ends| ends.map(Into::into)),
            margins: w.margins,
            consistent: w.consistent,
            singular: w.singular,
        }
    }
}

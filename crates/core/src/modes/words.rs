//! Modes of contacts, and words of modes.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::body::posture::MAX_CONTACTS;
use crate::error::Error;

/// The mode of one contact. Each row gives its equations and its tests [Or & Rimon 2008, Table I].
///
/// | mode     | letter | equations           | tests                                |
/// | -------- | ------ | ------------------- | ------------------------------------ |
/// | separate | S      | f_t = 0,   f_n = 0  | a_n > 0                              |
/// | fixed    | F      | a_t = 0,   a_n = 0  | \|f_t\| ≤ μ f_n                      |
/// | right    | R      | f_t = −μ f_n, a_n = 0 | f_n ≥ 0, and a_t > 0 where v_t = 0 |
/// | left     | L      | f_t = +μ f_n, a_n = 0 | f_n ≥ 0, and a_t < 0 where v_t = 0 |
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mode {
    /// S: the contact opens.
    Separate,
    /// F: it is fixed.
    Fixed,
    /// R: it slides along +t.
    Right,
    /// L: it slides along −t.
    Left,
}

impl Mode {
    /// All modes, in the order S, F, R, L.
    pub const ALL: [Self; 4] = [Self::Separate, Self::Fixed, Self::Right, Self::Left];

    /// Its letter.
    #[must_use]
    pub fn letter(self) -> char {
        match self {
            Self::Separate => 'S',
            Self::Fixed => 'F',
            Self::Right => 'R',
            Self::Left => 'L',
        }
    }

    /// Sign of the sliding: +1 for R, −1 for L, 0 otherwise.
    pub(crate) fn direction(self) -> f64 {
        match self {
            Self::Right => 1.0,
            Self::Left => -1.0,
            Self::Separate | Self::Fixed => 0.0,
        }
    }
}

/// A mode for each contact, in the order of the contacts: "FS", "RRL", …
///
/// ```
/// use standfast::modes::{Mode, Word};
///
/// let word: Word = "FS".parse()?;
/// assert_eq!((word.mode(0), word.mode(1)), (Mode::Fixed, Mode::Separate));
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Word {
    // Two bits for each letter, contact 0 in the highest bits, so that words are ordered by their letters.
    letters: u128,
    len: u8,
}

impl Word {
    /// All contacts separate. At most [`MAX_CONTACTS`] of them.
    pub(crate) fn separate(len: usize) -> Self {
        debug_assert!(len <= MAX_CONTACTS, "a word has at most 64 letters");
        Self { letters: 0, len: len as u8 }
    }

    /// Number of contacts.
    #[must_use]
    #[allow(clippy::len_without_is_empty, reason = "there is no empty word")]
    pub fn len(&self) -> usize {
        usize::from(self.len)
    }

    /// The mode of the contact with this index, from 0.
    ///
    /// # Panics
    ///
    /// If there are fewer contacts.
    #[must_use]
    pub fn mode(&self, index: usize) -> Mode {
        assert!(index < self.len(), "the word has {} letters", self.len);
        Mode::ALL[(self.letters >> Self::place(index) & 3) as usize]
    }

    #[must_use]
    pub(crate) fn with(mut self, index: usize, mode: Mode) -> Self {
        let place = Self::place(index);
        self.letters = self.letters & !(3 << place) | (mode as u128) << place;
        self
    }

    fn place(index: usize) -> usize {
        2 * (MAX_CONTACTS - 1 - index)
    }

    /// The modes in the order of the contacts.
    pub fn modes(&self) -> impl Iterator<Item = Mode> + '_ {
        (0..self.len()).map(|i| self.mode(i))
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text: String = self.modes().map(Mode::letter).collect();
        f.pad(&text)
    }
}

impl FromStr for Word {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = || Error::Unusable {
            field: "word".into(),
            value: text.chars().take(MAX_CONTACTS).collect(),
            allowed: format!("1 to {MAX_CONTACTS} of the letters S, F, R, L"),
        };
        let mut word = Self::separate(0);
        for (i, letter) in text.chars().enumerate() {
            let mode = Mode::ALL.into_iter().find(|mode| mode.letter() == letter);
            let (Some(mode), true) = (mode, i < MAX_CONTACTS) else { return Err(wrong()) };
            word = word.with(i, mode);
            word.len += 1;
        }
        if word.len == 0 { Err(wrong()) } else { Ok(word) }
    }
}

/// As text.
impl Serialize for Word {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Word {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_as_they_are_written() {
        let long = "SFRL".repeat(16);
        for text in ["S", "FS", "RL", "LLFSR", &long] {
            let word: Word = text.parse().unwrap();
            assert_eq!(word.to_string(), text);
            assert_eq!(word.len(), text.len());
        }
        for text in ["", "X", "fs", &"S".repeat(65)] {
            assert!(text.parse::<Word>().is_err(), "{text}");
        }
    }
}

//! Options of a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::posture::Posture;
use crate::error::{Error, finite, in_range};
use crate::math::clock::Clock;
use crate::serial::shown_as_written;

shown_as_written!(Model, Impact, Simultaneous, Stop, Edges, Jams);

/// Which equations are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// The local model where it is exact, because nothing turns the body; otherwise the full model. The default.
    #[default]
    Auto,
    /// All Jacobian rows frozen at q = 0: the paper's linearisation. Only for contacts on straight lines without ends.
    Local,
    /// Finite rotation.
    Full,
}

/// The law of impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Impact {
    /// Newton's law where no contact has friction, Moreau's where one has. The default; a result has the law that acted.
    #[default]
    Auto,
    /// Frictionless Newton restitution [Or & Rimon 2008, (4)]. Friction acts between impacts only; a run has a warning if a contact with
    /// friction is hit.
    Newton,
    /// Routh's process with friction; the impulse of restitution is e times that of compression.
    Poisson,
    /// Routh's process with friction; the normal work of restitution is −e² times that of compression.
    Stronge,
    /// Chatterjee & Ruina 1998: v_n⁺ = −e v_n, with friction and tangential restitution.
    ChatterjeeRuina,
    /// Moreau: v_n⁺ = −e v_n and v_t⁺ = −e_t v_t, or sliding; may have no solution.
    Moreau,
}

/// What happens when several contacts with zero gap approach at the same instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Simultaneous {
    /// All together: u⁺ + e u⁻ ≥ 0 ⊥ P ≥ 0, with Moreau's law for the friction. The default with [`Impact::Newton`] and [`Impact::Moreau`],
    /// and possible with these laws only. With Moreau's law, contacts at rest take part. Files may call it `newton`.
    #[default]
    #[serde(alias = "newton")]
    Together,
    /// The lowest number first, then again the lowest that still approaches. The default with every other law of impact.
    FirstContactFirst,
    /// The highest number first, then again the highest that still approaches.
    LastContactFirst,
}

/// Where a run ends, unless a limit ends it before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Stop {
    /// At rest, or when it is decided that the body does not come to rest. The default.
    #[default]
    Rest,
    /// At the first Zeno point.
    Zeno,
    /// At `time_limit`, also if the body has come to rest before.
    Time,
}

/// What happens where a corner of the ground meets a side of a body with an outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Edges {
    /// It is a contact: see [`Trajectory::contacts`](crate::Trajectory::contacts). The default.
    #[default]
    Contact,
    /// The corner passes through the side, with a warning: the motion from then on is not that of the whole body.
    Ignore,
}

/// What happens where a contact slides and no contact mode is consistent: it jams (Painlevé).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Jams {
    /// What the law of impact says: with Poisson's and Stronge's law an impact without collision follows; with the others the run ends, with the
    /// outcome `inconsistent`. The default.
    #[default]
    None,
    /// An impact without collision, whatever the law of impact: that of Poisson or Stronge, or else a plastic one that stops the contact.
    Impact,
}

/// The options of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Which equations are solved. Default `Auto`.
    #[serde(deserialize_with = "crate::serial::values::word")]
    pub model: Model,
    /// The law of impact. Default `Auto`: Newton's without friction, Moreau's with friction.
    #[serde(deserialize_with = "crate::serial::values::word")]
    pub impact: Impact,
    /// What happens when several contacts touch down together. The default is `together` with Newton's and Moreau's law of impact, and
    /// `first-contact-first` with the other laws.
    #[serde(
        deserialize_with = "crate::serial::values::some_word",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Simultaneous")]
    pub simultaneous: Option<Simultaneous>,
    /// Where the run ends. Default `Rest`.
    #[serde(deserialize_with = "crate::serial::values::word")]
    pub stop: Stop,
    /// Time on the clock at the start, in s. Default 0.
    pub time: f64,
    /// Latest time on the clock at which the run ends, in s. Default: no limit.
    #[serde(
        with = "crate::serial::numbers::extended_option",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Option<crate::serial::numbers::Extended>")]
    pub time_limit: Option<f64>,
    /// Largest number of events: collisions, and changes of the contact modes (a lift-off, the end of a slide, an accumulation
    /// of impacts that ends), one each. Impacts at one instant are not separated, so that the last of them may exceed the limit. A run that
    /// is recorded has at most 20 000 000 events over the number of contacts, and a warning says where that ended it. Steps of integration are not
    /// events; a run also ends once there are 250 000 more steps than events. Default 1 000 000.
    pub event_limit: usize,
    /// Growth of a small change of the start at which the run ends, with the outcome `sensitivity-limit`; see
    /// [`Trajectory::sensitivity`](crate::Trajectory::sensitivity). With 4.5e15, 1/ε, it ends where not one digit is determined any more. The run is
    /// followed up to four times. Default: no limit.
    #[serde(
        with = "crate::serial::numbers::extended_option",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Option<crate::serial::numbers::Extended>")]
    pub sensitivity_limit: Option<f64>,
    /// Displacement of the centre of mass, in m, beyond which the outcome is `escape`. It is
    /// checked whenever the kind of motion changes. Default infinite.
    #[serde(with = "crate::serial::numbers::extended")]
    #[schemars(with = "crate::serial::numbers::Extended")]
    pub neighbourhood: f64,
    /// What happens where a corner of the ground meets a side of a body with an outline. Default `Contact`.
    #[serde(deserialize_with = "crate::serial::values::word")]
    pub edges: Edges,
    /// What happens where a contact slides and jams. Default: what the law of impact says.
    #[serde(deserialize_with = "crate::serial::values::word")]
    pub jams: Jams,
    /// Whether the trajectory is kept. Default true.
    pub record: bool,
    /// Whether the run computes intervals that are proved to contain the times of its collisions and, in the local model, of its first Zeno
    /// point: `Trajectory::enclosure`. Default false.
    pub certify: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            model: Model::Auto,
            impact: Impact::Auto,
            simultaneous: None,
            stop: Stop::Rest,
            time: 0.0,
            time_limit: None,
            event_limit: 1_000_000,
            sensitivity_limit: None,
            neighbourhood: f64::INFINITY,
            edges: Edges::Contact,
            jams: Jams::None,
            record: true,
            certify: false,
        }
    }
}

impl Options {
    /// Checks every field.
    ///
    /// ```
    /// use standfast::{Options, Stop};
    ///
    /// let options = Options { stop: Stop::Time, time_limit: Some(2.0), ..Options::default() };
    /// assert!(options.validate().is_ok());
    /// // A run that ends at a time needs one.
    /// assert!(Options { time_limit: None, ..options }.validate().is_err());
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field.
    pub fn validate(&self) -> Result<(), Error> {
        finite("time", self.time)?;
        let unusable = |value: String, allowed: &str| Error::Unusable {
            field: "time_limit".into(),
            value,
            allowed: allowed.into(),
        };
        match self.time_limit {
            Some(limit) if limit.is_nan() || limit < self.time => {
                Err(unusable(format!("{limit:?}"), "at or after `time`"))
            }
            None | Some(f64::INFINITY) if self.stop == Stop::Time => {
                let value = self.time_limit.map_or("none", |_| "inf");
                Err(unusable(value.into(), "stop = \"time\" needs a finite time_limit"))
            }
            _ => Ok(()),
        }?;
        if let Some(limit) = self.sensitivity_limit {
            in_range("sensitivity_limit", limit, limit > 1.0, "> 1 (inf allowed)")?;
        }
        in_range(
            "neighbourhood",
            self.neighbourhood,
            self.neighbourhood > 0.0,
            "> 0 (inf allowed)",
        )?;
        Ok(())
    }

    /// The rule when several contacts touch down together: [`Options::simultaneous`] or, where that is `None`,
    /// [`Simultaneous::Together`] with Newton's and Moreau's law and [`Simultaneous::FirstContactFirst`] with every other law.
    #[must_use]
    pub fn policy(&self) -> Simultaneous {
        self.simultaneous.unwrap_or(match self.impact {
            Impact::Auto | Impact::Newton | Impact::Moreau => Simultaneous::Together,
            _ => Simultaneous::FirstContactFirst,
        })
    }

    /// The same options, with the law of impact that acts on contacts with these coefficients of friction.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] if that law is for one contact at a time, and several contacts shall be hit together.
    pub(crate) fn acting(
        &self,
        friction: impl ExactSizeIterator<Item = f64>,
    ) -> Result<Self, Error> {
        let (several, impact) = (friction.len() > 1, self.law_with(friction));
        let at_once = matches!(impact, Impact::Newton | Impact::Moreau);
        if several && !at_once && self.policy() == Simultaneous::Together {
            return Err(Error::Unusable {
                field: "simultaneous".into(),
                value: "together".into(),
                allowed: "first-contact-first or last-contact-first with a law of impact other than newton and moreau"
                    .into(),
            });
        }
        Ok(Self { impact, ..*self })
    }

    /// The law of impact that acts on the contacts of a posture: [`Options::impact`] or, where that is [`Impact::Auto`], Newton's without
    /// friction and Moreau's with friction.
    ///
    /// ```
    /// use standfast::options::Impact;
    /// use standfast::{Lamina, Options, Posture};
    ///
    /// let rod = |friction| Posture::rod(0.5, &Lamina { friction, ..Lamina::default() });
    /// assert_eq!(Options::default().law(&rod(0.0)?), Impact::Newton);
    /// assert_eq!(Options::default().law(&rod(0.3)?), Impact::Moreau);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn law(&self, posture: &Posture) -> Impact {
        self.law_with(posture.frictions())
    }

    fn law_with(&self, mut friction: impl Iterator<Item = f64>) -> Impact {
        match self.impact {
            Impact::Auto if friction.any(|mu| mu > 0.0) => Impact::Moreau,
            Impact::Auto => Impact::Newton,
            law => law,
        }
    }

    /// Returns true if contacts at rest take part in the impacts of others.
    pub(crate) fn hits_resting(&self) -> bool {
        self.impact == Impact::Moreau && self.policy() == Simultaneous::Together
    }

    /// Returns true if a motion has at most two contacts, which are points, impacts without friction and terrain at rest without ends. Two contacts at
    /// one point (ψ = 1) are excluded: no impact separates them.
    pub(crate) fn is_plain(&self, posture: &Posture) -> bool {
        let apart = match posture.geometry() {
            [one, two] => one.apart(two, 1.0) > 0.0,
            few => few.len() <= 1,
        };
        apart
            && self.is_frictionless(posture.frictions())
            && posture.ground(0).is_none()
            && !posture.has_rounds()
            && !posture.has_belts()
    }

    /// Returns true if impacts act along the normal of one contact that approaches, or of two, so that two contacts need no more than their
    /// gaps and rates. No contact jams without friction.
    pub(crate) fn is_frictionless(&self, mut friction: impl ExactSizeIterator<Item = f64>) -> bool {
        let is_one = friction.len() == 1;
        self.impact == Impact::Newton && self.jams == Jams::None
            || friction.all(|mu| mu == 0.0) && (is_one || !self.hits_resting())
    }

    /// The options with which a summed tail of this run is followed event by event, until `dt` after the start of the tail.
    pub(crate) fn of_resimulated_tail(&self, dt: f64) -> Self {
        Self {
            stop: Stop::Time,
            time: 0.0,
            time_limit: Some(dt),
            event_limit: RESIMULATED_EVENTS,
            record: false,
            edges: Edges::Ignore,
            sensitivity_limit: None,
            ..*self
        }
    }

    /// Largest number of events of a run of a body with `count` contacts: the event limit, or as many as can be recorded.
    pub(crate) fn events(&self, count: usize) -> usize {
        if self.record {
            self.event_limit.min(MOST_RECORDED / count.max(1))
        } else {
            self.event_limit
        }
    }

    /// The time on the clock: rounded at the end only, and at most the time limit. (The elapsed time up to the limit is a difference and
    /// has its own rounding error.)
    pub(crate) fn clock(&self, elapsed: Clock) -> f64 {
        let time = elapsed.added_to(self.time);
        self.time_limit.map_or(time, |limit| time.min(limit))
    }

    /// Latest elapsed time at which the run ends.
    pub(crate) fn end(&self) -> f64 {
        self.time_limit.map_or(f64::INFINITY, |limit| limit - self.time)
    }
}

/// Largest product of recorded events and contacts: the record then takes 3 GB at most.
pub(crate) const MOST_RECORDED: usize = 20_000_000;

/// Largest number of events when a summed tail is followed.
const RESIMULATED_EVENTS: usize = 100_000;

//! What a run is asked for: its start, its options, and their checks.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::clock::Clock;
use crate::contact_motion::{Point, Rounding, Stance};
use crate::error::{Error, finite, in_range, positive};
use crate::frame::{Base, Frame, Snapshot};
use crate::general::General;
use crate::hybrid::Driver;
use crate::impact::Simultaneous;
use crate::local::LocalModel;
use crate::log::{Center, Spin};
use crate::modes::LONGEST_ARM;
use crate::posture::{Geometry, Posture};
use crate::terrain::Under;
use crate::tolerance::TOUCH;
use crate::trajectory::{Record, Trajectory};
use crate::tumble::{Body, Tumble};
use crate::zeno::Gaps;

/// Configuration and velocity of a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// q = (r_x, r_y, θ), in m, m, rad.
    pub q: Vector3<f64>,
    /// q̇, in m/s, m/s, rad/s.
    pub qdot: Vector3<f64>,
}

impl State {
    /// A state from plain arrays.
    #[must_use]
    pub fn new(q: [f64; 3], qdot: [f64; 3]) -> Self {
        Self { q: q.into(), qdot: qdot.into() }
    }

    /// Checks that every component is finite.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`], naming the component.
    pub fn validate(&self) -> Result<(), Error> {
        for (name, value) in ["x", "y", "theta"].into_iter().zip(self.q.iter()) {
            finite(format_args!("q.{name}"), *value)?;
        }
        for (name, value) in ["x", "y", "theta"].into_iter().zip(self.qdot.iter()) {
            finite(format_args!("qdot.{name}"), *value)?;
        }
        Ok(())
    }

    /// At rest in configuration `q`.
    #[must_use]
    pub fn at_rest(q: [f64; 3]) -> Self {
        Self::new(q, [0.0; 3])
    }
}

/// Which equations are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// The smallest that is exact for the scene: local where the body cannot turn, else full.
    #[default]
    Auto,
    /// All Jacobian rows frozen at q = 0: the paper's linearisation.
    Local,
    /// Finite rotation.
    Full,
}

/// The law of impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Impact {
    /// Frictionless Newton restitution [Or & Rimon 2008, (4)].
    #[default]
    Newton,
    /// Routh's process with friction; the impulse of restitution is e times that of compression.
    Poisson,
    /// Routh's process with friction; the normal work of restitution is −e² times that of compression.
    Stronge,
    /// Chatterjee & Ruina 1998: v_n⁺ = −e v_n, with friction and tangential restitution.
    ChatterjeeRuina,
    /// Moreau: v_n⁺ = −e v_n and v_t⁺ = −e_t v_t, or sliding; may have no answer.
    Moreau,
}

/// Where a run ends, unless a limit ends it before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Stop {
    /// At rest, or when it is decided that there will be none.
    #[default]
    Rest,
    /// At the first Zeno point.
    Zeno,
    /// At `time_limit`, whatever happens until then.
    Time,
}

/// How a run is made. The field names are the keywords of the Python face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Which equations are solved.
    pub model: Model,
    /// The law of impact.
    pub impact: Impact,
    /// What happens when several contacts arrive together.
    pub simultaneous: Simultaneous,
    /// Where the run ends.
    pub stop: Stop,
    /// Time on the clock at the start, in s.
    pub time: f64,
    /// Time on the clock at which the run ends at the latest, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_limit: Option<f64>,
    /// Largest number of events: collisions, changes of the motion; a step of a held contact counts for 20.
    pub event_limit: usize,
    /// Displacement of the centre of mass, in m, beyond which the outcome is `escape`. Looked at wherever
    /// the kind of motion changes.
    #[serde(with = "crate::scene::extended")]
    #[schemars(with = "crate::scene::Extended")]
    pub neighbourhood: f64,
    /// Largest relative error that `Model::Auto` may make.
    pub tolerance: f64,
    /// Whether the trajectory is kept.
    pub record: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            model: Model::Auto,
            impact: Impact::Newton,
            simultaneous: Simultaneous::Newton,
            stop: Stop::Rest,
            time: 0.0,
            time_limit: None,
            event_limit: 1_000_000,
            neighbourhood: f64::INFINITY,
            tolerance: 1e-12,
            record: true,
        }
    }
}

impl Options {
    /// Checks every field.
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
                Err(unusable(value.into(), "a finite time_limit, because stop = \"time\""))
            }
            _ => Ok(()),
        }?;
        in_range(
            "neighbourhood",
            self.neighbourhood,
            self.neighbourhood > 0.0,
            "> 0 (inf allowed)",
        )?;
        positive("tolerance", self.tolerance)?;
        Ok(())
    }

    /// Elapsed time at which the run ends at the latest.
    pub(crate) fn end(&self) -> f64 {
        self.time_limit.map_or(f64::INFINITY, |limit| limit - self.time)
    }
}

/// The motion of `posture` from `state` on.
///
/// # Errors
///
/// A wrong option; a state that is not finite or lies in the terrain by more than [`TOUCH`] of the size of
/// the body; `simultaneous = "newton"` with another law of impact.
pub fn simulate(posture: &Posture, state: &State, options: &Options) -> Result<Trajectory, Error> {
    simulate_until(posture, state, options, &|| false)
        .map(|run| run.unwrap_or_else(|| unreachable!("a run that nobody cancels")))
}

/// As [`simulate`]; `cancel` is asked now and then, and `None` is returned once it says so.
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_until(
    posture: &Posture,
    state: &State,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Result<Option<Trajectory>, Error> {
    options.validate()?;
    solvable(posture, options)?;
    state.validate()?;
    let (model, reason) = choose(posture, state, options.model);
    let geometry = posture.geometry();
    let local = model == Model::Local;
    let unders: Vec<Under> =
        (0..geometry.len()).map(|i| posture.under(i, &state.q, local)).collect();
    let (mut heights, rates): (Vec<f64>, Vec<f64>) = unders
        .iter()
        .map(|under| {
            let k = &under.geometry;
            let (gap, rate) = if local {
                (k.local_gap(&state.q), k.local_rate(&state.qdot))
            } else {
                (k.gap(&state.q), k.gap_rate(&state.q, &state.qdot))
            };
            (if under.exists { gap } else { f64::INFINITY }, rate)
        })
        .unzip();
    let warnings = touch(&mut heights, TOUCH * posture.size())?;
    let body = Body::new(geometry, posture.gyration_squared(), posture.fields().gravity);
    let base = Base::of_body(posture, body, state);
    if geometry.len() > 2 || options.impact != Impact::Newton || posture.ground(0).is_some() {
        let theta = if local { 0.0 } else { state.q.z };
        let (sin, cos) = (libm::sin(theta), libm::cos(theta));
        let points = unders.iter().enumerate().map(|(i, under)| {
            let Geometry { tangent, normal, .. } = under.geometry;
            let (b, c) = under.geometry.turned(sin, cos);
            let friction = posture.contacts()[i].friction;
            let (place, h, u) = (under.place, heights[i], rates[i]);
            let (place_terms, spin) = (b.abs() + c.abs() + posture.size(), b * state.qdot.z);
            let rounding = Rounding::new(
                state.q.xy().norm() + place_terms,
                state.qdot.xy().norm() + spin.abs(),
            );
            Point { normal, tangent, friction, b, c, held: None, place, h, u, rounding }
        });
        let start = Stance {
            points: points.collect(),
            center: base.center(),
            spin: base.spin(),
            rho2: posture.gyration_squared(),
            gravity: posture.fields().gravity,
            frozen: local.then_some(0.0),
        };
        let run = General::new(posture, start, options, warnings, cancel).run();
        return Ok(run.map(|general| {
            let record = Record::of_general(base, general);
            Trajectory::new(record, model, reason, *options)
        }));
    }
    let mut gaps = Gaps { h: [f64::INFINITY; 2], u: [0.0; 2] };
    for (i, (h, u)) in heights.into_iter().zip(rates).enumerate() {
        (gaps.h[i], gaps.u[i]) = (h, u);
    }
    let start = Tumble::new(body, gaps, base.center(), base.spin());
    let first = match model {
        Model::Local => {
            let nominal = Tumble::new(body, gaps, Center::default(), Spin::default());
            Frame::frozen(start.snapshot(Clock::default()), &nominal)
        }
        _ => Frame::full(start.snapshot(Clock::default())),
    };
    let run = Driver::new(first, base, options, warnings, cancel).run();
    Ok(run.map(|record| Trajectory::new(record, model, reason, *options)))
}

impl LocalModel {
    /// The motion of the gaps and of θ from a state on. `theta` in rad, `omega` in rad/s.
    ///
    /// # Errors
    ///
    /// A wrong option, a state that is not finite, or a negative gap.
    pub fn simulate(
        &self,
        gaps: [f64; 2],
        rates: [f64; 2],
        theta: f64,
        omega: f64,
        options: &Options,
    ) -> Result<Trajectory, Error> {
        self.simulate_until(gaps, rates, theta, omega, options, &|| false)
            .map(|run| run.unwrap_or_else(|| unreachable!("a run that nobody cancels")))
    }

    /// As [`LocalModel::simulate`]; `cancel` is asked now and then, and `None` is returned once it says so.
    ///
    /// # Errors
    ///
    /// As [`LocalModel::simulate`].
    pub fn simulate_until(
        &self,
        gaps: [f64; 2],
        rates: [f64; 2],
        theta: f64,
        omega: f64,
        options: &Options,
        cancel: &dyn Fn() -> bool,
    ) -> Result<Option<Trajectory>, Error> {
        options.validate()?;
        for i in 0..2 {
            finite(format_args!("gaps.{}", i + 1), gaps[i])?;
            finite(format_args!("rates.{}", i + 1), rates[i])?;
        }
        finite("theta", theta)?;
        finite("omega", omega)?;
        let mut gaps = Gaps { h: gaps, u: rates };
        let warnings = touch(&mut gaps.h, 0.0)?;
        let base = Base::of_parameters(theta, omega);
        let start = Snapshot { gaps, spin: base.spin(), ..Snapshot::default() };
        let run = Driver::new(Frame::reduced(start, self), base, options, warnings, cancel).run();
        Ok(run.map(|record| {
            Trajectory::new(record, Model::Local, "given by its parameters", *options)
        }))
    }
}

/// What is not solved yet is refused by name.
fn solvable(posture: &Posture, options: &Options) -> Result<(), Error> {
    let contacts = posture.contacts();
    let together = options.simultaneous == Simultaneous::Newton;
    if contacts.len() > 1 && options.impact != Impact::Newton && together {
        return Err(Error::Unusable {
            field: "simultaneous".into(),
            value: "newton".into(),
            allowed:
                "first-contact-first or last-contact-first with a law of impact other than newton"
                    .into(),
        });
    }
    for (i, k) in posture.geometry().iter().enumerate() {
        if options.stop != Stop::Zeno {
            let arm = libm::hypot(k.b, k.c) / posture.fields().gyration_radius;
            in_range(
                format_args!("contacts.{}.point", i + 1),
                arm,
                arm <= LONGEST_ARM,
                "beyond the first Zeno point: distance from the centre of mass over gyration_radius at most 1e4",
            )?;
        }
    }
    Ok(())
}

/// The model, and why.
fn choose(posture: &Posture, state: &State, asked: Model) -> (Model, &'static str) {
    let upright = state.q.z == 0.0 && state.qdot.z == 0.0;
    let smooth = posture.contacts().iter().all(|contact| contact.friction == 0.0);
    match asked {
        Model::Local => (Model::Local, "asked for"),
        Model::Full => (Model::Full, "asked for"),
        Model::Auto if upright && smooth && no_impact_turns(posture) => {
            (Model::Local, "exact here: no impact turns the body")
        }
        Model::Auto => {
            (Model::Full, "the body turns; only the full model has no linearisation error")
        }
    }
}

/// Whether every contact is straight over or under the centre of mass, seen along each normal it may meet.
fn no_impact_turns(posture: &Posture) -> bool {
    posture.geometry().iter().enumerate().all(|(i, k)| match posture.ground(i) {
        Some(pieces) => pieces.iter().all(|piece| posture.on_piece(i, piece).b == 0.0),
        None => k.b == 0.0,
    })
}

/// Gaps within `touch` of zero are zero; deeper ones are refused.
fn touch(gaps: &mut [f64], touch: f64) -> Result<Vec<String>, Error> {
    let mut warnings = Vec::new();
    for (i, height) in gaps.iter_mut().enumerate() {
        let gap = *height;
        if gap < -touch || gap.is_nan() {
            return Err(Error::Penetrating { contact: i + 1, gap, touch });
        }
        if gap < 0.0 {
            *height = 0.0;
            warnings.push(format!(
                "contact {} starts {:?} m below the terrain, within rounding: taken as touching",
                i + 1,
                -gap
            ));
        }
    }
    Ok(warnings)
}

//! What acts on a body during a run besides gravity and contact: kicks, forces for a time, and the motion of the ground.
//!
//! ```text
//! kick J at a point with arm a:    q̇⁺ = q̇ + M⁻¹(J, a × J),  M = diag(m, m, mρ²)
//! force F at the centre of mass:   a body falls with (0, −g) + F/m
//! ground with acceleration A:      in its frame a body falls with (0, −g) − A
//! ground tilted by τ:              in its frame gravity is turned by −τ: g (−sin τ, −cos τ)
//! ```
//!
//! Positions and velocities of such a run are relative to the ground. From one of the times to the next A is constant or
//! changes at a constant rate.

use nalgebra::Vector2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::{self, Error, finite};
use crate::serial::shown_as_written;

/// An impulse on the body at an instant. A contact that it drives into the ground is hit at the same instant.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kick {
    /// Time on the clock, in s, not before the start.
    pub time: f64,
    /// Impulse (x, y), in N s.
    pub impulse: [f64; 2],
    /// The point of the body that it acts on, at its place in the nominal posture, in m; the centre of mass unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 2]>,
}

/// A constant force through the centre of mass, from one time to another. A force elsewhere would turn with the body: its torque would depend
/// on θ, and the flight would not be a parabola.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Time on the clock from which it acts, in s.
    pub start: f64,
    /// Time on the clock until which it acts, after `start`, in s.
    pub end: f64,
    /// Force (x, y), in N; in the frame of the ground, if that moves.
    pub force: [f64; 2],
}

/// What the acceleration of the ground does from one time to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// It keeps its value: the steps of a control, or of a record that is taken as it stands.
    #[default]
    Steps,
    /// It changes at a constant rate, as a record of an earthquake is usually read.
    Linear,
}

impl Interpolation {
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    fn is_steps(&self) -> bool {
        *self == Self::Steps
    }
}

shown_as_written!(Interpolation);

/// A motion of the ground: `acceleration` or `tilt` has an entry for each of the `times`. With steps an entry holds from its time to the next one;
/// a linear acceleration changes at a constant rate in between. Before the first time the ground is at rest and level; the last entry holds for
/// ever.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GroundMotion {
    /// Times on the clock, increasing, in s.
    pub times: Vec<f64>,
    /// Acceleration (x, y) of the ground, in m/s².
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub acceleration: Vec<[f64; 2]>,
    /// What the acceleration does between the times.
    #[serde(
        default,
        skip_serializing_if = "Interpolation::is_steps",
        deserialize_with = "crate::serial::values::word"
    )]
    pub interpolation: Interpolation,
    /// Angle of the ground, counterclockwise, in rad. Steps of the angle are infinitely slow: only the direction of gravity changes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tilt: Vec<f64>,
}

/// The kicks, the forces and the motion of the ground of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Excitation {
    /// The kicks. Those at one time act one after the other, in the order of this list, before the contacts react.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub kicks: Vec<Kick>,
    /// The forces. Those that act at one time add up.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub forces: Vec<Force>,
    /// The motion of the ground, if it moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground_motion: Option<GroundMotion>,
}

/// What acts on a mechanism during a run besides its own load, in all its coordinates.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MechanismExcitation {
    /// Kicks: time on the clock, in s, and generalised impulse, in N s or N m s.
    pub kicks: Vec<(f64, Vec<f64>)>,
    /// Loads beside that of the mechanism: each acts from this time on the clock (s) until the next one, the last one for ever; in N or N m.
    pub loads: Vec<(f64, Vec<f64>)>,
}

/// A change of the excitation at an instant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Change {
    /// Time since the start of the run, in s.
    pub(crate) elapsed: f64,
    pub(crate) load: Option<NewLoad>,
    /// Kicks of a body.
    pub(crate) kicks: Vec<Kick>,
    /// Kicks of a mechanism: time on the clock and generalised impulse.
    pub(crate) impulses: Vec<(f64, Vec<f64>)>,
}

/// What acts from an instant on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NewLoad {
    /// The acceleration of free fall of a body (m/s²) and its rate (m/s³).
    Fall([Vector2<f64>; 2]),
    /// The load of a mechanism, with its own.
    Load(Vec<f64>),
}

impl Change {
    fn at(elapsed: f64) -> Self {
        Self { elapsed, load: None, kicks: Vec::new(), impulses: Vec::new() }
    }
}

/// The change at this time among those in order, which is added if there is none.
fn change_at(changes: &mut Vec<Change>, elapsed: f64) -> &mut Change {
    let at = changes.partition_point(|change| change.elapsed < elapsed);
    if changes.get(at).is_none_or(|change| change.elapsed != elapsed) {
        changes.insert(at, Change::at(elapsed));
    }
    &mut changes[at]
}

impl MechanismExcitation {
    /// Returns true if nothing acts.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.kicks.is_empty() && self.loads.is_empty()
    }

    /// Checks every field. `start`: time on the clock at the start of the run, in s. `dof`: number of coordinates.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field.
    pub fn validate(&self, start: f64, dof: usize) -> Result<(), Error> {
        for (list, name) in [(&self.kicks, "kicks"), (&self.loads, "forces")] {
            for (k, (time, values)) in list.iter().enumerate() {
                let at = format!("{name}.{}", k + 1);
                let holds = time.is_finite() && (name == "forces" || *time >= start);
                error::in_range(
                    format!("{at}.time"),
                    *time,
                    holds,
                    "finite; of a kick, not before the start",
                )?;
                if values.len() != dof {
                    return Err(Error::Unusable {
                        field: at,
                        value: format!("[{} values]", values.len()),
                        allowed: format!("one value for each of the {dof} coordinates"),
                    });
                }
                for (c, value) in values.iter().enumerate() {
                    finite(format_args!("{at}.{c}"), *value)?;
                }
            }
        }
        let late = self.loads.windows(2).position(|pair| pair[1].0 <= pair[0].0);
        late.map_or(Ok(()), |k| {
            Err(Error::Unusable {
                field: format!("forces.{}.time", k + 2),
                value: format!("{:?} after {:?}", self.loads[k + 1].0, self.loads[k].0),
                allowed: "increasing times".into(),
            })
        })
    }

    /// The changes in the order of their times, of a mechanism with this load.
    pub(crate) fn changes(&self, start: f64, own: &[f64]) -> Vec<Change> {
        let mut changes: Vec<Change> = Vec::new();
        for (time, load) in &self.loads {
            let whole = own.iter().zip(load).map(|(own, more)| own + more).collect();
            let change = change_at(&mut changes, time.max(start) - start);
            change.load = Some(NewLoad::Load(whole));
        }
        for kick in &self.kicks {
            change_at(&mut changes, kick.0 - start).impulses.push(kick.clone());
        }
        changes
    }

    /// The warning about a load that never ends; `None` if there is none.
    pub(crate) fn lasting(&self) -> Option<String> {
        let (time, load) = self.loads.last()?;
        load.iter().any(|value| *value != 0.0).then(|| {
            format!(
                "the last of the forces, or the last entry of the ground_motion, lasts from t = {time:?} s on for ever; \
                 a last one of zero ends it"
            )
        })
    }
}

/// The warning about an acceleration of the ground that never ends; `None` if there is no such acceleration.
pub(crate) fn lasting(motion: Option<&GroundMotion>) -> Option<String> {
    let motion = motion?;
    let ([x, y], time) = (*motion.acceleration.last()?, motion.times.last()?);
    ([x, y] != [0.0; 2]).then(|| {
        format!(
            "ground_motion: the last acceleration, ({x:?}, {y:?}) m/s^2, lasts from t = {time:?} s on for ever; \
             a last entry (0, 0) ends the shaking"
        )
    })
}

/// The warning about those kicks among `changes` that the run does not reach; `None` if there are none.
pub(crate) fn missed_kicks(changes: &[Change]) -> Option<String> {
    let times = |change: &Change| -> Vec<f64> {
        let of_mechanism = change.impulses.iter().map(|(time, _)| *time);
        change.kicks.iter().map(|kick| kick.time).chain(of_mechanism).collect()
    };
    let mut kicks = changes.iter().flat_map(times);
    let first = kicks.next()?;
    let count = 1 + kicks.count();
    let these = if count == 1 { "1 kick".into() } else { format!("{count} kicks") };
    Some(format!("the run ends before {these}, from t = {first:?} s on"))
}

impl GroundMotion {
    /// Checks every field. `gravity`: of the posture, in m/s².
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field.
    pub fn validate(&self, gravity: f64) -> Result<(), Error> {
        let count = self.times.len();
        let unusable = |field: &str, value: String, allowed: &str| Error::Unusable {
            field: format!("ground_motion.{field}"),
            value,
            allowed: allowed.into(),
        };
        if self.acceleration.is_empty() == self.tilt.is_empty() {
            let value = format!("{} of each", self.tilt.len());
            return Err(unusable("acceleration, tilt", value, "exactly one of them is needed"));
        }
        for (field, entries) in
            [("acceleration", self.acceleration.len()), ("tilt", self.tilt.len())]
        {
            if entries != 0 && entries != count {
                let value = format!("[{entries} entries]");
                return Err(unusable(field, value, &format!("{count} entries, as many as times")));
            }
        }
        if self.interpolation == Interpolation::Linear && self.acceleration.is_empty() {
            let allowed = "\"steps\" with a tilt: slow tilting is a sequence of small steps";
            return Err(unusable("interpolation", "\"linear\"".into(), allowed));
        }
        for (k, time) in self.times.iter().enumerate() {
            finite(format!("ground_motion.times.{}", k + 1), *time)?;
        }
        if let Some(k) = self.times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let value = format!("{:?} after {:?}", self.times[k + 1], self.times[k]);
            return Err(unusable(&format!("times.{}", k + 2), value, "increasing times"));
        }
        for k in 0..count {
            let at = |field: &str| format!("ground_motion.{field}.{}", k + 1);
            if let Some(tilt) = self.tilt.get(k) {
                error::angle(at("tilt"), *tilt, "-pi < tilt <= pi, in rad")?;
            }
            if let Some([x, y]) = self.acceleration.get(k) {
                finite(format!("{}.x", at("acceleration")), *x)?;
                finite(format!("{}.y", at("acceleration")), *y)?;
                error::gravity(
                    format!("fall in the frame of {}", at("acceleration")),
                    self.fall(gravity, k).norm(),
                )?;
            }
        }
        Ok(())
    }

    /// The acceleration of free fall in the frame of the ground from time `k` on, and its rate.
    fn fall_from(&self, gravity: f64, k: usize) -> [Vector2<f64>; 2] {
        let fall = self.fall(gravity, k);
        let next = k + 1;
        if self.interpolation == Interpolation::Steps || next >= self.times.len() {
            return [fall, Vector2::zeros()];
        }
        [fall, (self.fall(gravity, next) - fall) / (self.times[next] - self.times[k])]
    }

    /// The acceleration of free fall in the frame of the ground at time `k`.
    fn fall(&self, gravity: f64, k: usize) -> Vector2<f64> {
        match self.tilt.get(k) {
            Some(tilt) => Vector2::new(-libm::sin(*tilt), -libm::cos(*tilt)) * gravity,
            None => Vector2::new(-self.acceleration[k][0], -gravity - self.acceleration[k][1]),
        }
    }
}

impl Excitation {
    /// Returns true if nothing acts.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.kicks.is_empty() && self.forces.is_empty() && self.ground_motion.is_none()
    }

    /// Checks every field. `start`: time on the clock at the start of the run, in s. `mass`, `gravity`: of the posture, in kg and m/s².
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field.
    pub fn validate(&self, start: f64, mass: f64, gravity: f64) -> Result<(), Error> {
        for (k, kick) in self.kicks.iter().enumerate() {
            let at = |field: &str| format!("kicks.{}.{field}", k + 1);
            error::in_range(
                at("time"),
                kick.time,
                kick.time >= start && kick.time < f64::INFINITY,
                "finite, not before the start",
            )?;
            for ([x, y], field) in [(Some(kick.impulse), "impulse"), (kick.point, "point")]
                .into_iter()
                .filter_map(|(pair, field)| Some((pair?, field)))
            {
                finite(at(&format!("{field}.x")), x)?;
                finite(at(&format!("{field}.y")), y)?;
            }
        }
        for (k, force) in self.forces.iter().enumerate() {
            let at = |field: &str| format!("forces.{}.{field}", k + 1);
            force.validate().map_err(|e| e.renamed(at))?;
        }
        self.ground_motion.as_ref().map_or(Ok(()), |motion| motion.validate(gravity))?;
        for time in self.forces.iter().flat_map(|force| [force.start, force.end]) {
            error::gravity(
                String::from("free fall with the forces"),
                self.fall(time, mass, gravity)[0].norm(),
            )?;
        }
        Ok(())
    }

    /// The acceleration of free fall at this time on the clock (s), in the frame of the ground, in m/s², and its rate from then on, in m/s³.
    /// `mass`, `gravity`: of the posture, in kg and m/s².
    fn fall(&self, time: f64, mass: f64, gravity: f64) -> [Vector2<f64>; 2] {
        let motion = self.ground_motion.as_ref();
        let begun = motion.map_or(0, |motion| motion.times.partition_point(|t| *t <= time));
        let ground = motion.zip(begun.checked_sub(1)).map(|(motion, last)| {
            let [fall, rate] = motion.fall_from(gravity, last);
            [fall + rate * (time - motion.times[last]), rate]
        });
        let [fall, rate] = ground.unwrap_or([Vector2::new(0.0, -gravity), Vector2::zeros()]);
        let acting = self.forces.iter().filter(|force| force.start <= time && time < force.end);
        let pushed = acting.fold(fall, |fall, force| fall + Vector2::from(force.force) / mass);
        [pushed, rate]
    }

    /// Whether the acceleration of the ground changes at a constant rate.
    pub(crate) fn is_linear(&self) -> bool {
        let motion = self.ground_motion.as_ref();
        motion.is_some_and(|motion| motion.interpolation == Interpolation::Linear)
    }

    /// The forces at this time on the clock (s), and the force on the body that replaces the motion of the ground, in the frame of the ground:
    /// −m A, or m times the change of gravity by the tilt; no moment; in N, N, N m. `mass`, `gravity`: of the posture, in kg and m/s².
    ///
    /// ```
    /// use standfast::excitation::{Excitation, GroundMotion};
    ///
    /// // The ground accelerates at 1 m/s² for 2 s: in its frame −m A acts on a body of 3 kg.
    /// let (times, acceleration) = (vec![0.0, 2.0], vec![[1.0, 0.0], [0.0, 0.0]]);
    /// let shake = GroundMotion { times, acceleration, ..GroundMotion::default() };
    /// let excitation = Excitation { ground_motion: Some(shake), ..Excitation::default() };
    /// assert_eq!(excitation.wrench(1.0, 3.0, 9.81), [-3.0, 0.0, 0.0]);
    /// assert_eq!(excitation.wrench(2.5, 3.0, 9.81), [0.0, 0.0, 0.0]);
    /// ```
    #[must_use]
    pub fn wrench(&self, time: f64, mass: f64, gravity: f64) -> [f64; 3] {
        let force = mass * (self.fall(time, mass, gravity)[0] - Vector2::new(0.0, -gravity));
        [force.x, force.y, 0.0]
    }

    /// The changes in the order of their times. If the excitation has begun before the start of the run, the first change is at the start.
    /// `mass`, `gravity`: of the posture, in kg and m/s².
    pub(crate) fn changes(&self, start: f64, mass: f64, gravity: f64) -> Vec<Change> {
        let motion = self.ground_motion.iter().flat_map(|motion| &motion.times);
        let forces = self.forces.iter().flat_map(|force| [&force.start, &force.end]);
        let mut times: Vec<f64> = motion.chain(forces).map(|time| time.max(start)).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let fall = |time: f64| Change {
            load: Some(NewLoad::Fall(self.fall(time, mass, gravity))),
            ..Change::at(time - start)
        };
        let mut changes: Vec<Change> = times.into_iter().map(fall).collect();
        for kick in &self.kicks {
            change_at(&mut changes, kick.time - start).kicks.push(*kick);
        }
        changes
    }
}

impl Force {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`], naming the field.
    pub fn validate(&self) -> Result<(), Error> {
        finite("start", self.start)?;
        let after = self.end > self.start && self.end < f64::INFINITY;
        error::in_range("end", self.end, after, "finite, after start")?;
        finite("force.x", self.force[0])?;
        finite("force.y", self.force[1])?;
        Ok(())
    }
}

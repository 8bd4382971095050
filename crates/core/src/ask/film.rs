//! A run as a film: what a player draws at each instant.

use serde::Serialize;

use crate::ask::{Drawing, DrawnSide};
use crate::error::Error;
use crate::excitation::Excitation;
use crate::options::Model;
use crate::outcome::{ContactNumber, Outcome, Phase, ZenoKind};
use crate::simulate::Trajectory;
use crate::simulate::clocks::{FilmClock, FilmTime};

/// Largest number of impacts that a film lists.
const MOST_IMPACTS: usize = 5000;

/// A run as a film. Its frames are at the times of [`Trajectory::sample_times`], at equal steps of Zeno time
/// ([`Trajectory::film_time`]), and at the events.
#[derive(Debug, Clone, Serialize)]
pub struct Film {
    outcome: Outcome,
    model: Model,
    warnings: Vec<String>,
    start: f64,
    end: f64,
    drawing: Drawing,
    phases: Vec<Phase>,
    /// The first [`MOST_IMPACTS`] impacts that were simulated one by one.
    impacts: Vec<Impact>,
    zeno_points: Vec<ZenoPoint>,
    #[serde(flatten)]
    excitation: Excitation,
    frames: Frames,
}

#[derive(Debug, Clone, Serialize)]
struct Impact {
    time: f64,
    contact: ContactNumber,
}

#[derive(Debug, Clone, Serialize)]
struct ZenoPoint {
    time: f64,
    kind: ZenoKind,
    contacts: Vec<ContactNumber>,
    /// Whether infinitely many impacts end there.
    infinite: bool,
}

/// The frames, column by column.
#[derive(Debug, Clone, Default, Serialize)]
struct Frames {
    /// On the clock, in s.
    t: Vec<f64>,
    /// The Zeno time of a film: see [`Trajectory::film_time`].
    zeno: Vec<f64>,
    /// Configuration (m, m, rad).
    q: Vec<[f64; 3]>,
    /// Gap of each contact of the posture, in m; null where there is no ground under it.
    gaps: Vec<Vec<f32>>,
    /// Force (tangential, normal) of each contact of the run, in N; null where it is not determined.
    forces: Vec<Vec<[f32; 2]>>,
}

impl Film {
    /// The film of a run with about `count` frames.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] if nothing was recorded, or if the run has no body; [`Error::Cancelled`] once `cancel` returns true.
    pub fn of(run: &Trajectory, count: usize, cancel: &dyn Fn() -> bool) -> Result<Self, Error> {
        let Some(posture) = run.posture() else {
            return Err(Error::Unusable {
                field: "run".into(),
                value: "a run of a local model".into(),
                allowed: "a run of a posture, which has a body to draw".into(),
            });
        };
        let impacts: Vec<Impact> = (run.impacts().iter().take(MOST_IMPACTS))
            .map(|impact| Impact { time: impact.time, contact: impact.contact })
            .collect();
        let half = count.div_ceil(2);
        let mut times = run.sample_times(half.max(2))?;
        let clock = run.film(FilmClock::Zeno);
        let whole = clock.of(run.elapsed());
        let step = |k: usize| run.on_clock(clock.shows(whole * k as f64 / half as f64));
        times.extend((0..half).map(step));
        times.extend(impacts.iter().map(|impact| impact.time));
        times.extend(run.phases().iter().map(|phase| phase.start));
        times.retain(|t| *t <= run.time());
        times.sort_by(f64::total_cmp);
        times.dedup();
        let frames = Frames::of(run, &clock, times, cancel)?;
        let zeno = |point: &crate::outcome::ZenoPoint| ZenoPoint {
            time: point.time,
            kind: point.kind,
            contacts: point.contacts.clone(),
            infinite: point.is_infinite(),
        };
        Ok(Self {
            outcome: run.outcome(),
            model: run.model(),
            warnings: run.warnings().to_vec(),
            start: run.options().time,
            end: run.time(),
            drawing: Drawing::of(
                posture,
                run.contacts().iter().filter_map(DrawnSide::of_run).collect(),
            ),
            phases: run.phases().to_vec(),
            impacts,
            zeno_points: run.zeno_points().iter().map(zeno).collect(),
            excitation: run.excitation().clone(),
            frames,
        })
    }
}

impl Film {
    /// The film as JSON, without spaces; undefined numbers are null.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_else(|e| unreachable!("a film is JSON: {e}"))
    }
}

impl Frames {
    /// The frames at these times. A time so deep in a sum of impacts that its state is not computed has none.
    fn of(
        run: &Trajectory,
        clock: &FilmTime,
        times: Vec<f64>,
        cancel: &dyn Fn() -> bool,
    ) -> Result<Self, Error> {
        let mut frames = Self::default();
        let mut reader = run.reader();
        for (k, t) in times.into_iter().enumerate() {
            if k % 64 == 0 && cancel() {
                return Err(Error::Cancelled);
            }
            let (Ok(now), Ok(forces)) = (reader.at(t), reader.forces(t)) else { continue };
            frames.t.push(t);
            frames.zeno.push(clock.of((t - run.options().time).min(run.elapsed())));
            frames.q.push(now.state.q.into());
            frames.gaps.push(now.gaps.iter().map(|gap| *gap as f32).collect());
            frames.forces.push(forces.iter().map(|force| force.map(|f| f as f32)).collect());
        }
        Ok(frames)
    }
}

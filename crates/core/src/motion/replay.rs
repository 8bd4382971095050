//! States within a sum of impacts: up to a time in closed form, then event by event.

use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::{Record, Tail};
use crate::motion::subject::Subject;
use crate::options::Options;
use crate::zeno::{FrozenModel, Gaps, Impulses};

/// Most events of a sum that are followed without a record: a second of computing time.
const MOST_FOLLOWED: usize = 20_000_000;

/// The last time up to `t` (s) in a tail from these gaps on that closed forms give, the gaps then, and the effects of the impacts until then.
fn within(tail: Tail, model: &FrozenModel, gaps: &Gaps, t: f64) -> (f64, Gaps, Impulses) {
    match tail {
        Tail::Bounce { contact } => model.skip_bounces(contact, gaps, t),
        Tail::Cycle { ratio, duration } => {
            let cycles = (libm::log1p(-t / duration) / libm::log(ratio)).floor();
            let scale = libm::pow(ratio, cycles);
            let t = duration * (1.0 - scale);
            let rates = gaps.u.map(|u| u * scale);
            (t, Gaps { h: [0.0; 2], u: rates }, model.lead_to(rates, gaps, t))
        }
        Tail::Collisions => (0.0, *gaps, Impulses::default()),
    }
}

/// The last state, up to the time `dt` (s) within a sum of impacts that starts in this state, that a closed form gives, and the time from there to
/// `dt`; `None`: there is no closed form.
pub(crate) fn lead(
    start: &Moving,
    tail: Tail,
    subject: &Subject,
    dt: f64,
) -> Option<(Moving, f64)> {
    let (mut state, gaps) = (start.clone(), start.gaps());
    let t = match (&mut state, subject.pair()) {
        (Moving::Turning(body), Some(pair)) => {
            let full = body.full(pair);
            let (t, gaps, own) = within(tail, &full.model(), &gaps, dt);
            body.follow(&full.hit(&full.model(), t, &own, &gaps));
            t
        }
        (Moving::Frozen(rows), _) => {
            let (t, gaps, own) = within(tail, rows.rows.gaps.as_ref()?, &gaps, dt);
            **rows = rows.hit(t, &own, &gaps);
            t
        }
        (Moving::Turning(_), None) => return None,
    };
    Some((state, (dt - t).max(0.0)))
}

/// The record of a sum of impacts that starts in this state, event by event up to the time `until` (s) within it; `None` if too many events
/// come before. `fastest`: the largest speed until then, in m/s; `options`: of the run.
pub(crate) fn replayed(
    start: Moving,
    fastest: f64,
    subject: &Subject,
    options: &Options,
    until: f64,
) -> Option<(Box<Record>, Options)> {
    let options = Options { record: true, ..options.of_resimulated_tail(until) };
    let record = follower(start, fastest, subject, &options)?.run_tail()?;
    Some((record, options))
}

/// The state at the time `dt` (s) within a sum of impacts that starts in this state, event by event without a record: for sums of two contacts over
/// constant rows with so many impacts that [`replayed`] ends before.
pub(crate) fn followed(
    start: Moving,
    fastest: f64,
    subject: &Subject,
    options: &Options,
    dt: f64,
) -> Option<Moving> {
    let options = Options { event_limit: MOST_FOLLOWED, ..options.of_resimulated_tail(dt) };
    let is_fast = match &start {
        Moving::Frozen(rows) => rows.rows.gaps.is_some(),
        Moving::Turning(_) => subject.pair().is_some(),
    };
    let follower = is_fast.then(|| follower(start, fastest, subject, &options))??;
    follower.state_after_tail()
}

/// The driver of a run from this state on that has recorded the Zeno points of its contacts at rest.
fn follower(
    start: Moving,
    fastest: f64,
    subject: &Subject,
    options: &Options,
) -> Option<Driver<'static>> {
    let resting = start.points().map(|point| point == (0.0, 0.0)).collect();
    let (subject, never) = (subject.clone(), &|| false);
    let mut run = match (start, subject.posture().cloned()) {
        (Moving::Turning(body), Some(posture)) => {
            Driver::of_body(&posture, *body, subject, options, Vec::new(), never)
        }
        (Moving::Frozen(rows), _) => {
            Driver::of_rows(*rows, 0.0, subject, options, Vec::new(), never)
        }
        (Moving::Turning(_), None) => return None,
    };
    (run.resting, run.fastest) = (resting, fastest);
    Some(run)
}

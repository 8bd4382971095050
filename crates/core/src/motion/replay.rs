//! States within a sum of impacts: up to a time in closed form, then event by event.

use crate::body::contact::ContactLetters;
use crate::modes::Mode;
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::Tail;
use crate::motion::subject::Subject;
use crate::options::Options;
use crate::zeno::{FrozenModel, Gaps, Impulses};

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

/// The state and the modes at time `dt` within a sum of impacts that starts in this state; `None` if too many events come before that time.
/// `fastest`: the largest speed until then, in m/s; `options`: of the run.
pub(crate) fn within_sum(
    start: &Moving,
    fastest: f64,
    tail: Tail,
    subject: &Subject,
    options: &Options,
    dt: f64,
) -> Option<(Moving, ContactLetters<Mode>)> {
    let (mut state, mut left) = (start.clone(), dt);
    if tail != Tail::Collisions {
        let gaps = start.gaps();
        match (&mut state, subject.pair()) {
            (Moving::Turning(body), Some(pair)) => {
                let full = body.full(pair);
                let (t, gaps, own) = within(tail, &full.model(), &gaps, dt);
                body.follow(&full.hit(&full.model(), t, &own, &gaps));
                left = (dt - t).max(0.0);
            }
            (Moving::Frozen(rows), _) => {
                let (t, gaps, own) = within(tail, rows.rows.gaps.as_ref()?, &gaps, dt);
                **rows = rows.hit(t, &own, &gaps);
                left = (dt - t).max(0.0);
            }
            (Moving::Turning(_), None) => return None,
        }
    }
    if matches!(tail, Tail::Bounce { .. }) {
        let word = ContactLetters::from_elem(Mode::Separate, state.count());
        return Some((state.flown(left), word));
    }
    let options = options.of_resimulated_tail(left);
    let resting = state.points().map(|point| point == (0.0, 0.0)).collect();
    let (subject, never) = (subject.clone(), || false);
    let mut run = match (state, subject.posture().cloned()) {
        (Moving::Turning(body), Some(posture)) => {
            Driver::of_body(&posture, *body, subject, &options, Vec::new(), &never)
        }
        (Moving::Frozen(rows), _) => {
            Driver::of_rows(*rows, 0.0, subject, &options, Vec::new(), &never)
        }
        (Moving::Turning(_), None) => return None,
    };
    (run.resting, run.fastest) = (resting, fastest);
    run.run_tail().map(|run| (run.state, run.log.word))
}

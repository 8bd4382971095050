//! Impacts without friction at one instant, of one or two contacts with constant rows.

use crate::collisions::log::Collision;
use crate::impact::newton::{self, Hit, SequenceEnd};
use crate::motion::driver::Driver;
use crate::motion::mechanism::Jointed;
use crate::motion::record::Tail;
use crate::options::Simultaneous;
use crate::outcome::{Cause, ContactNumber, Outcome, ZenoMethod};
use crate::tolerance::REACHED;
use crate::zeno::{FrozenModel, Impulses};

/// Impacts of one instant that are listed one by one.
const LISTED: usize = 64;

impl Driver<'_, Jointed> {
    /// The impacts of this instant: of both contacts at once, in turn, or of one contact. An outcome: the run ends here.
    pub(super) fn plain_impact(
        &mut self,
        model: &FrozenModel,
        coming: &[usize],
    ) -> Option<Outcome> {
        let gaps = self.body.state.gaps();
        let (before, both_touch) = (gaps.u, gaps.h == [0.0; 2]);
        let (tie, policy) = (coming.len() > 1, self.options.policy());
        if tie {
            self.warn_of_tie(coming);
        }
        let first = match coming {
            [first, _] if policy != Simultaneous::LastContactFirst => *first,
            [.., last] => *last,
            [] => return None,
        };
        let together = tie && policy == Simultaneous::Together;
        let (mut rates, mut jump, mut count) = (before, [0.0; 2], 0);
        let mut hits: Vec<Hit> = Vec::new();
        let mut in_step = false;
        if together {
            (jump, in_step) = newton::newton_together(model, before);
            rates = if in_step {
                [0, 1].map(|i| -model.e[i] * before[i]) // exact by the law, without rounding error
            } else {
                newton::kicked(model, before, jump)
            };
            let hit = |contact| Hit { contact, before, after: rates };
            hits.extend((0..2).filter(|&i| jump[i] > 0.0).map(hit));
        } else if both_touch {
            let end = newton::in_zero_time(model, first, &mut rates, |hit| {
                count += 1;
                jump[hit.contact] += hit.after[hit.contact] - hit.before[hit.contact];
                if hits.len() < LISTED {
                    hits.push(*hit);
                }
            });
            // So many impacts that the speeds underflow count as infinitely many. One impact on each contact may also leave zero rates.
            if end == SequenceEnd::Infinite || count > 2 && rates == [0.0; 2] {
                self.log.struck = [true; 2];
                let own =
                    Impulses { jump: model.solve_coupled(before.map(|u| -u)), path: [0.0; 2] };
                self.push_plainly(&own, [0.0; 2]);
                return self.settle(&[0, 1], ZenoMethod::Chatter, model.chatters(), 0.0);
            }
            if count > 1 {
                // The jumps of many impacts cancel: their sum is computed from the rates at the end.
                jump = model.solve_coupled([0, 1].map(|i| rates[i] - before[i]));
            }
        } else {
            rates = newton::newton(model, first, before);
            jump[first] = rates[first] - before[first];
            hits.push(Hit { contact: first, before, after: rates });
        }
        self.push_plainly(&Impulses { jump, path: [0.0; 2] }, rates);
        self.log.hits += count.max(hits.len());
        let last = hits.last().map_or(first, |hit| hit.contact);
        self.cause = Some(Cause::Impact(ContactNumber::of(last)));
        for hit in &hits {
            let contact = hit.contact;
            self.log.struck[contact] = true;
            if self.log.record {
                let own = hit.after[contact] - hit.before[contact];
                self.log.collisions.push(Collision {
                    elapsed: self.log.clock,
                    contact,
                    before: hit.before,
                    after: hit.after,
                    jump: if together { jump[contact] } else { own },
                    other_gap: gaps.h[1 - contact],
                });
            }
        }
        self.note_flight();
        if in_step && let Some(end) = self.bounce_in_step() {
            return end;
        }
        // Repeated ties end when the remaining time is below the rounding error of the clock.
        if together && both_touch && model.g[0] > 0.0 && model.g[1] > 0.0 {
            let left = 0.5 * f64::max(model.bounce[0] * rates[0], model.bounce[1] * rates[1]);
            if 0.0 < left && left <= 0.5 * REACHED * self.log.clock.hi {
                self.both_rest(model, left, Tail::Collisions);
                return self.settle(&[0, 1], ZenoMethod::Mixed, false, left);
            }
        }
        None
    }

    /// Applies own-rate jumps, with these exact rates after them.
    fn push_plainly(&mut self, own: &Impulses, rates: [f64; 2]) {
        let mut gaps = self.body.state.gaps();
        gaps.u = rates;
        self.body.state = self.body.state.hit(0.0, own, &gaps);
    }
}

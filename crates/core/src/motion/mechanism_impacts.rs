//! Impacts of a mechanism, and the sums of infinitely many of them: at one instant, of one contact that bounces alone, and in cycles while
//! another contact is held.

use std::sync::Arc;

use crate::body::contact::{ContactLetters, ContactValues};
use crate::body::terrain::Place;
use crate::collisions::log::names;
use crate::impact::friction::{
    self, Material, NO_FRICTION, plastic_jam, slides_in_impact, watch_energy,
};
use crate::impact::together::{NONE_TOGETHER, Party, SEVERAL, Together, all_closed, together};
use crate::math::clock::Clock;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::math::simplex::maximise;
use crate::modes::Mode;
use crate::motion::driver::{Coordinates as _, Driver, DriverStep};
use crate::motion::mechanism::Jointed;
use crate::motion::nested::{CycleSum, Landed, SlowLanding};
use crate::motion::record::{ListedImpact, Tail};
use crate::motion::slow::{GoesOn, InstantImpacts};
use crate::options::{Impact, Jams, Simultaneous};
use crate::outcome::{Cause, ContactNumber, Outcome, ZenoMethod};
use crate::sustained::frozen::{Frozen, GapState};
use crate::sustained::jam::by_contact;
use crate::tolerance::{CONTACT_STOPPED, HIT_IN_TURN, REMAINDER_FACTOR, STILL};

/// Number of impacts of a contact before the first attempt to sum its bounces.
const FIRST_ATTEMPT: usize = 2;

impl Driver<'_, Jointed> {
    pub(super) fn material(&self, i: usize) -> Material {
        self.body.state.rows.material[i]
    }

    /// One impact of contacts that approach at zero gap, or several at once.
    pub(super) fn impact(&mut self, coming: &[usize]) -> Option<Outcome> {
        if let Some(model) = self.body.plain() {
            return self.plain_impact(&model, coming);
        }
        let coming = self.arriving(coming);
        let arriving: ContactValues<usize> =
            coming.iter().copied().filter(|&i| !self.resting[i]).collect();
        let chosen = if arriving.is_empty() { &coming } else { &arriving };
        if chosen.len() > 1 {
            self.warn_of_tie(chosen);
        }
        if self.options.policy() == Simultaneous::Together {
            let parties = if self.options.hits_resting() {
                all_closed(self.body.state.points.iter().map(|p| (p.h, p.u)))
            } else {
                chosen.clone()
            };
            if parties.len() > 1 {
                if self.sum_up(chosen[0]) {
                    return self.stop_slow(0.0);
                }
                if let Some(end) = self.together(&parties) {
                    return end;
                }
                self.warn_once(NONE_TOGETHER.into());
            }
        }
        let last = self.options.policy() == Simultaneous::LastContactFirst;
        let i = if last { *chosen.last()? } else { chosen[0] };
        if self.sum_up(i) {
            return self.stop_slow(0.0);
        }
        let (law, material) = (self.options.impact, self.material(i));
        let w = self.body.state.impact_matrix(i);
        let GapState { u: rate, rounding, .. } = self.body.state.points[i];
        let slip = self.body.state.slip(i);
        let Some([p_t, mut p_n]) = friction::impulse(law, &w, [slip, rate], &material) else {
            self.record
                .warnings
                .push(format!("the law of impact has no solution at contact {}", i + 1));
            return Some(Outcome::Inconsistent);
        };
        let restitution = material.restitution;
        let newton = restitution == 0.0 || !matches!(law, Impact::Poisson | Impact::Stronge);
        if newton {
            // The remaining error of u⁺ + e u⁻ is subtracted.
            p_n -= ((1.0 + restitution) * rate + w.nt * p_t + w.nn * p_n) / w.nn;
        }
        let (before, speed) = (self.rates(), self.body.state.v.norm());
        self.apply_impulse(i, [p_t, p_n]);
        let speeds = [speed, self.body.state.v.norm()];
        watch_energy(&mut self.record.warnings, speeds, self.body.fastest);
        let p = &mut self.body.state.points[i];
        if newton {
            p.u = -restitution * rate; // exact by the law, without rounding error
        }
        p.rounding.rate = (p.u / rate).abs() * rounding.rate + f64::EPSILON * p.u.abs();
        self.hit_once(i, before, rate, [p_t, p_n]);
        if coming.len() == 1
            && let Some(end) = self.bounced(i, [p_t, p_n])
        {
            return end;
        }
        self.stop_slow(rate.abs())
    }

    /// The impacts whose recorded time is `end` (s since the start), which the run has reached, as those of bodies.
    pub(super) fn impacts_at(&mut self, end: f64) -> Option<Outcome> {
        let latest = Clock { hi: end, lo: f64::EPSILON * end };
        let (clock, options) = (self.log.clock, self.options);
        for p in &mut self.body.state.points {
            let due = || options.clock(clock.after(-p.h / p.u)) <= options.clock(latest);
            if p.h > 0.0 && p.u < 0.0 && due() {
                p.h = 0.0;
            }
        }
        loop {
            let points = &self.body.state.points;
            let coming: ContactValues<usize> =
                (0..points.len()).filter(|&i| points[i].h == 0.0 && points[i].u < 0.0).collect();
            if coming.is_empty() {
                return None;
            }
            if !self.log.step() {
                return Some(Outcome::EventLimit);
            }
            if Jointed::has_left(self) {
                return Some(Outcome::Escape);
            }
            if let Some(outcome) = self.impact(&coming) {
                return Some(outcome);
            }
        }
    }

    /// Those that are hit: these, and all that arrive with them, whose gaps are set to zero.
    fn arriving(&mut self, coming: &[usize]) -> ContactValues<usize> {
        let mut all = ContactValues::from_slice(coming);
        if self.body.sequence.goes_on(self.log.clock) {
            return all;
        }
        for j in 0..self.body.state.points.len() {
            let state = &mut self.body.state;
            let together = coming.iter().any(|&i| state.lands_with(j, &state.points[i]));
            if state.points[j].h > 0.0 && together {
                state.points[j].h = 0.0;
                all.push(j);
            }
        }
        all.sort_unstable();
        all
    }

    /// Gap rates; empty without a record.
    fn rates(&self) -> Vec<f64> {
        let count = if self.log.record { self.body.state.points.len() } else { 0 };
        self.body.state.points.iter().take(count).map(|p| p.u).collect()
    }

    /// Counts and records an impact.
    fn hit_once(&mut self, i: usize, before: Vec<f64>, rate: f64, impulse: [f64; 2]) {
        self.log.hits += 1;
        self.cause = Some(Cause::Impact(ContactNumber::of(i)));
        let friction = self.body.state.rows.friction[i];
        if self.options.impact != Impact::Newton {
            self.body.laps.rubs(i, slides_in_impact(impulse, friction), self.log.clock);
        }
        let rubs = self.options.impact == Impact::Newton && friction > 0.0;
        if rubs && !self.body.friction_warned {
            self.body.friction_warned = true;
            self.record.warnings.push(NO_FRICTION.into());
        }
        self.body.last.follow(i, -rate, &self.log);
        if self.log.record {
            let (clock, after) = (self.log.clock, self.rates());
            let collisions = self.log.collisions.len();
            let hit = ListedImpact { clock, collisions, contact: i, before, after, impulse };
            self.record.impacts.push(hit);
        }
    }

    fn apply_impulse(&mut self, i: usize, impulse: [f64; 2]) {
        let change = self.body.state.push(i, impulse);
        self.body.sequence.pushed(i, impulse[0], &change);
    }

    /// The law of impact for all these contacts at once. Those that approach after it are hit next. `None` if the law has no solution.
    fn together(&mut self, hit: &[usize]) -> Option<Option<Outcome>> {
        let (space, state) = (self.body.space(), &self.body.state);
        let parties: ContactValues<Party> = hit
            .iter()
            .map(|&i| {
                let before = [state.slip(i), state.points[i].u];
                Party { before, material: self.material(i).in_impacts(self.options.impact) }
            })
            .collect();
        let row = |k: usize| match k % 2 {
            0 => space.tangent(hit[k / 2]),
            _ => space.normal_row(hit[k / 2]),
        };
        let coordinates = space.pull().len();
        let found = together(&parties, |k, l| row(k).dot(row(l)), coordinates);
        let Together { impulses, hit: is_hit, several } = found?;
        if several {
            self.warn_once(SEVERAL.into());
        }
        let (listed, speed) = (self.rates(), self.body.state.v.norm());
        for (&i, &impulse) in hit.iter().zip(&impulses) {
            if impulse != [0.0; 2] {
                self.apply_impulse(i, impulse);
            }
        }
        let speeds = [speed, self.body.state.v.norm()];
        watch_energy(&mut self.record.warnings, speeds, self.body.fastest);
        for (k, &i) in hit.iter().enumerate() {
            let Party { before: [_, rate], material } = parties[k];
            if is_hit[k] {
                self.body.state.points[i].u = -material.restitution * rate + 0.0;
            }
            if impulses[k] != [0.0; 2] {
                self.hit_once(i, listed.clone(), rate, impulses[k]);
            }
        }
        let arrived =
            (0..hit.len()).rev().find(|&k| parties[k].before[1] < 0.0 && impulses[k] != [0.0; 2]);
        self.cause = arrived.map(|k| Cause::Impact(ContactNumber::of(hit[k]))).or(self.cause);
        let pushed = |(party, impulse): (&Party, &[f64; 2])| {
            party.material.friction == 0.0 && impulse[1] > 0.0
        };
        let all = impulses.len() == self.body.state.points.len()
            && parties.iter().zip(&impulses).all(pushed);
        if all && let Some(end) = self.bounce_in_step() {
            return Some(end);
        }
        let fastest = parties.iter().fold(0.0_f64, |most, party| most.max(-party.before[1]));
        Some(self.stop_slow(fastest))
    }

    /// As for bodies: infinitely many impacts at one instant, in cycles that shrink in one ratio, are summed.
    fn sum_up(&mut self, i: usize) -> bool {
        let rates: ContactValues<f64> = self.body.state.points.iter().map(|p| p.u).collect();
        let pieces = ContactValues::from_elem(0, rates.len());
        let Jointed { sequence, state, fastest, .. } = &mut self.body;
        let (rows, fastest) = (Arc::clone(&state.rows), *fastest);
        let space = &rows.space;
        let size = |v: &Coordinates| space.reach() * v.norm();
        let GoesOn::Shrinking { change, sum, start, rubs } =
            sequence.next(i, self.log.clock, &rates, pieces, size, fastest)
        else {
            return false;
        };
        let mut end = state.clone();
        end.v.add_scaled(&change, sum);
        for (j, p) in end.points.iter_mut().enumerate() {
            if p.h > 0.0 {
                p.u += sum * space.normal_row(j).dot(&change);
                continue;
            }
            let limit = InstantImpacts::<Coordinates>::limit_of_rate(p.u, start[j], sum);
            let Some(limit) = limit else { return false };
            p.u = limit;
        }
        let turns_back = |j: usize| {
            let (now, limit) = (state.slip(j), end.slip(j));
            end.points[j].u == 0.0
                && InstantImpacts::<Coordinates>::turns_back(now, limit, rubs[j], fastest)
        };
        if (0..rates.len()).any(turns_back) {
            return false;
        }
        *state = end;
        sequence.summed(&change, &rubs, sum);
        true
    }

    /// After an impact with the speed `hit` (m/s): sets those contacts to rest whose remaining motion is below its rounding error.
    pub(super) fn stop_slow(&mut self, hit: f64) -> Option<Outcome> {
        let limit = CONTACT_STOPPED * self.body.fastest;
        let count = self.body.state.points.len();
        let pulls: ContactValues<f64> = (0..count).map(|i| self.body.space().gravity(i)).collect();
        let points = self.body.state.points.iter();
        let speeds: ContactValues<f64> =
            points.zip(&pulls).map(|(p, pull)| p.landing_speed(*pull)).collect();
        let (slow, watched) = self.body.slow.stopping(hit, &speeds, limit);
        let (mut stopped, mut error) = (Vec::new(), 0.0_f64);
        let mut stops: ContactValues<bool> =
            self.body.state.points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        for (i, &speed) in speeds.iter().enumerate().filter(|(i, _)| slow[*i]) {
            stops[i] = true;
            let loss = 1.0 - self.material(i).restitution;
            if !self.resting[i] && pulls[i] >= 0.0 {
                if pulls[i] > 0.0 {
                    error = error.max(2.0 * speed / (pulls[i] * loss));
                }
                stopped.push(i);
            }
        }
        if slow.contains(&true) {
            let change = self.body.state.arrest(&stops);
            self.body.sequence.changes(&change);
            let place = self.body.place();
            self.body.state.reconcile(place);
            for (p, _) in self.body.state.points.iter_mut().zip(&stops).filter(|(_, stops)| **stops)
            {
                (p.h, p.u) = (0.0, 0.0);
            }
            if self.body.slow.chatters() && self.body.state.speed() <= watched {
                self.body.state.v.clear();
                self.body.state.points.iter_mut().for_each(|p| p.u = 0.0);
            }
        }
        if stopped.is_empty() {
            return None;
        }
        if self.body.slow.stopped() {
            self.body.stopped_chatter.0.extend(stopped.iter().copied());
            self.body.stopped_chatter.1 = watched;
        }
        let fades = hit <= HIT_IN_TURN * CONTACT_STOPPED * self.body.fastest;
        let method =
            if stopped.len() == 1 || !fades { ZenoMethod::Bounce } else { ZenoMethod::Mixed };
        self.settle(&stopped, method, false, error)
    }

    /// No mode is consistent: an impact without collision at a sliding contact, if the law has one or jams are impacts. Returns whether there
    /// is one.
    pub(super) fn jam(&mut self) -> bool {
        let points = &self.body.state.points;
        let mut closed: Vec<usize> =
            (0..points.len()).filter(|&i| points[i].h == 0.0 && points[i].u == 0.0).collect();
        if self.options.policy() == Simultaneous::LastContactFirst {
            closed.reverse();
        }
        let (law, state) = (self.options.impact, &self.body.state);
        let found = closed.iter().find_map(|&i| {
            friction::jam(law, &state.impact_matrix(i), state.slip(i), &self.material(i))
                .map(|impulse| (i, impulse))
        });
        let (impulses, stands) = match found {
            Some(one) => (vec![one], false),
            None if self.options.jams == Jams::Impact => match self.stops_jam(&closed) {
                Some(found) => found,
                None => return false,
            },
            None => return false,
        };
        let who = names(impulses.iter().map(|(i, _)| *i));
        self.warn_once(match found {
            Some(_) => format!(
                "{who} jammed while it slid: no contact mode was consistent, and an impact without collision followed"
            ),
            None => format!(
                "{who} jammed: no contact mode was consistent, and a plastic impact without collision followed (jams=\"impact\")"
            ),
        });
        for &(i, impulse) in &impulses {
            let before = self.rates();
            self.apply_impulse(i, impulse);
            if !stands && (found.is_none() || self.material(i).restitution == 0.0) {
                self.body.state.points[i].u = 0.0;
            }
            self.hit_once(i, before, 0.0, impulse);
            self.resting[i] = found.is_none() && self.resting[i];
        }
        if stands {
            self.body.state.v.clear();
            self.body.state.points.iter_mut().for_each(|p| p.u = 0.0);
        }
        self.record.undecided = None;
        true
    }

    /// The impulses of the plastic impact that ends a jam, and whether all contacts stop: forces in their friction cones stop all motion, or else
    /// the first contact that jams stops alone, if this opens the others.
    #[allow(clippy::type_complexity, reason = "used once")]
    fn stops_jam(&self, closed: &[usize]) -> Option<(Vec<(usize, [f64; 2])>, bool)> {
        let state = &self.body.state;
        if closed.len() > 1
            && let Some(impulses) = stopped_by(state, closed)
        {
            return Some((impulses, true));
        }
        closed.iter().find_map(|&i| {
            let friction = state.rows.friction[i];
            let impulse = plastic_jam(&state.impact_matrix(i), state.slip(i), friction)?;
            let mut after = state.clone();
            after.push(i, impulse);
            let opens = |k: &usize| *k == i || after.points[*k].u > 0.0;
            closed.iter().all(opens).then(|| (vec![(i, impulse)], false))
        })
    }

    /// Contact `i` alone has been hit by this impulse (tangential, normal). If all its further bounces are known, moves to their limit.
    fn bounced(&mut self, i: usize, impulse: [f64; 2]) -> Option<Option<Outcome>> {
        let alone =
            (0..self.body.state.points.len()).all(|j| j == i || self.body.state.points[j].h > 0.0);
        if !alone || !self.body.bounces.follow(i, self.log.hits, FIRST_ATTEMPT) {
            return None;
        }
        let (t, end) = self.end_of_bounces(i, impulse)?;
        self.write_sum(Tail::Collisions);
        self.body.state = end;
        self.log.clock = self.log.clock.after(t);
        self.body.bounces = crate::motion::bounces::Bounces::default();
        Some(self.settle(&[i], ZenoMethod::Bounce, false, 0.0))
    }

    /// The limit of all further bounces of contact `i`, in flight at the speed u after an impact with this impulse: the time until then, and the
    /// state. Each bounce multiplies u by r. With π the impulse per unit landing speed,
    ///
    /// ```text
    /// T = 2u/(g(1 − r)),   J = π u/(1 − r),   ẏ_∞ = ẏ + pull T + J
    /// ```
    ///
    /// and the impulses, in proportion to the time that is left, act as a constant force J/T with a correction that the gap of the contact shows.
    fn end_of_bounces(&self, i: usize, impulse: [f64; 2]) -> Option<(f64, Frozen)> {
        let (space, state) = (self.body.space(), &self.body.state);
        let (law, mut material) = (self.options.impact, self.material(i));
        if law == Impact::Newton {
            material.friction = 0.0;
        }
        let (g, u) = (space.gravity(i), state.points[i].u);
        if !(g > 0.0 && u > 0.0) {
            return None;
        }
        let (slip, pulled) = (state.slip(i), space.b()[2 * i]);
        let still = slip.abs() <= STILL * self.body.fastest;
        let sticks = impulse[0].abs() < (1.0 - STILL) * material.friction * impulse[1];
        if sticks && !(still && material.tangential_restitution == 0.0) {
            return None;
        }
        // The next impact: a contact that sticks lands with the sliding speed of one flight.
        let next = if sticks { 2.0 * pulled * u / g } else { slip + 2.0 * pulled * u / g };
        let w = state.impact_matrix(i);
        let [p_t, p_n] = friction::impulse(law, &w, [next, -u], &material)?;
        let returned = w.nt * p_t + w.nn * p_n - u;
        let r = returned / u;
        let sticks_again = p_t.abs() < (1.0 - STILL) * material.friction * p_n;
        let slides_on = !sticks && !sticks_again && p_t * impulse[0] >= 0.0;
        if !(r > 0.0 && r < 1.0) || !(sticks && sticks_again || slides_on) {
            return None;
        }
        if !sticks && material.friction > 0.0 && matches!(law, Impact::ChatterjeeRuina) {
            return None; // the impulse of a slide is not in proportion to the landing speed alone
        }
        let t = 2.0 * u / (g * (1.0 - r));
        if !(t <= self.log.left()) {
            return None;
        }
        let push = space.normal_row(i).scaled(p_n).plus(space.tangent(i), p_t);
        let total = push.scaled(1.0 / (1.0 - r));
        let mut end = state.flown(t);
        // Σ_k π u rᵏ (T − t_k) with T − t_k = T r^(k + 1): the way of these impulses.
        let way = push.scaled(t * r / (1.0 - r * r));
        end.v.add_scaled(&total, 1.0);
        end.y.add_scaled(&way, 1.0);
        // No other contact lands before: its gap falls by less than this.
        for (j, p) in end.points.iter_mut().enumerate() {
            let (was, row) = (state.points[j], space.normal_row(j));
            let (thrown, moved) = (row.dot(&total), row.dot(&way));
            (p.h, p.u) = (was.h + t * (was.u - 0.5 * space.gravity(j) * t) + moved, p.u + thrown);
            let most = t * (was.u.abs() + t * space.gravity(j).abs() + thrown.abs());
            if j != i && was.h <= REMAINDER_FACTOR * most {
                return None;
            }
        }
        // At the limit the contact rests on its ground, or does not slide either; what is left of these speeds is rounding error.
        let mode = |j: usize| match j == i {
            true if sticks => Mode::Fixed,
            true => Mode::Right,
            false => Mode::Separate,
        };
        let word: ContactLetters<Mode> = (0..state.points.len()).map(mode).collect();
        end.hold(&word);
        if !sticks && material.friction > 0.0 {
            let way = -impulse[0].signum();
            let turns = |slip: f64| slip * way < -STILL * self.body.fastest;
            if turns(slip) || turns(end.slip(i)) {
                return None;
            }
        }
        Some((t, end))
    }
}

/// Impulses (tangential, normal) in the friction cones of these contacts that stop all motion; `None` if there are none.
fn stopped_by(state: &Frozen, closed: &[usize]) -> Option<Vec<(usize, [f64; 2])>> {
    let (space, friction, v) = (state.space(), &state.rows.friction, &state.v);
    let speed = v.norm();
    let edges: Vec<(usize, [f64; 2], Coordinates)> = closed
        .iter()
        .flat_map(|&i| [1.0, -1.0].map(|side| (i, [side * friction[i], 1.0])))
        .map(|(i, [t, n])| (i, [t, n], space.normal_row(i).scaled(n).plus(space.tangent(i), t)))
        .collect();
    let balance: Vec<(Vec<f64>, f64)> = v
        .iter()
        .enumerate()
        .map(|(k, part)| {
            let along = |edge: &Coordinates| edge.iter().nth(k).unwrap_or(0.0);
            (edges.iter().map(|(.., edge)| along(edge)).collect(), -part / speed)
        })
        .collect();
    let parts = maximise(&balance, &vec![-1.0; edges.len()])?;
    Some(by_contact(edges, &parts, speed))
}

impl Landed for Jointed {
    type V = Coordinates;

    fn displacement(&self) -> Coordinates {
        self.state.y.clone()
    }

    fn velocity(&self) -> Coordinates {
        self.state.v.clone()
    }

    fn rate(&self, i: usize) -> f64 {
        self.state.points[i].u
    }

    fn place(&self, i: usize) -> Place {
        Place::anywhere(i)
    }

    fn friction(&self, i: usize) -> f64 {
        self.state.rows.friction[i]
    }

    fn slip(&self, i: usize, velocity: &Coordinates) -> f64 {
        self.space().tangent(i).dot(velocity)
    }

    fn speed(&self, velocity: &Coordinates) -> f64 {
        self.space().reach() * velocity.norm()
    }

    fn gravity(&self) -> f64 {
        self.space().largest_pull()
    }

    fn turned(&self, _: &Coordinates, _: f64, _: f64) -> f64 {
        0.0
    }

    fn along(&self, change: Coordinates) -> Coordinates {
        let mut moved = Frozen { v: change, ..self.state.clone() };
        let closed = ContactLetters::from_elem(Mode::Right, self.state.points.len());
        moved.project(&closed);
        moved.v
    }
}

impl Driver<'_, Jointed> {
    /// Contact `b` lands while the other of two contacts is held. If all further cycles are known, moves to their limit.
    pub(super) fn land_again(&mut self, b: usize) -> DriverStep {
        if self.body.state.points.len() != 2 {
            return DriverStep::Piece;
        }
        let (clock, left, fastest) = (self.log.clock, self.log.left(), self.body.fastest);
        let (speed, gravity) = (self.body.state.speed(), self.body.space().largest_pull());
        let landing = -self.body.state.points[b].u;
        if let Some(slow) = SlowLanding::of(landing, speed, fastest, gravity) {
            let state = &mut self.body.state;
            state.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
            state.project(&[Mode::Right; 2]);
            if slow.quiet {
                state.v.clear();
            }
            self.body.laps.forget();
            return self.settle(&[0, 1], ZenoMethod::Mixed, false, slow.error).into();
        }
        let mut laps = std::mem::take(&mut self.body.laps);
        // Without friction the gaps move by themselves, and all their motions scale.
        let rows = &self.body.state.rows;
        let alone = rows.gaps.is_some() && rows.friction.iter().all(|mu| *mu == 0.0);
        let sum = laps.next(b, alone, &self.body, clock, fastest, left);
        self.body.laps = laps;
        let Some(CycleSum { way, velocity, duration, ratio, repeats, error, .. }) = sum else {
            return DriverStep::Piece;
        };
        self.body.laps.forget();
        match self.body.state.rows.gaps {
            Some(model) if alone => {
                self.both_rest(&model, duration, Tail::Cycle { ratio, duration });
            }
            _ => {
                self.write_sum(Tail::Collisions);
                let state = &mut self.body.state;
                state.y.add_scaled(&way, 1.0);
                state.v = velocity;
                state.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
                self.log.clock = clock.after(duration);
            }
        }
        let method = if repeats { ZenoMethod::Nested } else { ZenoMethod::Mixed };
        self.settle(&[0, 1], method, alone && repeats, error).into()
    }

    /// The largest sliding speed that counts as zero, in m/s.
    pub(super) fn still_slide(&self) -> f64 {
        Jointed::sliding_tolerance(self)
    }
}

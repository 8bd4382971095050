//! Impacts: one at a time by the impact law of the options, several at once, or at a contact that jams.

use crate::body::contact::ContactValues;
use crate::impact::friction::{
    self, Material, NO_FRICTION, Party, plastic_jam, slides_in_impact, watch_energy,
};
use crate::impact::together::{NONE_TOGETHER, SEVERAL, all_closed, between, together};
use crate::math::clock::Clock;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::ListedImpact;
use crate::options::{Impact, Jams, Simultaneous};
use crate::outcome::{Cause, ContactNumber, Outcome};
use crate::tolerance::WITHIN_LAW;

/// The warning of a run whose impacts of one instant become ever faster.
const RUN_AWAY: &str = "the law of impact makes impacts of one instant ever faster, and no motion follows: with other restitution, or with \"poisson\" or \"stronge\", a run can go on";

/// Impulses (tangential, normal) of contacts.
type Impulses = Vec<(usize, [f64; 2])>;

impl Driver<'_> {
    /// One impact of contacts that approach at zero gap, or several at once.
    pub(super) fn impact(&mut self, coming: &[usize]) -> Option<Outcome> {
        if let Some(model) = self.plain_model() {
            return self.plain_impact(&model, coming);
        }
        let coming = self.arriving(coming);
        if coming.is_empty() {
            return None; // past a convex vertex
        }
        if self.sequence.runs_away(self.log.clock, self.fastest) {
            self.warn_once(RUN_AWAY.into());
            return Some(Outcome::Inconsistent);
        }
        let arriving: ContactValues<usize> =
            coming.iter().copied().filter(|&i| !self.resting[i]).collect();
        let chosen = if arriving.is_empty() { &coming } else { &arriving };
        let mut contacts: ContactValues<usize> =
            chosen.iter().map(|&i| self.state.contact(i)).collect();
        contacts.dedup();
        if contacts.len() > 1 {
            self.warn_of_tie(&contacts);
        }
        if self.options.policy() == Simultaneous::Together {
            let parties = if self.options.hits_resting() {
                all_closed(self.state.points())
            } else {
                chosen.clone()
            };
            if parties.len() > 1 {
                if self.sum_up(chosen[0]) {
                    return self.after_impact(&parties, 0.0);
                }
                if let Some(fastest) = self.together(&parties) {
                    if let Some(end) = self.bounce_in_step() {
                        return end;
                    }
                    return self.after_impact(&parties, fastest);
                }
                self.warn_once(NONE_TOGETHER.into());
            }
        }
        let last = self.options.policy() == Simultaneous::LastContactFirst;
        let i = if last { *chosen.last()? } else { chosen[0] };
        if self.sum_up(i) {
            return self.after_impact(&[i], 0.0);
        }
        let (law, material) = (self.options.impact, self.state.material(i));
        let (w, rate) = (self.state.impact_matrix(i), self.state.point(i).1);
        let slip = self.state.slip(i);
        let Some([p_t, mut p_n]) = friction::impulse(law, &w, [slip, rate], &material) else {
            let contact = self.state.contact(i) + 1;
            self.record
                .warnings
                .push(format!("the law of impact has no solution at contact {contact}"));
            return Some(Outcome::Inconsistent);
        };
        let restitution = material.restitution;
        let newton = restitution == 0.0 || !matches!(law, Impact::Poisson | Impact::Stronge);
        if newton {
            // On long arms the terms of the impulse cancel: the remaining error of u⁺ + e u⁻ is subtracted.
            p_n -= ((1.0 + restitution) * rate + w.nt * p_t + w.nn * p_n) / w.nn;
        }
        let (impulse, before) = ([p_t, p_n], self.rates());
        let (speed, known) = (self.state.total_speed(&[i]), self.state.rounding(i).rate);
        self.apply_impulse(i, impulse);
        self.watch_energy(&[i], speed);
        if newton {
            // Exact by the law, without rounding error.
            self.state.set_point(i, (0.0, -restitution * rate));
        }
        // Each law returns a fraction of the rate, and of its rounding error.
        let after = self.state.point(i).1;
        self.state.rounding(i).rate = (after / rate).abs() * known + f64::EPSILON * after.abs();
        self.cause = Some(Cause::Impact(ContactNumber::of(self.state.contact(i))));
        self.write_down(i, before, rate, impulse);
        if coming.len() == 1
            && let Some(end) = self.bounced(i, impulse)
        {
            return end;
        }
        self.after_impact(&[i], rate.abs())
    }

    /// The points that are hit: these, and all that arrive with them, whose gaps are set to zero.
    fn arriving(&mut self, coming: &[usize]) -> ContactValues<usize> {
        if let Some(mut ground) = self.on_ground() {
            return match ground.drop_sides_passed() {
                true => ContactValues::new(),
                false => ground.arriving(coming),
            };
        }
        if let Moving::Frozen(rows) = &mut self.state
            && !self.sequence.goes_on(self.log.clock)
        {
            rows.land_with(coming);
        }
        let approaches = |&i: &usize| {
            let (h, u) = self.state.point(i);
            h == 0.0 && u < 0.0
        };
        (0..self.state.count()).filter(approaches).collect()
    }

    /// The impacts whose recorded time is `end` (s since the start), which the run has reached. The difference of the time of a kick and
    /// the time of the start is rounded. Impacts that are recorded later by one rounding error therefore count too.
    pub(super) fn impacts_at(&mut self, end: f64) -> Option<Outcome> {
        let latest = Clock { hi: end, lo: f64::EPSILON * end };
        if let Some(mut ground) = self.on_ground() {
            ground.arriving_before(&[], latest);
        } else {
            let (clock, options) = (self.log.clock, self.options);
            for i in 0..self.state.count() {
                let (h, u) = self.state.point(i);
                let due = || options.clock(clock.after(-h / u)) <= options.clock(latest);
                if h > 0.0 && u < 0.0 && due() {
                    self.state.set_point(i, (0.0, u));
                }
            }
            if let Moving::Frozen(rows) = &mut self.state {
                rows.land_with(&[]);
            }
        }
        loop {
            let approaches = |(h, u): (f64, f64)| h == 0.0 && u < 0.0;
            let coming: ContactValues<usize> =
                (0..self.state.count()).filter(|&i| approaches(self.state.point(i))).collect();
            if coming.is_empty() {
                return None;
            }
            if !self.log.step() {
                return Some(Outcome::EventLimit);
            }
            // The largest speed so far, with which the speeds after an impact are compared.
            if self.has_left() {
                return Some(Outcome::Escape);
            }
            if let Some(outcome) = self.impact(&coming) {
                return Some(outcome);
            }
        }
    }

    /// The law of impact for all these contacts at once. Those that approach after it are hit next. Returns the speed of the fastest, in m/s;
    /// `None` if the law has no solution.
    fn together(&mut self, hit: &[usize]) -> Option<f64> {
        let law = self.options.impact;
        let party = |&i: &usize| Party {
            before: [self.state.slip(i), self.state.point(i).1],
            material: self.state.material(i).in_impacts(law),
        };
        let parties: ContactValues<Party> = hit.iter().map(party).collect();
        let rows: ContactValues<Coordinates> = hit
            .iter()
            .flat_map(|&i| [true, false].map(|tangential| self.state.row(i, tangential)))
            .collect();
        let dimensions = rows.first()?.len();
        let materials: ContactValues<Material> = parties.iter().map(|p| p.material).collect();
        let between = between(&materials, &rows);
        let outer: ContactValues<usize> =
            (0..hit.len()).filter(|&k| between[k].is_none()).collect();
        let own: ContactValues<Party> = outer.iter().map(|&k| parties[k]).collect();
        let row = |k: usize| &rows[2 * outer[k / 2] + k % 2];
        let found = together(&own, |k, l| row(k).dot(row(l)), dimensions)?;
        let mut impulses = ContactValues::from_elem([0.0; 2], hit.len());
        let mut is_hit = ContactValues::from_elem(false, hit.len());
        for (k, &party) in outer.iter().enumerate() {
            (impulses[party], is_hit[party]) = (found.impulses[k], found.hit[k]);
        }
        let several = found.several;
        for k in (0..hit.len()).filter(|&k| between[k].is_some()) {
            // ξ of a contact between others, with the size of its terms.
            let [_, need] = parties[k].needs();
            let (mut xi, mut terms) = (need, need.abs());
            let acts = |(_, impulse): &(usize, &f64)| **impulse != 0.0;
            for (l, impulse) in impulses.iter().flatten().enumerate().filter(acts) {
                let term = rows[2 * k + 1].dot(&rows[l]) * impulse;
                (xi, terms) = (xi + term, terms + term.abs());
            }
            is_hit[k] = xi.abs() <= WITHIN_LAW * terms;
        }
        if several {
            self.warn_once(SEVERAL.into());
        }
        let listed = self.rates();
        let known: ContactValues<f64> = hit.iter().map(|&i| self.state.rounding(i).rate).collect();
        let speed = self.state.total_speed(hit);
        for (&i, &impulse) in hit.iter().zip(&impulses) {
            if impulse != [0.0; 2] {
                self.apply_impulse(i, impulse);
            }
        }
        self.watch_energy(hit, speed);
        for (k, &i) in hit.iter().enumerate() {
            let Party { before: [_, rate], material } = parties[k];
            if is_hit[k] {
                // Exact by the law, without rounding error.
                let after = -material.restitution * rate + 0.0;
                self.state.set_point(i, (self.state.point(i).0, after));
                self.state.rounding(i).rate =
                    material.restitution * known[k] + f64::EPSILON * after.abs();
            }
            if impulses[k] != [0.0; 2] {
                if rate < 0.0 {
                    self.cause = Some(Cause::Impact(ContactNumber::of(self.state.contact(i))));
                }
                self.write_down(i, listed.clone(), rate, impulses[k]);
            }
        }
        Some(parties.iter().fold(0.0, |most, party| most.max(-party.before[1])))
    }

    /// After an impact of these points with the speed `hit` (m/s): those that have come to rest in vertices are on both pieces from now on.
    fn after_impact(&mut self, points: &[usize], hit: f64) -> Option<Outcome> {
        let wedged = self.on_ground().map(|mut ground| ground.wedge_all(points));
        match wedged {
            Some((wedged, slowest)) if !wedged.is_empty() => {
                let error = 2.0 * slowest / self.state.gravity();
                self.settle(&wedged, None, false, error, hit)
            }
            _ => self.stop_slow(hit),
        }
    }

    /// No word is consistent: an impact without collision at a sliding contact, if the law has one or jams are impacts. Returns whether there is
    /// one.
    pub(super) fn jam(&mut self) -> bool {
        let mut closed: Vec<usize> =
            (0..self.state.count()).filter(|&i| self.state.point(i) == (0.0, 0.0)).collect();
        if self.options.policy() == Simultaneous::LastContactFirst {
            closed.reverse();
        }
        let (law, state) = (self.options.impact, &self.state);
        let single = closed.iter().find_map(|&i| {
            friction::jam(law, &state.impact_matrix(i), state.slip(i), &state.material(i))
                .map(|impulse| (i, impulse))
        });
        let found = match single {
            Some(one) => Some((vec![one], false)),
            None if self.options.jams == Jams::Impact => self.stops_jam(&closed),
            None => None,
        };
        let Some((impulses, stands)) = found else { return false };
        let contacts: ContactValues<usize> =
            impulses.iter().map(|(i, _)| self.state.contact(*i)).collect();
        let who = self.record.subject.names(&contacts);
        self.warn_once(match single {
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
            // Exact at the end of compression, without rounding error.
            if !stands && (single.is_none() || self.state.material(i).restitution == 0.0) {
                self.state.set_point(i, (0.0, 0.0));
            }
            self.cause = Some(Cause::Impact(ContactNumber::of(self.state.contact(i))));
            self.write_down(i, before, 0.0, impulse);
            self.resting[i] &= single.is_none();
        }
        if stands {
            self.state.stand();
        }
        (self.record.undecided, self.record.undecided_mechanism) = (None, None);
        true
    }

    /// The impulses of the plastic impact that ends a jam, and whether everything stops: all closed contacts stop, if forces in their friction
    /// cones can do this; or else the first one that jams stops alone, if this opens the others.
    fn stops_jam(&self, closed: &[usize]) -> Option<(Impulses, bool)> {
        let state = &self.state;
        if closed.len() > 1
            && let Some(impulses) = state.stopped_by(closed)
        {
            return Some((impulses, true));
        }
        closed.iter().find_map(|&i| {
            let impulse = plastic_jam(&state.impact_matrix(i), state.slip(i), state.friction(i))?;
            let mut after = state.clone();
            after.push(i, impulse);
            let opens = |k: &usize| *k == i || after.point(*k).1 > 0.0;
            closed.iter().all(opens).then(|| (vec![(i, impulse)], false))
        })
    }

    /// Warns if an impact of these points has raised the kinetic energy; `before`: √(2T) before it.
    fn watch_energy(&mut self, hit: &[usize], before: f64) {
        let speeds = [before, self.state.total_speed(hit)];
        watch_energy(&mut self.record.warnings, speeds, self.fastest);
    }

    /// Gap rates per contact, without the second points of contacts in vertices, which come last. Empty without a record.
    fn rates(&self) -> Vec<f64> {
        if !self.log.record {
            return Vec::new();
        }
        let count = self.ground.as_ref().map_or(self.state.count(), |ground| ground.contacts);
        self.state.points().take(count).map(|(_, u)| u).collect()
    }

    /// Counts and records an impact of point `i` at this rate; for a contact in a vertex, as one of the point over the piece that is hit.
    fn write_down(&mut self, i: usize, mut before: Vec<f64>, rate: f64, impulse: [f64; 2]) {
        self.log.hits += 1;
        let (law, friction) = (self.options.impact, self.state.friction(i));
        if law != Impact::Newton {
            self.cycles.rubs(i, slides_in_impact(impulse, friction), self.log.clock);
        } else if friction > 0.0 && !self.friction_warned {
            self.friction_warned = true;
            self.record.warnings.push(NO_FRICTION.into());
        }
        let contact = self.state.contact(i);
        self.last.follow(contact, -rate, &self.log);
        if self.log.record {
            let (clock, mut after) = (self.log.clock, self.rates());
            let own = self.record.subject.posture().filter(|p| contact < p.contacts().len());
            let at = own.map_or(i, |posture| posture.point_of(contact));
            (before[at], after[at]) = (rate, self.state.point(i).1);
            let collisions = self.log.collisions.len();
            let hit = ListedImpact { clock, collisions, contact, before, after, impulse };
            self.record.impacts.push(hit);
        }
    }

    /// Applies an impulse (tangential, normal), per unit mass of a body, at point `i`.
    fn apply_impulse(&mut self, i: usize, impulse: [f64; 2]) {
        let change = self.state.push(i, impulse);
        self.sequence.pushed(i, impulse[0], &change);
    }
}

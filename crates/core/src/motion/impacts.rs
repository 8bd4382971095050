//! Impacts: one at a time by the impact law of the options, several at once, or at a contact that jams.

use nalgebra::Vector3;

use crate::body::contact::ContactValues;
use crate::collisions::log::names;
use crate::impact::friction::{
    self, Material, NO_FRICTION, plastic_jam, slides_in_impact, watch_energy,
};
use crate::impact::together::{NONE_TOGETHER, Party, SEVERAL, Together, all_closed, together};
use crate::motion::any::AnyContacts;
use crate::motion::driver::Driver;
use crate::motion::record::ListedImpact;
use crate::options::{Impact, Jams, Simultaneous};
use crate::outcome::{Cause, ContactNumber, Outcome};
use crate::sustained::ContactState;

impl Driver<'_, AnyContacts> {
    /// One impact of contacts that approach at zero gap, or several at once.
    pub(super) fn impact(&mut self, coming: &[usize]) -> Option<Outcome> {
        let coming = self.arriving(coming);
        if coming.is_empty() {
            return None; // past a convex vertex
        }
        let arriving: ContactValues<usize> =
            coming.iter().copied().filter(|&i| !self.resting[i]).collect();
        let chosen = if arriving.is_empty() { &coming } else { &arriving };
        if chosen.len() > 1 {
            let points = &self.body.state.points;
            let mut contacts: ContactValues<usize> =
                chosen.iter().map(|&i| points[i].place.contact).collect();
            contacts.dedup();
            if contacts.len() > 1 {
                self.warn_of_tie(&contacts);
            }
        }
        if self.options.policy() == Simultaneous::Together {
            let parties = if self.options.hits_resting() {
                all_closed(self.body.state.points.iter().map(|p| (p.h, p.u)))
            } else {
                chosen.clone()
            };
            if parties.len() > 1 {
                if self.sum_up(chosen[0]) {
                    return self.wedge_or_stop(&parties, 0.0);
                }
                if let Some(fastest) = self.together(&parties) {
                    return self.wedge_or_stop(&parties, fastest);
                }
                self.warn_once(NONE_TOGETHER.into());
            }
        }
        let last = self.options.policy() == Simultaneous::LastContactFirst;
        let i = if last { *chosen.last()? } else { chosen[0] };
        let owner = self.body.state.points[i].place.contact;
        let material = self.material(i);
        let restitution = material.restitution;
        let w = self.body.state.impact_matrix(i);
        let (rate, rounding) = (self.body.state.points[i].u, self.body.state.points[i].rounding);
        let law = self.options.impact;
        if self.sum_up(i) {
            return self.wedge_or_stop(&[i], 0.0);
        }
        let Some([p_t, mut p_n]) =
            friction::impulse(law, &w, [self.body.state.slip(i), rate], &material)
        else {
            self.record
                .warnings
                .push(format!("the law of impact has no solution at contact {}", owner + 1));
            return Some(Outcome::Inconsistent);
        };
        let before = self.rates();
        let newton = restitution == 0.0 || !matches!(law, Impact::Poisson | Impact::Stronge);
        if newton {
            // On long arms the terms of the impulse cancel: the remaining error of u⁺ + e u⁻ is subtracted.
            p_n -= ((1.0 + restitution) * rate + w.nt * p_t + w.nn * p_n) / w.nn;
        }
        let (impulse, speed) = ([p_t, p_n], self.body.state.total_speed());
        self.apply_impulse(i, impulse);
        let speeds = [speed, self.body.state.total_speed()];
        watch_energy(&mut self.record.warnings, speeds, self.body.fastest);
        let p = &mut self.body.state.points[i];
        if newton {
            p.u = -restitution * rate; // exact by the law, without rounding error
        }
        // Each law returns a fraction of the rate, and of its rounding error.
        p.rounding.rate = (p.u / rate).abs() * rounding.rate + f64::EPSILON * p.u.abs();
        self.log.hits += 1;
        self.cause = Some(Cause::Impact(ContactNumber::of(owner)));
        self.write_down(i, before, rate, impulse);
        if coming.len() == 1
            && let Some(end) = self.bounced(i, impulse)
        {
            return end;
        }
        self.wedge_or_stop(&[i], rate.abs())
    }

    /// No word is consistent: an impact without collision at a sliding contact, if the law has one. Returns whether it has.
    pub(super) fn jam(&mut self) -> bool {
        let points = &self.body.state.points;
        let mut closed: Vec<usize> =
            (0..points.len()).filter(|&i| points[i].h == 0.0 && points[i].u == 0.0).collect();
        if self.options.policy() == Simultaneous::LastContactFirst {
            closed.reverse();
        }
        let law = self.options.impact;
        let found = closed.iter().find_map(|&i| {
            let w = self.body.state.impact_matrix(i);
            let impulse = friction::jam(law, &w, self.body.state.slip(i), &self.material(i));
            impulse.map(|impulse| (i, impulse))
        });
        let Some((i, impulse)) = found else {
            return self.options.jams == Jams::Impact && self.stop_jam(&closed);
        };
        self.warn_once(format!(
            "contact {} jammed while it slid: no contact mode was consistent, and an impact without collision followed",
            self.number(i)
        ));
        // Exact at the end of compression, without rounding error.
        self.end_jam(i, impulse, self.material(i).restitution == 0.0);
        self.resting[i] = false;
        true
    }

    /// An impact without collision at point `i`. `stops`: its gap rate is then zero.
    fn end_jam(&mut self, i: usize, impulse: [f64; 2], stops: bool) {
        let before = self.rates();
        self.apply_impulse(i, impulse);
        if stops {
            self.body.state.points[i].u = 0.0;
        }
        self.record.undecided = None;
        self.log.hits += 1;
        let contact = self.body.state.points[i].place.contact;
        self.cause = Some(Cause::Impact(ContactNumber::of(contact)));
        self.write_down(i, before, 0.0, impulse);
    }

    /// The plastic impact that ends a jam: all closed contacts stop, if forces in their friction cones can do this; or else the first one that
    /// jams stops alone, if this opens the others. Returns whether there is such an impact.
    fn stop_jam(&mut self, closed: &[usize]) -> bool {
        let found = match self.body.state.stopped_by(closed) {
            Some(impulses) if closed.len() > 1 => Some((impulses, true)),
            _ => closed.iter().find_map(|&i| {
                let state = &self.body.state;
                let mu = state.points[i].friction;
                let impulse = plastic_jam(&state.impact_matrix(i), state.slip(i), mu)?;
                let mut after = state.clone();
                after.apply_impulse(i, impulse);
                let opens = |k: &usize| *k == i || after.points[*k].u > 0.0;
                closed.iter().all(opens).then(|| (vec![(i, impulse)], false))
            }),
        };
        let Some((impulses, stands)) = found else { return false };
        let owner = |i: usize| self.body.state.points[i].place.contact;
        self.warn_once(format!(
            "{} jammed: no contact mode was consistent, and a plastic impact without collision followed (jams=\"impact\")",
            names(impulses.iter().map(|(i, _)| owner(*i)))
        ));
        for &(i, impulse) in &impulses {
            self.end_jam(i, impulse, !stands);
        }
        if stands {
            self.body.state.stand();
        }
        true
    }

    /// Number of the contact of point `i`, counted from 1.
    fn number(&self, i: usize) -> usize {
        self.body.state.points[i].place.contact + 1
    }

    pub(super) fn material(&self, i: usize) -> Material {
        let owner = self.body.state.points[i].place.contact;
        if let Some(on) = self.body.state.side_contact(i) {
            let outline = self.body.posture.outline();
            let [friction, restitution, tangential_restitution] =
                outline.map_or([0.0; 3], |outline| outline.sides()[on.side].coefficients);
            return Material { friction, restitution, tangential_restitution };
        }
        let contact = self.body.posture.contacts()[owner];
        Material {
            friction: contact.friction,
            restitution: self.body.posture.geometry()[owner].restitution,
            tangential_restitution: contact.tangential_restitution,
        }
    }

    /// Gap rates per contact, without the second points of contacts in vertices, which come last. Empty without a record.
    pub(super) fn rates(&self) -> Vec<f64> {
        let count = if self.log.record { self.body.contacts } else { 0 };
        self.body.state.points.iter().take(count).map(|p| p.u).collect()
    }

    /// Records an impact of point `i` at this rate; for a contact in a vertex, as one of the point over the piece that is hit.
    pub(super) fn write_down(
        &mut self,
        i: usize,
        mut before: Vec<f64>,
        rate: f64,
        impulse: [f64; 2],
    ) {
        let (law, friction) = (self.options.impact, self.body.state.points[i].friction);
        if law != Impact::Newton {
            self.nested.rubs(i, slides_in_impact(impulse, friction), self.log.clock);
        }
        let rubs = law == Impact::Newton && friction > 0.0;
        if rubs && !self.body.friction_warned {
            self.body.friction_warned = true;
            self.record.warnings.push(NO_FRICTION.into());
        }
        let ContactState { place, u, .. } = self.body.state.points[i];
        let contact = place.contact;
        self.body.last.follow(contact, -rate, &self.log);
        if self.log.record {
            let (clock, mut after) = (self.log.clock, self.rates());
            let own = contact < self.body.posture.contacts().len();
            let at = if own { self.body.posture.point_of(contact) } else { i };
            (before[at], after[at]) = (rate, u);
            let collisions = self.log.collisions.len();
            let hit = ListedImpact { clock, collisions, contact, before, after, impulse };
            self.record.impacts.push(hit);
        }
    }

    /// The law of impact for all these contacts at once. Those that approach after it are hit next. Returns the speed of the fastest, in m/s;
    /// `None` if the law has no solution.
    fn together(&mut self, hit: &[usize]) -> Option<f64> {
        let state = &self.body.state;
        let parties: ContactValues<Party> = hit
            .iter()
            .map(|&i| {
                let before = [state.slip(i), state.points[i].u];
                Party { before, material: self.material(i).in_impacts(self.options.impact) }
            })
            .collect();
        let rho = state.rho2.sqrt();
        let row = |k: usize| {
            let p = &state.points[hit[k / 2]];
            let (along, turn) = match k % 2 {
                0 => (p.tangent, -p.touching_c()),
                _ => (p.normal, p.b),
            };
            Vector3::new(along.x, along.y, turn / rho)
        };
        let Together { impulses, hit: is_hit, several } =
            together(&parties, |k, l| row(k).dot(&row(l)), 3)?;
        if several {
            self.warn_once(SEVERAL.into());
        }
        let listed = self.rates();
        let points = &self.body.state.points;
        let roundings: ContactValues<f64> = hit.iter().map(|&i| points[i].rounding.rate).collect();
        let speed = self.body.state.total_speed();
        for (&i, &impulse) in hit.iter().zip(&impulses) {
            if impulse != [0.0; 2] {
                self.apply_impulse(i, impulse);
            }
        }
        let speeds = [speed, self.body.state.total_speed()];
        watch_energy(&mut self.record.warnings, speeds, self.body.fastest);
        for (k, &i) in hit.iter().enumerate() {
            let Party { before: [_, rate], material } = parties[k];
            if is_hit[k] {
                let p = &mut self.body.state.points[i];
                p.u = -material.restitution * rate + 0.0; // exact by the law, without rounding error
                p.rounding.rate = material.restitution * roundings[k] + f64::EPSILON * p.u.abs();
            }
            if impulses[k] != [0.0; 2] {
                self.log.hits += 1;
                if rate < 0.0 {
                    let contact = self.body.state.points[i].place.contact;
                    self.cause = Some(Cause::Impact(ContactNumber::of(contact)));
                }
                self.write_down(i, listed.clone(), rate, impulses[k]);
            }
        }
        Some(parties.iter().fold(0.0, |most, party| most.max(-party.before[1])))
    }

    /// After an impact of these points with the speed `hit` (m/s): those that have come to rest in vertices are on both pieces from now on.
    fn wedge_or_stop(&mut self, points: &[usize], hit: f64) -> Option<Outcome> {
        let wedged: ContactValues<usize> = if self.body.state.points.len() == self.body.contacts {
            points.iter().copied().filter(|&i| self.wedge(i, 0) || self.wedge(i, 1)).collect()
        } else {
            ContactValues::new()
        };
        if wedged.is_empty() {
            return self.stop_slow(hit);
        }
        let slowest = wedged.iter().map(|&i| self.wedged(i)).fold(0.0, f64::max);
        self.settle(&wedged, None, false, 2.0 * slowest / self.body.state.gravity, hit)
    }

    pub(super) fn arrest(&mut self, stopped: &[bool]) {
        let change = self.body.state.arrest(stopped);
        self.body.sequence.changes(&change);
    }

    /// Applies an impulse (tangential, normal) per unit mass at point `i`.
    pub(super) fn apply_impulse(&mut self, i: usize, impulse: [f64; 2]) {
        self.push(i, impulse, self.body.state.points[i].touching_c());
    }

    /// The same at the point on the normal of point `i` with this arm `c`.
    pub(super) fn push(&mut self, i: usize, impulse: [f64; 2], c: f64) {
        let change = self.body.state.push(i, impulse, c);
        self.body.sequence.pushed(i, impulse[0], &change);
    }
}

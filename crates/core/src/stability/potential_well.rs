//! Bodies that stand in a potential well: any number of them, with any contacts and joints, such as stacks.
//!
//! With the rows N_i, T_i of the contacts, a constant load and V = −load·q, let K = {q : N q ≥ 0} and E = ½q̇·Mq̇ + V. On frozen rows E never rises.
//!
//! | condition | meaning |
//! | --------- | ------- |
//! | *carried* | Nᵀλ = −load has solutions λ ≥ 0. Then V = Σ λ_i h_i ≥ 0 on K. Λ_i is the largest λ_i, I₊ the contacts with Λ_i > 0, N₊ their rows |
//! | *lift*    | some velocity z has N_i z > μ_i|T_i z| for all contacts |
//! | *goes on* | a motion exists from every state: for all faces of K, the contacts A closed on it, and all signs (also 0) of T_A q̇ some mode is consistent |
//! | *stiff*   | A(σ) = N M⁻¹(N − σμT)ᵀ is strictly copositive for all signs σ; this implies the two conditions before |
//! | *resists* | no z ≠ 0 with N₊z = 0 slides without resistance: no forces at contacts with N_i z = 0 hold the load and have μ_i f_n,i T_i z = 0 |
//! | *falls*   | no forces at the contacts that are closed at a q in K with V(q) > 0 hold the load |
//!
//! Let the load be carried, with a lift, and let a motion exist from every state. Then h_i ≤ E/Λ_i for ever, and
//!
//! * if N₊z = 0 only for z = 0, the posture is stable;
//! * otherwise it is stable if it resists and falls, with Moreau's law for all contacts that are hit together, one restitution e for all of
//!   them, and the same in tangential direction;
//! * it is unstable if it does not resist a z in K: the motion q = z t goes on for ever. And it is unstable where no motion exists.
//!
//! *Why.* λ exists, so that E bounds the gaps. An impact loses at least a share of |Δq̇|². The lift bounds the sum of all impulses in a given time, so that
//! impacts may accumulate in any way. In a limit with constant E no impact is left, forces act only where nothing slips or opens, and V̈ =
//! −|q̈|²: V is concave and not negative for all times, thus constant, and q̇ = z with N₊z = 0. The theory page has the proof.
//!
//! *One sign for an interface.* Contacts with parallel rows T_i = c_i T slide together: T_i q̇ = c_i T q̇. Only the sum of their friction acts, and it has one
//! sign σ for all of them, or one value between −1 and 1 where they stick. So A(σ) needs one sign for all of them.
//!
//! The signs of A(σ) are certain (intervals). Other conditions are linear programmes; their margins have to be larger than rounding and the width.
//!
//! *Levels.* A load that is in the span of the rows N is so for all numbers within the width only because of zeros that are exact, as slopes that are
//! multiples of a right angle are. So a coordinate is an *axis* if each contact moves by it along its ground, across it, or not at all, all of them at one rate:
//! (T_ik, N_ik) = (±c, 0), (0, ±c) or (0, 0). A turn is none: the arms of contacts may differ from those given. An axis without load that no contact in I₊ feels is
//! a *level*. N₊ must have full rank in the coordinates that are no levels, and contacts must feel all motions along levels but those of a coordinate
//! that no contact feels at all.

use std::collections::BTreeSet;

use crate::body::{ContactSpace, Mechanism};
use crate::math::copositive::is_strictly_copositive;
use crate::math::interval::Interval;
use crate::math::mass_vector::{Coordinates, MassVector, independent};
use crate::math::orthonormal::{complement, dot};
use crate::math::simplex::maximise;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{
    Forces, MechanismProblem, Method, Mode, ModeAnswer, Modes, Word, contact_modes,
};
use crate::options::{Impact, Jams};
use crate::stability::certify::WhyUndecided;
use crate::stability::cones::{Edge, balance, least_rest, unit_edges};
use crate::stability::faces::{Set, Unknown, faces, members, rays, whole};
use crate::stability::jams::no_motion_of;
use crate::stability::{Argument, Evidence, StabilityOptions};
use crate::tolerance::{DEPENDENT_ROW, FIRM_RANK, ROWS_ALIKE};
use crate::verified::rows::{EnclosedRows, dot as product};

type I = Interval;

/// Largest number of interfaces with friction: there are 2^n pairs of signs.
const MOST_INTERFACES: usize = 8;

/// Largest number of states of contact (a face and the signs of its slides) whose modes are solved.
const MOST_STATES: usize = 2000;

/// Largest number of words of a state that are enumerated.
const MOST_WORDS: f64 = 4096.0;

/// Largest number of directions of slides and of contacts beside I₊: each is zero or not.
const MOST_DIRECTIONS: usize = 10;

/// What is found.
#[derive(Debug)]
pub(super) enum Found {
    /// Stable, for these laws of impact.
    Stable(Evidence, Vec<Impact>),
    /// Unstable.
    Unstable(Argument, Evidence),
    Open(WhyUndecided),
}

/// Whether a mechanism stands in a potential well. `clear`: margin of a linear programme beyond which it is certain, in units of the load.
pub(super) fn decide(mechanism: &Mechanism, options: StabilityOptions, clear: f64) -> Found {
    let well = Well { mechanism, space: mechanism.contact_space(), options, clear };
    match well.decide() {
        Ok(found) => found,
        Err(reason) => Found::Open(reason),
    }
}

struct Well<'a> {
    mechanism: &'a Mechanism,
    space: &'a ContactSpace,
    options: StabilityOptions,
    clear: f64,
}

/// How normal forces carry the load.
struct Carrying {
    /// I₊
    bearing: Set,
    /// A basis of the z with N₊z = 0, in coordinates q_k √M_kk that are not locked.
    kernel: Vec<Vec<f64>>,
    /// Whether this holds for all numbers within the width.
    firm: bool,
}

impl Well<'_> {
    fn decide(&self) -> Result<Found, WhyUndecided> {
        let count = self.mechanism.contacts().len();
        let carrying = self.carried(whole(count))?;
        let slides = Slides::of(self, &carrying);
        if carrying.firm && !self.feels_levels(&carrying, &slides) {
            return Err(WhyUndecided::Degenerate);
        }
        if let Some(motion) = self.unresisted(&carrying, &slides)? {
            return Ok(Found::Unstable(Argument::AcceleratingMode, motion));
        }
        if !carrying.firm {
            return Err(WhyUndecided::Boundary);
        }
        if let Some(start) = self.goes_on()? {
            return Ok(Found::Unstable(Argument::NoSolution, start));
        }
        let moreau = self.is_moreau_dissipative();
        let largest = self.largest_forces(&carrying);
        let evidence = Evidence::PotentialWell { largest, level: slides.rank };
        if slides.rank == 0 {
            let laws = [Some(Impact::Newton), moreau.then_some(Impact::Moreau)];
            return Ok(Found::Stable(evidence, laws.into_iter().flatten().collect()));
        }
        if !self.falls(&carrying)? {
            return Err(WhyUndecided::Held);
        }
        if !moreau {
            return Err(WhyUndecided::Law);
        }
        Ok(Found::Stable(evidence, vec![Impact::Moreau]))
    }

    /// Moreau's law loses energy at every impact if all contacts have one restitution e, and the same in tangential direction where they have friction.
    fn is_moreau_dissipative(&self) -> bool {
        let e = self.mechanism.restitution(0);
        self.mechanism.contacts().iter().enumerate().all(|(i, contact)| {
            let tangential = contact.friction == 0.0 || contact.tangential_restitution == e;
            self.mechanism.restitution(i) == e && tangential
        })
    }

    /// √M_kk of a coordinate that is not locked.
    fn root(&self, place: usize) -> f64 {
        self.space.mass()[(place, place)].sqrt()
    }

    /// A row in the coordinates q_k √M_kk that are not locked.
    fn scaled(&self, row: &[f64]) -> Vec<f64> {
        let free = self.space.free().iter().enumerate();
        free.map(|(place, &k)| row[k] / self.root(place)).collect()
    }

    fn normal(&self, contact: usize) -> Vec<f64> {
        self.scaled(&self.mechanism.contacts()[contact].normal)
    }

    /// Whether a coordinate is an axis: see above.
    fn is_axis(&self, place: usize) -> bool {
        let k = self.space.free()[place];
        let contacts = self.mechanism.contacts();
        let pairs = || contacts.iter().map(|c| [c.tangential[k].abs(), c.normal[k].abs()]);
        let rate = pairs().flatten().fold(0.0, f64::max);
        pairs().all(|pair| [[0.0, 0.0], [rate, 0.0], [0.0, rate]].contains(&pair))
    }

    /// Whether contacts feel all motions along levels but those of a coordinate that no contact feels at all.
    fn feels_levels(&self, carrying: &Carrying, slides: &Slides) -> bool {
        let contacts = self.mechanism.contacts();
        let felt = |axis: &&Vec<f64>| {
            contacts.iter().any(|c| {
                dot(axis, &self.scaled(&c.tangential)) != 0.0
                    || dot(axis, &self.scaled(&c.normal)) != 0.0
            })
        };
        carrying.kernel.iter().filter(felt).count() == slides.rank
    }

    /// The programme Nᵀλ = −load of some contacts, in these coordinates, with N of unit length and in units of the load.
    fn programme(&self, among: &[usize], coordinates: &[usize]) -> Vec<(Vec<f64>, f64)> {
        let load = self.scaled(&self.mechanism.fields().load);
        let weight = dot(&load, &load).sqrt();
        let unit = if weight > 0.0 { weight } else { 1.0 };
        let rows: Vec<Vec<f64>> = among.iter().map(|i| self.normal(*i)).collect();
        let length: Vec<f64> = rows.iter().map(|row| dot(row, row).sqrt()).collect();
        let along = |k: usize| rows.iter().zip(&length).map(|(row, l)| row[k] / l).collect();
        coordinates.iter().map(|&k| (along(k), -load[k] / unit)).collect()
    }

    /// How the normal forces of these contacts carry the load.
    ///
    /// A coordinate without load in which the rows of all contacts that may carry have one sign shows that those with an entry carry nothing: a wall
    /// beside a box on level ground.
    fn carried(&self, among: Set) -> Result<Carrying, WhyUndecided> {
        let load = self.scaled(&self.mechanism.fields().load);
        let n = load.len();
        let mut bearing: Vec<usize> = members(among).collect();
        loop {
            let before = bearing.len();
            for k in (0..n).filter(|k| load[*k] == 0.0 && self.is_axis(*k)) {
                let entries: Vec<f64> = bearing.iter().map(|i| self.normal(*i)[k]).collect();
                if entries.iter().all(|x| *x >= 0.0) || entries.iter().all(|x| *x <= 0.0) {
                    let mut entries = entries.into_iter();
                    bearing.retain(|_| entries.next() == Some(0.0));
                }
            }
            if bearing.len() == before {
                break;
            }
        }
        let unfelt =
            |k: &usize| load[*k] == 0.0 && bearing.iter().all(|i| self.normal(*i)[*k] == 0.0);
        let (level, felt): (Vec<usize>, Vec<usize>) = (0..n).partition(unfelt);
        let rows = self.programme(&bearing, &felt);
        if maximise(&rows, &vec![0.0; bearing.len()]).is_none() {
            let fails = bearing.is_empty() || least_rest(&rows) > self.clear;
            return Err(if fails { WhyUndecided::Joints } else { WhyUndecided::Boundary });
        }
        // Weights λ' + t with λ' ≥ 0 and the largest t.
        let shared: Vec<(Vec<f64>, f64)> = rows
            .iter()
            .map(|(row, load)| {
                let sum = row.iter().sum();
                (row.iter().copied().chain([sum]).collect(), *load)
            })
            .collect();
        let mut objective = vec![0.0; bearing.len()];
        objective.push(1.0);
        // No largest one: contacts press against each other.
        let most = maximise(&shared, &objective).ok_or(WhyUndecided::Jam)?;
        let in_felt: Vec<Coordinates> = bearing
            .iter()
            .map(|i| {
                let row = self.normal(*i);
                Coordinates::from_iter(felt.iter().map(|k| row[*k]))
            })
            .collect();
        let rank = independent(&in_felt.iter().collect::<Vec<_>>(), FIRM_RANK).len();
        if most.last().is_some_and(|margin| *margin > self.clear) && rank == felt.len() {
            let unit = |k: &usize| (0..n).map(|j| f64::from(u8::from(j == *k))).collect();
            let kernel = level.iter().map(unit).collect();
            let bearing = bearing.iter().fold(0, |set, i| set | 1 << i);
            return Ok(Carrying { bearing, kernel, firm: true });
        }
        if self.options.width > 0.0 {
            let tie = rank == felt.len();
            return Err(if tie { WhyUndecided::Boundary } else { WhyUndecided::Degenerate });
        }
        // With the numbers exactly as given, what is zero up to rounding is zero.
        let carries = |place: usize| {
            let mut objective = vec![0.0; bearing.len()];
            objective[place] = 1.0;
            maximise(&rows, &objective).is_none_or(|x| x[place] > self.clear)
        };
        let bearing: Vec<usize> = (0..bearing.len())
            .filter(|place| carries(*place))
            .map(|place| bearing[place])
            .collect();
        let rows: Vec<Vec<f64>> = bearing.iter().map(|i| self.normal(*i)).collect();
        let kernel = complement(&rows, n);
        Ok(Carrying { bearing: bearing.iter().fold(0, |set, i| set | 1 << i), kernel, firm: false })
    }

    /// Λ of each contact, in N: there is a largest force, because of the lift.
    fn largest_forces(&self, carrying: &Carrying) -> Vec<f64> {
        let bearing: Vec<usize> = members(carrying.bearing).collect();
        let all: Vec<usize> = (0..self.space.free().len()).collect();
        let rows = self.programme(&bearing, &all);
        let load = self.scaled(&self.mechanism.fields().load);
        let weight = dot(&load, &load).sqrt();
        let mut largest = vec![0.0; self.mechanism.contacts().len()];
        for (place, &i) in bearing.iter().enumerate() {
            let mut objective = vec![0.0; bearing.len()];
            objective[place] = 1.0;
            let row = self.normal(i);
            let of = |x: Vec<f64>| x[place] * weight / dot(&row, &row).sqrt();
            largest[i] = maximise(&rows, &objective).map_or(0.0, of);
        }
        largest.unsigned_zero()
    }

    /// How far forces at some contacts, with friction at some of them, are from holding the load; in units of the load.
    fn unheld(&self, acts: impl Fn(usize) -> bool, rubs: impl Fn(usize) -> bool) -> f64 {
        let space = self.space;
        let all = unit_edges(self.mechanism, 1.0);
        let mut edges: Vec<Edge> = all.into_iter().filter(|(i, ..)| acts(*i) && rubs(*i)).collect();
        let smooth = (0..space.count()).filter(|i| acts(*i) && !rubs(*i)).map(|i| {
            let row = space.normal_row(i);
            (i, [0.0, 1.0], row.divided(row.norm()))
        });
        edges.extend(smooth);
        least_rest(&balance(self.mechanism, &edges))
    }

    /// A motion q = z t that nothing resists, if there is one; an error if that is not certain.
    ///
    /// For each set Z of directions of slides, and of contacts beside I₊, with z = 0 in them: contacts carry that have N_i z = 0, and those with
    /// friction only if T_i z = 0.
    fn unresisted(
        &self,
        carrying: &Carrying,
        slides: &Slides,
    ) -> Result<Option<Evidence>, WhyUndecided> {
        let count = slides.directions.len();
        if slides.rank == 0 {
            return Ok(None);
        }
        if count > MOST_DIRECTIONS {
            return Err(WhyUndecided::Many);
        }
        let rank = |zero: Set| {
            let chosen: Vec<&Coordinates> = members(zero).map(|k| &slides.directions[k]).collect();
            independent(&chosen, FIRM_RANK).len()
        };
        let moves = |zero: Set| rank(zero) < slides.rank;
        for zero in (0..=whole(count)).filter(|zero| moves(*zero)) {
            // A larger set that moves lets more contacts carry.
            if members(whole(count) & !zero).any(|k| moves(zero | 1 << k)) {
                continue;
            }
            let still = |place: Option<usize>| place.is_none_or(|k| zero >> k & 1 == 1);
            let sticks = |i: usize| still(slides.tangential[i]);
            let acts = |i: usize| {
                let smooth = self.mechanism.contacts()[i].friction == 0.0;
                (smooth || sticks(i)) && still(slides.normal[i])
            };
            if self.unheld(acts, sticks) > self.clear {
                continue;
            }
            let those = (0..self.space.count()).filter(|i| acts(*i)).fold(0, |set, i| set | 1 << i);
            let firm = self.options.width == 0.0 || self.carried(those).is_ok_and(|c| c.firm);
            let motion = firm.then(|| self.slide(carrying, slides, zero)).flatten();
            return motion.map(Some).ok_or(WhyUndecided::Slides);
        }
        Ok(None)
    }

    /// A motion z in K with N₊z = 0 that is zero in these directions.
    fn slide(&self, carrying: &Carrying, slides: &Slides, zero: Set) -> Option<Evidence> {
        let d = carrying.kernel.len();
        let others: Vec<&Coordinates> = slides.others.iter().map(|(_, along)| along).collect();
        // z = Σ (a_k − b_k) kernel_k, a slack for each contact beside I₊.
        let row = |along: &Coordinates, slack: Option<usize>| -> Vec<f64> {
            let slacks = (0..others.len()).map(|j| if slack == Some(j) { -1.0 } else { 0.0 });
            along.iter().chain(along.iter().map(|x| -x)).chain(slacks).collect()
        };
        let mut fixed: Vec<(Vec<f64>, f64)> =
            members(zero).map(|k| (row(&slides.directions[k], None), 0.0)).collect();
        fixed.extend(others.iter().enumerate().map(|(j, along)| (row(along, Some(j)), 0.0)));
        let none = vec![0.0; 2 * d + others.len()];
        let tangents = slides.tangents.iter().flatten();
        let found = tangents.chain(others.iter().copied()).find_map(|along| {
            [1.0, -1.0].into_iter().find_map(|side| {
                let mut rows = fixed.clone();
                rows.push((row(along, None), side));
                maximise(&rows, &none)
            })
        })?;
        let mut velocity = vec![0.0; self.mechanism.dof()];
        for (place, &k) in self.space.free().iter().enumerate() {
            let z: f64 =
                (0..d).map(|j| (found[j] - found[d + j]) * carrying.kernel[j][place]).sum();
            velocity[k] = z / self.root(place);
        }
        let rate = |row: &[f64]| dot(row, &velocity);
        let contacts = self.mechanism.contacts();
        let rates = contacts.iter().map(|c| [rate(&c.tangential), rate(&c.normal)]);
        let rates: Vec<[f64; 2]> = rates.collect();
        let fastest = rates.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        let letter = |[slip, lift]: &[f64; 2]| {
            if *lift > DEPENDENT_ROW * fastest {
                Mode::Separate
            } else if slip.abs() <= DEPENDENT_ROW * fastest {
                Mode::Fixed
            } else if *slip > 0.0 {
                Mode::Right
            } else {
                Mode::Left
            }
        };
        let letters = rates.iter().enumerate();
        let start = Word::separate(rates.len());
        let word = letters.fold(start, |word, (i, rates)| word.with(i, letter(rates)));
        let velocity: Vec<f64> = velocity.iter().map(|v| v / fastest).collect();
        Some(Evidence::Motion { word, velocity: velocity.unsigned_zero() })
    }

    /// Whether nothing holds the load away from the posture.
    fn falls(&self, carrying: &Carrying) -> Result<bool, WhyUndecided> {
        let rays = rays(self.space).map_err(reason)?;
        Ok(rays.into_iter().filter(|closed| carrying.bearing & !closed != 0).all(|closed| {
            let acts = |i: usize| closed >> i & 1 == 1;
            self.unheld(acts, |_| true) > self.clear
        }))
    }

    /// Whether there is a lift.
    fn lifts(&self) -> bool {
        let (space, count) = (self.space, self.space.count());
        let r = space.pull().len();
        let unit = |i: usize, side: f64| {
            let friction = side * self.mechanism.contacts()[i].friction;
            let row = space.normal_row(i).plus(space.tangent(i), friction);
            row.divided(space.normal_row(i).norm())
        };
        let limits: Vec<Coordinates> =
            (0..count).flat_map(|i| [unit(i, 1.0), unit(i, -1.0)]).collect();
        // z = a − b with a + b + rest = 1 in each coordinate; every limit less t is a slack.
        let width = 3 * r + limits.len() + 1;
        let mut rows = Vec::new();
        for k in 0..r {
            let mut row = vec![0.0; width];
            (row[k], row[r + k], row[2 * r + k]) = (1.0, 1.0, 1.0);
            rows.push((row, 1.0));
        }
        for (j, limit) in limits.iter().enumerate() {
            let mut row = vec![0.0; width];
            for (k, x) in limit.iter().enumerate() {
                (row[k], row[r + k]) = (x, -x);
            }
            (row[3 * r + j], row[width - 1]) = (-1.0, -1.0);
            rows.push((row, 0.0));
        }
        let mut objective = vec![0.0; width];
        objective[width - 1] = 1.0;
        maximise(&rows, &objective).is_some_and(|x| x[width - 1] > self.clear)
    }

    /// A start without a motion, if there is one; `None` if a motion exists from every state.
    fn goes_on(&self) -> Result<Option<Evidence>, WhyUndecided> {
        let sliding = Sliding::of(self).ok_or(WhyUndecided::Degenerate)?;
        if sliding.interfaces > MOST_INTERFACES {
            return Err(WhyUndecided::Many);
        }
        let loose = sliding.loose();
        if loose.is_empty() {
            return Ok(None);
        }
        // An impact that ends a jam is not part of the theorem.
        if self.options.jams == Jams::Impact {
            return Err(WhyUndecided::Jam);
        }
        let rays = rays(self.space).map_err(reason)?;
        let faces = faces(&rays, self.space.count(), MOST_STATES).ok_or(WhyUndecided::Many)?;
        let jams = self.jams(&sliding, &loose, &faces)?;
        if jams.is_none() && !self.lifts() {
            return Err(WhyUndecided::Jam);
        }
        Ok(jams)
    }

    /// A start on a face of K from which no mode goes on; `None` if there is certainly none. `loose`: the σ of which A(σ) may not be strictly copositive.
    fn jams(
        &self,
        sliding: &Sliding,
        loose: &[Vec<i8>],
        faces: &BTreeSet<Set>,
    ) -> Result<Option<Evidence>, WhyUndecided> {
        // Closed contacts, and the signs of interfaces, 0 where they do not slide or are open.
        let mut states: BTreeSet<(Set, Vec<i8>)> = BTreeSet::new();
        for &closed in faces {
            let touched = sliding.touched(closed);
            let restricted: BTreeSet<Vec<i8>> = loose
                .iter()
                .map(|signs| {
                    let mut own = vec![0; sliding.interfaces];
                    touched.iter().for_each(|g| own[*g] = signs[*g]);
                    own
                })
                .collect();
            for signs in restricted.into_iter().filter(|signs| !sliding.is_stiff(closed, signs)) {
                // Where slips are 0, any σ between −1 and 1 may follow.
                for still in 0..1_usize << touched.len() {
                    let mut part = signs.clone();
                    let stops = touched.iter().enumerate().filter(|(bit, _)| still >> bit & 1 == 1);
                    stops.for_each(|(_, g)| part[*g] = 0);
                    states.insert((closed, part));
                }
                if states.len() > MOST_STATES {
                    return Err(WhyUndecided::Many);
                }
            }
        }
        let mut open = None;
        // Those that slide everywhere first: they have few words.
        let stops = |signs: &[i8]| signs.iter().filter(|sign| **sign == 0).count();
        let mut states: Vec<_> = states.into_iter().collect();
        states.sort_by_key(|(_, signs)| stops(signs));
        for (closed, signs) in states {
            match self.state(sliding, closed, &signs) {
                State::GoesOn => {}
                State::Jams(start) => return Ok(Some(start)),
                State::Unsure(reason) => open = open.or(Some(reason)),
            }
        }
        open.map_or(Ok(None), Err)
    }

    /// Whether a mode goes on while these contacts are closed and slide with these signs.
    fn state(&self, sliding: &Sliding, closed: Set, signs: &[i8]) -> State {
        let count = self.space.count();
        let sign = |i: usize| sliding.interface[i].map_or(1, |(g, side)| side * signs[g]);
        let slides: Vec<Option<i8>> =
            (0..count).map(|i| (closed >> i & 1 == 1).then(|| sign(i))).collect();
        let unsure = State::Unsure(WhyUndecided::Jam);
        let Ok(problem) = MechanismProblem::new(self.mechanism, &slides) else { return unsure };
        let goes_on = |modes: &Modes| modes.consistent().any(|answer| !answer.near_degenerate());
        // One mode by programmes is cheaper than all of them.
        if contact_modes(&problem, Method::Qp).is_ok_and(|modes| goes_on(&modes)) {
            return State::GoesOn;
        }
        let words = slides.iter().flatten().map(|sign| if *sign == 0 { 4.0 } else { 2.0 });
        if words.product::<f64>() > MOST_WORDS {
            return State::Unsure(WhyUndecided::Many);
        }
        let Ok(modes) = contact_modes(&problem, Method::Enumerate) else { return unsure };
        if goes_on(&modes) {
            return State::GoesOn;
        }
        let all = modes.answers();
        let none = !all.is_empty() && all.iter().all(fails_clearly);
        // Frictionless contacts have no part in the law; a start gives those that slide.
        let moving = members(closed).all(|i| sliding.interface[i].is_none() || sign(i) != 0);
        if !none || !moving {
            return unsure;
        }
        let those: Vec<(usize, f64)> = members(closed).map(|i| (i, f64::from(sign(i)))).collect();
        match no_motion_of(self.mechanism, &those) {
            Some(start) => State::Jams(Evidence::NoMotion(start)),
            None => unsure,
        }
    }
}

fn reason(unknown: Unknown) -> WhyUndecided {
    match unknown {
        Unknown::Many => WhyUndecided::Many,
        Unknown::Unsure => WhyUndecided::Degenerate,
    }
}

/// What follows a state of contact.
enum State {
    /// A mode is consistent.
    GoesOn,
    /// None is.
    Jams(Evidence),
    Unsure(WhyUndecided),
}

/// Whether a word is certainly no motion: a test fails by more than a tie, or its accelerations contradict each other.
fn fails_clearly(answer: &ModeAnswer) -> bool {
    if answer.determined == Forces::Impossible {
        return !answer.near_degenerate();
    }
    answer.margins.iter().any(|margin| !margin.holds() && !margin.is_tie())
}

/// The slides with N₊z = 0, by the rows of contacts along a basis of them.
struct Slides {
    /// T_i of each contact; `None`: zero.
    tangents: Vec<Option<Coordinates>>,
    /// N_i of the contacts beside I₊, where it is not zero.
    others: Vec<(usize, Coordinates)>,
    /// Different directions of T_i with friction and of N_i.
    directions: Vec<Coordinates>,
    /// The place of the direction of T_i, and of N_i, of each contact; `None`: T_i or N_i is zero, or T_i has no friction.
    tangential: Vec<Option<usize>>,
    normal: Vec<Option<usize>>,
    /// Number of independent slides that a contact feels.
    rank: usize,
}

impl Slides {
    fn of(well: &Well<'_>, carrying: &Carrying) -> Self {
        let along = |row: &[f64]| {
            let scaled = well.scaled(row);
            let parts = carrying.kernel.iter().map(|axis| dot(axis, &scaled));
            let parts = Coordinates::from_iter(parts);
            (parts.norm() > DEPENDENT_ROW * dot(&scaled, &scaled).sqrt()).then_some(parts)
        };
        let contacts = well.mechanism.contacts();
        let tangents: Vec<Option<Coordinates>> =
            contacts.iter().map(|contact| along(&contact.tangential)).collect();
        let beside = |i: &usize| carrying.bearing >> i & 1 == 0;
        let others: Vec<(usize, Coordinates)> = (0..contacts.len())
            .filter(beside)
            .filter_map(|i| along(&contacts[i].normal).map(|row| (i, row)))
            .collect();
        let mut directions: Vec<Coordinates> = Vec::new();
        let mut place = |row: &Coordinates| {
            let known = directions.iter().position(|d| along_factor(row, d).is_some());
            known.unwrap_or_else(|| {
                directions.push(row.clone());
                directions.len() - 1
            })
        };
        let tangential = contacts
            .iter()
            .zip(&tangents)
            .map(|(contact, row)| row.as_ref().filter(|_| contact.friction > 0.0).map(&mut place));
        let tangential = tangential.collect();
        let mut normal = vec![None; contacts.len()];
        others.iter().for_each(|(i, row)| normal[*i] = Some(place(row)));
        let all: Vec<&Coordinates> =
            tangents.iter().flatten().chain(others.iter().map(|(_, row)| row)).collect();
        let rank = independent(&all, FIRM_RANK).len();
        Self { tangents, others, directions, tangential, normal, rank }
    }
}

/// The factor c of a row that is c times another one.
fn along_factor(row: &Coordinates, other: &Coordinates) -> Option<f64> {
    let factor = row.dot(other) / other.norm_squared();
    (row.plus(other, -factor).norm() <= ROWS_ALIKE * row.norm()).then_some(factor)
}

/// The matrices A(σ).
struct Sliding {
    /// N_iM⁻¹N_jᵀ and μ_j N_iM⁻¹T_jᵀ, with N of about unit length.
    normal: Vec<Vec<I>>,
    rubbing: Vec<Vec<I>>,
    /// The interface of each contact with friction, and whether its tangent has the direction (1) of that of the interface or the opposite one (−1).
    interface: Vec<Option<(usize, i8)>>,
    interfaces: usize,
}

impl Sliding {
    fn of(well: &Well<'_>) -> Option<Self> {
        let (mechanism, space, width) = (well.mechanism, well.space, well.options.width);
        let count = space.count();
        let rows = EnclosedRows::<I>::of(mechanism)?.widened(width);
        let length = |i: usize| 1.0 / product(&rows.normals[i], &rows.normals[i]).middle().sqrt();
        let lengths: Vec<f64> = (0..count).map(length).collect();
        let of = |i: usize, j: usize, row: &[I]| {
            product(&rows.normals[i], row).times(lengths[i]).times(lengths[j])
        };
        let friction = |j: usize| {
            let mu = mechanism.contacts()[j].friction;
            I::from(mu).widened(width * mu)
        };
        let square = |entry: &dyn Fn(usize, usize) -> I| -> Vec<Vec<I>> {
            (0..count).map(|i| (0..count).map(|j| entry(i, j)).collect()).collect()
        };
        let normal = square(&|i, j| of(i, j, &rows.normals[j]));
        let rubbing = square(&|i, j| friction(j) * of(i, j, &rows.tangents[j]));
        let mut leading: Vec<usize> = Vec::new();
        let interface = (0..count)
            .map(|i| {
                if mechanism.contacts()[i].friction == 0.0 {
                    return None;
                }
                let factor = |k: &usize| along_factor(space.tangent(i), space.tangent(*k));
                let known = leading.iter().enumerate();
                let known = known.filter_map(|(g, k)| factor(k).map(|c| (g, c))).next();
                Some(known.map_or_else(
                    || {
                        leading.push(i);
                        (leading.len() - 1, 1)
                    },
                    |(g, c)| (g, if c > 0.0 { 1 } else { -1 }),
                ))
            })
            .collect();
        Some(Self { normal, rubbing, interface, interfaces: leading.len() })
    }

    /// Whether A(σ) of these contacts is certainly strictly copositive.
    fn is_stiff(&self, closed: Set, signs: &[i8]) -> bool {
        let those: Vec<usize> = members(closed).collect();
        let entry = |i: usize, j: usize| {
            let side = self.interface[j].map_or(0, |(g, side)| side * signs[g]);
            self.normal[i][j] - self.rubbing[i][j].times(f64::from(side))
        };
        let matrix: Vec<Vec<I>> =
            those.iter().map(|i| those.iter().map(|j| entry(*i, *j)).collect()).collect();
        is_strictly_copositive(&matrix)
    }

    /// All signs σ of interfaces for which A(σ) of all contacts may not be strictly copositive.
    fn loose(&self) -> Vec<Vec<i8>> {
        let all = whole(self.normal.len());
        let signs = |number: usize| -> Vec<i8> {
            (0..self.interfaces).map(|g| if number >> g & 1 == 1 { 1 } else { -1 }).collect()
        };
        (0..1 << self.interfaces).map(signs).filter(|signs| !self.is_stiff(all, signs)).collect()
    }

    /// The interfaces of these contacts.
    fn touched(&self, closed: Set) -> Vec<usize> {
        let all: BTreeSet<usize> =
            members(closed).filter_map(|i| self.interface[i].map(|(g, _)| g)).collect();
        all.into_iter().collect()
    }
}

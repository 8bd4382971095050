//! Contacts at rest on the terrain, or sliding along it: their contact-mode word, and how long it lasts.
//!
//! A word has a mode for each contact. It is chosen by the contact-mode problem when contacts come to rest, and again after each event that
//! ends a mode. Where a force has reached its limit (a contact lifts off or breaks loose), the new mode of that contact is given: at
//! that instant the accelerations of both words agree, and a free choice could not distinguish them.

use crate::body::contact::{ContactLetters, ContactValues};
use crate::body::posture::Posture;
use crate::collisions::log::Log;
use crate::error::{Error, LARGEST};
use crate::impact::friction::Material;
use crate::impact::together::between;
use crate::math::clock::Clock;
use crate::math::mass_vector::Coordinates;
use crate::modes::{
    ContactProblem, Forces, LONGEST_ARM, Method, Mode, ProblemFields, Row, contact_modes,
    only_mode, scale,
};
use crate::options::{Options, Stop};
use crate::outcome::{Cause, ContactNumber, Outcome};
use crate::sustained::edges::{EdgeWatch, Entry, Path};
use crate::sustained::endless::{ClosedMotion, Swing};
use crate::sustained::next_order::{Onward, Search};
use crate::sustained::{BodyState, ContactState, ORDERS, Step, StepEnd, lies_level};
use crate::tolerance::{
    BODY_STOPPED, DEPARTED, GRAZE_OF_SIZE, GRAZE_OF_WAY, LOAD_AHEAD, SLOWER_SLIDE, STILL, TOUCH,
};
use nalgebra::{Vector2, Vector3};

impl BodyState {
    /// The fields of a contact-mode problem, without state or load.
    pub(crate) fn fields(&self, mass: f64) -> ProblemFields {
        ProblemFields {
            mass,
            gyration_radius: self.rho2.sqrt(),
            arms: self.points.iter().map(|p| p.touching_arm().into()).collect(),
            tangents: self.points.iter().map(|p| p.tangent.into()).collect(),
            friction: self.points.iter().map(|p| p.friction).collect(),
            ..ProblemFields::default()
        }
    }

    /// The contact-mode problem of this state. `ways`: the signs of sliding, `None` for separate contacts.
    pub(crate) fn problem(&self, mass: f64, ways: &[Option<i8>]) -> Result<ContactProblem, Error> {
        let omega_squared = self.square_of_turn();
        ContactProblem::new(ProblemFields {
            sliding: ways.to_vec(),
            bias: (0..self.points.len()).map(|i| self.bias(i, ways[i], omega_squared)).collect(),
            free_acceleration: [self.fall.x, self.fall.y, 0.0],
            ..self.fields(mass)
        })
    }

    /// (−b ω², −c ω² − 2 ω v_t): the accelerations of a closed contact that the motion of the body causes without any q̈; the last term is that
    /// of a corner of the ground that slides along a side. It is w²/R where a disc turns about a corner.
    pub(super) fn bias(&self, i: usize, way: Option<i8>, omega_squared: f64) -> [f64; 2] {
        let p = &self.points[i];
        let turns = p.corner.is_some() || way.is_some_and(|way| way != 0);
        let turning = if turns { self.coriolis(i) } else { 0.0 };
        [-p.b * omega_squared, -p.c * omega_squared - turning]
    }

    /// The only consistent word in which up to two closed contacts continue, and its q̈, by closed forms without allocation. Contacts in the
    /// air have no part in it. `None`: the problem has to be solved.
    pub(crate) fn only_mode(
        &self,
        ways: &[Option<i8>],
    ) -> Option<(ContactLetters<Mode>, [f64; 3])> {
        let rho = self.rho2.sqrt();
        let omega_squared = self.square_of_turn();
        let mut rows = [Row::ABSENT; 2];
        let (mut closed, mut n) = ([0; 2], 0);
        for (i, p) in self.points.iter().enumerate() {
            if ways[i].is_none() {
                continue;
            }
            *closed.get_mut(n)? = i;
            rows[n] = Row::new(
                p.tangent,
                p.touching_arm() / rho,
                self.bias(i, ways[i], omega_squared),
                p.friction,
                ways[i],
            );
            n += 1;
        }
        let (letters, acceleration) = only_mode_of(&mut rows[..n.max(1)], self.fall, rho)?;
        let mut word = ContactLetters::from_elem(Mode::Separate, self.points.len());
        closed[..n].iter().zip(letters).for_each(|(&i, letter)| word[i] = letter);
        Some((word, acceleration))
    }

    /// The word in which all points, which rest, stay at rest, and the largest sliding speed, by closed forms. `tolerance`: speed in m/s that
    /// counts as zero; `size`: of the body, in m. `None`: they do not decide.
    pub(crate) fn stands(&self, tolerance: f64, size: f64) -> Option<(ContactLetters<Mode>, f64)> {
        let Self { points, center, spin, fall, gravity, .. } = self;
        let most = |v: [f64; 3]| v[0].abs().max(v[1].abs()).max(size * v[2].abs());
        if !(most([center.v.x, center.v.y, spin.omega]) <= tolerance) {
            return None;
        }
        if let [one, two] = &points[..]
            && let levels = [one, two].map(|p| (p.friction, p.normal, p.b))
            && lies_level(*fall, *gravity, levels, &center.v, spin.omega)
        {
            return Some((ContactLetters::from_elem(Mode::Fixed, 2), 0.0));
        }
        let mut fastest = 0.0_f64;
        for (i, p) in points.iter().enumerate() {
            let slip = self.slip(i).abs();
            if slip > if p.friction > 0.0 { tolerance } else { 0.0 } {
                return None;
            }
            fastest = fastest.max(slip);
        }
        let ways: ContactLetters<Option<i8>> = points.iter().map(|_| Some(0)).collect();
        let (word, acceleration) = self.only_mode(&ways)?;
        (most(acceleration) <= STILL * gravity).then_some((word, fastest))
    }

    /// After point `i` has lifted off one of the two pieces that a contact touches in a vertex: the other point of the contact,
    /// if it has no friction, and the direction in which it then slides up its piece.
    fn up_from_vertex(&self, i: usize) -> Option<(usize, i8)> {
        let j = self.twin(i).filter(|&j| self.points[j].friction == 0.0)?;
        Some((j, if self.is_left_of(i, j) { 1 } else { -1 }))
    }

    /// The sliding speed of a contact has decreased to zero. If it is the only closed one, the body may turn about it. If not,
    /// either the whole body has stopped (`slow`), or only this point; returns whether it is only this point.
    fn stop(&mut self, modes: &[Mode], slow: bool) -> bool {
        let closed = modes.iter().filter(|&&mode| mode != Mode::Separate).count();
        if closed > 1 && slow {
            self.spin.omega = 0.0;
            let ground = self.velocity_of_ground(|_, i| modes[i] != Mode::Separate);
            self.center.v = ground.unwrap_or_default();
        }
        closed > 1 && !slow
    }
}

/// The only consistent word of up to two contacts under this acceleration of free fall, and its q̈, by closed forms. `None` beyond the range of a problem,
/// which then has the error.
pub(crate) fn only_mode_of(
    rows: &mut [Row],
    fall: Vector2<f64>,
    rho: f64,
) -> Option<([Mode; 2], [f64; 3])> {
    let in_range = |row: &Row| {
        row.arm.is_none_or(|arm| arm.norm_squared() <= LONGEST_ARM * LONGEST_ARM)
            && row.bias.iter().all(|b| b.abs() <= LARGEST)
    };
    if !rows.iter().all(in_range) {
        return None;
    }
    let load = Vector3::new(fall.x, fall.y, 0.0);
    let scale = scale(rows, load.amax());
    let (letters, y) = only_mode(rows, load / scale)?;
    Some((letters, [y.x * scale, y.y * scale, y.z * scale / rho]))
}

pub(crate) struct ContactPhase<'a> {
    pub(crate) body: BodyState,
    /// Signs of sliding; `None` for separate contacts.
    ways: ContactLetters<Option<i8>>,
    posture: Posture,
    mass: f64,
    /// Largest arm or ρ, in m.
    size: f64,
    /// Sliding speed that counts as zero, in m/s.
    sliding_tolerance: f64,
    /// Contacts between two others over one piece of ground, which land with these.
    pub(crate) follows: ContactValues<bool>,
    /// The largest sliding speed that counted as zero, in m/s.
    pub(crate) dropped: f64,
    /// The smallest and the largest rotation in the last word, in rad.
    turned: [f64; 2],
    options: &'a Options,
    pub(crate) word: ContactLetters<Mode>,
    /// The problem without a consistent word, or with several.
    pub(crate) undecided: Option<ContactProblem>,
    /// q̈ of an endless slide.
    pub(crate) acceleration: Option<[f64; 3]>,
    pub(crate) warnings: Vec<String>,
    /// The cause of this word.
    pub(crate) cause: Option<Cause>,
}

/// A function that records the motion. It is called at the start of every step with the state, the contact-mode word, the time, and,
/// at the first step in a word, the cause of that word.
pub(crate) type Note<'n> = dyn FnMut(&BodyState, &[Mode], Clock, Option<Cause>) + 'n;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PhaseEnd {
    Outcome(Outcome),
    /// Another contact has landed: an impact.
    Landing(usize),
    /// This contact has come to the left (0) or right (1) end of the piece of terrain under it.
    Leave(usize, usize),
    /// A corner of the ground meets a side of the body.
    Corner(Entry),
    /// All contacts have left.
    Free,
    /// All that the contacts feel is at rest.
    Stands,
}

/// What ends a stretch: the motion in one word up to an event.
#[derive(Debug, Clone, Copy)]
enum StretchEnd {
    End(PhaseEnd),
    LiftOff(usize),
    /// The sliding speed of this contact has decreased to zero. With the direction in which it slid.
    Stop(usize, Mode),
    Slip(usize, Mode),
    /// The contacts no longer hold the body at rest under a load that changes.
    Yields,
}

impl<'a> ContactPhase<'a> {
    /// A body without closed contacts. `sliding_tolerance`: the speed that counts as zero, in m/s.
    pub(crate) fn new(
        posture: &Posture,
        body: BodyState,
        sliding_tolerance: f64,
        options: &'a Options,
        cause: Option<Cause>,
    ) -> Self {
        Self {
            body,
            ways: ContactLetters::new(),
            // A clone of a posture is cheap: it shares its data.
            posture: posture.clone(),
            mass: posture.fields().mass,
            size: posture.size(),
            sliding_tolerance,
            dropped: 0.0,
            turned: [0.0; 2],
            options,
            follows: ContactValues::new(),
            word: ContactLetters::new(),
            undecided: None,
            acceleration: None,
            warnings: Vec::new(),
            cause,
        }
    }

    /// Closes the contacts at rest and sets the signs of their sliding. Contacts that touch and whose gaps follow from these
    /// (the third of three on one straight floor) are closed with them.
    pub(crate) fn close(&mut self, rests: &mut [bool]) {
        for i in 0..rests.len() {
            let touches = !rests[i] && self.body.points[i].h <= TOUCH * self.size;
            rests[i] |= touches && self.body.depends(i, rests);
            if rests[i] {
                (self.body.points[i].h, self.body.points[i].u) = (0.0, 0.0);
            }
        }
        self.body.close(rests);
        let slips: ContactValues<f64> = (0..rests.len()).map(|i| self.body.slip(i)).collect();
        // A contact without friction sticks in a vertex only.
        let sticks = |i: usize| self.body.points[i].friction > 0.0 || self.body.twin(i).is_some();
        let tolerance = |i: usize| if sticks(i) { self.sliding_tolerance } else { 0.0 };
        let closed = || (0..rests.len()).filter(|&i| rests[i]);
        let fastest = closed().map(|i| slips[i].abs()).fold(0.0, f64::max);
        // Contacts that leave the body one degree of freedom slide all together or not at all.
        let limit = closed().map(tolerance).fold(0.0, f64::max);
        // At an end of terrain each counts by itself: its own speed decides whether it comes to rest in the vertex.
        let endless = self.body.points.iter().all(|p| p.place.sides == [f64::INFINITY; 2]);
        let alike = self.body.velocity_of_ground(|_, i| rests[i]).is_some();
        let together = endless && alike && self.body.leaves_one_motion(rests);
        let none = |i: usize| match together {
            true if fastest > limit => slips[i].abs() <= SLOWER_SLIDE * fastest,
            true => true,
            false => slips[i].abs() <= tolerance(i),
        };
        let sign = |slip: f64| i8::from(slip > 0.0) - i8::from(slip < 0.0);
        let ways = (0..rests.len())
            .map(|i| rests[i].then(|| if none(i) { 0 } else { sign(slips[i]) }))
            .collect();
        let dropped = closed().filter(|&i| none(i)).map(|i| slips[i].abs());
        self.dropped = dropped.fold(self.dropped, f64::max);
        self.ways = ways;
    }

    /// The largest of the speeds of the body over the ground of its closed contacts, in m/s.
    fn speed(&self) -> f64 {
        let ground = self.body.velocity_of_ground(|_, i| self.ways[i].is_some());
        let v = self.body.center.v - ground.unwrap_or_default();
        v.x.abs().max(v.y.abs()).max(self.size * self.body.spin.omega.abs())
    }

    /// A flight under a load that changes, up to a landing or another end.
    pub(crate) fn fly(
        &mut self,
        log: &mut Log<'_>,
        edges: &mut EdgeWatch,
        note: &mut Note<'_>,
    ) -> PhaseEnd {
        let count = self.body.points.len();
        self.word = ContactLetters::from_elem(Mode::Separate, count);
        self.ways = ContactLetters::from_elem(None, count);
        let none = ContactLetters::<bool>::from_elem(false, count);
        let fall = self.body.fall;
        match self.hold([fall.x, fall.y, 0.0], None, [&none, &none], log, edges, note) {
            StretchEnd::End(end) => end,
            _ => PhaseEnd::Free,
        }
    }

    /// The word in which a body at rest begins to move under a load that changes: that of the load a moment later.
    fn choose_ahead(&mut self) -> Result<Onward, Outcome> {
        let (fall, rate) = (self.body.fall, self.body.fall_rate);
        // Beside a load that is zero now: that after the time in which its change moves the body by its size.
        let grown = rate.norm() * libm::cbrt(self.size / rate.norm());
        let ahead = LOAD_AHEAD * self.body.gravity.max(grown) / rate.norm();
        self.body.set_fall(fall + rate * ahead, rate);
        let chosen = self.choose();
        self.body.set_fall(fall, rate);
        chosen
    }

    /// Simulates word after word until the phase ends. `note` is called at the start of every step.
    pub(crate) fn run(
        &mut self,
        log: &mut Log<'_>,
        edges: &mut EdgeWatch,
        note: &mut Note<'_>,
    ) -> PhaseEnd {
        if self.ways.iter().all(Option::is_none) {
            return self.fly(log, edges, note);
        }
        let mut last = None;
        let mut swings: Vec<Swing> = Vec::new();
        loop {
            let chosen = match last {
                Some(StretchEnd::Yields) => self.choose_ahead(),
                _ => self.choose(),
            };
            let Onward { word, changed, acceleration } = match chosen {
                Ok(chosen) => chosen,
                Err(outcome) => return PhaseEnd::Outcome(outcome),
            };
            self.word = word;
            let starts =
                |(way, mode): (&Option<i8>, &Mode)| *way == Some(0) && mode.direction() != 0.0;
            let starting: ContactLetters<bool> =
                self.ways.iter().zip(&self.word).map(starts).collect();
            for (way, mode) in self.ways.iter_mut().zip(&self.word) {
                *way = (*mode != Mode::Separate).then_some(mode.direction() as i8);
            }
            if self.word.iter().all(|&mode| mode == Mode::Separate) {
                return PhaseEnd::Free;
            }
            swings.iter_mut().for_each(|swing| swing.passes(self.turned));
            let stopped = match last {
                Some(StretchEnd::Stop(i, way)) => Some((i, way)),
                _ => None,
            };
            if let Some(now) = Swing::begins(&self.body, &self.word, stopped) {
                if swings.iter().any(|before| before.encloses(&now, &self.body))
                    && log.end == f64::INFINITY
                {
                    self.acceleration = Some(acceleration);
                    log.enter(&self.word);
                    note(&self.body, &self.word, log.clock, self.cause);
                    return PhaseEnd::Outcome(Outcome::Sliding);
                }
                swings.retain(|before| !before.is_like(&now));
                swings.push(now);
            }
            let next = self.hold(acceleration, last, [&starting, &changed], log, edges, note);
            match next {
                StretchEnd::End(end) => {
                    if end == PhaseEnd::Outcome(Outcome::Inconsistent) {
                        self.undecided = self.body.problem(self.mass, &self.ways).ok();
                    }
                    return end;
                }
                StretchEnd::LiftOff(i) => {
                    self.ways[i] = None;
                    if let Some((j, way)) = self.body.up_from_vertex(i)
                        && self.ways[j] == Some(0)
                    {
                        self.ways[j] = Some(way);
                    }
                }
                StretchEnd::Stop(i, _) => {
                    // Over grounds that do not move alike not all slides end at once.
                    let closed = |_: &ContactState, i: usize| self.word[i] != Mode::Separate;
                    let slow = self.speed() <= self.sliding_tolerance * BODY_STOPPED
                        && self.body.velocity_of_ground(closed).is_some();
                    if self.body.stop(&self.word, slow) {
                        self.ways[i] = Some(0);
                    } else {
                        self.ways.iter_mut().for_each(|way| *way = way.map(|_| 0));
                    }
                }
                StretchEnd::Yields => {
                    for (i, way) in self.ways.iter_mut().enumerate() {
                        // A contact that does not rub on its ground begins anew.
                        *way = way.map(|way| if self.body.slip(i) == 0.0 { 0 } else { way });
                    }
                }
                StretchEnd::Slip(i, mode) => {
                    // In a vertex the contact slides up one piece and leaves the other.
                    if let Some(j) = self.body.twin(i) {
                        self.ways[j] = None;
                    }
                    self.ways[i] = Some(mode.direction() as i8);
                }
            }
            let contact = |i: usize| ContactNumber::of(self.body.points[i].place.contact);
            self.cause = match next {
                StretchEnd::LiftOff(i) => Some(Cause::LiftOff(contact(i))),
                StretchEnd::Stop(i, _) => Some(Cause::Stop(contact(i))),
                StretchEnd::Slip(i, _) => Some(Cause::Slip(contact(i))),
                StretchEnd::End(_) | StretchEnd::Yields => self.cause,
            };
            last = Some(next);
        }
    }

    /// The only word in which the motion continues; an error: the outcome if there is none or more than one. If there is no such word while
    /// the body turns with a speed that counts as zero, the rotation is stopped first: without gravity its ω² would be the only load.
    fn choose(&mut self) -> Result<Onward, Outcome> {
        let mut chosen = self.choose_as_it_turns();
        if chosen.is_err() && self.turns_slowly() {
            self.undecided = None;
            self.stop_turning();
            chosen = self.choose_as_it_turns();
        }
        chosen
    }

    /// Returns true if the body turns, with speeds that count as zero.
    fn turns_slowly(&self) -> bool {
        let turn = self.size * self.body.spin.omega.abs();
        turn > 0.0 && turn <= self.sliding_tolerance
    }

    fn stop_turning(&mut self) {
        let omega = std::mem::take(&mut self.body.spin.omega);
        for (p, way) in self.body.points.iter_mut().zip(&self.ways) {
            if way.is_none() {
                p.u -= p.b * omega;
            }
        }
    }

    fn choose_as_it_turns(&mut self) -> Result<Onward, Outcome> {
        let mut search = Search::default();
        let (mut problem, mut vague) = (None, false);
        if let Some((word, acceleration)) = self.body.only_mode(&self.ways) {
            let only = Onward::same(word, acceleration);
            if !self.is_open(&only) {
                return Ok(only);
            }
            self.body.next_order(&only, &self.ways, &mut search);
        } else {
            let inner = self.between();
            let outer = |i: usize| self.ways[i].filter(|_| inner[i].is_none());
            let ways: ContactValues<Option<i8>> = (0..self.ways.len()).map(outer).collect();
            let asked = self.body.problem(self.mass, &ways);
            let solved = asked.and_then(|problem| {
                contact_modes(&problem, Method::Enumerate).map(|modes| (problem, modes))
            });
            let (asked, modes) = solved.map_err(|error| {
                self.warnings.push(format!("the contact modes could not be solved: {error}"));
                Outcome::EventLimit
            })?;
            problem = Some(asked).filter(|_| inner.iter().all(Option::is_none));
            for answer in modes.consistent() {
                let &[ax, ay, turn] = &answer.acceleration[..] else { continue };
                let mut word: ContactLetters<Mode> = answer.word.modes().collect();
                for (i, outer) in inner.iter().enumerate() {
                    // What two contacts do between which it is.
                    if let Some([one, other]) = *outer
                        && word[one] == word[other]
                    {
                        word[i] = word[one];
                    }
                }
                let one = Onward::same(word, [ax, ay, turn]);
                if self.is_open(&one) {
                    self.body.next_order(&one, &self.ways, &mut search);
                } else {
                    search.add(one.clone());
                }
                // The motion depends on undetermined forces, and the next order does not exclude this word.
                vague |= answer.determined == Forces::Undetermined && search.found.contains(&one);
            }
        }
        let none = search.found.is_empty();
        match search.found.pop() {
            Some(one) if search.found.is_empty() && !vague => Ok(one),
            _ => {
                self.undecided = problem.or_else(|| self.body.problem(self.mass, &self.ways).ok());
                Err(if none { Outcome::Inconsistent } else { Outcome::Ambiguous })
            }
        }
    }

    /// Of each closed contact that is between two others, with which it is held or not, these.
    fn between(&self) -> ContactValues<Option<[usize; 2]>> {
        let closed: ContactValues<usize> =
            (0..self.ways.len()).filter(|&i| self.ways[i].is_some()).collect();
        let mut found = ContactValues::from_elem(None, self.ways.len());
        let materials: ContactValues<Material> =
            closed.iter().map(|&i| self.body.points[i].material()).collect();
        let rows: ContactValues<Coordinates> =
            closed.iter().flat_map(|&i| [true, false].map(|t| self.body.row(i, t))).collect();
        for (k, outer) in between(&materials, &rows).iter().enumerate() {
            let outer = outer.map(|outer| outer.map(|k| closed[k]));
            let alike =
                |outer: &[usize; 2]| outer.iter().all(|&j| self.ways[j] == self.ways[closed[k]]);
            found[closed[k]] = outer.filter(alike);
        }
        found
    }

    /// Returns true if the next order of the motion may change this word.
    fn is_open(&self, word: &Onward) -> bool {
        self.moves(word.acceleration) && self.body.is_open(&word.word)
    }

    /// Whether the body moves or is accelerated.
    fn moves(&self, [ax, ay, turn]: [f64; 3]) -> bool {
        let most = ax.abs().max(ay.abs()).max(self.size * turn.abs());
        !(self.speed() <= self.sliding_tolerance && most <= STILL * self.body.gravity)
    }

    /// The step of the motion in this word from now on, with its first event and the time until then, at most `left` (s). `last`: the event that
    /// ended the previous word; `starts`: at the start of this word, the contacts that begin to slide, and those whose letters follow from the
    /// next order of the motion. `None`: the forces are singular.
    fn next_step(
        &self,
        acceleration: [f64; 3],
        last: Option<StretchEnd>,
        starts: Option<[&[bool]; 2]>,
        left: f64,
    ) -> Option<(Box<Step>, f64, StepEnd)> {
        let (body, posture) = (&self.body, &self.posture);
        // Sets coefficients at the start of the stretch that are known exactly.
        let begins = |mut step: Box<Step>| {
            if let Some([starting, changed]) = starts {
                (0..starting.len()).filter(|&i| starting[i]).for_each(|i| step.starts(i));
                let changed = (0..changed.len()).filter(|&i| changed[i]);
                changed.for_each(|i| step.emerges(body, i));
            }
            if self.word.iter().all(|&mode| mode == Mode::Separate) {
                // The body has just left the ground with these, by the change of the load or of their normals.
                let leaves = |i: &usize| {
                    let p = &body.points[*i];
                    (p.h, p.u) == (0.0, 0.0) && body.known_pull(*i) == 0.0
                };
                (0..body.points.len()).filter(leaves).for_each(|i| step.lifts_off(i));
            }
            match last {
                Some(StretchEnd::LiftOff(i)) if self.word[i] == Mode::Separate => {
                    step.lifts_off(i);
                    if let Some((j, _)) = body.up_from_vertex(i) {
                        step.breaks_loose(j);
                    }
                    if let Some(j) = body.second(i) {
                        step.leaves_corner(j);
                    }
                }
                Some(StretchEnd::Slip(i, mode)) if self.word[i] == mode => {
                    if !step.breaks_loose(i) {
                        return None;
                    }
                    // From a vertex the contact slides up one piece and leaves the other.
                    if let Some(j) = body.twin(i).filter(|&j| body.points[j].h == 0.0)
                        && self.word[j] == Mode::Separate
                    {
                        step.lifts_off(j);
                    }
                }
                Some(StretchEnd::Yields) => {
                    let begins = |i: usize| starts.is_some_and(|[starting, _]| starting[i]);
                    for (i, mode) in self.word.iter().enumerate() {
                        match mode {
                            Mode::Separate if body.points[i].h == 0.0 => step.lifts_off(i),
                            _ if !begins(i) => {}
                            _ if step.breaks_loose(i) => {}
                            _ => return None,
                        }
                    }
                }
                _ => {}
            }
            // The bits of an event do not depend on the end of the run, or of its stage.
            let (t, end) = step.first_event(body, &self.follows);
            let strike = |i: usize| Some((step.strike(body, i, posture, t)?, i));
            let strikes = (0..body.points.len()).filter_map(strike);
            let (t, end) = match strikes.min_by(|one, other| one.0.0.total_cmp(&other.0.0)) {
                Some(((t, k), i)) => (t, StepEnd::Strike(i, k)),
                None => (t, end),
            };
            Some(if t < left { (step, t, end) } else { (step, left, StepEnd::Reach) })
        };
        let mut found = None;
        let soon = body.soon(&self.word, acceleration);
        for (order, _) in ORDERS.into_iter().filter(|(_, reach)| !(soon > *reach)) {
            found = Step::new(body, &self.word, order).and_then(begins);
            let Some((_, t, end)) = &found else { break };
            if *end != StepEnd::Reach || *t >= left || *t == f64::INFINITY {
                break;
            }
        }
        while let Some((step, t, _)) = &found
            && let Some(longer) = step.longer(body, &self.word, *t)
        {
            found = begins(longer);
        }
        found
    }

    /// Holds the contacts in their word until an event. `last`: the event that ended the previous word. `starting`: contacts that
    /// begin to slide. `changed`: those whose letters follow from the next order of the motion.
    fn hold(
        &mut self,
        mut acceleration: [f64; 3],
        mut last: Option<StretchEnd>,
        [starting, changed]: [&[bool]; 2],
        log: &mut Log<'_>,
        edges: &mut EdgeWatch,
        note: &mut Note<'_>,
    ) -> StretchEnd {
        let outcome = |outcome| StretchEnd::End(PhaseEnd::Outcome(outcome));
        // If the rows leave no motion, the velocity over the ground is rounding error.
        let fixed = self.body.is_fixed(&self.word);
        let changes = self.body.fall_changes();
        let rests = fixed || !changes && !self.moves(acceleration);
        let rides = rests && self.body.rides(&self.word);
        let rests = rests && !rides;
        let body = &mut self.body;
        if rests {
            (body.center.v, body.spin.omega) = (Vector2::zeros(), 0.0);
            for (p, mode) in body.points.iter_mut().zip(&mut self.word) {
                p.u = 0.0;
                if *mode != Mode::Separate && p.friction == 0.0 {
                    *mode = Mode::Fixed; // forces do not change
                }
            }
        } else {
            body.hold(&self.word);
        }
        let rides_on =
            rides && body.ride(&self.word) && self.options.neighbourhood == f64::INFINITY;
        self.turned = [body.spin.theta; 2];
        // At a singularity of the forces in a slide.
        let jams = |body: &mut BodyState, word: &[Mode]| match body.jams(word) {
            Some(i) => StretchEnd::Stop(i, word[i]),
            None => outcome(Outcome::Inconsistent),
        };
        let mut side = None;
        let mut cycle = ClosedMotion::new(body, &self.word);
        let began = log.clock;
        let mut fresh = true;
        loop {
            log.enter(&self.word);
            // A further step of the same stretch has no cause.
            note(&self.body, &self.word, log.clock, self.cause.filter(|_| fresh));
            if rests && !changes && self.options.stop != Stop::Time {
                return outcome(Outcome::Rest);
            }
            if rests || rides_on {
                let left = log.left().max(0.0);
                if left == f64::INFINITY {
                    self.acceleration = Some([0.0; 3]);
                    return outcome(Outcome::Sliding);
                }
                let time = if changes { self.body.holds_for(&self.word, left) } else { left };
                let body = &mut self.body;
                body.center.r += body.center.v * time;
                body.advance_fall(time);
                log.clock = log.clock.after(time);
                if time >= left {
                    return outcome(Outcome::TimeLimit);
                }
                return if log.step() { StretchEnd::Yields } else { outcome(Outcome::EventLimit) };
            }
            let starts = std::mem::take(&mut fresh).then_some([starting, changed]);
            let found = self.next_step(acceleration, last.take(), starts, log.left());
            let (body, posture) = (&mut self.body, &self.posture);
            let before = side.take();
            let on = found.filter(|(step, ..)| before.is_none_or(|side| side == step.side));
            let Some((step, t, mut end)) = on else {
                // The singularity is reached, or passed by a rounding error. At the start of a stretch no slide leads to it.
                return match before {
                    Some(_) => jams(body, &self.word),
                    None => outcome(Outcome::Inconsistent),
                };
            };
            side = Some(step.side);
            acceleration = step.acceleration();
            let [ax, ay, _] = acceleration;
            let way = t * (body.center.v.norm() + t * libm::hypot(ax, ay));
            // A body that is farther away than any bound has no further event either.
            let endless = t == f64::INFINITY || way > DEPARTED;
            let (at, free) =
                (|t| step.at(body, t).place(), endless.then_some(Vector2::new(ax, ay)));
            let clock = |t| self.options.clock(log.clock.after(t));
            let path = Path::new(posture, &body.sides, &at);
            if let Some(entry) = edges.entry(path, t, free, clock, &mut self.warnings) {
                *body = step.at(body, entry.t);
                log.clock = log.clock.after(entry.t);
                return StretchEnd::End(PhaseEnd::Corner(entry));
            }
            if endless || cycle.is_complete(body, &self.word) && log.end == f64::INFINITY {
                self.acceleration = Some(acceleration);
                return outcome(Outcome::Sliding);
            }
            *body = step.at(body, t);
            let [least, most] = self.turned;
            self.turned = [least.min(body.spin.theta), most.max(body.spin.theta)];
            log.clock = log.clock.after(t);
            let counted = log.step();
            if let StepEnd::Landing(i) = end
                && body.passes(i, step.lift(i, t), log.clock.since(began), self.size)
            {
                end = StepEnd::Reach;
            }
            match end {
                StepEnd::Landing(i) => {
                    let p = &mut body.points[i];
                    (p.h, p.u) = (0.0, p.u.min(0.0));
                    return StretchEnd::End(PhaseEnd::Landing(i));
                }
                StepEnd::Strike(i, k) => {
                    body.put_on(i, posture, k);
                    return StretchEnd::End(PhaseEnd::Landing(i));
                }
                StepEnd::Leave(i, side) => {
                    body.points[i].place.sides[side] = 0.0;
                    return StretchEnd::End(PhaseEnd::Leave(i, side));
                }
                StepEnd::Surface(i) => body.points[i].surfaces(),
                StepEnd::Jam => return jams(body, &self.word),
                StepEnd::Reach if log.left() <= 0.0 => return outcome(Outcome::TimeLimit),
                _ if !counted => return outcome(Outcome::EventLimit),
                StepEnd::LiftOff(i) => return StretchEnd::LiftOff(i),
                StepEnd::Stop(i) => return StretchEnd::Stop(i, self.word[i]),
                StepEnd::Slip(i, mode) => return StretchEnd::Slip(i, mode),
                StepEnd::Reach => {
                    if body.center.r.norm() > self.options.neighbourhood {
                        return outcome(Outcome::Escape);
                    }
                }
            }
        }
    }
}

impl BodyState {
    /// Returns true if a contact whose gap has reached zero passes over the ground without landing; its gap is then raised. It does so if
    /// its acceleration ḧ = `lift` (m/s²) turns it round at a depth u²/(2ḧ) that is below the rounding error of the gap after this `time`
    /// (s) of motion.
    fn passes(&mut self, i: usize, lift: f64, time: f64, size: f64) -> bool {
        let (v, omega) = (self.center.v.norm(), self.spin.omega);
        let p = &mut self.points[i];
        let depth = p.u * p.u / (2.0 * lift);
        let rounding = f64::EPSILON
            * (GRAZE_OF_SIZE * size).min(GRAZE_OF_WAY * time * (v + (p.b * omega).abs()));
        let passes = lift > 0.0 && depth <= rounding;
        if passes {
            p.h += 2.0 * depth;
        }
        passes
    }
}

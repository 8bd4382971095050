//! What every fuzz target tries, and what must hold of its answers. Bytes are read as scenes of any kind, most of them with
//! some value that is wrong or extreme; they are told to the library as a user would, and nothing may panic, run without end,
//! or contradict itself. Shared by the targets of cargo-fuzz and by the tests, which try a corpus and random bytes.

use standfast::modes::{ContactProblem, Level, Method, ProblemFields, contact_modes};
use standfast::options::{Impact, Simultaneous};
use standfast::stability::{conditions, friction_margin, static_forces};
use standfast::{
    Contact, Error, Model, Options, Outcome, Posture, PostureFields, Scene, State, Stop,
    Trajectory, simulate, simulate_many, stability,
};

/// Events that a run may have here.
const EVENTS: usize = 2000;
/// Energy that a run may seem to win, relative to the largest there was: roundings of that many events.
const ENERGY: f64 = 1e-9;

/// Roundings of the places of points of the body, relative to [`ENERGY`].
const EXACT: f64 = 1e-5;
/// Steepest ground on which heights are looked at, and longest arms, in radii of gyration.
const STEEP: f64 = 1e3;
const LONG: f64 = 100.0;
/// Rotation, in rad, and time, in s, up to which energies are compared.
const TURNED: f64 = 1e6;
const LATE: f64 = 1e18;
/// Energies below, in J, are differences of squares that are hardly numbers.
const TINIEST: f64 = 1e-290;

/// Numbers where arithmetic ends, angles where functions change, and the scales between.
const SPECIAL: [f64; 30] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    9.81,
    1e-3,
    1e-9,
    1e-16,
    1e-155,
    1e-300,
    f64::MIN_POSITIVE,
    5e-324,
    1e9,
    1e16,
    1e155,
    1e300,
    f64::MAX,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    std::f64::consts::FRAC_PI_2,
    std::f64::consts::FRAC_PI_4,
    std::f64::consts::PI,
    1.0 - f64::EPSILON,
    1.0 + f64::EPSILON,
    1.0 / 3.0,
    -1e300,
    -5e-324,
];

/// Bytes, read one after the other; behind their end there are zeros.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count
    }

    fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// A number of the size that is usual in scenes, mostly; else a special one, or any bits.
    fn number(&mut self) -> f64 {
        let share = |byte: u8| f64::from(byte) / 255.0;
        match self.byte() {
            0..160 => share(self.byte()) + share(self.byte()) / 256.0,
            160..200 => 4.0 * share(self.byte()) - 2.0,
            200..225 => self.pick(&SPECIAL),
            225..240 => 10f64.powi(i32::from(self.byte()) - 128),
            _ => f64::from_bits(u64::from_le_bytes(std::array::from_fn(|_| self.byte()))),
        }
    }

    fn pair(&mut self) -> [f64; 2] {
        [self.number(), self.number()]
    }

    fn triple(&mut self) -> [f64; 3] {
        [self.number(), self.number(), self.number()]
    }

    /// Whether something rare is there.
    fn rarely(&mut self) -> bool {
        self.byte() >= 224
    }

    fn contact(&mut self) -> Contact {
        let mut contact = Contact::at(4.0 * self.number() - 2.0, 0.0);
        if self.rarely() {
            contact.point = self.pair();
        }
        if self.rarely() {
            contact.slope = self.number();
        }
        if self.byte() < 128 {
            contact.friction = self.number();
        }
        if self.rarely() {
            contact.restitution = Some(self.number());
        }
        if self.rarely() {
            contact.tangential_restitution = self.number();
        }
        if self.rarely() {
            contact.segment = [-self.number(), self.number()];
        }
        contact
    }

    fn fields(&mut self) -> PostureFields {
        let mut fields = PostureFields {
            mass: 1.0,
            gyration_radius: 0.05 + self.number(),
            center_of_mass: [4.0 * self.number() - 2.0, self.number()],
            contacts: Vec::new(),
            restitution: 0.0,
            gravity: 9.81,
            ..PostureFields::default()
        };
        let count = self.pick(&[2, 2, 2, 2, 1, 3, 4, 0]);
        fields.contacts = (0..count).map(|_| self.contact()).collect();
        fields.restitution = self.number();
        if self.rarely() {
            fields.mass = self.number();
        }
        if self.rarely() {
            fields.gravity = self.number();
        }
        if self.rarely() {
            fields.terrain = (0..self.below(6)).map(|_| self.pair()).collect();
        }
        match self.byte() {
            224.. => {
                for contact in &mut fields.contacts {
                    contact.radius = self.number();
                }
            }
            192..224 => self.sides(&mut fields),
            _ => {}
        }
        fields
    }

    /// A body with an outline, above a terrain with corners that its sides can meet.
    fn sides(&mut self, fields: &mut PostureFields) {
        let count = 3 + self.below(6);
        let coefficients = self.contact();
        let size = 0.1 + self.number();
        let corner = |bytes: &mut Self, k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / count as f64;
            let radius = size * (1.0 + f64::from(bytes.byte())) / 256.0;
            [radius * angle.cos(), 2.5 + radius * angle.sin()]
        };
        fields.outline = (0..count).map(|k| corner(self, k)).collect();
        fields.contacts = fields
            .outline
            .iter()
            .map(|&point| Contact {
                point,
                segment: Contact::at(0.0, 0.0).segment,
                slope: 0.0,
                ..coefficients
            })
            .collect();
        fields.center_of_mass = [0.0, 2.5];
        let mut x = -10.0;
        fields.terrain = vec![[x, 0.0]];
        x = -1.0;
        for _ in 0..1 + self.below(6) {
            x += self.number();
            fields.terrain.push([x, self.number()]);
        }
        fields.terrain.push([20.0, 0.0]);
    }

    fn state(&mut self) -> State {
        let mut q = [0.0; 3];
        if self.byte() < 192 {
            q = self.triple();
        }
        let qdot = if self.byte() < 192 { self.triple() } else { [0.0; 3] };
        State::new(q, qdot)
    }

    fn options(&mut self) -> Options {
        let mut options = Options { event_limit: EVENTS, ..Options::default() };
        options.model = self.pick(&[Model::Full, Model::Local, Model::Auto]);
        if self.byte() < 96 {
            options.impact = self.pick(&[
                Impact::Newton,
                Impact::Poisson,
                Impact::Stronge,
                Impact::ChatterjeeRuina,
                Impact::Moreau,
            ]);
            options.simultaneous = Some(self.pick(&[
                Simultaneous::FirstContactFirst,
                Simultaneous::LastContactFirst,
                Simultaneous::Together,
            ]));
        }
        options.stop = self.pick(&[Stop::Rest, Stop::Rest, Stop::Zeno, Stop::Time]);
        if options.stop == Stop::Time || self.rarely() {
            options.time_limit = Some(self.number());
        }
        if self.rarely() {
            options.time = self.number();
        }
        if self.rarely() {
            options.neighbourhood = self.number();
        }
        if self.rarely() {
            options.sensitivity_limit = Some(self.number());
        }
        if self.rarely() {
            options.event_limit = self.below(20);
        }
        options.record = self.byte() < 192;
        options
    }
}

/// Text as a scene file: read, told again, and read again to the same.
pub fn scene(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    for read in [Scene::from_toml, Scene::from_json] {
        match read(&text) {
            Ok(scene) => {
                let again = Scene::from_json(&scene.to_json());
                assert_eq!(again.as_ref(), Ok(&scene), "{}", scene.to_json());
                assert_eq!(Scene::from_toml(&scene.to_toml()).as_ref(), Ok(&scene));
            }
            Err(error) => complains(&error),
        }
    }
}

/// A body, its start and the options.
pub fn motion(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (fields, state, options) = (bytes.fields(), bytes.state(), bytes.options());
    let posture = match Posture::new(fields) {
        Ok(posture) => posture,
        Err(error) => return complains(&error),
    };
    let run = match simulate(&posture, &state, &options) {
        Ok(run) => run,
        Err(error) => return complains(&error),
    };
    let many = simulate_many(std::slice::from_ref(&posture), &[state], &options);
    let ends = many.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(ends[0].outcome, run.outcome());
    assert_eq!(ends[0].elapsed.to_bits(), run.elapsed().to_bits());
    let bits = |state: &State| [state.q, state.qdot].map(|v| [v.x, v.y, v.z].map(f64::to_bits));
    assert_eq!(bits(&ends[0].state), bits(run.state()));
    holds_together(&run, &state, &options);
    match simulate(&posture, &state, &Options { certify: true, ..options }) {
        Ok(proved) => agrees(&run, &proved),
        Err(error) => complains(&error),
    }
}

/// Impacts that are proved are those of the run, and their bounds follow each other.
fn agrees(run: &Trajectory, proved: &Trajectory) {
    let enclosure = proved.enclosure().unwrap_or_else(|| panic!("asked for"));
    assert!(enclosure.zeno.is_some() != enclosure.reason.is_some(), "{enclosure:?}");
    let mut last = 0.0;
    for impact in &enclosure.impacts {
        let bounds = impact.elapsed;
        assert!(
            0.0 <= bounds.low && bounds.low <= bounds.high && last <= bounds.high,
            "{enclosure:?}"
        );
        last = bounds.low;
    }
    assert_eq!(run.elapsed().to_bits(), proved.elapsed().to_bits());
}

/// What is true of every run.
fn holds_together(run: &Trajectory, start: &State, options: &Options) {
    // Impacts in turn in one instant are one event, and at most 64 of them are kept.
    let most = 64 * (options.event_limit + 1);
    assert!(run.impacts().len() <= most, "{} impacts", run.impacts().len());
    let told = || format!("{:?} {start:?} {options:?}", run.posture().map(|p| p.fields().clone()));
    let elapsed = run.elapsed();
    assert!((0.0..f64::INFINITY).contains(&elapsed), "elapsed {elapsed}: {}", told());
    if let Some(limit) = options.time_limit {
        assert!(run.time() <= limit, "time {}", run.time());
    }
    let state = run.state();
    let numbers = state.q.iter().chain(&state.qdot);
    assert!(numbers.clone().all(|x| x.is_finite()), "{state:?}: {}", told());
    if run.outcome() == Outcome::Rest {
        assert!(state.qdot.iter().all(|v| *v == 0.0), "{state:?}");
    }
    if !options.record {
        return;
    }
    let impacts = run.impacts();
    let times = impacts.windows(2).all(|two| two[0].elapsed <= two[1].elapsed);
    assert!(times, "impacts are not in order");
    let _ = run.phases();
    for zeno in run.zeno_points() {
        assert!(zeno.elapsed <= run.elapsed(), "{} {}", zeno.elapsed, run.elapsed());
    }
    let Ok(times) = run.sample_times(7) else { return };
    let Some(&PostureFields { mass, gravity, gyration_radius, .. }) =
        run.posture().map(Posture::fields)
    else {
        return;
    };
    if run.options().impact == Impact::Moreau {
        return; // Newton's restitution beside friction can add energy [Kane 1984].
    }
    // Of a linear model places follow from gaps as long as that, nearly parallel; in such a time rounding alone leads far.
    if run.model() == Model::Local && state.q.z.abs() > TURNED || run.elapsed() > LATE {
        return;
    }
    let ground = run.posture().filter(|posture| run.model() == Model::Full && is_plain(posture));
    let (mut last, mut scale) = (f64::INFINITY, 0.0_f64);
    let mut far = start.q.xy().norm();
    for t in times {
        let (Ok(energy), Ok(instant)) = (run.energy(t), run.at(t)) else { continue };
        // Of terms that may cancel, and of the place as a whole; a rotation has a rounding that arms have from it,
        // and long arms make more of it.
        let body = run.posture().map_or(0.0, Posture::size) * EXACT;
        let height = gravity * (instant.state.q.xy().norm() + body);
        let lever = run.posture().map_or(1.0, |p| p.size() / gyration_radius);
        let turned = instant.state.q.z.abs() * f64::EPSILON * lever / ENERGY;
        if let Some(posture) = ground {
            let gaps = posture.gaps(&instant.state.q);
            far = far.max(instant.state.q.xy().norm());
            let lowest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
            // The load is held by forces that have roundings of it.
            let loaded = f64::EPSILON * gravity * run.elapsed() * run.elapsed();
            let deep = lowest < -ENERGY * (posture.size() + far) * (1.0 + 8.0 * turned) - loaded;
            assert!(!deep || gaps.contains(&f64::INFINITY), "gaps {gaps:?} at {t:?}: {}", told());
        }
        let [x, y, omega] = instant.state.qdot.into();
        let squares = x * x + y * y + (gyration_radius * omega).powi(2);
        scale = scale.max(mass * (height + squares) * (1.0 + turned));
        assert!(
            !(energy > last + ENERGY * scale + TINIEST),
            "energy {last:?} -> {energy:?} at {t:?}: {}",
            told()
        );
        last = energy;
    }
}

/// Whether heights have as many digits as places: ground that is not too steep, without ends that a contact could go round, and
/// arms that are not too long.
fn is_plain(posture: &Posture) -> bool {
    let PostureFields { terrain, contacts, gyration_radius, .. } = posture.fields();
    if posture.size() > LONG * gyration_radius {
        return false;
    }
    let endless = contacts.iter().all(|k| k.segment == [f64::NEG_INFINITY, f64::INFINITY]);
    let steep = |two: &[[f64; 2]]| (two[1][1] - two[0][1]).abs() > STEEP * (two[1][0] - two[0][0]);
    endless && !terrain.windows(2).any(steep)
}

/// Contacts and what they are asked for.
pub fn modes(data: &[u8]) {
    let mut bytes = Bytes(data);
    let count = bytes.pick(&[2, 2, 2, 1, 3, 4, 6, 0]);
    let mut many = |most: f64| -> Vec<[f64; 2]> {
        (0..count).map(|_| bytes.pair().map(|x| most * (2.0 * x - 1.0))).collect()
    };
    let (arms, bias) = (many(1.0), many(0.2));
    let fields = ProblemFields {
        mass: 1.0,
        gyration_radius: 0.05 + bytes.number(),
        arms,
        tangents: (0..count)
            .map(|_| {
                let angle = if bytes.byte() < 128 { 0.0 } else { bytes.number() };
                [angle.cos(), angle.sin()]
            })
            .collect(),
        friction: (0..count).map(|_| bytes.number()).collect(),
        sliding: (0..count).map(|_| bytes.pick(&[Some(0), Some(1), Some(-1), None])).collect(),
        bias,
        free_acceleration: bytes.triple().map(|x| 4.0 * x - 2.0),
        level: bytes.pick(&[Level::Acceleration, Level::Impulse]),
    };
    let problem = match ContactProblem::new(fields) {
        Ok(problem) => problem,
        Err(error) => return complains(&error),
    };
    let method = bytes.pick(&[Method::Auto, Method::Enumerate, Method::Qp]);
    match contact_modes(&problem, method) {
        Ok(modes) => {
            for answer in modes.consistent() {
                assert!(answer.acceleration.iter().all(|a| a.is_finite()), "{answer:?}");
            }
        }
        Err(error) => complains(&error),
    }
    let _ = problem.pair_modes();
}

/// A posture and whether it stands.
pub fn standing(data: &[u8]) {
    let posture = match Posture::new(Bytes(data).fields()) {
        Ok(posture) => posture,
        Err(error) => return complains(&error),
    };
    let errors = [stability(&posture).err(), conditions(&posture).err()];
    errors.iter().flatten().for_each(complains);
    let _ = (static_forces(&posture), friction_margin(&posture));
}

/// An error in one line that says something.
fn complains(error: &Error) {
    let text = error.to_string();
    assert!(!text.is_empty() && text.lines().count() == 1, "{text}");
}

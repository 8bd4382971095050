//! One vocabulary for pages and notebooks: a question as JSON, its answer as JSON.
//!
//! | question | answer |
//! | --- | --- |
//! | `{"ask": "scene", "scene": …}` | the scene with all its fields, as JSON and as TOML |
//! | `{"ask": "posture", "scene": …}` | what to draw of the posture, its equilibrium region, the modes at rest, the verdict in words |
//! | `{"ask": "motion", "scene": …, "frames": 1000}` | the run as a [`Film`] |
//! | `{"ask": "map", "scene": …, "over": [{"path": …, "values": […]}, …], "quantity": ["by", …]}` | the quantities over the grid, the last path fastest |
//!
//! `scene` is an object in the form of the scene files, or a text in TOML. Where there is no answer, the answer is `{"error": "…"}`, which
//! names the field, its value and the allowed range. Infinities are the strings "inf" and "-inf", undefined numbers null.

mod film;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::body::{Contact, GroundPiece, Posture, State};
use crate::error::Error;
use crate::modes::{ContactProblem, Method, contact_modes};
use crate::options::Options;
use crate::outcome::RunContact;
use crate::scene::Scene;
use crate::serial::numbers::Extended;
use crate::simulate::Simulation;
use crate::stability::{
    StabilityOptions, equilibrium_region, friction_margin, stability_with, static_forces,
};
use crate::sweep::{Axis, Column, Quantity, Sweep};

pub use film::Film;

/// Largest number of frames of a film: its answer then has about 20 MB for two contacts.
pub const MOST_FRAMES: usize = 100_000;

/// Largest number of points of a map: its answer then has some MB for each quantity.
pub const MOST_CELLS: usize = 1_000_000;

/// A question.
#[derive(Debug, Deserialize)]
#[serde(tag = "ask", rename_all = "kebab-case", deny_unknown_fields)]
enum Question {
    Scene {
        scene: Value,
    },
    Posture {
        scene: Value,
    },
    Motion {
        scene: Value,
        #[serde(default = "frames")]
        frames: usize,
    },
    Map {
        scene: Value,
        over: Vec<Over>,
        quantity: Vec<String>,
    },
}

fn frames() -> usize {
    1000
}

/// An axis of a map.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Over {
    path: String,
    values: Vec<f64>,
}

/// The values of a quantity over a grid.
#[derive(Serialize)]
#[serde(untagged)]
enum Values {
    Flags { values: Vec<bool> },
    Numbers { values: Vec<Option<f64>> },
    Words { words: &'static [&'static str], codes: Vec<u8> },
}

/// What a picture shows of a posture at rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Drawing {
    /// The corners of the body, in order, in m; none for a body on one contact without an outline.
    pub corners: Vec<[f64; 2]>,
    /// Whether the outline of the body is known; otherwise the corners are the convex hull of the contacts.
    pub has_outline: bool,
    /// Centre of mass, in m.
    pub center_of_mass: [f64; 2],
    /// Radius of gyration, in m.
    pub gyration_radius: f64,
    /// The longest arm or the radius of gyration, in m.
    pub size: f64,
    /// Mass times gravity, in N.
    pub weight: f64,
    /// Contact points in the nominal posture, in m.
    pub contacts: Vec<[f64; 2]>,
    /// Centre of the disc of each contact, in m; the contact point itself if it is a point.
    pub centers: Vec<[f64; 2]>,
    /// Radius of the disc of each contact, in m; 0 if it is a point.
    pub radii: Vec<f64>,
    /// Coefficient of friction of each contact.
    pub friction: Vec<f64>,
    /// The sides of the body that touch corners of the ground: the contacts after those of the posture.
    pub sides: Vec<DrawnSide>,
    /// The pieces of the ground.
    pub ground: Vec<GroundPiece>,
}

/// A side of the body on a corner of the ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DrawnSide {
    /// The corner, in m.
    pub corner: [f64; 2],
    /// Unit vector along the side in the nominal posture, with the body on its left.
    pub along: [f64; 2],
    /// Coefficient of friction.
    pub friction: f64,
}

impl DrawnSide {
    /// A side that touches a corner of the ground in the nominal posture, as a contact.
    fn at_rest(side: &Contact) -> Self {
        Self { corner: side.point, along: side.tangent().into(), friction: side.friction }
    }

    /// A contact of a run, if it is a side.
    fn of_run(contact: &RunContact) -> Option<Self> {
        let RunContact { corner, along, friction, .. } = *contact;
        Some(Self { corner: corner?, along: along?, friction })
    }
}

impl Drawing {
    /// `sides`: those that touch corners of the ground.
    fn of(posture: &Posture, sides: Vec<DrawnSide>) -> Self {
        let fields = posture.fields();
        Self {
            sides,
            corners: posture.drawn_corners(),
            has_outline: !fields.outline.is_empty(),
            center_of_mass: fields.center_of_mass,
            gyration_radius: fields.gyration_radius,
            size: posture.size(),
            weight: fields.mass * fields.gravity,
            contacts: fields.contacts.iter().map(|contact| contact.point).collect(),
            centers: fields.contacts.iter().map(|contact| contact.center().into()).collect(),
            radii: fields.contacts.iter().map(|contact| contact.radius).collect(),
            friction: fields.contacts.iter().map(|contact| contact.friction).collect(),
            ground: posture.drawn_ground(),
        }
    }
}

/// The answer to a question; see the [module](self).
///
/// ```
/// let scene = r#"{"gravity": 9.81, "restitution": 0.1, "body": {"mass": 1, "gyration_radius": 0.2, "center_of_mass": [0, 0]},
///     "contact": [{"point": [-0.5, 0], "friction": 0.5}, {"point": [0.5, 0], "friction": 0.5}]}"#;
/// let answer = standfast::ask(&format!(r#"{{"ask": "posture", "scene": {scene}}}"#));
/// let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
/// assert_eq!(answer["verdict"]["frictional_stability"], "stable");
/// assert_eq!(answer["region"], serde_json::json!([-0.5, 0.5]));
/// ```
#[must_use]
pub fn ask(question: &str) -> String {
    ask_until(question, 1, &|| false)
}

/// As [`ask`], with `threads` for maps. `cancel` is called every few milliseconds, on the thread that has called this function; once it
/// returns true, the answer is the error "stopped".
#[must_use]
pub fn ask_until(question: &str, threads: usize, cancel: &dyn Fn() -> bool) -> String {
    match answer(question, threads, cancel) {
        Ok(answer) => answer,
        Err(problem) => json!({ "error": problem }).to_string(),
    }
}

/// The answer as JSON.
fn answer(question: &str, threads: usize, cancel: &dyn Fn() -> bool) -> Result<String, String> {
    let question: Question = serde_json::from_str(question).map_err(|e| e.to_string())?;
    let text = |error: Error| error.to_string();
    match question {
        Question::Scene { scene } => {
            let scene = read(scene)?;
            Ok(json!({ "scene": scene, "toml": scene.to_toml() }).to_string())
        }
        Question::Posture { scene } => Ok(about(&read(scene)?).to_string()),
        Question::Motion { scene, frames } => {
            if !(2..=MOST_FRAMES).contains(&frames) {
                return Err(format!("frames = {frames} is outside 2 to {MOST_FRAMES}"));
            }
            let mut scene = read(scene)?;
            (scene.options.record, scene.options.certify) = (true, false);
            let run = Simulation { cancel, ..scene.simulation() }.run().map_err(text)?;
            Film::of(&run, frames, cancel).map(|film| film.to_json()).map_err(text)
        }
        Question::Map { scene, over, quantity } => {
            let lengths: Vec<usize> = over.iter().map(|axis| axis.values.len()).collect();
            let points = lengths.iter().copied().try_fold(1_usize, usize::checked_mul);
            if points.is_none_or(|points| points > MOST_CELLS) {
                return Err(format!("over has {lengths:?} values: at most {MOST_CELLS} points"));
            }
            let Scene { posture, start, options, .. } = read(scene)?;
            let axes: Result<Vec<_>, _> = over
                .into_iter()
                .map(|Over { path, values }| Axis::new(&path, values, &posture))
                .collect();
            let quantities: Result<Vec<_>, _> =
                quantity.iter().map(|name| Quantity::parse(name)).collect();
            let sweep = Sweep::new(&posture, axes.map_err(text)?, quantities.map_err(text)?)
                .map_err(text)?
                .with_jams(options.jams);
            let sweep = if sweep.needs_start() {
                let options = Options { certify: false, ..options };
                sweep.from_start(start, options).map_err(text)?
            } else {
                sweep
            };
            let columns = sweep.run(0..sweep.size(), threads, cancel).map_err(text)?;
            let values: Vec<Values> = columns.into_iter().map(Values::from).collect();
            let named: Vec<Value> = (quantity.iter().zip(&values))
                .map(|(name, values)| {
                    let mut value = json!(values);
                    value["name"] = json!(name);
                    value
                })
                .collect();
            Ok(json!({ "quantity": named }).to_string())
        }
    }
}

impl From<Column> for Values {
    fn from(column: Column) -> Self {
        match column {
            Column::Flags(values) => Self::Flags { values },
            Column::Numbers(values) => Self::Numbers {
                values: values
                    .into_iter()
                    .map(|value| value.is_finite().then_some(value))
                    .collect(),
            },
            Column::Words { words, codes } => Self::Words { words, codes },
        }
    }
}

/// A scene as an object, or as a text in TOML.
fn read(scene: Value) -> Result<Scene, String> {
    match scene {
        Value::String(text) => Scene::from_toml(&text).map_err(|e| e.to_string()),
        object => Scene::deserialize(object).map_err(|e| format!("scene: {e}")),
    }
}

/// A result, or the reason why there is none.
fn or_error<T: Serialize>(result: Result<T, Error>) -> Value {
    match result {
        Ok(value) => json!(value),
        Err(error) => json!({ "error": error.to_string() }),
    }
}

/// All about the posture of a scene, at rest in its nominal configuration.
fn about(scene: &Scene) -> Value {
    let posture = &scene.posture;
    let verdict = stability_with(
        posture,
        &StabilityOptions { jams: scene.options.jams, ..StabilityOptions::default() },
    )
    .map(|verdict| {
        let mut written = json!(verdict);
        written["in_words"] = json!(verdict.in_words());
        written["reason"] = json!(verdict.reason());
        written
    });
    let problem = ContactProblem::of_posture(posture, &State::at_rest([0.0; 3]), [0.0; 3]);
    let modes = problem.and_then(|problem| contact_modes(&problem, Method::Auto)).map(|modes| {
        let words: Vec<_> = modes.consistent().map(|mode| mode.word).collect();
        json!({ "status": modes.status().as_str(), "consistent": words, "modes": modes.answers() })
    });
    json!({
        "drawing": Drawing::of(posture, posture.side_contacts().iter().map(DrawnSide::at_rest).collect()),
        "region": equilibrium_region(posture).map(|[low, high]| [Extended::from(low), Extended::from(high)]),
        "friction_margin": friction_margin(posture),
        "forces": static_forces(posture),
        "modes": or_error(modes),
        "verdict": or_error(verdict),
    })
}

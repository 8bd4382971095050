//! Scene files of mechanisms: a mechanism, a start and the options of a run, as TOML or JSON.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::body::{ContactRows, Mechanism, MechanismFields};
use crate::error::Error;
use crate::file::text::Format;
use crate::file::write::write_whole;
use crate::options::Options;
use crate::scene::{Scene, is_json, load_as};
use crate::serial::values;
use crate::simulate::simulate_mechanism;
use crate::simulate::trajectory::Trajectory;

/// A mechanism, where it starts, and how the run is made.
///
/// ```
/// use standfast::mechanism_scene::MechanismScene;
/// use standfast::Outcome;
///
/// // A point of 1 kg falls 5 m, and stays.
/// let scene = MechanismScene::from_toml(r#"
///     mass_matrix = [[1.0, 0.0], [0.0, 1.0]]
///     load = [0.0, -10.0]
///     [[contact]]
///     normal = [0.0, 1.0]
///     tangential = [1.0, 0.0]
///     [start]
///     q = [0.0, 5.0]
///     qdot = [0.0, 0.0]
/// "#)?;
/// let run = scene.simulate()?;
/// assert_eq!((run.outcome(), run.time()), (Outcome::Rest, 1.0));
/// assert_eq!(MechanismScene::from_toml(&scene.to_toml())?, scene);
/// assert_eq!(MechanismScene::from_json(&scene.to_json())?, scene);
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MechanismScene {
    /// The mechanism.
    pub mechanism: Mechanism,
    /// The displacement of its coordinates at the start, (dof).
    pub q: Vec<f64>,
    /// Their velocities, (dof).
    pub qdot: Vec<f64>,
    /// The options of the run.
    pub options: Options,
}

/// The tables of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    restitution: f64,
    mass_matrix: Vec<Vec<f64>>,
    load: Vec<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    locked: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    armature: Vec<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    coordinate_names: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    contact_names: Vec<String>,
    contact: Vec<ContactRows>,
    #[serde(default, deserialize_with = "values::table")]
    start: StartTable,
    #[serde(default, deserialize_with = "values::table")]
    run: Options,
}

/// Where it starts; empty: at rest in its posture.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct StartTable {
    q: Vec<f64>,
    qdot: Vec<f64>,
}

/// What a scene file has.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyScene {
    /// A body on its contacts.
    Body(Scene),
    /// A mechanism: the file has a `mass_matrix`.
    Mechanism(MechanismScene),
}

impl AnyScene {
    /// Reads a scene file; a name that ends in `.json` is JSON, any other TOML.
    ///
    /// # Errors
    ///
    /// As [`Scene::load`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        load_as(path.as_ref(), |format, text| {
            if format.has(text, "mass_matrix") {
                MechanismScene::read(format, text).map(Self::Mechanism)
            } else {
                Scene::read(format, text).map(Self::Body)
            }
        })
    }
}

impl MechanismScene {
    /// A scene whose start and options have been checked.
    ///
    /// # Errors
    ///
    /// A start that does not have a finite value for each coordinate, options that contradict each other.
    pub fn new(
        mechanism: Mechanism,
        q: Vec<f64>,
        qdot: Vec<f64>,
        options: Options,
    ) -> Result<Self, Error> {
        options.validate()?;
        let dof = mechanism.dof();
        for (field, values) in [("q", &q), ("qdot", &qdot)] {
            if values.len() != dof || !values.iter().all(|value| value.is_finite()) {
                return Err(Error::Unusable {
                    field: field.into(),
                    value: format!("{values:?}"),
                    allowed: format!("a finite value for each of the {dof} coordinates"),
                });
            }
        }
        Ok(Self { mechanism, q, qdot, options })
    }

    /// Reads a scene from TOML.
    ///
    /// # Errors
    ///
    /// [`Error::File`] with line and column, or the error of the values.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        Self::read(Format::Toml, text)
    }

    /// Reads a scene from JSON.
    ///
    /// # Errors
    ///
    /// [`Error::File`] with line and column, or the error of the values.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        Self::read(Format::Json, text)
    }

    fn read(format: Format, text: &str) -> Result<Self, Error> {
        Self::of_file(format.read(text)?).map_err(|error| format.placed(text, error))
    }

    fn of_file(file: File) -> Result<Self, Error> {
        let mechanism = Mechanism::new(MechanismFields {
            mass_matrix: file.mass_matrix,
            load: file.load,
            contacts: file.contact,
            restitution: file.restitution,
            locked: file.locked,
            armature: file.armature,
            coordinate_names: file.coordinate_names,
            contact_names: file.contact_names,
        })
        .map_err(|e| e.renamed(of_mechanism))?;
        file.run.validate().map_err(|e| e.renamed(|field| format!("run.{field}")))?;
        let or_zero = |values: Vec<f64>| match values.is_empty() {
            true => vec![0.0; mechanism.dof()],
            false => values,
        };
        let (q, qdot) = (or_zero(file.start.q), or_zero(file.start.qdot));
        Self::new(mechanism, q, qdot, file.run)
            .map_err(|e| e.renamed(|field| format!("start.{field}")))
    }

    fn to_file(&self) -> File {
        let f = self.mechanism.fields();
        File {
            restitution: f.restitution,
            mass_matrix: f.mass_matrix.clone(),
            load: f.load.clone(),
            locked: f.locked.clone(),
            armature: f.armature.clone(),
            coordinate_names: f.coordinate_names.clone(),
            contact_names: f.contact_names.clone(),
            contact: f.contacts.clone(),
            start: StartTable { q: self.q.clone(), qdot: self.qdot.clone() },
            run: self.options,
        }
    }

    /// The scene as TOML. Reading it back gives the same bits.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(&self.to_file()).unwrap_or_else(|e| unreachable!("a scene is TOML: {e}"))
    }

    /// The scene as JSON. Reading it back gives the same bits.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(&self.to_file())
            .unwrap_or_else(|e| unreachable!("a scene is JSON: {e}"))
    }

    /// Reads a scene file; a name that ends in `.json` is JSON, any other TOML.
    ///
    /// # Errors
    ///
    /// As [`Scene::load`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        load_as(path.as_ref(), Self::read)
    }

    /// Writes the scene, whole or not at all; a name that ends in `.json` gets JSON, any other TOML.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let text = if is_json(path) { self.to_json() } else { self.to_toml() };
        write_whole(path, text.as_bytes())
    }

    /// Runs the scene.
    ///
    /// # Errors
    ///
    /// As [`simulate_mechanism`].
    pub fn simulate(&self) -> Result<Trajectory, Error> {
        simulate_mechanism(&self.mechanism, &self.q, &self.qdot, &self.options)
    }
}

/// A field of a mechanism as the file names it; entries count from 1.
fn of_mechanism(field: &str) -> String {
    let mut parts = field.split('.');
    let name = parts.next().unwrap_or_default();
    if name == "contacts" {
        return std::iter::once("contact").chain(parts).collect::<Vec<_>>().join(".");
    }
    let from_one = |part: &str| part.parse::<usize>().map_or(part.into(), |k| (k + 1).to_string());
    std::iter::once(name.to_owned()).chain(parts.map(from_one)).collect::<Vec<_>>().join(".")
}

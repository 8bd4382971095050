//! Scene files of mechanisms and of assemblies: what moves, a start and the options of a run, as TOML or JSON.

use std::borrow::Cow;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::assembly::table::{
    BodyTable, ContactTable, ForceTable, GroundTable, KickTable, of_system,
};
use crate::assembly::{System, SystemExcitation, SystemFields};
use crate::body::{ContactRows, Mechanism, MechanismFields};
use crate::error::Error;
use crate::excitation::{GroundMotion, MechanismExcitation};
use crate::file::text::Format;
use crate::file::write::write_whole;
use crate::options::Options;
use crate::scene::{Scene, is_json, load_as, of_excitation};
use crate::serial::values;
use crate::simulate::simulate_mechanism_until;
use crate::simulate::trajectory::Trajectory;

/// A mechanism or an assembly, where it starts, and how the run is made.
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
    /// What moves.
    pub of: SceneOf,
    /// The displacement of its coordinates at the start, (dof).
    pub q: Vec<f64>,
    /// Their velocities, (dof).
    pub qdot: Vec<f64>,
    /// The options of the run.
    pub options: Options,
}

/// What moves in a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum SceneOf {
    /// A mechanism that is given by its matrices.
    Mechanism(Mechanism),
    /// An assembly, and what acts on it; its file has bodies.
    System(Box<System>, SystemExcitation),
}

impl SceneOf {
    /// As a mechanism.
    ///
    /// # Errors
    ///
    /// As [`System::mechanism`].
    pub fn mechanism(&self) -> Result<Cow<'_, Mechanism>, Error> {
        match self {
            Self::Mechanism(mechanism) => Ok(Cow::Borrowed(mechanism)),
            Self::System(system, _) => system.mechanism().map(Cow::Owned),
        }
    }

    /// Runs it from this start.
    ///
    /// # Errors
    ///
    /// As [`simulate_mechanism_until`] and [`System::simulate_until`].
    pub fn simulate_until(
        &self,
        q: &[f64],
        qdot: &[f64],
        options: &Options,
        cancel: &dyn Fn() -> bool,
    ) -> Result<Trajectory, Error> {
        match self {
            Self::Mechanism(of) => {
                let nothing = MechanismExcitation::default();
                simulate_mechanism_until(of, q, qdot, options, &nothing, cancel)
            }
            Self::System(of, excitation) => of.simulate_until(q, qdot, options, excitation, cancel),
        }
    }

    /// Number of coordinates.
    #[must_use]
    pub fn dof(&self) -> usize {
        match self {
            Self::Mechanism(mechanism) => mechanism.dof(),
            Self::System(system, _) => 3 * system.fields().bodies.len(),
        }
    }
}

/// The tables of the file of an assembly.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SystemFile {
    #[serde(default = "defaults::friction")]
    friction: f64,
    #[serde(default = "defaults::ground")]
    ground: GroundTable,
    #[serde(default = "defaults::gravity")]
    gravity: f64,
    #[serde(default)]
    restitution: f64,
    #[serde(default)]
    tangential_restitution: f64,
    body: Vec<BodyTable>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    contact: Option<Vec<ContactTable>>,
    #[serde(default, deserialize_with = "values::table")]
    start: StartTable,
    #[serde(default, deserialize_with = "values::table")]
    run: Options,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    kick: Vec<KickTable>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    force: Vec<ForceTable>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ground_motion: Option<GroundMotion>,
}

/// What a file of an assembly leaves out.
mod defaults {
    use super::{GroundTable, SystemFields};

    pub(super) fn friction() -> f64 {
        SystemFields::default().friction
    }

    pub(super) fn gravity() -> f64 {
        SystemFields::default().gravity
    }

    pub(super) fn ground() -> GroundTable {
        GroundTable::of(SystemFields::default().ground.as_ref())
    }
}

/// The tables of the file of a mechanism.
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
    /// A mechanism or an assembly: the file has a `mass_matrix`, or `body` is a list.
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
            if MechanismScene::is_in(format, text) {
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
    /// As [`System::excitation`]; a start that does not have a finite value for each coordinate, options that contradict each other.
    pub fn new(of: SceneOf, q: Vec<f64>, qdot: Vec<f64>, options: Options) -> Result<Self, Error> {
        options.validate()?;
        if let SceneOf::System(system, excitation) = &of {
            system.excitation(excitation, options.time)?;
        }
        let dof = of.dof();
        for (field, values) in [("q", &q), ("qdot", &qdot)] {
            if values.len() != dof || !values.iter().all(|value| value.is_finite()) {
                return Err(Error::Unusable {
                    field: field.into(),
                    value: format!("{values:?}"),
                    allowed: format!("a finite value for each of the {dof} coordinates"),
                });
            }
        }
        Ok(Self { of, q, qdot, options })
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

    /// Returns true if a text has a scene of this kind.
    pub(crate) fn is_in(format: Format, text: &str) -> bool {
        format.has(text, "mass_matrix") || format.has_tables(text, "body")
    }

    fn read(format: Format, text: &str) -> Result<Self, Error> {
        let read = if format.has_tables(text, "body") {
            Self::of_system_file(format.read(text)?)
        } else {
            Self::of_file(format.read(text)?)
        };
        read.map_err(|error| format.placed(text, error))
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
        Self::begun(SceneOf::Mechanism(mechanism), file.start, file.run)
    }

    fn of_system_file(file: SystemFile) -> Result<Self, Error> {
        let of_one = |name: &'static str, k: usize| {
            move |e: Error| e.renamed(|field| format!("{name}.{}.{field}", k + 1))
        };
        let bodies = file.body.into_iter().enumerate();
        let bodies = bodies.map(|(k, body)| body.read(k + 1).map_err(of_one("body", k)));
        let bodies = bodies.collect::<Result<Vec<_>, _>>()?;
        let contacts = file.contact.map(|all| {
            let all = all.into_iter().enumerate();
            let read =
                |(k, one): (usize, ContactTable)| one.read(&bodies).map_err(of_one("contact", k));
            all.map(read).collect::<Result<Vec<_>, _>>()
        });
        let kicks = file.kick.into_iter().enumerate();
        let kicks = kicks.map(|(k, one)| one.read(&bodies).map_err(of_one("kick", k)));
        let forces = file.force.into_iter().enumerate();
        let forces = forces.map(|(k, one)| one.read(&bodies).map_err(of_one("force", k)));
        let excitation = SystemExcitation {
            kicks: kicks.collect::<Result<_, _>>()?,
            forces: forces.collect::<Result<_, _>>()?,
            ground_motion: file.ground_motion,
        };
        let fields = SystemFields {
            contacts: contacts.transpose()?,
            bodies,
            friction: file.friction,
            ground: file.ground.read(),
            gravity: file.gravity,
            restitution: file.restitution,
            tangential_restitution: file.tangential_restitution,
        };
        let system =
            System::new(fields.clone()).map_err(|e| e.renamed(|name| of_system(&fields, name)))?;
        Self::begun(SceneOf::System(Box::new(system), excitation), file.start, file.run)
    }

    /// A scene with this start; errors name the fields of the file.
    fn begun(of: SceneOf, start: StartTable, run: Options) -> Result<Self, Error> {
        run.validate().map_err(|e| e.renamed(|field| format!("run.{field}")))?;
        let or_zero = |values: Vec<f64>| match values.is_empty() {
            true => vec![0.0; of.dof()],
            false => values,
        };
        let (q, qdot) = (or_zero(start.q), or_zero(start.qdot));
        Self::new(of, q, qdot, run).map_err(|e| {
            e.renamed(|field| match field {
                "q" | "qdot" => format!("start.{field}"),
                field => of_excitation(field),
            })
        })
    }

    /// The tables of the file, for a writer of TOML or JSON.
    fn written<T, E: std::fmt::Display>(
        &self,
        of_mechanism: impl FnOnce(&File) -> Result<T, E>,
        of_system: impl FnOnce(&SystemFile) -> Result<T, E>,
    ) -> T {
        let start = StartTable { q: self.q.clone(), qdot: self.qdot.clone() };
        let run = self.options;
        let text = match &self.of {
            SceneOf::Mechanism(mechanism) => {
                let f = mechanism.fields();
                of_mechanism(&File {
                    restitution: f.restitution,
                    mass_matrix: f.mass_matrix.clone(),
                    load: f.load.clone(),
                    locked: f.locked.clone(),
                    armature: f.armature.clone(),
                    coordinate_names: f.coordinate_names.clone(),
                    contact_names: f.contact_names.clone(),
                    contact: f.contacts.clone(),
                    start,
                    run,
                })
            }
            SceneOf::System(system, excitation) => {
                let f = system.fields();
                let SystemExcitation { kicks, forces, ground_motion } = excitation;
                let contact = |one| ContactTable::of(one, &f.bodies);
                of_system(&SystemFile {
                    friction: f.friction,
                    ground: GroundTable::of(f.ground.as_ref()),
                    gravity: f.gravity,
                    restitution: f.restitution,
                    tangential_restitution: f.tangential_restitution,
                    body: f.bodies.iter().map(BodyTable::of).collect(),
                    contact: f.contacts.as_ref().map(|all| all.iter().map(contact).collect()),
                    start,
                    run,
                    kick: kicks.iter().map(|kick| KickTable::of(kick, &f.bodies)).collect(),
                    force: forces.iter().map(|force| ForceTable::of(force, &f.bodies)).collect(),
                    ground_motion: ground_motion.clone(),
                })
            }
        };
        text.unwrap_or_else(|e| unreachable!("a scene is TOML and JSON: {e}"))
    }

    /// The scene as TOML. Reading it back gives the same bits.
    #[must_use]
    pub fn to_toml(&self) -> String {
        self.written(toml::to_string::<File>, toml::to_string::<SystemFile>)
    }

    /// The scene as JSON. Reading it back gives the same bits.
    #[must_use]
    pub fn to_json(&self) -> String {
        self.written(
            serde_json::to_string_pretty::<File>,
            serde_json::to_string_pretty::<SystemFile>,
        )
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
    /// As [`simulate_mechanism`](crate::simulate::simulate_mechanism).
    pub fn simulate(&self) -> Result<Trajectory, Error> {
        self.of.simulate_until(&self.q, &self.qdot, &self.options, &|| false)
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

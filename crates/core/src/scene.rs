//! Scene files: a posture, a start and the options of a run, as TOML or JSON.

use std::path::Path;

use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::body::contact::Contact;
use crate::body::fields::{GroundKind, PostureFields, Surface};
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::{Error, quoted};
use crate::excitation::{Excitation, Force, GroundMotion, Kick};
use crate::file::read::{in_file, read_whole};
use crate::file::text::Format;
use crate::file::write::write_whole;
use crate::options::Options;
use crate::serial::values;
use crate::simulate::Simulation;
use crate::simulate::trajectory::Trajectory;

/// Largest scene file that is read, in bytes. A scene with 64 contacts has a few thousand.
pub(crate) const LARGEST_FILE: u64 = 1 << 20;

/// A body on its contacts, where it starts, and how the run is made. Serde writes and reads it in the form of the scene files.
///
/// ```
/// use standfast::{Outcome, Scene};
///
/// let scene = Scene::from_toml(r#"
///     gravity = 10.0
///     restitution = 0.5
///     [body]
///     mass = 1.0
///     gyration_radius = 0.1
///     center_of_mass = [0.0, 0.0]
///     [[contact]]
///     point = [0.0, 0.0]
///     [start]
///     q = [0.0, 5.0, 0.0]
/// "#)?;
/// let run = scene.simulate()?;
/// assert_eq!((run.outcome(), run.time()), (Outcome::Rest, 3.0));
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The body and its contacts.
    pub posture: Posture,
    /// The start.
    pub start: State,
    /// The options of the run.
    pub options: Options,
    /// The kicks, the forces and the motion of the ground.
    pub excitation: Excitation,
}

/// The tables of the file.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "standfast scene")]
struct File {
    /// Gravity g ≥ 0, downwards, in m/s².
    gravity: f64,
    /// Coefficient of restitution e in [0, 1] of each contact without a coefficient in its table.
    restitution: f64,
    /// Vertices (x, y) of the terrain, with the ground on the right of the polyline, in m; without any each contact meets only its own line, of its slope through its point.
    #[serde(
        default,
        skip_serializing_if = "Vec::is_empty",
        deserialize_with = "crate::serial::values::vertices"
    )]
    terrain: Vec<Vertex>,
    /// What each piece of the terrain is made of, from vertex k to vertex k + 1; none: as the contacts say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    surfaces: Vec<Surface>,
    /// Without a terrain: "own", each contact has its own line, or "shared", all contacts meet one line without ends, of their slope, through
    /// the lowest of them.
    #[serde(
        default,
        skip_serializing_if = "GroundKind::is_own",
        deserialize_with = "values::word"
    )]
    ground: GroundKind,
    #[serde(deserialize_with = "values::table")]
    body: BodyTable,
    /// The contacts, numbered from 1.
    #[serde(deserialize_with = "values::contacts")]
    contact: Vec<Contact>,
    #[serde(default, deserialize_with = "values::table")]
    start: StartTable,
    #[serde(default, deserialize_with = "values::table")]
    run: Options,
    /// Impulses on the body during the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    kick: Vec<Kick>,
    /// Forces on the body for a time, through its centre of mass.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    force: Vec<Force>,
    /// The motion of the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ground_motion: Option<GroundMotion>,
}

/// A vertex of the terrain.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
struct Vertex(#[serde(deserialize_with = "values::exactly")] [f64; 2]);

/// The rigid body.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct BodyTable {
    /// Mass m > 0, in kg.
    mass: f64,
    /// Radius of gyration ρ > 0, in m.
    gyration_radius: f64,
    /// Nominal centre of mass, in m.
    #[serde(deserialize_with = "values::exactly")]
    center_of_mass: [f64; 2],
    /// Corners of the polygon of the body in its nominal posture, in order, in m.
    #[serde(
        default,
        skip_serializing_if = "Vec::is_empty",
        deserialize_with = "crate::serial::values::vertices"
    )]
    outline: Vec<Vertex>,
}

/// Where the body starts.
#[derive(Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct StartTable {
    /// Displacement of the centre of mass (m, m) and rotation (rad).
    #[serde(deserialize_with = "values::exactly")]
    q: [f64; 3],
    /// Velocity, in m/s, m/s, rad/s.
    #[serde(deserialize_with = "values::exactly")]
    qdot: [f64; 3],
}

impl Scene {
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

    /// Reads a scene file; a name that ends in `.json` is JSON, any other TOML.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be read; [`Error::File`] if it is not a regular file, is empty or larger than 1 MiB, is not a text
    /// or does not hold a scene. The error names the kind of a file that is a result, a map, a picture or a schema.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        load_as(path.as_ref(), |format, text| {
            let of_others = [
                (format.has(text, "mass_matrix"), "mass_matrix", "a matrix", "a mechanism"),
                (format.has_tables(text, "body"), "body", "a list", "an assembly"),
            ];
            if let Some((_, field, value, other)) = of_others.into_iter().find(|(has, ..)| *has) {
                let field = field.into();
                let allowed = format!("a scene of a body, and this is one of {other}");
                let error = Error::Unusable { field, value: value.into(), allowed };
                return Err(format.placed(text, error));
            }
            Self::read(format, text)
        })
    }

    /// The scene as TOML. Reading it back gives the same bits.
    ///
    /// ```
    /// use standfast::{Lamina, Options, Posture, Scene, State};
    ///
    /// let scene = Scene {
    ///     posture: Posture::rod(0.5, &Lamina::default())?,
    ///     start: State::at_rest([0.0, 0.011, 0.002]),
    ///     options: Options::default(),
    ///     excitation: Default::default(),
    /// };
    /// assert_eq!(Scene::from_toml(&scene.to_toml())?, scene);
    /// assert_eq!(Scene::from_json(&scene.to_json())?, scene);
    /// # Ok::<(), standfast::Error>(())
    /// ```
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

    /// Writes the scene; a name that ends in `.json` gets JSON, any other TOML. The file is complete or not
    /// there: it is written under another name and renamed.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let text = if is_json(path) { self.to_json() } else { self.to_toml() };
        write_whole(path, text.as_bytes())
    }

    /// JSON Schema of scene files.
    #[must_use]
    pub fn schema() -> String {
        serde_json::to_string_pretty(&schemars::schema_for!(File))
            .unwrap_or_else(|e| unreachable!("a schema is JSON: {e}"))
    }

    /// Runs the scene.
    ///
    /// # Errors
    ///
    /// As [`Simulation::run`].
    pub fn simulate(&self) -> Result<Trajectory, Error> {
        self.simulation().run()
    }

    /// The run of the scene, for other options or to stop it.
    pub fn simulation(&self) -> Simulation<'_> {
        let Self { posture, start, options, excitation } = self;
        Simulation { excitation, ..Simulation::new(posture, *start, *options) }
    }

    pub(crate) fn read(format: Format, text: &str) -> Result<Self, Error> {
        Self::of_file(format.read(text)?).map_err(|error| format.placed(text, error))
    }

    /// Errors name the fields as the file does.
    fn of_file(file: File) -> Result<Self, Error> {
        let BodyTable { mass, gyration_radius, center_of_mass, outline } = file.body;
        let posture = Posture::new(PostureFields {
            mass,
            gyration_radius,
            center_of_mass,
            contacts: file.contact,
            restitution: file.restitution,
            gravity: file.gravity,
            terrain: file.terrain.into_iter().map(|vertex| vertex.0).collect(),
            surfaces: file.surfaces,
            ground: file.ground,
            outline: outline.into_iter().map(|vertex| vertex.0).collect(),
        })
        .map_err(|e| e.renamed(of_posture))?;
        file.run.validate().map_err(|e| e.renamed(|field| format!("run.{field}")))?;
        let start = State::new(file.start.q, file.start.qdot);
        start.validate().map_err(|e| e.renamed(|field| format!("start.{field}")))?;
        let excitation =
            Excitation { kicks: file.kick, forces: file.force, ground_motion: file.ground_motion };
        let fields = posture.fields();
        excitation
            .validate(file.run.time, fields.mass, fields.gravity)
            .map_err(|e| e.renamed(of_excitation))?;
        Ok(Self { posture, start, options: file.run, excitation })
    }

    fn to_file(&self) -> File {
        let f = self.posture.fields();
        File {
            gravity: f.gravity,
            restitution: f.restitution,
            body: BodyTable {
                mass: f.mass,
                gyration_radius: f.gyration_radius,
                center_of_mass: f.center_of_mass,
                outline: f.outline.iter().copied().map(Vertex).collect(),
            },
            contact: f.contacts.clone(),
            terrain: f.terrain.iter().copied().map(Vertex).collect(),
            surfaces: f.surfaces.clone(),
            ground: f.ground,
            start: StartTable { q: self.start.q.into(), qdot: self.start.qdot.into() },
            run: self.options,
            kick: self.excitation.kicks.clone(),
            force: self.excitation.forces.clone(),
            ground_motion: self.excitation.ground_motion.clone(),
        }
    }
}

impl Serialize for Scene {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_file().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Scene {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::of_file(File::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

/// Reads a scene file with this reader.
pub(crate) fn load_as<T>(
    path: &Path,
    read: impl FnOnce(Format, &str) -> Result<T, Error>,
) -> Result<T, Error> {
    let name = quoted(path);
    let problem = |problem: String| Error::File { path: name.clone(), problem, error: None };
    let bytes = read_whole(path, "scene file", Some(LARGEST_FILE))?;
    let other = other_kind(&bytes);
    let other = other.map(|kind| problem(format!("is {kind}, not a scene file")));
    if bytes.len() as u64 > LARGEST_FILE {
        let large = "is larger than 1 MiB, the most a scene file may have";
        return Err(other.unwrap_or_else(|| problem(large.into())));
    }
    let text = match std::str::from_utf8(&bytes) {
        Ok(text) => text,
        Err(e) => {
            let no_text = || problem(format!("is no UTF-8 text: {e}"));
            return Err(other.unwrap_or_else(no_text));
        }
    };
    let (format, read_as) = match path.extension() {
        _ if is_json(path) => (Format::Json, ""),
        Some(name) if name.eq_ignore_ascii_case("toml") => (Format::Toml, ""),
        _ => (Format::Toml, "read as TOML, "),
    };
    read(format, text).map_err(|e| match e {
        _ if other.is_some() => other.unwrap_or(e),
        e => in_file(path, read_as, e),
    })
}

/// A field of an excitation as the file names it.
pub(crate) fn of_excitation(field: &str) -> String {
    let one = |list: &str, name: &str| Some(format!("{name}.{}", field.strip_prefix(list)?));
    one("kicks.", "kick").or_else(|| one("forces.", "force")).unwrap_or_else(|| field.into())
}

/// A field of a posture as the file names it.
fn of_posture(field: &str) -> String {
    match field.split_once('.').unwrap_or((field, "")) {
        ("contacts", of_one) => format!("contact.{of_one}").trim_end_matches('.').into(),
        ("mass" | "gyration_radius" | "center_of_mass" | "outline", _) => format!("body.{field}"),
        _ => field.into(),
    }
}

/// What kind of file this is, if its bytes show that it is one of standfast's other files.
fn other_kind(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [b'C', b'D', b'F', ..] | [0x89, b'H', b'D', b'F', ..] => {
            return Some("a NetCDF file (such as a map)");
        }
        [0x89, b'P', b'N', b'G', ..] | [b'%', b'P', b'D', b'F', ..] => return Some("a picture"),
        _ => {}
    }
    let text = String::from_utf8_lossy(bytes);
    let kinds = [
        ("\"model_reason\"", "the result of a run (JSON)"),
        ("\"frictional_stability\"", "a verdict on stability (JSON)"),
        ("\"consistent\"", "a table of contact modes (JSON)"),
        ("\"title\": \"standfast scene\"", "the JSON Schema of scene files"),
        ("<svg", "a picture"),
    ];
    kinds.into_iter().find(|(mark, _)| text.contains(mark)).map(|(_, kind)| kind)
}

pub(crate) fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

#[cfg(test)]
mod tests {
    use std::error::Error as _;
    use std::io::{self, ErrorKind};

    use super::*;

    const TOML: &str = "gravity = 9.81
restitution = 0.1
[body]
mass = 1.0
gyration_radius = 0.2
center_of_mass = [0.0, 0.0]
[[contact]]
point = [-0.5, 0.0]
[start]
q = [0.0, 0.011, 0.002]
[run]
model = \"full\"
";

    const JSON: &str = r#"{"gravity": 9.81, "restitution": 0.1,
"body": {"mass": 1.0, "gyration_radius": 0.2, "center_of_mass": [0.0, 0.0]},
"contact": [{"point": [-0.5, 0.0]}],
"run": {"model": "full"}}"#;

    /// The error message for a text in which one part is replaced. `tests/python_api/test_messages.py` tests all messages of this kind.
    fn refusal(read: fn(&str) -> Result<Scene, Error>, text: &str, old: &str, new: &str) -> String {
        assert!(text.contains(old), "{old}");
        read(&text.replacen(old, new, 1)).unwrap_err().to_string()
    }

    #[test]
    fn a_number_out_of_range_has_its_line_and_column() {
        for (old, new, expected) in [
            ("mass = 1.0", "mass = 0.0", "scene: line 4, column 8: body.mass = 0.0 is"),
            ("-0.5, 0.0", "-0.5, nan", "scene: line 8, column 16: contact.1.point.y = NaN is"),
            ("0.011", "inf", "scene: line 10, column 11: start.q.y = inf is"),
            ("model = \"full\"", "time_limit = -1", "scene: line 12, column 14: run.time_limit ="),
        ] {
            let message = refusal(Scene::from_toml, TOML, old, new);
            assert!(message.starts_with(expected), "{message}");
        }
        let message = refusal(Scene::from_json, JSON, "-0.5, 0.0", "-0.5, 1e200");
        assert!(
            message.starts_with("scene: line 3, column 30: contact.1.point.y = 1e200 is"),
            "{message}"
        );
    }

    #[test]
    fn a_table_is_no_array_and_a_word_no_table() {
        let body = "[body]\nmass = 1.0\ngyration_radius = 0.2\ncenter_of_mass = [0.0, 0.0]";
        for (old, new) in [
            (body, "body = [1.0, 0.2, [0.0, 0.0]]"),
            ("[run]", "[[run]]"),
            ("model = \"full\"", "model = { full = 1 }"),
            ("[[contact]]", "[contact]"),
        ] {
            let message = refusal(Scene::from_toml, TOML, old, new);
            assert!(message.contains(": invalid type: "), "{message}");
        }
        for (old, new) in [
            (JSON, "[9.81, 0.1]"),
            ("{\"model\": \"full\"}", "[\"full\"]"),
            ("{\"point\": [-0.5, 0.0]}", "[[-0.5, 0.0]]"),
            ("\"full\"", "{\"full\": null}"),
        ] {
            let message = refusal(Scene::from_json, JSON, old, new);
            assert!(message.contains(": invalid type: "), "{message}");
        }
    }

    /// The cause, which has to be of this type.
    fn cause<E: std::error::Error + 'static>(error: &Error) -> &E {
        error.source().and_then(|cause| cause.downcast_ref()).expect("a cause of this type")
    }

    #[test]
    fn the_source_of_the_error_of_a_file_is_its_cause() {
        let missing = Scene::load("no such folder/scene.toml").unwrap_err();
        assert_eq!(cause::<io::Error>(&missing).kind(), ErrorKind::NotFound);
        assert_eq!(missing, missing.clone());

        // The value that is wrong in a file.
        let text = "gravity = -1.0\nrestitution = 0.0\ncontact = []\n[body]\nmass = 1.0\ngyration_radius = 1.0\ncenter_of_mass = [0.0, 0.0]";
        let file = Scene::from_toml(text).unwrap_err();
        assert!(matches!(&file, Error::File { problem, .. } if problem.starts_with("line 1,")));
        let Error::OutOfRange { field, value, .. } = cause::<Error>(&file) else {
            panic!("{file:?}")
        };
        assert_eq!((field.as_str(), *value), ("gravity", -1.0));
        // A text that cannot be read has none.
        assert!(Scene::from_toml("gravity = ").unwrap_err().source().is_none());
    }
}

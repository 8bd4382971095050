//! standfast called from Rust, for the ratios to the fixed-step baseline, which is Rust as well: whole runs with the call and
//! the end of the trajectory, unrecorded.
//!
//! `cargo run --profile bench -p standfast-benches --bin standfast-run -- SCENES.json` prints a line of JSON for each run.

use serde_json::{Value, json};
use standfast::body::GroundKind;
use standfast::{Contact, Model, Options, Posture, PostureFields, State, Trajectory, simulate};
use standfast_benches::harness;

fn main() {
    for (name, scene) in harness::scenes() {
        let (body, start) = (&scene["body"], &scene["start"]);
        let q: [f64; 3] = harness::read(&start["q"]);
        // The posture is nominal where its points touch the floor.
        let arms: Vec<[f64; 2]> = harness::read(&body["arms"]);
        let turns = harness::TURNING.contains(&name.as_str());
        let lowest = arms.iter().map(|arm| arm[1]).fold(f64::INFINITY, f64::min);
        let [x, y] = match name.as_str() {
            "ball" => [0.0, 0.1],
            "rod" | "nested" | "elastic" => [0.0; 2],
            _ if turns => [q[0], -lowest],
            _ => [q[0], q[1]],
        };
        let terrain: Option<Vec<[f64; 2]>> = scene.get("terrain").map(harness::read);
        let contact = |[dx, dy]: [f64; 2]| Contact {
            slope: harness::read(&body["slope"]),
            friction: harness::read(&body["friction"]),
            ..Contact::at(x + dx, y + dy)
        };
        let shared = turns && terrain.is_none();
        let posture = Posture::new(PostureFields {
            mass: harness::read(&body["mass"]),
            gyration_radius: harness::read(&body["gyration_radius"]),
            center_of_mass: [x, y],
            contacts: arms.into_iter().map(contact).collect(),
            restitution: harness::read(&body["restitution"]),
            gravity: harness::GRAVITY,
            terrain: terrain.unwrap_or_default(),
            ground: if shared { GroundKind::Shared } else { GroundKind::Own },
            ..PostureFields::default()
        });
        let posture = posture.unwrap_or_else(|e| panic!("{name}: {e}"));
        let state = State::new([q[0] - x, q[1] - y, q[2]], harness::read(&start["v"]));
        let mut options = Options { record: false, ..Options::default() };
        options.impact = harness::read(&scene["law"]);
        let run = |options: &Options| -> Trajectory {
            simulate(&posture, &state, options).unwrap_or_else(|e| panic!("{name}: {e}"))
        };
        let settings = [(Model::Full, "full"), (Model::Auto, "auto"), (Model::Local, "local")];
        // The local model is that of small rotations.
        for (model, setting) in settings.into_iter().take(if turns { 2 } else { 3 }) {
            options.model = model;
            let report = |task: &str, seconds: f64, found: Value| {
                let mut found = found;
                found["law"] = scene["law"].clone();
                harness::report("standfast, in Rust", &name, task, setting, seconds, &found);
            };
            if let Some(time) = scene["before"]["time"].as_f64() {
                let options = Options { time_limit: Some(time), ..options };
                let (seconds, end) = harness::timed(|| *run(&options).state());
                let values = if name == "block" {
                    vec![x + end.q.x, y + end.q.y]
                } else if turns {
                    harness::watched(&scene, [x + end.q.x, y + end.q.y, end.q.z])
                } else {
                    posture.gaps(&end.q)
                };
                report("before", seconds, json!({ "values": values }));
            }
            if scene.get("rest").is_none() {
                continue;
            }
            let (seconds, (time, q)) = harness::timed(|| {
                let run = run(&options);
                (run.time(), run.state().q)
            });
            report("rest", seconds, json!({ "time": time, "q": [x + q.x, y + q.y, q.z] }));
        }
    }
}

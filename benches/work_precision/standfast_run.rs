//! standfast called from Rust, for the ratios to the fixed-step baseline, which is Rust as well: whole runs with the call and
//! the end of the trajectory, unrecorded.
//!
//! `cargo run --profile bench -p standfast-benches --bin standfast-run -- SCENES.json` prints a line of JSON for each run.

use serde_json::{Value, json};
use standfast::{Model, Options, Trajectory, simulate};
use standfast_benches::harness;

fn main() {
    for (name, scene) in harness::scenes() {
        let (posture, state) = harness::start(&name, &scene);
        let turns = harness::turns(&scene);
        let [x, y] = posture.fields().center_of_mass;
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

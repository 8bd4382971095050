//! standfast up to rest, beside Box2D with its usual step of 1/60 s up to the same time: the ratio of their times.

use serde_json::{Map, Value};
use standfast::{Options, simulate};
use standfast_benches::harness;

use crate::{Scene, box2d, median_time};

/// The scenes of the chart that turn over, and the rocking block with its two upper corners.
const SCENES: [&str; 5] = ["rocking", "octagon", "thrown", "stairs", "feet"];

/// Prints a line for each scene.
pub fn compare(scenes: &Map<String, Value>) {
    for name in SCENES {
        let mut given = scenes[name].clone();
        given["law"] = "moreau".into();
        if name == "rocking" {
            let arms: Vec<[f64; 2]> = harness::read(&given["body"]["arms"]);
            let upper = arms.iter().map(|[x, y]| [*x, -y]);
            given["body"]["arms"] = arms.iter().copied().chain(upper).collect::<Vec<_>>().into();
        }
        let scene = Scene::read(&given, harness::GRAVITY);
        let (posture, state) = harness::start(name, &given);
        let options =
            Options { record: false, impact: harness::read(&given["law"]), ..Options::default() };
        let (seconds, run) =
            harness::timed(|| simulate(&posture, &state, &options).expect("a run"));
        let end = run.time();
        let box2d = || box2d::run(&scene, "rest", end, 1.0 / 60.0);
        let theirs = median_time(false, box2d);
        let ([x, y], q) = (posture.fields().center_of_mass, run.state().q);
        let apart = (box2d().q[0] - x - q.x).hypot(box2d().q[1] - y - q.y);
        println!(
            "{name:8} {:10} at {end:.3} s: {:8.1} µs beside {:8.1} µs, {:.2} x; then {apart:.1e} m apart",
            run.outcome().to_string(),
            1e6 * seconds,
            1e6 * theirs,
            seconds / theirs,
        );
    }
}

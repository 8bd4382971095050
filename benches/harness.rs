//! Common parts of the programs of the work-precision chart: scenes, timing, and the line of JSON for a point.

use std::hint::black_box;
use std::time::Instant;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use standfast::body::GroundKind;
use standfast::{Contact, Posture, PostureFields, State};

/// Gravity in all scenes, in m/s².
pub const GRAVITY: f64 = 9.81;
/// Least duration of a measurement, in s: reading the clock takes about 30 ns.
const ROUND: f64 = 1e-5;

/// Whether the body may turn over: unturned, its lowest point is on the floor y = 0.
#[must_use]
pub fn turns(scene: &Value) -> bool {
    scene["body"]["arms"].as_array().is_some_and(|arms| arms.len() > 2)
}

/// Whether the small version of the chart is asked for: no run of more than milliseconds.
#[must_use]
pub fn quick() -> bool {
    std::env::args().any(|argument| argument == "--quick")
}

/// What the task "before" compares: the heights of the contact points of a body with its centre of mass at (x, y), with friction also x.
#[must_use]
pub fn watched(scene: &Value, [x, y, theta]: [f64; 3]) -> Vec<f64> {
    let (sin, cos) = theta.sin_cos();
    let arms: Vec<[f64; 2]> = read(&scene["body"]["arms"]);
    let heights = arms.iter().map(|[a, b]| y + sin * a + cos * b);
    let rubs = read::<f64>(&scene["body"]["friction"]) > 0.0;
    rubs.then_some(x).into_iter().chain(heights).collect()
}

/// The scenes of the file that is the first argument on the command line.
#[must_use]
pub fn scenes() -> Vec<(String, Value)> {
    let path = std::env::args().nth(1).unwrap_or_else(|| panic!("a file of scenes is needed"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let file: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
    let gravity: f64 = read(&file["gravity"]);
    assert!((gravity - GRAVITY).abs() < f64::EPSILON, "{path}: gravity = {gravity}");
    let Some(scenes) = file["scenes"].as_object() else { panic!("{path}: no scenes") };
    scenes.iter().map(|(name, scene)| (name.clone(), scene.clone())).collect()
}

/// The nominal posture of a scene, in which its points touch the floor, and the start.
#[must_use]
pub fn start(name: &str, scene: &Value) -> (Posture, State) {
    let (body, start) = (&scene["body"], &scene["start"]);
    let q: [f64; 3] = read(&start["q"]);
    // The posture is nominal where its points touch the floor.
    let arms: Vec<[f64; 2]> = read(&body["arms"]);
    let turns = turns(scene);
    let lowest = arms.iter().map(|arm| arm[1]).fold(f64::INFINITY, f64::min);
    let [x, y] = match name {
        "ball" => [0.0, 0.1],
        "rod" | "nested" | "elastic" => [0.0; 2],
        _ if turns => [q[0], -lowest],
        _ => [q[0], q[1]],
    };
    let terrain: Option<Vec<[f64; 2]>> = scene.get("terrain").map(read);
    let contact = |[dx, dy]: [f64; 2]| Contact {
        slope: read(&body["slope"]),
        friction: read(&body["friction"]),
        ..Contact::at(x + dx, y + dy)
    };
    let shared = turns && terrain.is_none();
    let posture = Posture::new(PostureFields {
        mass: read(&body["mass"]),
        gyration_radius: read(&body["gyration_radius"]),
        center_of_mass: [x, y],
        contacts: arms.into_iter().map(contact).collect(),
        restitution: read(&body["restitution"]),
        gravity: GRAVITY,
        terrain: terrain.unwrap_or_default(),
        ground: if shared { GroundKind::Shared } else { GroundKind::Own },
        ..PostureFields::default()
    });
    let posture = posture.unwrap_or_else(|e| panic!("{name}: {e}"));
    let state = State::new([q[0] - x, q[1] - y, q[2]], read(&start["v"]));
    (posture, state)
}

/// A value of the scene file.
pub fn read<T: DeserializeOwned>(value: &Value) -> T {
    serde_json::from_value(value.clone()).unwrap_or_else(|e| panic!("{value}: {e}"))
}

/// The median time of several runs, in s, and the result of one of them.
pub fn timed<T>(run: impl Fn() -> T) -> (f64, T) {
    let mut seconds = Vec::new();
    let mut count = 1;
    loop {
        let start = Instant::now();
        let mut found = black_box(run());
        for _ in 1..count {
            found = black_box(run());
        }
        let spent = start.elapsed().as_secs_f64();
        if spent < ROUND {
            count *= 2;
            continue;
        }
        seconds.push(spent / f64::from(count));
        let all = f64::from(count) * seconds.iter().sum::<f64>();
        if seconds.len() >= 5 && (quick() || all > 0.05) || all > 5.0 {
            seconds.sort_by(f64::total_cmp);
            return (seconds[seconds.len() / 2], found);
        }
    }
}

/// Prints a point of the chart.
pub fn report(tool: &str, scene: &str, task: &str, setting: &str, seconds: f64, found: &Value) {
    let mut line = json!({
        "tool": tool, "scene": scene, "task": task, "setting": setting, "seconds": seconds,
        "values": null, "time": null, "q": null,
    });
    for (key, value) in found.as_object().into_iter().flatten() {
        line[key] = value.clone();
    }
    println!("{line}");
}

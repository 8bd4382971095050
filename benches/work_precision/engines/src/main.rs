//! The scenes of the work-precision chart, run by engines that are reached from Rust: Rapier, and version 3 of Box2D.
//!
//! `engines rapier|box2d scenes.json [--quick]` prints one JSON object a line. `engines frames scenes.json` sets standfast, up to rest, beside
//! Box2D with its usual step up to the same time.
//!
//! The contact points are discs of radius [`RADIUS`], the floor is lowered as much. The last step is shortened to end at the time asked for.

mod box2d;
mod frames;
mod rapier;

use serde_json::{Value, json};
use standfast_benches::harness;

/// Radius of the discs, in m.
const RADIUS: f64 = 0.02;
/// Radius of the discs of bodies that turn over, in m: the levers of friction are wrong by it.
const TURNING_RADIUS: f64 = 1e-4;
/// Depth of the blocks that stand for the treads of stairs, in m.
const DEEP: f64 = 1.0;
/// The step unless told otherwise.
const DEFAULT: &str = "1/60";
/// Speed below which there is none, in m/s.
const STILL: f64 = 1e-6;
/// No step is tried with which one run would take longer, in s.
const PATIENCE: f64 = 2.0;
const STEPS: [(&str, f64); 12] = [
    ("1/60", 1.0 / 60.0),
    ("1e-2", 1e-2),
    ("3e-3", 3e-3),
    ("1e-3", 1e-3),
    ("3e-4", 3e-4),
    ("1e-4", 1e-4),
    ("3e-5", 3e-5),
    ("1e-5", 1e-5),
    ("3e-6", 3e-6),
    ("1e-6", 1e-6),
    ("3e-7", 3e-7),
    ("1e-7", 1e-7),
];

#[derive(Clone)]
struct Scene {
    gravity: f64,
    mass: f64,
    gyration_radius: f64,
    arms: Vec<[f64; 2]>,
    restitution: f64,
    friction: f64,
    slope: f64,
    q: [f64; 3],
    v: [f64; 3],
    radius: f64,
    /// Level pieces of the ground: (from x, to x, height); none: one floor.
    treads: Vec<[f64; 3]>,
}

/// The state at the end of a run: position of the centre of mass and angle, and the time since when the body has been still.
struct End {
    /// Wall time of the steps; setting up the world is not timed.
    seconds: f64,
    q: [f64; 3],
    still_since: Option<f64>,
}

/// The time since when the body has been still.
#[derive(Default)]
struct Still {
    since: Option<f64>,
}

impl Still {
    /// Looks at the velocity after a step.
    fn look(&mut self, time: f64, scene: &Scene, [vx, vy, omega]: [f64; 3]) {
        let speed = vx.abs().max(vy.abs()).max(omega.abs() * scene.gyration_radius);
        if speed < STILL {
            self.since.get_or_insert(time);
        } else {
            self.since = None;
        }
    }
}

/// A run of a scene, for this task ("before" or "rest"), of this duration, with this step.
type Run = fn(&Scene, &str, f64, f64) -> End;

/// Wall time of a run in s, the median of some.
fn median_time(quick: bool, run: impl Fn() -> End) -> f64 {
    let mut seconds = Vec::new();
    loop {
        seconds.push(run().seconds);
        if quick {
            return seconds[0];
        }
        let enough = match seconds[0] {
            s if s > 5.0 => 1,
            s if s > 1.0 => 3,
            _ => 5,
        };
        let spent: f64 = seconds.iter().sum();
        if seconds.len() >= enough && (spent > 0.1 || seconds.len() >= 25) {
            seconds.sort_by(f64::total_cmp);
            return seconds[seconds.len() / 2];
        }
    }
}

/// A number of the file, which writes the long ones as text.
fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str()?.parse().ok()).expect("a number")
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| number(&value[i]))
}

/// The level pieces of a polyline.
fn treads(corners: &Value) -> Vec<[f64; 3]> {
    let corners: Vec<[f64; 2]> = corners.as_array().into_iter().flatten().map(numbers).collect();
    let level = |pair: &[[f64; 2]]| {
        (pair[0][1] == pair[1][1]).then(|| [pair[0][0], pair[1][0], pair[0][1]])
    };
    corners.windows(2).filter_map(level).collect()
}

impl Scene {
    fn read(given: &Value, gravity: f64) -> Self {
        let body = &given["body"];
        Self {
            gravity,
            mass: number(&body["mass"]),
            gyration_radius: number(&body["gyration_radius"]),
            arms: body["arms"].as_array().expect("arms").iter().map(numbers).collect(),
            restitution: number(&body["restitution"]),
            friction: number(&body["friction"]),
            slope: number(&body["slope"]),
            q: numbers(&given["start"]["q"]),
            v: numbers(&given["start"]["v"]),
            radius: if harness::turns(given) { TURNING_RADIUS } else { RADIUS },
            treads: treads(&given["terrain"]),
        }
    }

    /// The heights of the contact points above the line of the floor.
    fn heights(&self, [x, y, angle]: [f64; 3]) -> Vec<f64> {
        let (sin, cos) = angle.sin_cos();
        let height = |[a, b]: &[f64; 2]| {
            let at = [x + cos * a - sin * b, y + sin * a + cos * b];
            self.slope.cos() * at[1] - self.slope.sin() * at[0]
        };
        self.arms.iter().map(height).collect()
    }
}

fn main() {
    let usage = "usage: engines rapier|box2d|frames scenes.json [--quick]";
    let engine = std::env::args().nth(1).expect(usage);
    let path = std::env::args().nth(2).expect(usage);
    let quick = std::env::args().any(|argument| argument == "--quick");
    let patience = if quick { 0.03 } else { PATIENCE };
    let text = std::fs::read_to_string(path).expect("a readable file");
    let file: Value = serde_json::from_str(&text).expect("JSON");
    let (gravity, scenes) =
        (number(&file["gravity"]), file["scenes"].as_object().expect("scenes by name"));
    let engines: &[(&str, Run)] = match &engine[..] {
        "rapier" => &[
            ("rapier2d 0.36.1", rapier::single::run),
            ("rapier2d-f64 0.36.1", rapier::double::run),
        ],
        "box2d" => &[("Box2D 3.2", box2d::run)],
        "frames" => return frames::compare(scenes),
        _ => panic!("{usage}"),
    };
    for (name, given) in scenes {
        let scene = Scene::read(given, gravity);
        for (task, longer) in [("before", 1.0), ("rest", 1.5)] {
            if given[task].is_null() {
                continue;
            }
            let duration = longer * number(&given[task]["time"]);
            for &(tool, run) in engines {
                let mut last: Option<f64> = None;
                for (label, dt) in STEPS {
                    if last.is_some_and(|work| work / dt > patience) {
                        break;
                    }
                    let end = run(&scene, task, duration, dt);
                    // A run to rest is timed up to the time of rest that it found, as if that had been known.
                    let known = end.still_since.filter(|_| task == "rest").unwrap_or(duration);
                    let seconds = median_time(quick, || run(&scene, task, known, dt));
                    last = Some(seconds * dt);
                    let (values, time, q) = match (task, name.as_str()) {
                        ("rest", _) => (Value::Null, json!(end.still_since), json!(end.q)),
                        (_, "block") => (json!(end.q[..2]), Value::Null, Value::Null),
                        _ if scene.friction > 0.0 => {
                            let place = [&end.q[..1], &scene.heights(end.q)].concat();
                            (json!(place), Value::Null, Value::Null)
                        }
                        _ => (json!(scene.heights(end.q)), Value::Null, Value::Null),
                    };
                    println!(
                        "{}",
                        json!({
                            "tool": tool, "scene": name, "task": task, "setting": format!("dt = {label}"),
                            "parameter": dt, "default": label == DEFAULT, "seconds": seconds, "values": values, "time": time, "q": q,
                        })
                    );
                }
            }
        }
    }
}

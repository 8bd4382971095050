//! The scenes of the work-precision chart, run by Rapier in single and in double precision:
//! `rapier scenes.json` prints one JSON object a line.
//!
//! The contact points are discs of radius [`RADIUS`] without mass, the floor is a half-space lowered as much, and both
//! surfaces carry the scene's restitution and friction, so that every combine rule gives the same. The body never sleeps:
//! sleep ends motion by a timer. Two defaults are changed, for the better of Rapier. The floor's natural frequency is 1 kHz
//! instead of 60 Hz: the body then rests .3 µm deep instead of 70 µm. And for the rest of a body on two contacts there are 16
//! stabilization iterations instead of one, with which its speeds hardly ever stay below 1e-6 m/s; before the impacts
//! accumulate they cost time and gain nothing. More substeps (4) do about what a shorter `dt` does; the recycling of
//! contacts, warm starts and the prediction distance were left as they are, for no change of theirs was a gain. The last step is
//! shortened to end at the time asked for. Rapier applies restitution only to a contact that had no impulse in the step before,
//! so that the last, shortest rebounds are dropped. The rebound follows the friction of a step and has none of its own. Nothing tells it that impacts stick in the scene `rocking`; friction does.

use serde_json::{Value, json};

/// Radius of the discs, in m.
const RADIUS: f64 = 0.02;
/// Radius of the discs of bodies that turn over, in m: the levers of friction are wrong by it.
const TURNING_RADIUS: f64 = 1e-4;
/// Such bodies.
const TURNING: [&str; 4] = ["thrown", "octagon", "stairs", "feet"];
/// Depth of the blocks that stand for the treads of stairs, in m.
const DEEP: f64 = 1.0;
/// The step unless told otherwise.
const DEFAULT: &str = "1/60";
/// Natural frequency of the contacts with the floor, in Hz.
const FLOOR_FREQUENCY: f64 = 1e3;
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

/// The state at the end of a run: position of the centre of mass and angle, heights of the contact points above the floor,
/// and the time since when the body has been still.
struct End {
    /// Wall time of the steps; setting up the world is not timed.
    seconds: f64,
    q: [f64; 3],
    heights: Vec<f64>,
    still_since: Option<f64>,
}

macro_rules! engine {
    ($module:ident, $rapier:ident) => {
        mod $module {
            use super::{DEEP, End, FLOOR_FREQUENCY, STILL, Scene};
            use std::time::Instant;

            use $rapier::prelude::*;

            pub fn run(scene: &Scene, duration: f64, dt: f64, stabilization: usize) -> End {
                let vector = |[x, y]: [f64; 2]| Vector::new(x as Real, y as Real);
                let surface = |collider: ColliderBuilder| {
                    collider.restitution(scene.restitution as Real).friction(scene.friction as Real)
                };
                let mut world = PhysicsWorld::new();
                world.gravity = vector([0.0, -scene.gravity]);
                let parameters = &mut world.integration_parameters;
                parameters.dt = dt as Real;
                parameters.static_contact_softness.natural_frequency = FLOOR_FREQUENCY as Real;
                parameters.num_internal_stabilization_iterations = stabilization;

                let normal = [-scene.slope.sin(), scene.slope.cos()];
                if scene.treads.is_empty() {
                    let floor = ColliderBuilder::new(SharedShape::halfspace(vector(normal)))
                        .translation(vector(normal.map(|n| -scene.radius * n)));
                    world.insert_collider(surface(floor), None);
                }
                for [x, end, y] in &scene.treads {
                    let (half, deep) = ((end - x) / 2.0, DEEP / 2.0);
                    let block = ColliderBuilder::cuboid(half as Real, deep as Real)
                        .translation(vector([x + half, y - scene.radius - deep]));
                    world.insert_collider(surface(block), None);
                }
                let inertia = scene.mass * scene.gyration_radius.powi(2);
                let body = RigidBodyBuilder::dynamic()
                    .translation(vector([scene.q[0], scene.q[1]]))
                    .rotation(scene.q[2] as Real)
                    .linvel(vector([scene.v[0], scene.v[1]]))
                    .angvel(scene.v[2] as Real)
                    .additional_mass_properties(MassProperties::new(
                        Vector::ZERO,
                        scene.mass as Real,
                        inertia as Real,
                    ))
                    .can_sleep(false);
                let body = world.insert_body(body);
                for &arm in &scene.arms {
                    let disc = ColliderBuilder::ball(scene.radius as Real).density(0.0);
                    world.insert_collider(surface(disc.translation(vector(arm))), Some(body));
                }

                let start = Instant::now();
                let steps = (duration / dt - 1e-6).ceil() as usize;
                let mut still_since = None;
                for step in 1..=steps {
                    let mut time = step as f64 * dt;
                    if step == steps {
                        let last = duration - (step - 1) as f64 * dt;
                        world.integration_parameters.dt = last as Real;
                        time = duration;
                    }
                    world.step();
                    let (v, omega) = (world.bodies[body].linvel(), world.bodies[body].angvel());
                    let speed = v.x.abs().max(v.y.abs()) as f64;
                    let rim = omega.abs() as f64 * scene.gyration_radius;
                    if speed < STILL && rim < STILL {
                        still_since.get_or_insert(time);
                    } else {
                        still_since = None;
                    }
                }
                let pose = *world.bodies[body].position();
                let (at, angle) = (pose.translation, pose.rotation.angle());
                let height = |&arm: &[f64; 2]| {
                    let point = pose * vector(arm);
                    normal[0] * point.x as f64 + normal[1] * point.y as f64
                };
                End {
                    seconds: start.elapsed().as_secs_f64(),
                    q: [at.x as f64, at.y as f64, angle as f64],
                    heights: scene.arms.iter().map(height).collect(),
                    still_since,
                }
            }
        }
    };
}

engine!(single, rapier2d);
engine!(double, rapier2d_f64);

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

fn main() {
    let path = std::env::args().nth(1).expect("usage: rapier scenes.json [--quick]");
    let quick = std::env::args().any(|argument| argument == "--quick");
    let patience = if quick { 0.03 } else { PATIENCE };
    let text = std::fs::read_to_string(path).expect("a readable file");
    let file: Value = serde_json::from_str(&text).expect("JSON");
    let engines: [(&str, fn(&Scene, f64, f64, usize) -> End); 2] =
        [("rapier2d 0.36.1", single::run), ("rapier2d-f64 0.36.1", double::run)];
    for (name, given) in file["scenes"].as_object().expect("scenes by name") {
        let body = &given["body"];
        let scene = Scene {
            gravity: number(&file["gravity"]),
            mass: number(&body["mass"]),
            gyration_radius: number(&body["gyration_radius"]),
            arms: body["arms"].as_array().expect("arms").iter().map(numbers).collect(),
            restitution: number(&body["restitution"]),
            friction: number(&body["friction"]),
            slope: number(&body["slope"]),
            q: numbers(&given["start"]["q"]),
            v: numbers(&given["start"]["v"]),
            radius: if TURNING.contains(&name.as_str()) { TURNING_RADIUS } else { RADIUS },
            treads: treads(&given["terrain"]),
        };
        for (task, longer) in [("before", 1.0), ("rest", 1.5)] {
            if given[task].is_null() {
                continue;
            }
            let duration = longer * number(&given[task]["time"]);
            let stabilization = if task == "rest" && scene.arms.len() > 1 { 16 } else { 1 };
            for (tool, run) in engines {
                let mut last: Option<f64> = None;
                for (label, dt) in STEPS {
                    if last.is_some_and(|work| work / dt > patience) {
                        break;
                    }
                    let end = run(&scene, duration, dt, stabilization);
                    // A run to rest is timed up to the time of rest that it found, as if that had been known.
                    let known = end.still_since.filter(|_| task == "rest").unwrap_or(duration);
                    let seconds = median_time(quick, || run(&scene, known, dt, stabilization));
                    last = Some(seconds * dt);
                    let (values, time, q) = match (task, name.as_str()) {
                        ("rest", _) => (Value::Null, json!(end.still_since), json!(end.q)),
                        (_, "block") => (json!(end.q[..2]), Value::Null, Value::Null),
                        _ if scene.friction > 0.0 => {
                            let place = [&end.q[..1], &end.heights].concat();
                            (json!(place), Value::Null, Value::Null)
                        }
                        _ => (json!(end.heights), Value::Null, Value::Null),
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

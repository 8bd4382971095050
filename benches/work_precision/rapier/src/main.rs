//! The scenes of the work-precision chart run by Rapier: `rapier scenes.json` prints one JSON object a line.

use serde_json::{Value, json};
use std::time::Instant;

/// Radius of the discs that stand for the contact points, in m; the floor lies as much lower.
const RADIUS: f64 = 0.02;

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
}

struct Run {
    q: [f64; 3],
    heights: Vec<f64>,
    settled: Option<f64>,
}

macro_rules! engine {
    ($name:ident, $rapier:ident) => {
        mod $name {
            use super::{RADIUS, Run, Scene};
            use $rapier::prelude::*;

            pub fn run(scene: &Scene, duration: f64, dt: f64) -> Run {
                let vector = |x: [f64; 2]| Vector::new(x[0] as Real, x[1] as Real);
                let surface = |c: ColliderBuilder| {
                    c.restitution(scene.restitution as Real).friction(scene.friction as Real)
                };
                let mut world = PhysicsWorld::new();
                world.gravity = vector([0.0, -scene.gravity]);
                let env = |n: &str, d: f64| std::env::var(n).map_or(d, |x| x.parse().unwrap());
                let p = &mut world.integration_parameters;
                if env("FREQ", 0.0) > 0.0 {
                    p.static_contact_softness.natural_frequency = env("FREQ", 0.0) as Real;
                }
                if env("DAMP", 0.0) > 0.0 {
                    p.static_contact_softness.damping_ratio = env("DAMP", 0.0) as Real;
                }
                p.contact_recycling = env("RECYCLE", 1.0) > 0.0;
                p.friction_in_bias_pass = env("FBIAS", 0.0) > 0.0;
                p.num_solver_iterations = env("ITER", 4.0) as usize;
                p.num_internal_pgs_iterations = env("PGS", 1.0) as usize;
                p.num_internal_stabilization_iterations = env("STAB", 1.0) as usize;
                p.warmstart_coefficient = env("WARM", 1.0) as Real;
                p.normalized_prediction_distance = env("PRED", 0.02) as Real;
                p.normalized_allowed_linear_error = env("SLOP", 0.005) as Real;
                p.max_ccd_substeps = env("CCD", 1.0) as usize;
                p.dt = dt as Real;
                let up = [-scene.slope.sin(), scene.slope.cos()];
                let floor = ColliderBuilder::new(SharedShape::halfspace(vector(up)))
                    .translation(vector(up.map(|n| -RADIUS * n)));
                world.insert_collider(surface(floor), None);
                let inertia = (scene.mass * scene.gyration_radius.powi(2)) as Real;
                let body = RigidBodyBuilder::dynamic()
                    .translation(vector([scene.q[0], scene.q[1]]))
                    .rotation(scene.q[2] as Real)
                    .linvel(vector([scene.v[0], scene.v[1]]))
                    .angvel(scene.v[2] as Real)
                    .additional_mass_properties(MassProperties::new(
                        Vector::ZERO,
                        scene.mass as Real,
                        inertia,
                    ))
                    .can_sleep(env("SLEEP", 0.0) > 0.0);
                let body = world.insert_body(body);
                for arm in &scene.arms {
                    let disc = ColliderBuilder::ball(RADIUS as Real)
                        .translation(vector(*arm))
                        .density(0.0);
                    world.insert_collider(surface(disc), Some(body));
                }
                let steps = (duration / dt - 1e-6).ceil();
                let (mut time, mut settled) = (0.0, Some(0.0));
                for step in 1..=steps as usize {
                    if step as f64 == steps {
                        world.integration_parameters.dt = (duration - time) as Real;
                    }
                    world.step();
                    time = if step as f64 == steps { duration } else { step as f64 * dt };
                    let body = &world.bodies[body];
                    let (v, omega) = (body.linvel(), body.angvel() as f64);
                    if std::env::var("TRACE").is_ok() { eprintln!("{time} {} {} {} {}", body.translation().y, body.rotation().angle(), v.y, omega); }
                    let speed = (v.x.abs().max(v.y.abs()) as f64)
                        .max(omega.abs() * scene.gyration_radius);
                    if !(speed < 1e-6) {
                        settled = None;
                    } else if settled.is_none() {
                        settled = Some(time);
                    }
                }
                let body = &world.bodies[body];
                let pose = *body.position();
                let gap = |arm: &[f64; 2]| {
                    let p = pose * vector(*arm);
                    p.x as f64 * up[0] + p.y as f64 * up[1]
                };
                Run {
                    q: [
                        pose.translation.x as f64,
                        pose.translation.y as f64,
                        pose.rotation.angle() as f64,
                    ],
                    heights: scene.arms.iter().map(gap).collect(),
                    settled,
                }
            }
        }
    };
}

engine!(single, rapier2d);
engine!(double, rapier2d_f64);

fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str()?.parse().ok()).expect("a number")
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| number(&value[i]))
}

fn main() {
    let path = std::env::args().nth(1).expect("usage: rapier scenes.json");
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for (name, told) in file["scenes"].as_object().unwrap() {
        let body = &told["body"];
        let scene = Scene {
            gravity: number(&file["gravity"]),
            mass: number(&body["mass"]),
            gyration_radius: number(&body["gyration_radius"]),
            arms: body["arms"].as_array().unwrap().iter().map(numbers).collect(),
            restitution: number(&body["restitution"]),
            friction: number(&body["friction"]),
            slope: number(&body["slope"]),
            q: numbers(&told["start"]["q"]),
            v: numbers(&told["start"]["v"]),
        };
        let engines: [(&str, fn(&Scene, f64, f64) -> Run); 2] =
            [("rapier2d 0.36.1", single::run), ("rapier2d-f64 0.36.1", double::run)];
        for (tool, run) in engines {
            for task in ["before", "rest"] {
                if told[task].is_null() {
                    continue;
                }
                let rest = task == "rest";
                let duration = number(&told[task]["time"]) * if rest { 1.5 } else { 1.0 };
                for (label, dt) in [("1/60", 1.0 / 60.0), ("1e-2", 1e-2), ("1e-3", 1e-3), ("1e-4", 1e-4), ("1e-5", 1e-5)] {
                    let start = Instant::now();
                    let r = run(&scene, duration, dt);
                    let secs = start.elapsed().as_secs_f64();
                    if std::env::var("BRIEF").is_ok() {
                        let ex = &told[task];
                        if rest {
                            let t = number(&ex["time"]); let q: [f64;3] = numbers(&ex["q"]);
                            let e: Vec<_> = (0..3).map(|i| format!("{:.1e}", r.q[i]-q[i])).collect();
                            println!("{name:8} {tool:20} {label:5} {secs:.1e} rest terr {:?} qerr {}", r.settled.map(|x| x/t-1.0), e.join(" "));
                        } else {
                            let v: Vec<f64> = if name == "block" { r.q[..2].to_vec() } else { r.heights.clone() };
                            let e: Vec<_> = v.iter().enumerate().map(|(i, x)| format!("{:.1e}", x - number(&ex["values"][i]))).collect();
                            println!("{name:8} {tool:20} {label:5} {secs:.1e} before err {}", e.join(" "));
                        }
                    } else { println!("{}", json!({"q": r.q, "v": r.heights, "t": r.settled})); }
                    if secs > 3.0 { break; }
                }
            }
        }
    }
}

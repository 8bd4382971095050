//! Box2D 3 in single precision.
//!
//! The contact points are discs, the floor is a segment lowered by their radius. Four sub-steps a step are the default, and continuous
//! collisions. The body does not sleep: sleep ends motion by a timer. Box2D has absolute lengths: it drops restitution below 1 m/s and leaves
//! .005 m of penetration. Therefore all lengths are multiplied by .1 s/dt, at most by 1e5: restitution is then dropped below 10 dt m/s, which
//! is about the change of the speed in a step. Contacts are springs, whose frequency is a quarter of that of the sub-steps at most.

use std::time::Instant;

use boxdd::{
    BodyBuilder, BodyType, Foundation, MassData, Position, ShapeDef, SurfaceMaterial, Vec2,
    WorldBuilder, shapes,
};

use crate::{End, Scene, Still};

/// Lengths are multiplied by this time over the step.
const LENGTH: f64 = 0.1;
const LARGEST: f64 = 1e5;
/// Sub-steps of a step.
const SUB_STEPS: i32 = 4;
/// Half the length of the floor, in m.
const FAR: f64 = 10.0;

pub fn run(scene: &Scene, _task: &str, duration: f64, dt: f64) -> End {
    simulate(scene, duration, dt).expect("a valid scene")
}

fn simulate(scene: &Scene, duration: f64, dt: f64) -> boxdd::Result<End> {
    let scale = (LENGTH / dt).min(LARGEST);
    let vector = |v: [f64; 2]| Vec2::from(v.map(|x| (scale * x) as f32));
    let foundation = Foundation::initialize_default()?;
    let mut world = foundation.create_world(
        WorldBuilder::from(foundation.world_def())
            .gravity(vector([0.0, -scene.gravity]))
            .maximum_linear_speed(f32::MAX.sqrt())
            .enable_sleep(false)
            .build()?,
    )?;
    let surface = |restitution: f64| -> boxdd::Result<ShapeDef> {
        let material = SurfaceMaterial::default()
            .with_friction(scene.friction as f32)?
            .with_restitution(restitution as f32)?;
        ShapeDef::builder().material(material).density(0.0).build()
    };
    let (sin, cos) = scene.slope.sin_cos();
    let low = [scene.radius * sin, -scene.radius * cos];
    let floor = [-FAR, FAR].map(|s| [low[0] + s * cos, low[1] + s * sin]);
    let treads = scene.treads.iter().map(|[x, end, y]| [*x, *end].map(|x| [x, y - scene.radius]));
    let pieces: Vec<[[f64; 2]; 2]> =
        if scene.treads.is_empty() { vec![floor] } else { treads.collect() };
    let ground = world.create_body(BodyBuilder::from(foundation.body_def()).build()?)?;
    for [from, to] in pieces {
        world.body(ground)?.create_segment_between(&surface(0.0)?, vector(from), vector(to))?;
    }
    let [x, y, angle] = scene.q;
    let [vx, vy, omega] = scene.v;
    let body = world.create_body(
        BodyBuilder::from(foundation.body_def())
            .body_type(BodyType::Dynamic)
            .position(Position::from(vector([x, y])))
            .angle(angle as f32)
            .linear_velocity(vector([vx, vy]))
            .angular_velocity(omega as f32)
            .build()?,
    )?;
    for &arm in &scene.arms {
        let disc = shapes::circle(vector(arm), (scale * scene.radius) as f32)?;
        world.body(body)?.create_circle(&surface(scene.restitution)?, &disc)?;
    }
    let inertia = scene.mass * (scale * scene.gyration_radius).powi(2);
    let mass = MassData::new(scene.mass as f32, Vec2::new(0.0, 0.0), inertia as f32)?;
    world.body(body)?.set_mass_data(mass)?;

    let steps = (duration / dt - 1e-6).ceil() as usize;
    let (start, mut still) = (Instant::now(), Still::default());
    for step in 1..=steps {
        let last = step == steps;
        let (dt, time) = match last {
            true => (duration - (step - 1) as f64 * dt, duration),
            false => (dt, step as f64 * dt),
        };
        drop(world.step(dt as f32, SUB_STEPS)?);
        let body = world.body(body)?;
        let v = body.linear_velocity()?;
        let omega = f64::from(body.angular_velocity()?);
        still.look(time, scene, [f64::from(v.x) / scale, f64::from(v.y) / scale, omega]);
    }
    let seconds = start.elapsed().as_secs_f64();
    let body = world.body(body)?;
    let (at, turn) = (body.position()?, body.rotation()?);
    Ok(End {
        seconds,
        q: [f64::from(at.x) / scale, f64::from(at.y) / scale, f64::from(turn.angle())],
        still_since: still.since,
    })
}

//! Rapier in single and in double precision.
//!
//! The contact points are discs without mass, the floor is a half-space lowered by their radius, and both
//! surfaces carry the scene's restitution and friction, so that every combine rule gives the same. The body never sleeps:
//! sleep ends motion by a timer. Two defaults are changed, for the better of Rapier. The floor's natural frequency is 1 kHz
//! instead of 60 Hz: the body then rests .3 µm deep instead of 70 µm. And for the rest of a body on two contacts there are 16
//! stabilization iterations instead of one, with which its speeds hardly ever stay below 1e-6 m/s; before the impacts
//! accumulate they cost time and gain nothing. More substeps (4) do about what a shorter `dt` does; the recycling of
//! contacts, warm starts and the prediction distance were left as they are, for no change of theirs was a gain. Rapier
//! applies restitution only to a contact that had no impulse in the step before,
//! so that the last, shortest rebounds are dropped. The rebound follows the friction of a step and has none of its own. Nothing tells it that impacts stick in the scene `rocking`; friction does.

/// Natural frequency of the contacts with the floor, in Hz.
const FLOOR_FREQUENCY: f64 = 1e3;

macro_rules! engine {
    ($module:ident, $rapier:ident) => {
        pub mod $module {
            use super::FLOOR_FREQUENCY;
            use crate::{DEEP, End, Scene, Still};
            use std::time::Instant;

            use $rapier::prelude::*;

            pub fn run(scene: &Scene, task: &str, duration: f64, dt: f64) -> End {
                let stabilization = if task == "rest" && scene.arms.len() > 1 { 16 } else { 1 };
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
                let mut still = Still::default();
                for step in 1..=steps {
                    let mut time = step as f64 * dt;
                    if step == steps {
                        let last = duration - (step - 1) as f64 * dt;
                        world.integration_parameters.dt = last as Real;
                        time = duration;
                    }
                    world.step();
                    let (v, omega) = (world.bodies[body].linvel(), world.bodies[body].angvel());
                    still.look(time, scene, [v.x, v.y, omega].map(f64::from));
                }
                let pose = *world.bodies[body].position();
                let (at, angle) = (pose.translation, pose.rotation.angle());
                End {
                    seconds: start.elapsed().as_secs_f64(),
                    q: [at.x as f64, at.y as f64, angle as f64],
                    still_since: still.since,
                }
            }
        }
    };
}

engine!(single, rapier2d);
engine!(double, rapier2d_f64);

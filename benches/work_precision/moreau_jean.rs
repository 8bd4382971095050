//! Moreau–Jean time stepping: the fixed-step baseline of the chart.
//!
//! With step h, velocities v and impulses λ of a step,
//!
//! ```text
//! v⁺ = v + h g + M⁻¹ Jᵀ λ,   q⁺ = q + ½h (v + v⁺)
//! 0 ≤ λ_n ⊥ u_n⁺ + e u_n ≥ 0,   |λ_t| ≤ μλ_n, opposing u_t⁺      at contacts with gap(q + ½hv) ≤ 0
//! ```
//!
//! [Jean 1999]. Contacts are solved exactly, word by word: the first word of S, F, R, L per contact whose conditions hold. No
//! allocation in a step; times are medians of whole runs, the state being looked at after each step.
//!
//! `cargo run --profile bench -p standfast-benches --bin moreau-jean -- SCENES.json` prints a line of JSON for each run.

use nalgebra::{SMatrix, SVector, Vector3};
use serde_json::{Value, json};
use standfast_benches::harness;

/// Longest run that is made, in steps.
const LONGEST: f64 = 2e7;
/// Speeds below it are none, in m/s.
const STILL: f64 = 1e-6;
/// Conditions hold to rounding.
const ROUNDING: f64 = 1e-12;
/// Singular values below it, relative, are none: two fixed contacts share their tangential forces.
const SINGULAR: f64 = 1e-10;

/// A body over a floor.
struct Body {
    arms: Vec<[f64; 2]>,
    rho2: f64,
    e: f64,
    mu: f64,
    slope: (f64, f64),
    gravity: f64,
    /// Level pieces of the ground: (from x, to x, height).
    treads: Vec<[f64; 3]>,
}

/// What a contact does in a step.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Separate,
    Fixed,
    Slide(f64),
}

const MODES: [Mode; 4] = [Mode::Separate, Mode::Fixed, Mode::Slide(1.0), Mode::Slide(-1.0)];

impl Body {
    fn read(scene: &Value) -> Self {
        let body = &scene["body"];
        let corners: Vec<[f64; 2]> = scene.get("terrain").map_or_else(Vec::new, harness::read);
        let level = |pair: &[[f64; 2]]| match *pair {
            [[x, y], [end, to]] if y == to => Some([x, end, y]),
            _ => None,
        };
        let number = |key: &str| body[key].as_f64().unwrap_or_else(|| panic!("{key}"));
        let rho = number("gyration_radius");
        Self {
            arms: serde_json::from_value(body["arms"].clone()).unwrap_or_else(|e| panic!("{e}")),
            rho2: rho * rho,
            e: number("restitution"),
            mu: number("friction"),
            slope: number("slope").sin_cos(),
            gravity: harness::GRAVITY,
            treads: corners.windows(2).filter_map(level).collect(),
        }
    }

    /// Gap, and rows of the tangential and the normal rate, of a contact point.
    fn contact(&self, i: usize, q: &Vector3<f64>) -> (f64, Vector3<f64>, Vector3<f64>) {
        let (sin, cos) = q.z.sin_cos();
        let [x, y] = self.arms[i];
        let (dx, dy) = (cos * x - sin * y, sin * x + cos * y);
        let (s, c) = self.slope;
        let under = |tread: &&[f64; 3]| (tread[0]..tread[1]).contains(&(q.x + dx));
        let level = self.treads.iter().find(under).map_or(0.0, |tread| tread[2]);
        let gap = -s * (q.x + dx) + c * (q.y + dy - level);
        let tangent = Vector3::new(c, s, s * dx - c * dy);
        let normal = Vector3::new(-s, c, c * dx + s * dy);
        (gap, tangent, normal)
    }

    fn inverse_mass(&self, row: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(row.x, row.y, row.z / self.rho2)
    }

    /// `word`: that of the last step with as many contacts, which is tried first.
    fn step(&self, q: &mut Vector3<f64>, v: &mut Vector3<f64>, h: f64, word: &mut usize) {
        let middle = *q + *v * (0.5 * h);
        let mut free = *v;
        free.y -= self.gravity * h;
        // Of more than two closed contacts the two deepest ones.
        let mut closed = [(0, Vector3::zeros(), Vector3::zeros()); 2];
        let (mut deep, mut count) = ([0.0; 2], 0);
        for i in 0..self.arms.len() {
            let (gap, tangent, normal) = self.contact(i, &middle);
            if gap > 0.0 {
                continue;
            }
            let place = if count < 2 { count } else { usize::from(deep[1] > deep[0]) };
            if count < 2 || gap < deep[place] {
                (deep[place], closed[place]) = (gap, (i, tangent, normal));
            }
            count += 1;
        }
        let after = match count {
            0 => free,
            1 => self.solve::<1>(v, &free, [closed[0]], word),
            _ => self.solve::<2>(v, &free, closed, word),
        };
        *q += (*v + after) * (0.5 * h);
        *v = after;
    }

    /// The velocity after the impulses of `N` closed contacts.
    fn solve<const N: usize>(
        &self,
        before: &Vector3<f64>,
        free: &Vector3<f64>,
        closed: [(usize, Vector3<f64>, Vector3<f64>); N],
        last: &mut usize,
    ) -> Vector3<f64> {
        let kinds = if self.mu > 0.0 { 4 } else { 2 };
        let words = usize::pow(kinds, N as u32);
        for word in std::iter::once(*last % words).chain(0..words) {
            let modes: [Mode; N] =
                std::array::from_fn(|k| MODES[word / usize::pow(kinds, k as u32) % kinds]);
            if let Some(after) = self.try_word(before, free, &closed, &modes) {
                *last = word;
                return after;
            }
        }
        *free
    }

    fn try_word<const N: usize>(
        &self,
        before: &Vector3<f64>,
        free: &Vector3<f64>,
        closed: &[(usize, Vector3<f64>, Vector3<f64>); N],
        modes: &[Mode; N],
    ) -> Option<Vector3<f64>> {
        // Unknowns: normal and tangential impulses, two a contact; identity rows where they vanish.
        let mut matrix = SMatrix::<f64, 4, 4>::identity();
        let mut right = SVector::<f64, 4>::zeros();
        for (k, (_, tangent, normal)) in closed.iter().enumerate() {
            let (n, t) = (2 * k, 2 * k + 1);
            if modes[k] == Mode::Separate {
                continue;
            }
            matrix[(n, n)] = 0.0;
            for (l, (_, other_t, other_n)) in closed.iter().enumerate() {
                matrix[(n, 2 * l)] = normal.dot(&self.inverse_mass(other_n));
                matrix[(n, 2 * l + 1)] = normal.dot(&self.inverse_mass(other_t));
            }
            right[n] = -normal.dot(free) - self.e * normal.dot(before);
            match modes[k] {
                Mode::Slide(way) => matrix[(t, n)] = way * self.mu,
                Mode::Fixed if self.mu > 0.0 => {
                    for (l, (_, other_t, other_n)) in closed.iter().enumerate() {
                        matrix[(t, 2 * l)] = tangent.dot(&self.inverse_mass(other_n));
                        matrix[(t, 2 * l + 1)] = tangent.dot(&self.inverse_mass(other_t));
                    }
                    right[t] = -tangent.dot(free);
                }
                _ => {}
            }
        }
        let fixed = modes.iter().filter(|mode| **mode == Mode::Fixed).count();
        let impulses = if fixed == 2 && self.mu > 0.0 {
            matrix.svd(true, true).solve(&right, SINGULAR).ok()?
        } else {
            matrix.lu().solve(&right)?
        };
        let mut after = *free;
        for (k, (_, tangent, normal)) in closed.iter().enumerate() {
            after += self.inverse_mass(normal) * impulses[2 * k];
            after += self.inverse_mass(tangent) * impulses[2 * k + 1];
        }
        let scale = before.amax() + free.amax();
        let holds =
            closed.iter().zip(modes).enumerate().all(|(k, ((_, tangent, normal), mode))| {
                let (push, rub) = (impulses[2 * k], impulses[2 * k + 1]);
                let opens = normal.dot(&after) + self.e * normal.dot(before);
                match mode {
                    Mode::Separate => opens >= -ROUNDING * scale,
                    Mode::Fixed => {
                        push >= -ROUNDING * scale && rub.abs() <= self.mu * push + ROUNDING * scale
                    }
                    Mode::Slide(way) => {
                        push >= -ROUNDING * scale && way * tangent.dot(&after) >= -ROUNDING * scale
                    }
                }
            });
        holds.then_some(after)
    }
}

fn main() {
    for (name, scene) in harness::scenes() {
        let body = Body::read(&scene);
        let longest = if harness::quick() { 2e5 } else { LONGEST };
        let start = |key: &str| Vector3::from(harness::read::<[f64; 3]>(&scene["start"][key]));
        let (q0, v0) = (start("q"), start("v"));
        let rest: f64 = scene["rest"]["time"].as_str().and_then(|t| t.parse().ok()).unwrap_or(0.0);
        let rho = body.rho2.sqrt();
        for exponent in 4..20 {
            let h = 10_f64.powf(-0.5 * f64::from(exponent));
            let report = |task: &str, seconds: f64, found: Value| {
                let setting = format!("dt = {h:.1e}");
                harness::report("Moreau–Jean (ours)", &name, task, &setting, seconds, &found);
            };
            let end = scene["before"]["time"].as_f64().unwrap_or(0.0).max(1.5 * rest);
            if end / h > longest {
                break;
            }
            if h > 0.2 * end / 1.5 {
                continue;
            }
            if let Some(time) = scene["before"]["time"].as_f64() {
                let (seconds, q) = harness::timed(|| {
                    let (mut q, mut v, mut t, mut word) = (q0, v0, 0.0, 0);
                    while t < time {
                        let dt = h.min(time - t);
                        body.step(&mut q, &mut v, dt, &mut word);
                        t += dt;
                    }
                    q
                });
                let values: Vec<f64> = if name == "block" {
                    vec![q.x, q.y]
                } else if harness::turns(&scene) {
                    harness::watched(&scene, [q.x, q.y, q.z])
                } else {
                    (0..body.arms.len()).map(|i| body.contact(i, &q).0).collect()
                };
                report("before", seconds, json!({ "values": values }));
            }
            if scene.get("rest").is_none() {
                continue;
            }
            let run = |end: f64| {
                let (mut q, mut v, mut t, mut word) = (q0, v0, 0.0, 0);
                let mut settled = f64::NAN;
                while t < end {
                    body.step(&mut q, &mut v, h, &mut word);
                    t += h;
                    if v.x.abs().max(v.y.abs()).max(v.z.abs() * rho) >= STILL {
                        settled = f64::NAN;
                    } else if settled.is_nan() {
                        settled = t;
                    }
                }
                (settled, q)
            };
            // Timed up to the time of rest that it finds, as if that had been known.
            let (settled, q) = run(1.5 * rest);
            let end = if settled.is_nan() { 1.5 * rest } else { settled };
            let (seconds, _) = harness::timed(|| run(end));
            let time = if settled.is_nan() { Value::Null } else { json!(settled) };
            report("rest", seconds, json!({ "time": time, "q": [q.x, q.y, q.z] }));
        }
    }
}

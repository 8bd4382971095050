//! The end of a slide whose friction matrix becomes singular (dynamic jam).
//!
//! M f = r gives the forces f that keep the rows at zero, and det M → 0 along the slide. With M p = 0 and l M = 0 the forces approach p
//! (l·r)/det M: they grow without bounds. Each impulse p J reduces det M by a factor. So the forces act as an impulse, in no time and at
//! constant geometry, until another event comes. In most cases this event is the end of a slide: because M p = 0, the impulse keeps the
//! normal rows at zero, and because friction takes energy, some J stops the slide. Two other events may come first: ω reaches zero, and det
//! M grows again; or l·r reaches zero, and the forces are 0/0 (Painlevé's singular point, beyond which a rigid body has no unique motion
//! [Génot & Brogliato 1999; Nordmark, Várkonyi & Champneys 2018]).

use nalgebra::{Matrix3, Vector3};

use crate::body::contact::ContactValues;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::math::simplex::maximise;
use crate::modes::Mode;
use crate::sustained::BodyState;
use crate::sustained::frozen::Frozen;

/// The impulses of contacts, from those along the edges of their friction cones, in the order of the contacts: the contact, the edge (tangential,
/// normal), its direction, and its part of `speed`. Contacts without an impulse are left out.
fn by_contact<V>(
    edges: Vec<(usize, [f64; 2], V)>,
    parts: &[f64],
    speed: f64,
) -> Vec<(usize, [f64; 2])> {
    let mut impulses: Vec<(usize, [f64; 2])> = Vec::new();
    for ((i, force, _), part) in edges.into_iter().zip(parts) {
        let impulse = force.map(|f| f * part * speed);
        match impulses.last_mut() {
            Some((last, sum)) if *last == i => {
                sum.iter_mut().zip(impulse).for_each(|(sum, add)| *sum += add);
            }
            _ => impulses.push((i, impulse)),
        }
    }
    impulses.retain(|(_, impulse)| impulse[1] > 0.0);
    impulses
}

impl Frozen {
    /// Impulses (tangential, normal) in the friction cones of these contacts that stop all motion; `None` if there are none.
    pub(crate) fn stopped_by(&self, closed: &[usize]) -> Option<Vec<(usize, [f64; 2])>> {
        let (space, friction, v) = (self.space(), &self.rows.friction, &self.v);
        let speed = v.norm();
        let edges: Vec<(usize, [f64; 2], Coordinates)> = closed
            .iter()
            .flat_map(|&i| [1.0, -1.0].map(|side| (i, [side * friction[i], 1.0])))
            .map(|(i, [t, n])| (i, [t, n], space.normal_row(i).scaled(n).plus(space.tangent(i), t)))
            .collect();
        let balance: Vec<(Vec<f64>, f64)> = v
            .iter()
            .enumerate()
            .map(|(k, part)| {
                let along = |edge: &Coordinates| edge.iter().nth(k).unwrap_or(0.0);
                (edges.iter().map(|(.., edge)| along(edge)).collect(), -part / speed)
            })
            .collect();
        let parts = maximise(&balance, &vec![-1.0; edges.len()])?;
        Some(by_contact(edges, &parts, speed))
    }
}

impl BodyState {
    /// Impulses (tangential, normal), per unit mass, in the friction cones of these points that bring the body to rest on their ground: those with the
    /// smallest sum of their parts along the edges of the cones. `None` if there are none.
    pub(crate) fn stopped_by(&self, closed: &[usize]) -> Option<Vec<(usize, [f64; 2])>> {
        // No velocity stops the slides over surfaces that do not move alike.
        let ground = self.velocity_of_ground(|_, i| closed.contains(&i))?;
        let (rho, v) = (self.rho2.sqrt(), self.center.v - ground);
        let motion = Vector3::new(v.x, v.y, rho * self.spin.omega);
        let speed = motion.norm();
        let edges = self.edges_of_cones(closed);
        let row = |k: usize| (edges.iter().map(|(.., u)| u[k]).collect(), -motion[k] / speed);
        let parts = maximise(&[row(0), row(1), row(2)], &vec![-1.0; edges.len()])?;
        Some(by_contact(edges, &parts, speed))
    }

    /// The edges of the friction cones of these points: the point, the force (tangential, normal), and its action in coordinates (x, y, ρθ).
    fn edges_of_cones(&self, closed: &[usize]) -> Vec<(usize, [f64; 2], Vector3<f64>)> {
        let rho = self.rho2.sqrt();
        closed
            .iter()
            .flat_map(|&i| [1.0, -1.0].map(|side| (i, [side * self.points[i].friction, 1.0])))
            .map(|(i, [f_t, f_n])| {
                let p = &self.points[i];
                let force = p.tangent * f_t + p.normal * f_n;
                let turn = (p.b * f_n - p.touching_c() * f_t) / rho;
                (i, [f_t, f_n], Vector3::new(force.x, force.y, turn))
            })
            .collect()
    }

    /// How long the points closed in these modes hold the body at rest on its ground while the acceleration a of free fall changes at its rate ȧ:
    /// the longest time t, in s, at most `left`, for which a + ȧ t is balanced by forces in the friction cones; at a contact that slides over a
    /// surface, along the edge of its cone. The loads that can be balanced are convex, so that all earlier ones are, too.
    pub(crate) fn holds_for(&self, modes: &[Mode], left: f64) -> f64 {
        let closed: ContactValues<usize> =
            (0..modes.len()).filter(|&i| modes[i] != Mode::Separate).collect();
        let mut edges = self.edges_of_cones(&closed);
        edges.retain(|(i, [f_t, _], _)| modes[*i].direction() * f_t <= 0.0);
        // The unknowns: parts of the edges, in units of the largest load, and the time and the rest of `left`, in units of `left`.
        let unit = self.gravity.max(self.fall_rate.norm() * left);
        let (load, rate) = (self.fall / unit, self.fall_rate * (left / unit));
        let row = |k: usize, load: f64, rate: f64| {
            let parts = edges.iter().map(|(.., u)| u[k]);
            (parts.chain([rate, 0.0]).collect::<Vec<f64>>(), -load)
        };
        let mut end = vec![0.0; edges.len()];
        end.extend([1.0, 1.0]);
        let rows = [row(0, load.x, rate.x), row(1, load.y, rate.y), row(2, 0.0, 0.0), (end, 1.0)];
        let mut objective = vec![0.0; edges.len() + 2];
        objective[edges.len()] = 1.0;
        maximise(&rows, &objective).map_or(0.0, |found| found[edges.len()].clamp(0.0, 1.0) * left)
    }

    /// Applies the impulse of a jam up to the first slide that it stops; returns this contact. `None`, without a change, if
    /// another event comes first.
    pub(crate) fn jams(&mut self, modes: &[Mode]) -> Option<usize> {
        let rows = self.independent(modes);
        // The test of the loads below holds for contacts whose normals do not turn.
        let turns = |i: usize| self.points[i].corner.is_some() || self.side_contact(i).is_some();
        if rows.iter().any(|row| turns(row.unknown.contact)) {
            return None;
        }
        let (n, rho) = (rows.len(), self.rho2.sqrt());
        // A force (tangential, normal), and its action in coordinates (x, y, ρθ).
        let force = |k: usize| {
            let i = rows[k].unknown.contact;
            if rows[k].unknown.tangential {
                [1.0, 0.0]
            } else {
                [-modes[i].direction() * self.points[i].friction, 1.0]
            }
        };
        let along = |k: usize| {
            let (p, [slope, _]) = (&self.points[rows[k].unknown.contact], force(k));
            let side = Vector3::new(p.tangent.x, p.tangent.y, -p.touching_c() / rho);
            if rows[k].unknown.tangential { rows[k].whole } else { rows[k].whole + side * slope }
        };
        let matrix = Matrix3::from_fn(|i, j| match (i < n, j < n) {
            (true, true) => rows[i].whole.dot(&along(j)) / (rows[i].whole.norm() * along(j).norm()),
            _ => f64::from(u8::from(i == j)),
        });
        let (left, right) = (annihilated(&matrix.transpose()), annihilated(&matrix));
        let normal = |k: &usize| !rows[*k].unknown.tangential;
        let sign = (0..n).filter(normal).map(|k| right[k]).sum::<f64>().signum();
        if (0..n).filter(normal).any(|k| sign * right[k] < 0.0) {
            return None;
        }
        let impulses: [f64; 3] =
            std::array::from_fn(|k| if k < n { sign * right[k] / along(k).norm() } else { 0.0 });
        let change: Vector3<f64> = (0..n).map(|k| along(k) * impulses[k]).sum();
        let turn = change.z / rho;
        let mut first: Option<(f64, usize)> = None;
        for (i, p) in self.points.iter().enumerate() {
            let slides = matches!(modes[i], Mode::Right | Mode::Left) && p.friction > 0.0;
            let slower = p.tangent.dot(&change.xy()) - p.touching_c() * turn;
            let until = -self.slip(i) / slower;
            if slides && until >= 0.0 && first.is_none_or(|(before, _)| until < before) {
                first = Some((until, i));
            }
        }
        let (size, stopped) = first?;
        // l·r is monotonic in ω²: it keeps its sign in between if it has the same sign at both ends and ω keeps its own.
        let omega = self.spin.omega;
        let pull = |omega: f64| -> f64 {
            let row = |k: usize| {
                let p = &self.points[rows[k].unknown.contact];
                let centripetal = if rows[k].unknown.tangential { p.b } else { p.c };
                let weight = -self.fall.dot(&rows[k].whole.xy());
                left[k] * (centripetal * omega * omega + weight) / rows[k].whole.norm()
            };
            (0..n).map(row).sum()
        };
        let after = omega + turn * size;
        let turns = |f: &dyn Fn(f64) -> f64| f(omega).signum() != f(after).signum();
        if turns(&|omega| omega) || turns(&pull) {
            return None;
        }
        let impulses: [[f64; 2]; 3] = std::array::from_fn(|k| {
            if k < n { force(k).map(|part| part * impulses[k] * size) } else { [0.0; 2] }
        });
        for (row, impulse) in rows.iter().zip(impulses) {
            self.apply_impulse(row.unknown.contact, impulse);
        }
        for (p, mode) in self.points.iter_mut().zip(modes) {
            if *mode != Mode::Separate {
                p.u = 0.0;
            }
        }
        Some(stopped)
    }
}

/// The unit vector x with Mx = 0 of a singular matrix M of rank two. It is orthogonal to all rows: the cross product of the two
/// most independent ones.
fn annihilated(matrix: &Matrix3<f64>) -> Vector3<f64> {
    let row = |i: usize| matrix.row(i).transpose();
    let products = [row(1).cross(&row(2)), row(2).cross(&row(0)), row(0).cross(&row(1))];
    let longest = |a: &Vector3<f64>, b: &Vector3<f64>| if b.norm() > a.norm() { *b } else { *a };
    products[1..].iter().fold(products[0], |a, b| longest(&a, b)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_singular_matrix_annihilates_its_vector() {
        for matrix in [
            Matrix3::new(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
            Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0),
            Matrix3::new(1.0, -1.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 1e-3),
        ] {
            for m in [matrix, matrix.transpose()] {
                let x = annihilated(&m);
                assert!((x.norm() - 1.0).abs() < 1e-15 && (m * x).amax() < 1e-14, "{m} {x}");
            }
        }
    }
}

//! Moreau's law for all contacts that are hit at one instant [Moreau 1988]; without friction it is Newton's.
//!
//! Let A be the contacts that take part, u⁻ = (u_t, u_n) their rates before the impact, and W their impact matrix:
//!
//! ```text
//! u⁺ = u⁻ + W P,   ξ_n = u_n⁺ + e u_n⁻,   ξ_t = u_t⁺ + e_t u_t⁻
//! ξ_n ≥ 0  ⊥  P_n ≥ 0,   −P_t ∈ μ P_n Sgn(ξ_t)            for every contact of A
//! ```
//!
//! As for contact modes, each contact has a letter: S (P = 0), F (ξ = 0) or R, L (ξ_n = 0, P_t = ∓μ P_n). A solution with the fewest
//! impulses satisfies a word of which the equations are independent, and all other conditions as inequalities that are not strict. So the
//! search needs no more impulses than the body has coordinates. Where rows depend on each other, these solutions are the corners of the
//! polytope of all impulses; the smallest impulse of the polytope is taken.
//!
//! With e_t = e the energy lost is (1−e)/(2(1+e)) |Δq̇|² + Σ μ P_n |ξ_t|/(1+e) ≥ 0, for any number of contacts with one e.

use smallvec::SmallVec;

use crate::body::contact::ContactValues;
use crate::impact::friction::{Material, Party};
use crate::impact::pivoting;
use crate::math::least_distance::nearest;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::tolerance::{DEPENDENT_IMPULSES, ONE_VELOCITY, ROWS_ALIKE, WITHIN_LAW};

/// Largest number of contacts whose words are all tried: 700 words of a body, with three coordinates, and 4⁸ of a mechanism.
const MOST_TRIED: usize = 8;

/// The same of a mechanism, unless pivoting finds no word.
const FEW_TRIED: usize = 4;

/// The warning of a run in which the law of simultaneous impacts left a choice.
pub(crate) const SEVERAL: &str = "the law of impact allowed several velocities after contacts were hit together; the one with the least kinetic energy was taken";

/// The warning of a run in which the law had no solution.
pub(crate) const NONE_TOGETHER: &str = "the law of impact has no solution for all contacts that were hit together, because friction can press them against each other; they were hit one after the other";

/// The impact.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Together {
    /// Impulses (tangential, normal).
    pub(crate) impulses: ContactValues<[f64; 2]>,
    /// Contacts with u_n⁺ = −e u_n⁻.
    pub(crate) hit: ContactValues<bool>,
    /// Whether the law allows several velocities after the impact, of which this one has the least kinetic energy.
    pub(crate) several: bool,
}

/// What a contact does: S (P = 0), F (ξ = 0), or it slides with this sign of ξ_t.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Letter {
    Separate,
    Fixed,
    Slides(f64),
}

/// The contacts with zero gap that approach, and after them those at rest; `contacts`: the gap (m) and the rate (m/s) of each.
pub(crate) fn all_closed(
    contacts: impl Iterator<Item = (f64, f64)> + Clone,
) -> ContactValues<usize> {
    let closed = |takes_part: fn(f64) -> bool| {
        let all = contacts.clone().enumerate();
        all.filter(move |(_, (h, u))| *h == 0.0 && takes_part(*u)).map(|(i, _)| i)
    };
    closed(|u| u < 0.0).chain(closed(|u| u == 0.0)).collect()
}

/// Of many contacts those that make the impact, with the same velocities after it. `rows`: (tangential, normal) of each, in the metric of the mass.
///
/// Let contacts of one material have one tangential row, and normal rows N_j = w_j N_i + (1 − w_j) N_k with 0 ≤ w_j ≤ 1, as the feet of a straight
/// sole on one line of ground. Then the same holds for ξ_n,j, which is positive where those of the two outer contacts i and k are, and ξ_t is one
/// for all. Impulses of the inner contacts, which are in the friction cone with the sign of one slip, act as impulses w_j P_j and (1 − w_j) P_j of
/// the outer ones do; where an inner contact has an impulse, ξ_n,j = 0, so that both outer contacts have ξ_n = 0 or the weight 0.
///
/// Of each inner contact the two outer ones; `None`: it is no inner one. Of a few contacts none is an inner one.
pub(crate) fn between(
    materials: &[Material],
    rows: &[Coordinates],
) -> ContactValues<Option<[usize; 2]>> {
    let mut between = ContactValues::from_elem(None, materials.len());
    if materials.len() <= MOST_TRIED {
        return between;
    }
    let mut taken = ContactValues::from_elem(false, materials.len());
    for i in 0..materials.len() {
        if taken[i] {
            continue;
        }
        let [tangent, normal] = [&rows[2 * i], &rows[2 * i + 1]];
        let near = ROWS_ALIKE * (tangent.norm() + normal.norm());
        let alike = |j: &usize| {
            !taken[*j]
                && materials[*j] == materials[i]
                && rows[2 * j].plus(tangent, -1.0).norm() <= near
        };
        let step = |j: usize| rows[2 * j + 1].plus(normal, -1.0);
        let alike: ContactValues<usize> = (i..materials.len()).filter(alike).collect();
        let far = alike.iter().copied().max_by(|&j, &k| step(j).norm().total_cmp(&step(k).norm()));
        let Some(way) = far.map(step).filter(|way| way.norm() > near) else { continue };
        let way = way.divided(way.norm());
        let place = |j: usize| way.dot(&step(j));
        let is_on = |j: &usize| step(*j).plus(&way, -place(*j)).norm() <= near;
        let line: ContactValues<usize> = alike.iter().copied().filter(is_on).collect();
        let by_place = |j: &&usize, k: &&usize| place(**j).total_cmp(&place(**k));
        let ends = [line.iter().min_by(by_place), line.iter().max_by(by_place)];
        let [Some(&first), Some(&last)] = ends else { continue };
        for j in line {
            taken[j] = true;
            between[j] = (j != first && j != last).then_some([first, last]);
        }
    }
    between
}

/// The law for these contacts. `w`: entries of the impact matrix, contact by contact (tangential, normal), per unit of impulse;
/// `coordinates`: number of coordinates of the body, at least the rank of W. `None` if no solution is found. There is one unless forces in
/// the friction cones can press the contacts against each other (a wedge).
pub(crate) fn together(
    parties: &[Party],
    w: impl Fn(usize, usize) -> f64,
    coordinates: usize,
) -> Option<Together> {
    let size = 2 * parties.len();
    let w: SmallVec<[f64; 64]> = (0..size * size).map(|k| w(k / size, k % size)).collect();
    let law = Law { parties, w: &w };
    let most = if coordinates <= 3 { MOST_TRIED } else { FEW_TRIED };
    let mut found = Vec::new();
    if parties.len() > most {
        found.extend(law.pivoted());
    }
    if found.is_empty() && parties.len() <= MOST_TRIED {
        law.try_words(&mut Word::new(), coordinates, &mut found);
    }
    law.choose(&found)
}

type Word = ContactValues<Letter>;
type Impulses = ContactValues<[f64; 2]>;

struct Law<'a> {
    parties: &'a [Party],
    w: &'a [f64],
}

/// An unknown impulse: of this contact, with the tangential and the normal part of one unit; its equation is ξ_t = 0 or ξ_n = 0.
struct Unknown {
    contact: usize,
    unit: [f64; 2],
    equation: usize,
}

impl Law<'_> {
    fn w(&self, row: usize, column: usize) -> f64 {
        self.w[row * 2 * self.parties.len() + column]
    }

    /// One solution, by pivoting; its word is solved exactly.
    fn pivoted(&self) -> Option<Impulses> {
        pivoting::solutions(self.parties, self.w)
            .filter_map(|impulses| self.solve(&self.word_of(&impulses)))
            .find(|impulses| self.holds(impulses))
    }

    /// Adds the solutions of all words that begin with this one and have at most `room` more unknowns.
    fn try_words(&self, word: &mut Word, room: usize, found: &mut Vec<Impulses>) {
        let Some(next) = self.parties.get(word.len()) else {
            found.extend(self.solve(word).filter(|impulses| self.holds(impulses)));
            return;
        };
        let letters: &[(Letter, usize)] = if next.material.friction > 0.0 {
            &[
                (Letter::Separate, 0),
                (Letter::Fixed, 2),
                (Letter::Slides(1.0), 1),
                (Letter::Slides(-1.0), 1),
            ]
        } else {
            &[(Letter::Separate, 0), (Letter::Slides(1.0), 1)]
        };
        for (letter, unknowns) in letters {
            if *unknowns <= room {
                word.push(*letter);
                self.try_words(word, room - unknowns, found);
                word.pop();
            }
        }
    }

    /// The impulses of a word; `None` if its equations depend on each other.
    fn solve(&self, word: &[Letter]) -> Option<Impulses> {
        let mut unknowns: SmallVec<[Unknown; 8]> = SmallVec::new();
        for (contact, letter) in word.iter().enumerate() {
            let mu = self.parties[contact].material.friction;
            let (tangential, normal) = (2 * contact, 2 * contact + 1);
            match letter {
                Letter::Separate => {}
                Letter::Fixed => {
                    unknowns.push(Unknown { contact, unit: [1.0, 0.0], equation: tangential });
                    unknowns.push(Unknown { contact, unit: [0.0, 1.0], equation: normal });
                }
                Letter::Slides(side) => {
                    unknowns.push(Unknown { contact, unit: [-side * mu, 1.0], equation: normal });
                }
            }
        }
        let n = unknowns.len();
        let mut system: SmallVec<[f64; 96]> = SmallVec::with_capacity(n * (n + 1));
        for row in &unknowns {
            let k = row.equation;
            for Unknown { contact, unit, .. } in &unknowns {
                system
                    .push(unit[0] * self.w(k, 2 * contact) + unit[1] * self.w(k, 2 * contact + 1));
            }
            system.push(-self.parties[row.contact].needs()[k % 2]);
        }
        // Rows have the length √W_kk.
        for (k, row) in unknowns.iter().enumerate() {
            let length = self.w(row.equation, row.equation).sqrt();
            system[k * (n + 1)..][..=n].iter_mut().for_each(|entry| *entry /= length);
        }
        let sizes: SmallVec<[f64; 8]> =
            unknowns.iter().map(|u| self.w(u.equation, u.equation).sqrt()).collect();
        eliminate(&mut system, n, &sizes)?;
        let mut impulses: Impulses = ContactValues::from_elem([0.0; 2], self.parties.len());
        for (k, Unknown { contact, unit, .. }) in unknowns.iter().enumerate() {
            let size = system[k * (n + 1) + n];
            impulses[*contact][0] += unit[0] * size;
            impulses[*contact][1] += unit[1] * size;
        }
        Some(impulses)
    }

    /// ξ of an equation, and the size of its terms.
    fn xi(&self, impulses: &[[f64; 2]], equation: usize) -> (f64, f64) {
        let need = self.parties[equation / 2].needs()[equation % 2];
        let terms = impulses.iter().flatten().enumerate();
        terms.fold((need, need.abs()), |(sum, size), (k, impulse)| {
            let term = self.w(equation, k) * impulse;
            (sum + term, size + term.abs())
        })
    }

    /// Whether the impulses satisfy the law, within rounding errors.
    fn holds(&self, impulses: &[[f64; 2]]) -> bool {
        (0..self.parties.len()).all(|i| {
            let mu = self.parties[i].material.friction;
            let ([p_t, p_n], (normal, terms)) = (impulses[i], self.xi(impulses, 2 * i + 1));
            let (slip, slips) = self.xi(impulses, 2 * i);
            let rounding = WITHIN_LAW * terms;
            let least = rounding / self.w(2 * i + 1, 2 * i + 1);
            if p_n == 0.0 && p_t == 0.0 {
                return normal >= -rounding;
            }
            let limit = mu * p_n;
            let is_slow = slip.abs() <= WITHIN_LAW * slips;
            normal.abs() <= rounding
                && p_n >= -least
                && p_t.abs() <= limit + (1.0 + mu) * least
                && (is_slow || (p_t + slip.signum() * limit).abs() <= (1.0 + mu) * least)
        })
    }

    /// The letters of impulses that satisfy the law.
    fn word_of(&self, impulses: &[[f64; 2]]) -> Word {
        let letter = |(party, [p_t, p_n]): (&Party, &[f64; 2])| {
            let mu = party.material.friction;
            if *p_n == 0.0 {
                Letter::Separate
            } else if *p_t == 0.0 {
                Letter::Slides(0.0) // another contact with the same tangential row stops it
            } else if p_t.abs() < mu * p_n * (1.0 - WITHIN_LAW) {
                Letter::Fixed
            } else {
                Letter::Slides(if *p_t > 0.0 { -1.0 } else { 1.0 })
            }
        };
        self.parties.iter().zip(impulses).map(letter).collect()
    }

    /// Of these solutions those with the least kinetic energy, and of their impulses the smallest.
    fn choose(&self, found: &[Impulses]) -> Option<Together> {
        let after = |impulses: &Impulses| -> SmallVec<[f64; 16]> {
            let before = self.parties.iter().flat_map(|party| party.before);
            let moved = |k: usize| {
                impulses.iter().flatten().enumerate().map(|(l, p)| self.w(k, l) * p).sum::<f64>()
            };
            before.enumerate().map(|(k, u)| u + moved(k)).collect()
        };
        let ends: Vec<_> = found.iter().map(after).collect();
        // ½ P·(u⁻ + u⁺)
        let gain = |k: usize| {
            let before = self.parties.iter().flat_map(|party| party.before);
            let means = before.zip(&ends[k]).map(|(u, end)| 0.5 * (u + end));
            found[k].iter().flatten().zip(means).map(|(p, u)| p * u).sum::<f64>()
        };
        let least = (0..found.len()).min_by(|&a, &b| gain(a).total_cmp(&gain(b)))?;
        let starts = self.parties.iter().flat_map(|party| party.before);
        let speed = starts.fold(0.0_f64, |most, u| most.max(u.abs()));
        let is_same = |k: &usize| {
            let mut pairs = ends[*k].iter().zip(&ends[least]);
            pairs.all(|(one, other)| (one - other).abs() <= ONE_VELOCITY * speed)
        };
        let corners: Vec<Vec<f64>> = (0..found.len())
            .filter(is_same)
            .map(|k| found[k].iter().flatten().copied().collect())
            .collect();
        let impulses = match smallest(&corners) {
            Some(smallest) => smallest.chunks_exact(2).map(|p| [p[0], p[1].max(0.0)]).collect(),
            None => found[least].clone(),
        };
        let closed = |i: usize| {
            let (normal, terms) = self.xi(&impulses, 2 * i + 1);
            impulses[i][1] > 0.0 || normal.abs() <= WITHIN_LAW * terms
        };
        let hit = (0..self.parties.len()).map(closed).collect();
        Some(Together { hit, several: corners.len() < found.len(), impulses })
    }
}

/// The smallest point of the hull of these points; `None` if there is only one.
///
/// With p_k·x ≥ |x|² at the smallest point x, z = x/|x|² is the smallest point of {z: p_k·z ≥ 1}.
fn smallest(corners: &[Vec<f64>]) -> Option<Vec<f64>> {
    let size = corners.iter().flatten().fold(0.0_f64, |most, p| most.max(p.abs()));
    let near = |other: &Vec<f64>| {
        corners[0].iter().zip(other).all(|(a, b)| (a - b).abs() <= ONE_VELOCITY * size)
    };
    if corners.iter().skip(1).all(near) {
        return None;
    }
    let scaled: Vec<Vec<f64>> =
        corners.iter().map(|p| p.iter().map(|p| p / size).collect()).collect();
    let z = nearest(&scaled, &vec![1.0; scaled.len()])?;
    let square: f64 = z.iter().map(|z| z * z).sum();
    Some(z.iter().map(|z| z / square * size).collect())
}

/// Gaussian elimination with pivoting in `n` rows of n + 1 entries, the right-hand side last, which becomes the solution; `None` if a
/// pivot is small beside `sizes`, those of the columns.
fn eliminate(m: &mut [f64], n: usize, sizes: &[f64]) -> Option<()> {
    let width = n + 1;
    for k in 0..n {
        let entry = |i: usize| m[i * width + k].abs();
        let pivot = (k..n).max_by(|&i, &j| entry(i).total_cmp(&entry(j)))?;
        if entry(pivot) <= DEPENDENT_IMPULSES * sizes[k] {
            return None;
        }
        for l in 0..width {
            m.swap(k * width + l, pivot * width + l);
        }
        for i in k + 1..n {
            let factor = m[i * width + k] / m[k * width + k];
            for l in k..width {
                m[i * width + l] -= factor * m[k * width + l];
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|l| m[k * width + l] * m[l * width + n]).sum();
        m[k * width + n] = (m[k * width + n] - known) / m[k * width + k];
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::impact::friction::Material;
    use crate::math::random::Random;

    /// A contact of a body of 1 kg with ρ = 1: (t, −c) and (n, b).
    type Rows = [[f64; 3]; 2];

    fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    fn material(friction: f64, restitution: f64, tangential_restitution: f64) -> Material {
        Material { friction, restitution, tangential_restitution }
    }

    /// The velocity after the impact of contacts with these rows and coefficients.
    fn after(rows: &[Rows], materials: &[Material], v: [f64; 3]) -> ([f64; 3], Together) {
        let parties: Vec<Party> = rows
            .iter()
            .zip(materials)
            .map(|(r, m)| Party { before: [dot(&r[0], &v), dot(&r[1], &v)], material: *m })
            .collect();
        let row = |k: usize| &rows[k / 2][k % 2];
        let found = together(&parties, |k, l| dot(row(k), row(l)), 3).expect("a solution");
        let mut end = v;
        for (r, p) in rows.iter().zip(&found.impulses) {
            for k in 0..3 {
                end[k] += p[0] * r[0][k] + p[1] * r[1][k];
            }
        }
        (end, found)
    }

    /// Both lower corners of a uniform box, in the coordinates (x, y, ρθ).
    fn corners(width: f64, height: f64) -> Vec<Rows> {
        let rho = ((width * width + height * height) / 12.0).sqrt();
        let row =
            |side: f64| [[1.0, 0.0, 0.5 * height / rho], [0.0, 1.0, side * 0.5 * width / rho]];
        vec![row(-1.0), row(1.0)]
    }

    #[test]
    fn a_box_on_both_lower_corners() {
        // Width, height, μ, e, velocity (ẋ, ẏ, θ̇) before and after; by hand.
        let cases = [
            (1.0, 1.0, 0.3, [0.0, -1.0, 0.0], [0.0, 0.3, 0.0]),
            (1.0, 1.0, 0.3, [1.0, -1.0, 0.0], [0.35, 0.3, 0.0]),
            (1.0, 1.0, 0.3, [0.1, -1.0, 0.0], [0.0, 0.3, 0.0]),
            (1.0, 3.0, 0.0, [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]),
            (1.0, 3.0, 0.3, [0.2, -1.0, 0.0], [0.0, 0.3, 0.0]),
            (2.0, 1.0, 0.5, [1.0, -1.0, 0.1], [0.25, 0.5, -0.05]),
            (2.0, 1.0, 0.5, [1.0, -1.0, -0.1], [0.25, 0.5, 0.05]),
        ];
        for (width, height, e, before, expected) in cases {
            let rho = ((width * width + height * height) / 12.0_f64).sqrt();
            let v = [before[0], before[1], rho * before[2]];
            let (end, found) = after(&corners(width, height), &[material(0.5, e, 0.0); 2], v);
            let end = [end[0], end[1], end[2] / rho];
            for (one, other) in end.iter().zip(expected) {
                assert!((one - other).abs() < 1e-15, "{width} {height} {before:?}: {end:?}");
            }
            assert!(
                !found.several && found.hit.iter().all(|hit| *hit),
                "{width} {height} {before:?}: {found:?}"
            );
        }
    }

    #[test]
    fn of_three_feet_on_a_line_each_takes_its_share() {
        // Least Σ P² with ΣP = 1, Σ x P = 0 for feet at −1, 0, 1: a third each.
        let row = |x: f64| [[1.0, 0.0, 1.0], [0.0, 1.0, x]];
        let feet = [row(-1.0), row(0.0), row(1.0)];
        let (end, found) = after(&feet, &[material(0.5, 0.0, 0.0); 3], [0.0, -1.0, 0.0]);
        assert!(
            found.impulses.iter().all(|p| p[0].abs() < 1e-15 && (p[1] - 1.0 / 3.0).abs() < 1e-14)
        );
        assert!(end.iter().all(|v| v.abs() < 1e-15), "{end:?}");
    }

    /// Random contacts of bodies of any number of coordinates: pivoting finds a velocity that the search of all words finds, but in a few cases.
    /// Contacts with different restitutions that can be pressed against each other may have none.
    #[test]
    fn pivoting_agrees_with_the_search_of_all_words() {
        let mut random = Random(5);
        let (mut cases, mut several, mut none, mut rays) = (0, 0, 0, 0);
        for case in 0..4000 {
            let (n, dof) = (1 + case % 4, 2 + case / 4 % 5);
            let shared = case % 3 == 0;
            let mut rows: Vec<Vec<f64>> =
                (0..2 * n).map(|_| (0..dof).map(|_| random.between(-1.0, 1.0)).collect()).collect();
            if shared && n > 1 {
                rows[2] = rows[0].clone(); // contacts of one flat foot
            }
            let v: Vec<f64> = (0..dof).map(|_| random.between(-1.0, 1.0)).collect();
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let rests = case % 5 == 0;
            let parties: Vec<Party> = (0..n)
                .map(|i| {
                    let rate = product(&rows[2 * i + 1], &v);
                    if rate > 0.0 {
                        rows[2 * i + 1].iter_mut().for_each(|x| *x = -*x);
                    }
                    let rate = if rests && i == 0 { 0.0 } else { -rate.abs() };
                    let e = random.between(0.0, 0.9);
                    let material =
                        material(1.2 * random.next(), e, if case % 2 == 0 { e } else { 0.0 });
                    Party { before: [product(&rows[2 * i], &v), rate], material }
                })
                .collect();
            let w = |k: usize, l: usize| product(&rows[k], &rows[l]);
            let Some(found) = together(&parties, w, dof) else {
                none += 1;
                continue;
            };
            let table: Vec<f64> = (0..4 * n * n).map(|k| w(k / (2 * n), k % (2 * n))).collect();
            let law = Law { parties: &parties, w: &table };
            let Some(exact) = law.pivoted() else {
                rays += 1;
                continue;
            };
            let moved = |impulses: &[[f64; 2]]| -> Vec<f64> {
                (0..2 * n)
                    .map(|k| impulses.iter().flatten().enumerate().map(|(l, p)| w(k, l) * p).sum())
                    .collect()
            };
            let (one, two) = (moved(&found.impulses), moved(&exact));
            let same = one.iter().zip(&two).all(|(a, b)| (a - b).abs() < 1e-8);
            assert!(same || found.several, "{case}: {found:?} {exact:?}");
            cases += 1;
            several += usize::from(found.several);
        }
        assert!(
            cases > 3800 && several < 400 && none < 150 && rays < 20,
            "{cases} {several} {none} {rays}"
        );
    }
}

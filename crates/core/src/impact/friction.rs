//! Laws of impact with friction at a single contact. Each law has a closed form.
//!
//! With v = (v_t, v_n) before the impact, the impulse P per unit mass and the impact matrix W = [w_tt, w_nt; w_nt, w_nn] of the contact, v⁺
//! = v + W P. In Routh's process P grows gradually. p is its normal part, and Coulomb's law holds at every p:
//!
//! ```text
//! slides (σ = sign v_t):   dv_t/dp = w_nt − σμ w_tt,   dv_n/dp = w_nn − σμ w_nt,      P_t' = −σμ
//! sticks (|w_nt| ≤ μ w_tt): dv_t/dp = 0,               dv_n/dp = w_nn − w_nt²/w_tt,   P_t' = −w_nt/w_tt
//! ```
//!
//! So v_n(p) has at most two straight pieces, of which the second one rises. It has one zero p_c, the end of compression.

use crate::options::Impact;
use crate::tolerance::{ENERGY_GAIN, GAIN_ROUNDINGS, JAMMED_SLIDE, STILL};

/// The warning of a run with [`Impact::Newton`] in which a contact with friction is hit.
pub(crate) const NO_FRICTION: &str = "friction acts between impacts only: a contact with friction was hit, and impact = \"newton\" has no friction in impacts; the default \"auto\", \"poisson\", \"stronge\", \"chatterjee-ruina\" and \"moreau\" have it";

/// The warning of a run in which an impact raised the kinetic energy.
const GAINS: &str = "energy-gain: an impact raised the kinetic energy; Moreau's law may where restitution and tangential_restitution differ, and Newton's where contacts have different restitution; \"poisson\" and \"stronge\" do not";

/// Warns, once, if an impact raised the kinetic energy T by more than its rounding error: √(2T) `before` and `after` it, for unit mass, and the
/// largest speed so far, whose rounding error is in both; in m/s.
pub(crate) fn watch_energy(warnings: &mut Vec<String>, [before, after]: [f64; 2], fastest: f64) {
    let gains = after - before > ENERGY_GAIN * before + GAIN_ROUNDINGS * f64::EPSILON * fastest;
    if gains && !warnings.iter().any(|warning| warning == GAINS) {
        warnings.push(GAINS.into());
    }
}

/// Impact matrix of a contact, per unit mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Matrix {
    pub(crate) nn: f64,
    pub(crate) nt: f64,
    pub(crate) tt: f64,
}

/// Coefficients of friction and restitution of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Material {
    pub(crate) friction: f64,
    pub(crate) restitution: f64,
    pub(crate) tangential_restitution: f64,
}

impl Material {
    /// The coefficients that act in impacts by this law: Newton's has no friction.
    pub(crate) fn in_impacts(self, law: Impact) -> Self {
        let friction = if law == Impact::Newton { 0.0 } else { self.friction };
        Self { friction, ..self }
    }
}

/// A straight piece of Routh's process: slopes of v_n and of P_t.
#[derive(Debug, Clone, Copy)]
struct Piece {
    rise: f64,
    tangential: f64,
}

/// A contact that takes part in an impact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Party {
    /// (u_t, u_n) before the impact, u_n ≤ 0, in m/s.
    pub(crate) before: [f64; 2],
    pub(crate) material: Material,
}

impl Party {
    /// ξ (tangential, normal) without impulses.
    pub(crate) fn needs(&self) -> [f64; 2] {
        let Material { restitution: e, tangential_restitution: e_t, .. } = self.material;
        [(1.0 + e_t) * self.before[0], (1.0 + e) * self.before[1]]
    }
}

/// Routh's process: one straight piece up to the normal impulse `change`, and another one from there on.
#[derive(Debug, Clone, Copy)]
struct Process {
    first: Piece,
    change: f64,
    second: Piece,
    /// v_n before the impact.
    start: f64,
}

impl Process {
    fn new(w: &Matrix, [v_t, v_n]: [f64; 2], mu: f64) -> Self {
        let sliding = |side: f64| Piece { rise: w.nn - side * mu * w.nt, tangential: -side * mu };
        let sticks = w.nt.abs() <= mu * w.tt;
        let stopped = if sticks && w.tt > 0.0 {
            Piece { rise: w.nn - w.nt * w.nt / w.tt, tangential: -w.nt / w.tt }
        } else {
            sliding(1.0_f64.copysign(w.nt))
        };
        let (first, change) = if v_t == 0.0 {
            (stopped, 0.0)
        } else {
            let side = 1.0_f64.copysign(v_t);
            let slope = w.nt - side * mu * w.tt;
            // The sliding speed grows, or never reaches zero.
            let stop = if side * slope < 0.0 { -v_t / slope } else { f64::INFINITY };
            (sliding(side), stop)
        };
        Self { first, change, second: stopped, start: v_n }
    }

    /// v_n at the change of pieces.
    fn at_change(&self) -> f64 {
        if self.change == 0.0 { self.start } else { self.start + self.first.rise * self.change }
    }

    /// p_c, the zero of v_n.
    fn compression(&self) -> f64 {
        let zero = -self.start / self.first.rise;
        if self.first.rise > 0.0 && zero <= self.change {
            zero
        } else {
            self.change - self.at_change() / self.second.rise
        }
    }

    /// (P_t, P_n) at the normal impulse `p`.
    fn impulse(&self, p: f64) -> [f64; 2] {
        let before = p.min(self.change);
        let after = (p - self.change).max(0.0);
        [self.first.tangential * before + self.second.tangential * after, p]
    }

    /// ∫ v_n dp from 0 to `p`.
    fn work(&self, p: f64) -> f64 {
        let before = p.min(self.change);
        let after = (p - self.change).max(0.0);
        let first = before * (self.start + 0.5 * self.first.rise * before);
        if after > 0.0 {
            first + after * (self.at_change() + 0.5 * self.second.rise * after)
        } else {
            first
        }
    }

    /// The normal impulse p ≥ p_c at which v_n has done the work `target` ≥ 0 since p_c.
    fn restitution(&self, p_c: f64, target: f64) -> f64 {
        let straight = |v: f64, rise: f64, work: f64| {
            // v x + ½ rise x² = work
            2.0 * work / (v + (v * v + 2.0 * rise * work).sqrt())
        };
        if target == 0.0 {
            return p_c;
        }
        if p_c >= self.change {
            return p_c + straight(0.0, self.second.rise, target);
        }
        let to_change = self.work(self.change) - self.work(p_c);
        if !(to_change < target) {
            return p_c + straight(0.0, self.first.rise, target);
        }
        self.change + straight(self.at_change(), self.second.rise, target - to_change)
    }
}

/// The impulse (P_t, P_n), per unit mass, of a contact that approaches with v = (v_t, v_n), v_n < 0; `None` where the
/// law has no solution.
pub(crate) fn impulse(
    law: Impact,
    w: &Matrix,
    v: [f64; 2],
    material: &Material,
) -> Option<[f64; 2]> {
    let Material { friction: mu, restitution: e, tangential_restitution: e_t } = *material;
    let [v_t, v_n] = v;
    match law {
        Impact::Auto | Impact::Newton => Some([0.0, -(1.0 + e) * v_n / w.nn]),
        Impact::Poisson => {
            let process = Process::new(w, v, mu);
            Some(process.impulse((1.0 + e) * process.compression()))
        }
        Impact::Stronge => {
            // Work of the normal force in restitution: −e² times that in compression.
            let process = Process::new(w, v, mu);
            let p_c = process.compression();
            Some(process.impulse(process.restitution(p_c, -e * e * process.work(p_c))))
        }
        Impact::ChatterjeeRuina => {
            // P_I stops the normal motion alone, P_II all motion; P = (1+e)P_I + κ(P_II − P_I), κ ≤ 1 + e_t, in the cone.
            let normal = -v_n / w.nn;
            let stick = inverse(w, [-v_t, -v_n]);
            let (t, n) = (stick[0], stick[1] - normal);
            let whole = [(1.0 + e_t) * t, (1.0 + e) * normal + (1.0 + e_t) * n];
            if whole[0].abs() <= mu * whole[1] {
                return Some(whole);
            }
            let kappa = mu * (1.0 + e) * normal / (t.abs() - mu * n);
            Some([kappa * t, (1.0 + e) * normal + kappa * n])
        }
        Impact::Moreau => {
            let stick = inverse(w, [-(1.0 + e_t) * v_t, -(1.0 + e) * v_n]);
            if stick[0].abs() <= mu * stick[1] {
                return Some(stick);
            }
            // σ = sign of v_t⁺ + e_t v_t⁻
            [1.0, -1.0].into_iter().find_map(|side| {
                let rise = w.nn - side * mu * w.nt;
                let p = -(1.0 + e) * v_n / rise;
                let after = v_t + w.nt * p - side * mu * w.tt * p;
                (p > 0.0 && side * (after + e_t * v_t) >= 0.0).then_some([-side * mu * p, p])
            })
        }
    }
}

/// The direction in which a contact slides that is hit by this impulse; 0 if friction stops it.
pub(crate) fn slides_in_impact([p_t, p_n]: [f64; 2], mu: f64) -> f64 {
    if p_t.abs() < (1.0 - STILL) * mu * p_n { 0.0 } else { -p_t.signum() }
}

/// The impulse (P_t, P_n), per unit mass, of a contact that slides at v_t without approaching and would be pulled into the terrain by its
/// normal force (w_nn − σμ w_nt < 0, Painlevé): an impact without collision. Compression begins although v_n = 0, and continues after
/// sliding has ended. `None` if w_nn − σμ w_nt ≥ 0, or if the law is not based on Routh's process.
pub(crate) fn jam(law: Impact, w: &Matrix, v_t: f64, material: &Material) -> Option<[f64; 2]> {
    let Material { friction: mu, restitution: e, .. } = *material;
    let mut process = Process::new(w, [v_t, 0.0], mu);
    if v_t == 0.0 || process.first.rise > JAMMED_SLIDE * w.nn {
        return None;
    }
    process.first.rise = process.first.rise.min(0.0);
    let p_c = process.compression();
    match law {
        Impact::Poisson => Some(process.impulse((1.0 + e) * p_c)),
        Impact::Stronge => {
            Some(process.impulse(process.restitution(p_c, -e * e * process.work(p_c))))
        }
        _ => None,
    }
}

/// The impulse (P_t, P_n), per unit mass, of such a contact that only stops it: (P_t, P_n) = −W⁻¹(v_t, 0). It is in the friction cone if the
/// contact jams, because |P_t|/P_n = w_nn/|w_nt| ≤ μ. `None` if the contact does not jam.
pub(crate) fn plastic_jam(w: &Matrix, v_t: f64, mu: f64) -> Option<[f64; 2]> {
    let rise = Process::new(w, [v_t, 0.0], mu).first.rise;
    (v_t != 0.0 && rise <= JAMMED_SLIDE * w.nn).then(|| inverse(w, [-v_t, 0.0]))
}

/// The impulse that changes the velocity by `change` (tangential, normal).
fn inverse(w: &Matrix, change: [f64; 2]) -> [f64; 2] {
    let det = w.nn * w.tt - w.nt * w.nt; // > 0: the rows of a contact are independent
    [(w.nn * change[0] - w.nt * change[1]) / det, (w.tt * change[1] - w.nt * change[0]) / det]
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Impact; 4] =
        [Impact::Poisson, Impact::Stronge, Impact::ChatterjeeRuina, Impact::Moreau];

    fn after(w: &Matrix, v: [f64; 2], p: [f64; 2]) -> [f64; 2] {
        [v[0] + w.tt * p[0] + w.nt * p[1], v[1] + w.nt * p[0] + w.nn * p[1]]
    }

    /// Change of the kinetic energy per unit mass: P·(v + v⁺)/2.
    fn gain(w: &Matrix, v: [f64; 2], p: [f64; 2]) -> f64 {
        let end = after(w, v, p);
        0.5 * (p[0] * (v[0] + end[0]) + p[1] * (v[1] + end[1]))
    }

    /// The rod of Painlevé with sides 3, 4, 5 and μ = 2: W = [2.92, −1.44; −1.44, 2.08]. From v_t = −1 sliding stops at
    /// p = 1/4.4, with v_n = −0.8 p; then it sticks.
    #[test]
    fn an_impact_without_collision() {
        let w = Matrix { nn: 2.08, nt: -1.44, tt: 2.92 };
        let (stop, rise) = (1.0 / 4.4, 2.08 - 1.44 * 1.44 / 2.92);
        let p_c = stop + 0.8 * stop / rise;
        for (e, law) in [(0.0, Impact::Poisson), (0.5, Impact::Poisson), (0.5, Impact::Stronge)] {
            let p = jam(law, &w, -1.0, &material(2.0, e)).unwrap();
            let end = after(&w, [-1.0, 0.0], p);
            // Stronge: ½ rise x² = e² ½ (0.8 stop)(p_c)
            let back =
                if law == Impact::Poisson { e * p_c } else { e * (0.8 * stop * p_c / rise).sqrt() };
            assert!((p[1] - p_c - back).abs() < 1e-15, "{p:?}");
            assert!((end[1] - rise * back).abs() < 1e-15 && end[0].abs() < 1e-15, "{end:?}");
            assert!(gain(&w, [-1.0, 0.0], p) < 0.0);
        }
        assert_eq!(jam(Impact::Poisson, &w, 1.0, &material(2.0, 0.5)), None);
        assert_eq!(jam(Impact::Moreau, &w, -1.0, &material(2.0, 0.5)), None);
        assert_eq!(jam(Impact::Poisson, &w, -1.0, &material(1.0, 0.5)), None);
    }

    fn material(friction: f64, restitution: f64) -> Material {
        Material { friction, restitution, tangential_restitution: 0.0 }
    }

    /// Newton's restitution v_n⁺ = −e v_n at the end of Routh's process.
    fn newton_with_friction(w: &Matrix, v: [f64; 2], material: &Material) -> [f64; 2] {
        let process = Process::new(w, v, material.friction);
        let end = -material.restitution * v[1];
        let p = (end - process.start) / process.first.rise;
        process.impulse(if process.first.rise > 0.0 && p <= process.change {
            p
        } else {
            process.change + (end - process.at_change()) / process.second.rise
        })
    }

    /// The uniform rod at 45°, e = μ = 1: energy at the contact ½ v·W⁻¹v goes from 1/5 to 5/16 by Newton's restitution.
    #[test]
    fn newtons_restitution_with_friction_gains_energy() {
        let w = Matrix { nn: 2.5, nt: 1.5, tt: 2.5 };
        let energy = |v: [f64; 2]| {
            let p = inverse(&w, v);
            0.5 * (p[0] * v[0] + p[1] * v[1])
        };
        let v = [-0.6, -1.0];
        let end = after(&w, v, newton_with_friction(&w, v, &material(1.0, 1.0)));
        assert!((energy(v) - 0.2).abs() < 1e-15);
        assert!((energy(end) - 5.0 / 16.0).abs() < 1e-15, "{end:?}");
        for law in [Impact::Poisson, Impact::Stronge, Impact::ChatterjeeRuina] {
            let p = impulse(law, &w, v, &material(1.0, 0.999_999)).unwrap();
            assert!(gain(&w, v, p) <= 1e-15, "{law:?}");
        }
    }

    /// Random impacts: impulses in the cone, energy never gained, and Newton's law without friction.
    #[test]
    fn laws_keep_their_promises() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / 9_007_199_254_740_992.0
        };
        for _ in 0..400_000 {
            let (nn, tt) = (0.2 + 3.0 * random(), 0.2 + 3.0 * random());
            let nt = (2.0 * random() - 1.0) * 0.999 * f64::sqrt(nn * tt);
            let w = Matrix { nn, nt, tt };
            let v = [4.0 * random() - 2.0, -random()];
            let (mu, e) = (3.0 * random() * random(), random());
            for law in LAWS {
                let Some(p) = impulse(law, &w, v, &material(mu, e)) else {
                    assert_eq!(law, Impact::Moreau);
                    continue;
                };
                let size = p[0].abs() + p[1];
                assert!(p[0].abs() <= mu * p[1] + 1e-12 * size, "{law:?} {p:?}");
                let end = after(&w, v, p);
                assert!(end[1] >= -1e-12, "{law:?} {end:?}");
                if law != Impact::Moreau {
                    let energy = v[0] * v[0] + v[1] * v[1];
                    assert!(gain(&w, v, p) <= 1e-12 * energy * (1.0 + size), "{law:?}");
                }
                if matches!(law, Impact::ChatterjeeRuina | Impact::Moreau) {
                    assert!((end[1] + e * v[1]).abs() < 1e-9 * (1.0 + size), "{law:?} {end:?}");
                }
            }
        }
        let w = Matrix { nn: 1.5, nt: 0.4, tt: 2.0 };
        for law in LAWS {
            let p = impulse(law, &w, [0.7, -1.0], &material(0.0, 0.5)).unwrap();
            assert!(p[0] == 0.0 && (p[1] - 1.0).abs() < 1e-15, "{law:?} {p:?}");
        }
    }

    /// Integrates Routh's differential equation in small steps. It ends when `ends` returns true; the arguments of `ends` are p, p_c, the
    /// work so far and the work up to p_c.
    fn stepped(
        w: &Matrix,
        mut v: [f64; 2],
        mu: f64,
        ends: impl Fn(f64, f64, f64, f64) -> bool,
    ) -> [f64; 2] {
        const STEP: f64 = 1e-5;
        let (mut p, mut work) = ([0.0; 2], 0.0);
        let mut compression = None;
        loop {
            let slope = if v[0].abs() > 2.0 * STEP * (w.nt.abs() + mu * w.tt) {
                -mu * v[0].signum()
            } else {
                v[0] = 0.0;
                (-w.nt / w.tt).clamp(-mu, mu)
            };
            work += v[1] * STEP;
            v = [v[0] + STEP * (w.nt + slope * w.tt), v[1] + STEP * (w.nn + slope * w.nt)];
            p = [p[0] + STEP * slope, p[1] + STEP];
            if v[1] >= 0.0 {
                let (p_c, work_c) = *compression.get_or_insert((p[1], work));
                if ends(p[1], p_c, work, work_c) {
                    return p;
                }
            }
            assert!(p[1] < 100.0);
        }
    }

    #[test]
    fn the_process_against_small_steps() {
        for (nt, v_t, mu) in
            [(0.5, 1.0, 0.3), (-1.2, -1.0, 0.4), (1.4, 0.3, 0.2), (1.3, 0.2, 2.0), (0.9, 0.0, 0.1)]
        {
            let (w, v, e) = (Matrix { nn: 1.0, nt, tt: 2.2 }, [v_t, -1.0], 0.6);
            let poisson = stepped(&w, v, mu, |p, p_c, _, _| p >= (1.0 + e) * p_c);
            let stronge = stepped(&w, v, mu, |_, _, work, work_c| work - work_c >= -e * e * work_c);
            for (law, found) in [(Impact::Poisson, poisson), (Impact::Stronge, stronge)] {
                let exact = impulse(law, &w, v, &material(mu, e)).unwrap();
                let off = (found[0] - exact[0]).hypot(found[1] - exact[1]);
                assert!(off < 1e-3 * exact[1], "{law:?} {nt} {v_t} {mu}: {found:?} {exact:?}");
            }
        }
    }
}

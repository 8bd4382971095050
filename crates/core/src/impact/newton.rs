//! Impacts: frictionless Newton restitution, one contact at a time or several at once.
//!
//! Let w = u_i⁻ < 0 be the gap rate of the contact that is hit. Then u_i⁺ = −e_i w and u_j⁺ = u_j⁻ + (1+e_i)ψ_i w [Or & Rimon 2008, (4),
//! (6)]. The energy lost is (1−e²)w²/(2D_ii).

use crate::math::real::Ring;
use crate::tolerance::UNLOADED;
use crate::zeno::FrozenModel;

/// One impact: the contact and the gap rates around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    pub(crate) contact: usize,
    pub(crate) before: [f64; 2],
    pub(crate) after: [f64; 2],
}

/// Rates after an impact with the speed s = −w. The contact that is hit leaves with u_i⁺ = e s; the rate of the `other` contact is u_j⁺ =
/// u_j⁻ − κ s, with κ = (1+e)ψ_i.
#[inline(always)]
pub(crate) fn rates_after<T: Ring>(e: T, kappa: T, s: T, other: T) -> [T; 2] {
    [e * s, other - kappa * s]
}

/// Own-rate jump (1+e)s of an impact with the speed s, and this jump divided by `own` = b² + ρ²: the impulse per unit mass divided by ρ².
#[inline(always)]
pub(crate) fn own_jump(e: f64, s: f64, own: f64) -> (f64, f64) {
    let jump = (e + 1.0) * s;
    (jump, jump / own)
}

/// Rates after an impact at `i`.
#[inline]
pub(crate) fn newton(model: &FrozenModel, i: usize, before: [f64; 2]) -> [f64; 2] {
    let mut after = before;
    [after[i], after[1 - i]] = rates_after(model.e[i], model.kappa[i], -before[i], before[1 - i]);
    after
}

/// An impact of both contacts at once: the impulses P ≥ 0 (as own-rate jumps) with u⁺ + e u⁻ ≥ 0 ⊥ P.
///
/// The first set of contacts out of {1, 2}, {1}, {2} that satisfies the conditions is taken. For a positive definite impact matrix exactly
/// one set does. For equal rows an impact at the contact that needs the larger impulse is enough. The flag in the result is true if both
/// contacts have an impulse and u⁺ = −e u⁻ at both.
pub(crate) fn newton_together(model: &FrozenModel, before: [f64; 2]) -> ([f64; 2], bool) {
    let need = [-(1.0 + model.e[0]) * before[0], -(1.0 + model.e[1]) * before[1]];
    let jump = model.solve_coupled(need);
    let rounding = UNLOADED * need[0].max(need[1]);
    let more = need[1] + model.psi[0] * need[0]; // impulse of contact 2 in addition to that of contact 1
    let meets = !model.is_parallel() || more.abs() <= rounding; // equal rows cannot satisfy two different equations
    if jump[0] >= -rounding && jump[1] >= -rounding && meets {
        return (jump.map(|jump| jump.max(0.0)), true);
    }
    let one = if more <= 0.0 { [need[0], 0.0] } else { [0.0, need[1]] };
    (one, false)
}

/// Rates after impulses given as own-rate jumps.
pub(crate) fn kicked(model: &FrozenModel, before: [f64; 2], jump: [f64; 2]) -> [f64; 2] {
    [before[0] + jump[0] - model.psi[1] * jump[1], before[1] + jump[1] - model.psi[0] * jump[0]]
}

/// How a sequence of impacts in zero time ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SequenceEnd {
    /// After finitely many impacts no contact approaches.
    Finite,
    /// Infinitely many impacts bring both contacts to rest: a chattering Zeno.
    Infinite,
}

/// Number of impacts in zero time after which a sequence counts as infinite. A sequence of n impacts has the frequency f = π/n per impact.
/// For this n, P and 2√e are equal within their rounding errors.
const MOST_AT_ONCE: usize = 10_000_000;

/// Impacts one after the other while both gaps are zero, `first` first, until no contact approaches.
///
/// After the first impact the contacts alternate. The impact speeds obey x_{k+1} = p x_k − e x_{k−1}, with p = (1+e)ψ of the contact that
/// is hit. The sequence is infinite iff [`FrozenModel::chatters_from`] holds. Speeds are rescaled during the sequence, so that even after
/// thousands of impacts only the final speeds can underflow. `report` is called for each impact.
pub(crate) fn in_zero_time(
    model: &FrozenModel,
    first: usize,
    rates: &mut [f64; 2],
    mut report: impl FnMut(&Hit),
) -> SequenceEnd {
    let mut contact = first;
    let (mut u, mut exponent) = (*rates, 0_i32);
    for _ in 0..MOST_AT_ONCE {
        if u[contact] >= 0.0 {
            contact = 1 - contact;
            if u[contact] >= 0.0 {
                *rates = u.map(|rate| libm::scalbn(rate, exponent));
                return SequenceEnd::Finite;
            }
        }
        if model.chatters_from(contact, u) {
            *rates = [0.0, 0.0];
            return SequenceEnd::Infinite;
        }
        let after = newton(model, contact, u);
        let scale = |rates: [f64; 2]| rates.map(|rate| libm::scalbn(rate, exponent));
        report(&Hit { contact, before: scale(u), after: scale(after) });
        u = after;
        contact = 1 - contact;
        if u[0].abs().max(u[1].abs()) < TINY {
            u = u.map(|rate| libm::scalbn(rate, RENORMALISE));
            exponent -= RENORMALISE;
        }
    }
    *rates = [0.0, 0.0];
    SequenceEnd::Infinite
}

/// Speeds below this are multiplied by 2^RENORMALISE.
const TINY: f64 = 1e-150;
const RENORMALISE: i32 = 400;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::local_model::{LocalModel, LocalModelFields};

    fn model(e: f64, psi: f64) -> FrozenModel {
        FrozenModel::new(
            &LocalModel::new(LocalModelFields {
                gravity: [1.0; 2],
                psi: [psi; 2],
                restitution: [e; 2],
                ..LocalModelFields::default()
            })
            .unwrap(),
        )
    }

    #[test]
    fn order_matters() {
        // e = .3, ψ = −.5, u = (−1, −1): first contact first ends at (.5275, .105).
        let m = model(0.3, -0.5);
        let mut u = [-1.0, -1.0];
        assert_eq!(in_zero_time(&m, 0, &mut u, |_| ()), SequenceEnd::Finite);
        assert!((u[0] - 0.5275).abs() < 1e-15 && (u[1] - 0.105).abs() < 1e-15, "{u:?}");
        let mut mirrored = [-1.0, -1.0];
        in_zero_time(&m, 1, &mut mirrored, |_| ());
        assert_eq!([u[1], u[0]], mirrored);
        let together = kicked(&m, [-1.0, -1.0], newton_together(&m, [-1.0, -1.0]).0);
        assert!((together[0] - 0.3).abs() < 1e-15 && (together[1] - 0.3).abs() < 1e-15);
    }

    /// u⁺ + e u⁻ ≥ 0 ⊥ P ≥ 0, with couplings up to equal rows. If an impact at either contact alone leaves the other one too slow, both
    /// contacts are hit and leave with −e u⁻.
    #[test]
    fn together_is_the_complementary_one() {
        for k in 1..400 {
            let psi = -1.0 + libm::pow(10.0, -f64::from(k) / 30.0);
            for before in [[-2.0, -2.0], [-0.7, -0.71], [-1e-8, -1.1e-8], [-3.0, -1.0]] {
                let m = model(0.1, psi);
                let (jump, both) = newton_together(&m, before);
                let after = kicked(&m, before, jump);
                let need = before.map(|u| -1.1 * u);
                let alone = [need[1] + psi * need[0] <= 0.0, need[0] + psi * need[1] <= 0.0];
                assert_eq!(both, alone == [false; 2], "psi {psi}, {before:?}");
                for i in 0..2 {
                    let excess = after[i] + 0.1 * before[i];
                    // The impulses are 1/(1 + ψ) times as large as the rates.
                    let rounding = 1e-15 * (jump[0] + jump[1] - before[0]);
                    assert!(excess >= -rounding && jump[i] >= 0.0);
                    assert!(excess <= rounding || jump[i] == 0.0, "psi {psi}, {before:?}");
                }
            }
        }
    }

    /// Contact 1 rests, contact 2 lands with speed 1: with cos f = P/(2√e) there are n = ⌈π/f⌉ − 1
    /// impacts; the last leaves with e·e^((n−1)/2) sin(nf)/sin f, the other with −e^(n/2) sin((n+1)f)/sin f.
    #[test]
    fn corner_against_its_closed_form() {
        for (e, psi) in [(0.3, 0.2), (0.3, 0.7), (0.3, 0.84), (0.3, 0.842), (0.7, 0.5), (0.05, 0.1)]
        {
            let m = model(e, psi);
            let f = ((1.0 + e) * psi / (2.0 * f64::sqrt(e))).acos();
            let n = (std::f64::consts::PI / f).ceil() - 1.0;
            let (mut u, mut hits, mut last) = ([0.0, -1.0], 0.0, 0);
            let end = in_zero_time(&m, 1, &mut u, |hit| {
                hits += 1.0;
                last = hit.contact;
            });
            assert_eq!((end, hits), (SequenceEnd::Finite, n), "e {e} psi {psi}");
            let leaving = e * e.powf(0.5 * (n - 1.0)) * (n * f).sin() / f.sin();
            let other = -e.powf(0.5 * n) * ((n + 1.0) * f).sin() / f.sin();
            // The oracle's own rounding: acos near 1 loses a factor n, its phase is taken n times and the
            // sine near π loses another n.
            let rounding = 8.0 * f64::EPSILON * n.powi(3);
            assert!((u[last] / leaving - 1.0).abs() < rounding, "{} {leaving}", u[last]);
            assert!((u[1 - last] / other - 1.0).abs() < rounding, "{} {other}", u[1 - last]);
        }
    }

    /// Both ends touch, one of them leaves fast: P ≥ 2√e, but outside the cone one impact is all.
    #[test]
    fn a_contact_that_leaves_ends_the_sequence() {
        let m = model(0.1, 0.9);
        let (mut u, mut hits) = ([1.0, -0.1], 0);
        assert_eq!(in_zero_time(&m, 1, &mut u, |_| hits += 1), SequenceEnd::Finite);
        assert_eq!(hits, 1);
        assert!((u[0] - (1.0 - 1.1 * 0.9 * 0.1)).abs() < 1e-15 && (u[1] - 0.01).abs() < 1e-17);
        assert_eq!(in_zero_time(&m, 1, &mut [0.09, -0.1], |_| ()), SequenceEnd::Finite);
        assert_eq!(in_zero_time(&m, 1, &mut [0.08, -0.1], |_| ()), SequenceEnd::Infinite);
        assert_eq!(in_zero_time(&m, 1, &mut [-1.0, -0.1], |_| ()), SequenceEnd::Infinite);
    }

    #[test]
    fn just_below_goyal_the_sequence_is_long_but_finite() {
        let m = model(0.3, 0.84265);
        let (mut u, mut hits) = ([0.0, -1.0], 0_u32);
        assert_eq!(in_zero_time(&m, 1, &mut u, |_| hits += 1), SequenceEnd::Finite);
        let f = (1.3 * 0.84265 / (2.0 * 0.3f64.sqrt())).acos();
        assert_eq!(f64::from(hits), (std::f64::consts::PI / f).ceil() - 1.0);
        assert!(hits > 1249);
        assert_eq!(
            in_zero_time(&model(0.3, 0.8427), 1, &mut [0.0, -1.0], |_| ()),
            SequenceEnd::Infinite
        );
    }
}

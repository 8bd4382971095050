//! How long a frictionless motion lasts until its first Zeno point.

use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::stability::local::Local;
use crate::tolerance::BOUND_MARGIN;

type I = Interval;

/// Number of cells into which √x is divided, x being the part of the energy at one contact, see [`settling`].
const SHARES: usize = 32;

/// Blocks (impacts in a row at one contact) of up to this number of impacts are treated one by one, longer ones together.
const IMPACTS: usize = 4;

/// The iteration for W in [`settling`]: the largest number of rounds of eight steps, and the factor by which W is enlarged before each
/// check.
const ROUNDS: usize = 500;
const SLACK: f64 = 1.01;

/// C: the time from a start to the first Zeno point is at most C√(2E), with E = ½u·D⁻¹u + λ·h at the start. The result is infinite if no C
/// is found.
///
/// Consecutive impacts at one contact are a *block*. Let E_j = (½u_j² + g_j h_j)/D_jj, which changes at impacts only. A block of n impacts
/// at j starts with the energies E and E_j = y E. With w = e_jⁿ it takes the time T_j √y √E (1 − w), and it leaves E' = E (1 − (1 − w²) y)
/// and E_j' = w² E_j. After a block at i with E_i = x E the next block, at j, has y ≥ Y(x)². W_i(x) √E is a bound of the remaining time if
/// for all y and n
///
/// ```text
/// W_i(x) ≥ T_j √y (1 − w) + √(E'/E) W_j(x'),   x' = E_j'/E'
/// ```
///
/// W is computed by iteration on cells of √x and √y, and the inequality is checked at the end.
pub(super) fn settling(l: &Local, weights: [I; 2]) -> f64 {
    // E_i is at most `most` times E; and E_i κ + (√E_j + |ψ|√E_i)²/(1 − ψ²) is at least E at an impact at j, κ = `kappa`.
    let ratio = [0, 1].map(|i| l.g[i] / (l.nn[i][i] * weights[i]));
    let most = ratio.map(|ratio| ratio.hi.max(1.0));
    let kappa = ratio.map(|ratio| I::ONE.max(I::ONE / ratio).hi);
    let coupling = (l.psi[0] * l.psi[1]).non_negative().map_or(I::ZERO, I::sqrt);
    let across = (l.determinant() / (l.nn[0][0] * l.nn[1][1])).lo;
    let time =
        |i: usize| ((l.nn[i][i].times(2.0)).sqrt().times(2.0) / (l.g[i] * (I::ONE - l.e[i]))).hi;
    let times = [time(0), time(1)];
    // Limits of the cells of √x, or √y.
    let limits = most.map(|most| {
        let end = most.sqrt() * (1.0 + BOUND_MARGIN);
        std::array::from_fn::<f64, { SHARES + 1 }, _>(|k| {
            end * (k as f64 / SHARES as f64) * (k as f64 / SHARES as f64)
        })
    });
    // For x up to limit k: the first cell that may contain √y.
    let first: [[usize; SHARES + 1]; 2] = std::array::from_fn(|i| {
        std::array::from_fn(|k| {
            let root = limits[i][k];
            let rest = (across * (1.0 - kappa[i] * root * root)).max(0.0).sqrt();
            let least = (rest - coupling.hi * root) * (1.0 - BOUND_MARGIN) - BOUND_MARGIN;
            limits[1 - i][1..SHARES].partition_point(|&limit| limit <= least)
        })
    });
    // Blocks at j by cell and number of impacts (the last entry: that many or more): time, √(E'/E), and the limit of x'.
    let blocks: [[[Block; IMPACTS]; SHARES]; 2] = std::array::from_fn(|j| {
        std::array::from_fn(|cell| {
            let (low, high) = (limits[j][cell], limits[j][cell + 1]);
            std::array::from_fn(|n| {
                let power = (0..=n).fold(I::ONE, |w, _| w * l.e[j]);
                let w = power.hi;
                let shorter = if n + 1 == IMPACTS { 0.0 } else { power.lo };
                let left = |root: f64| 1.0 - (1.0 - w * w) * root * root;
                let next =
                    if left(high) > 0.0 { w * high / left(high).sqrt() } else { f64::INFINITY };
                let next = limits[j][..SHARES]
                    .partition_point(|&limit| limit < next * (1.0 + BOUND_MARGIN));
                Block {
                    time: times[j] * high * (1.0 - shorter) * (1.0 + BOUND_MARGIN),
                    left: (left(low) + BOUND_MARGIN).max(0.0).sqrt(),
                    next,
                }
            })
        })
    });
    let together = tie(l.e, l.psi, coupling).sqrt() * (1.0 + BOUND_MARGIN);
    let wait = (0..2).map(|j| times[j] * (1.0 - l.e[j].lo) * limits[j][SHARES]).fold(0.0, f64::max)
        * (1.0 + BOUND_MARGIN);
    // Bound from a start with a block at either contact, and W after a block at i.
    let round = |after: &[[f64; SHARES + 1]; 2]| {
        let longest: [[f64; SHARES]; 2] = std::array::from_fn(|j| {
            let mut longest = [0.0_f64; SHARES];
            let mut most = 0.0_f64;
            for cell in (0..SHARES).rev() {
                for block in &blocks[j][cell] {
                    most = most.max(block.time + block.left * after[j][block.next]);
                }
                longest[cell] = most;
            }
            longest
        });
        // After a tie the motion is as from a start, with less energy.
        let start = longest[0][0].max(longest[1][0]).max(wait / (1.0 - together).max(0.0));
        let tied = wait + together * start;
        let next: [[f64; SHARES + 1]; 2] =
            std::array::from_fn(|i| std::array::from_fn(|k| longest[1 - i][first[i][k]].max(tied)));
        (start, next)
    };
    let mut after = [[0.0; SHARES + 1]; 2];
    for _ in 0..ROUNDS {
        for _ in 0..8 {
            after = round(&after).1;
        }
        let wider = after.map(|row| row.map(|time| time * SLACK));
        let (start, again) = round(&wider);
        let holds = |i: usize| {
            wider[i].iter().zip(&again[i]).all(|(w, next)| next * (1.0 + BOUND_MARGIN) <= *w)
        };
        if holds(0) && holds(1) {
            return start * std::f64::consts::FRAC_1_SQRT_2 * (1.0 + BOUND_MARGIN);
        }
    }
    f64::INFINITY
}

/// Consecutive impacts at one contact.
#[derive(Clone, Copy)]
struct Block {
    /// Duration, for E = 1 at the start.
    time: f64,
    /// √(E'/E)
    left: f64,
    /// Index of a cell limit above x'.
    next: usize,
}

/// Largest part of the energy that remains after both contacts land at one instant and their impacts are solved together.
fn tie(e: [I; 2], psi: [I; 2], coupling: I) -> f64 {
    if e[0] == e[1] || psi[0].lo >= 0.0 {
        // u_i⁺ = −e_i u_i⁻. Either both e_i are equal, or no term of u·D⁻¹u is negative.
        let most = e[0].hi.max(e[1].hi);
        return most * most * (1.0 + BOUND_MARGIN);
    }
    // The smaller of two bounds: the largest u⁺·D⁻¹u⁺ for u·D⁻¹u = 1, and one less the least loss ½Δu·D⁻¹Δu (1 − e)/(1 + e).
    let square = coupling.square();
    let across = I::ONE - square;
    let product = e[0] * e[1];
    let sum = e[0].square() + e[1].square() - (square * product).times(2.0);
    let root = (sum.square() - (product * across).square().times(4.0)).non_negative();
    let stretched = (sum + root.map_or(I::ZERO, I::sqrt)) / across.times(2.0);
    let [one, two] = e.map(|e| ((I::ONE - e) / (I::ONE + e)).lo);
    let kept = I::ONE - I::from(one.min(two)) * (I::ONE - coupling) / (I::ONE + coupling);
    stretched.hi.min(kept.hi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::contact::Contact;
    use crate::body::fields::PostureFields;
    use crate::body::posture::Posture;
    use crate::body::state::State;
    use crate::options::{Model, Options, Stop};
    use crate::simulate::simulate;

    /// Numbers in [0, 1), evenly distributed.
    fn share(k: usize, factor: f64) -> f64 {
        (k as f64 * factor).fract()
    }

    fn posture(k: usize) -> Posture {
        let at = |factor, low: f64, high: f64| low + (high - low) * share(k, factor);
        let contact = |x: f64, y: f64, slope: f64, e: f64| Contact {
            restitution: Some(e),
            ..Contact::at(x, y).on_slope(slope)
        };
        let e = at(0.618_033_988, 0.0, 0.9);
        let other = if k.is_multiple_of(3) { at(0.302_775_637, 0.0, 0.9) } else { e };
        Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: at(0.414_213_562, 0.2, 1.5),
            center_of_mass: [at(0.732_050_807, -1.0, 1.0), at(0.236_067_977, -1.0, 2.0)],
            contacts: vec![
                contact(-1.0, 0.0, at(0.645_751_311, -0.9, 0.9), e),
                contact(1.0, 0.0, at(0.316_624_790, -0.9, 0.9), other),
            ],
            restitution: 0.0,
            gravity: 1.0,
            ..PostureFields::default()
        })
        .unwrap()
    }

    #[test]
    fn no_motion_takes_longer_to_its_first_zeno_point() {
        let (mut postures, mut largest) = (0, 0.0_f64);
        for k in 0..400 {
            let posture = posture(k);
            let Some(l) = Local::new(&posture, 0.0) else { continue };
            let weights = l.weights();
            if !weights.iter().chain(&l.g).all(|x| x.is_positive()) {
                continue;
            }
            postures += 1;
            let time = settling(&l, weights);
            for n in 0..25 {
                let j = 25 * k + n;
                let rate = |factor| 1e-3 * (2.0 * share(j, factor) - 1.0);
                let qdot = [rate(0.123_105_625), rate(0.358_898_943), rate(0.795_831_523)];
                let mut q = [0.0; 3];
                if n % 2 == 1 {
                    q[1] = 1e-6 * share(j, 0.567_764_362);
                }
                let start = State::new(q, qdot);
                let options =
                    Options { model: Model::Local, stop: Stop::Zeno, ..Options::default() };
                let run = simulate(&posture, &start, &options).unwrap();
                let zeno = &run.zeno_points()[0];
                // 2E from the rows of the geometry.
                let rows = posture.geometry();
                let u = [0, 1].map(|i| rows[i].local_gap(&qdot.into()));
                let h = [0, 1].map(|i| rows[i].local_gap(&q.into()));
                let nn = l.nn.map(|row| row.map(I::middle));
                let det = nn[0][0] * nn[1][1] - nn[0][1] * nn[1][0];
                let kinetic = (nn[1][1] * u[0] * u[0] - 2.0 * nn[0][1] * u[0] * u[1]
                    + nn[0][0] * u[1] * u[1])
                    / det;
                let twice: f64 =
                    kinetic + 2.0 * (weights[0].middle() * h[0] + weights[1].middle() * h[1]);
                let part = zeno.elapsed / (time * twice.sqrt());
                largest = largest.max(part);
                assert!(part <= 1.0, "{posture:?} {qdot:?}: {part}");
            }
        }
        assert!(postures > 200, "{postures}");
        // The bound is not needlessly large: it is reached within a factor of three.
        assert!(largest > 1.0 / 3.0, "{largest}");
    }
}

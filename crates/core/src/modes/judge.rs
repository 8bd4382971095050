//! Tests whether the accelerations and forces of a word are consistent with it.

use crate::modes::answer::{Forces, Margin, ModeAnswer, test};
use crate::modes::scaled::Problem;
use crate::modes::words::Word;
use crate::outcome::ContactNumber;
use crate::tolerance::{CONE_TIE_ACCELERATION, FIXED_ACCELERATION, TIE};

/// Tests a solution of a word.
pub(super) fn judge<P: Problem>(
    problem: &P,
    word: Word,
    y: &P::V,
    scaled: &[[f64; 2]],
    determined: Forces,
) -> ModeAnswer {
    if determined == Forces::Impossible {
        let (acceleration, forces) =
            (vec![f64::NAN; problem.coordinates()], vec![[f64::NAN; 2]; scaled.len()]);
        let (margins, consistent) = (Vec::new(), false);
        let force_interval = None;
        return ModeAnswer {
            word,
            acceleration,
            forces,
            determined,
            force_interval,
            margins,
            consistent,
            singular: false,
        };
    }
    let mut margins = Vec::with_capacity(2 * scaled.len());
    for (i, row) in problem.rows().iter().enumerate() {
        let tangential = || row.tangential(y);
        let normal = || row.opening(y);
        test(row, word.mode(i), tangential, normal, scaled[i], |condition, value| {
            margins.push(Margin { contact: ContactNumber::of(i), condition, value });
        });
    }
    let consistent = margins.iter().all(Margin::holds) && !leans_on_a_tie(&margins);
    ModeAnswer {
        word,
        acceleration: problem.acceleration(y),
        forces: scaled.iter().enumerate().map(|(i, force)| problem.force(i, *force)).collect(),
        determined,
        force_interval: None,
        margins,
        consistent,
        singular: false,
    }
}

/// Returns true if a strict test holds only because of a tie: a force is outside its cone by less than a tie, and the acceleration of the
/// strict test is below the acceleration that this force can cause.
pub(super) fn leans_on_a_tie(margins: &[Margin]) -> bool {
    let least = |strict: bool| {
        let of_kind = margins.iter().filter(|m| m.condition.is_strict() == strict);
        of_kind.map(|m| m.value).fold(f64::INFINITY, f64::min)
    };
    let missing = -least(false);
    missing > FIXED_ACCELERATION && least(true) <= TIE + CONE_TIE_ACCELERATION * missing
}

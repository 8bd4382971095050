//! One solution of Coulomb's law by pivoting, where it is a linear complementarity problem with an unknown speed λ of each contact at rest
//! [Stewart & Trinkle 1996]:
//!
//! ```text
//! 0 ≤ f_n ⊥ a_n ≥ 0,   0 ≤ f_± ⊥ λ ± a_t ≥ 0,   0 ≤ λ ⊥ μ f_n − f_+ − f_− ≥ 0,   f_t = f_+ − f_−
//! ```
//!
//! Where a contact slides, f_t = ∓μ f_n.

use crate::math::lemke::complementary;

/// A contact of the problem. Pairs are (tangential, normal).
pub(crate) struct Pivoted {
    pub(crate) friction: f64,
    /// Sign of its sliding speed; `None`: it separates.
    pub(crate) sliding: Option<i8>,
    /// Its acceleration without contact forces.
    pub(crate) pull: [f64; 2],
    /// What unit forces of each contact do to its acceleration: [own axis][axis of the force].
    pub(crate) effects: Vec<[[f64; 2]; 2]>,
}

/// The forces of the contacts; `None` if the method ends in a ray.
pub(crate) fn by_pivoting(contacts: &[Pivoted]) -> Option<Vec<[f64; 2]>> {
    // Each unknown force: its contact, and the force (tangential, normal).
    let mut unknown: Vec<(usize, [f64; 2])> = Vec::new();
    let mut speeds = Vec::new();
    for (i, contact) in contacts.iter().enumerate() {
        let Some(sign) = contact.sliding else { continue };
        unknown.push((i, [-f64::from(sign) * contact.friction, 1.0]));
        if sign == 0 && contact.friction > 0.0 {
            unknown.extend([1.0, -1.0].map(|side| (i, [side, 0.0])));
            speeds.push(i);
        }
    }
    let (forces, count) = (unknown.len(), unknown.len() + speeds.len());
    let mut matrix = vec![vec![0.0; count]; count];
    let mut b = vec![0.0; count];
    for (k, (i, [side, normal])) in unknown.iter().enumerate() {
        let contact = &contacts[*i];
        let (axis, sign) = if *normal == 1.0 { (1, 1.0) } else { (0, *side) };
        for (l, (j, [t, n])) in unknown.iter().enumerate() {
            let effect = contact.effects[*j][axis];
            matrix[k][l] = sign * (effect[0] * t + effect[1] * n);
        }
        b[k] = sign * contact.pull[axis];
        if *normal == 0.0
            && let Some(at) = speeds.iter().position(|speed| speed == i)
        {
            matrix[k][forces + at] = 1.0;
        }
    }
    for (at, speed) in speeds.iter().enumerate() {
        for (l, (i, [_, normal])) in unknown.iter().enumerate().filter(|(_, u)| u.0 == *speed) {
            matrix[forces + at][l] = if *normal == 1.0 { contacts[*i].friction } else { -1.0 };
        }
    }
    let z = complementary(&matrix, &b)?;
    let mut pairs = vec![[0.0; 2]; contacts.len()];
    for ((i, [t, n]), part) in unknown.iter().zip(&z) {
        pairs[*i][0] += t * part;
        pairs[*i][1] += n * part;
    }
    Some(pairs)
}

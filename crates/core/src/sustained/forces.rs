//! The contact forces of a smooth motion.

use crate::body::contact::ContactLetters;
use crate::body::lines::Feet;
use crate::body::posture::Posture;
use crate::body::terrain::Place;
use crate::error::Error;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{Mode, Word, forces};
use crate::sustained::{BodyState, ContactState};

impl BodyState {
    /// Adds the points of the inner feet of its rows, each between two points that the body has.
    pub(crate) fn set_on(&mut self, feet: &Feet) {
        let between = |[one, other]: [ContactState; 2], w: f64| ContactState {
            b: w * one.b + (1.0 - w) * other.b,
            c: w * one.c + (1.0 - w) * other.c,
            ..one
        };
        let number = |(contact, p): (usize, ContactState)| ContactState {
            place: Place { contact, ..p.place },
            ..p
        };
        let all = feet.all(self.points.len(), |i| self.points[i], between).enumerate();
        self.points = all.map(number).collect();
    }

    /// The forces (tangential, normal) of all contacts in these modes of their points, in N; then those of corners of the ground on sides, up
    /// to the last one that is near. NaN where no forces cause the motion. Where
    /// several forces do, the smallest ones. Contacts that move as one share their force, and a contact in a vertex has the sum of the
    /// forces of both pieces, in the axes of the first one.
    pub(crate) fn forces(&self, posture: &Posture, modes: &[Mode]) -> Result<Vec<[f64; 2]>, Error> {
        let count = posture.contacts().len();
        let all = self.sides.iter().map(|side| side.contact + 1).fold(count, usize::max);
        if modes.iter().all(|&mode| mode == Mode::Separate) {
            return Ok(vec![[0.0; 2]; all]);
        }
        // Contact and point of each force.
        let distinct = posture.distinct().count();
        let firsts = (0..count).map(|contact| (contact, posture.point_of(contact)));
        let sides = (distinct..self.points.len())
            .filter(|&i| self.side_contact(i).is_some())
            .map(|i| (self.points[i].place.contact, i));
        let twins = (distinct..self.points.len()).filter(|&i| self.side_contact(i).is_none());
        let seconds = twins.flat_map(|i| {
            let point = posture.point_of(self.points[i].place.contact);
            (0..count)
                .filter(move |&contact| posture.point_of(contact) == point)
                .map(move |contact| (contact, i))
        });
        let closed = |&(_, i): &(usize, usize)| modes[i] != Mode::Separate;
        let pushed: Vec<_> = firsts.chain(sides).chain(seconds).filter(closed).collect();
        let mut body = self.clone();
        body.points = pushed.iter().map(|&(_, i)| self.points[i]).collect();
        // Without friction a fixed contact has a normal force only, like a sliding one.
        let mode = |i: usize| match modes[i] {
            Mode::Fixed if self.points[i].friction == 0.0 => Mode::Right,
            mode => mode,
        };
        let ways: ContactLetters<_> =
            pushed.iter().map(|&(_, i)| Some(mode(i).direction() as i8)).collect();
        let problem = body.problem(posture.fields().mass, &ways)?;
        let letters = pushed.iter().enumerate();
        let word =
            letters.fold(Word::separate(pushed.len()), |word, (k, &(_, i))| word.with(k, mode(i)));
        let Some(parts) = forces(&problem, word) else { return Ok(vec![[f64::NAN; 2]; all]) };
        let mut sums = vec![[0.0; 2]; all];
        for (&(contact, i), [f_t, f_n]) in pushed.iter().zip(parts) {
            let same = pushed.iter().filter(|of| of.0 == contact).map(|of| of.1);
            let first = same.min_by_key(|&j| self.points[j].place.piece).unwrap_or(i);
            let (p, axes) = (&self.points[i], &self.points[first]);
            let force = p.tangent * f_t + p.normal * f_n;
            let part = if i == first {
                [f_t, f_n]
            } else {
                [axes.tangent.dot(&force), axes.normal.dot(&force)]
            };
            sums[contact] = [sums[contact][0] + part[0], sums[contact][1] + part[1]];
        }
        Ok(sums.unsigned_zero())
    }
}

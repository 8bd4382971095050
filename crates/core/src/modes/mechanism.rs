//! The contact-mode problem of a mechanism.
//!
//! In the coordinates y of [`ContactSpace`] the mass is the identity, and the equations are those of a body with other rows:
//!
//! ```text
//! ÿ = pull + Σ_i (T_i f_t,i + N_i f_n,i)        a_n,i = N_i·ÿ     a_t,i = T_i·ÿ
//! ```
//!
//! Rows are divided by ν_i = |N_i|, accelerations by ν_i and by the largest component of the pull. Up to three coordinates are padded with
//! zeros to three, for which two contacts have closed forms.

use nalgebra::Vector3;

use crate::body::contact::ContactLetters;
use crate::body::{ContactSpace, Mechanism};
use crate::error::Error;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::modes::answer::{Forces, ModeAnswer};
use crate::modes::pair;
use crate::modes::rows::{Row, scale};
use crate::modes::scaled::Problem;
use crate::modes::squeeze::Squeeze;
use crate::modes::words::{Mode, Word};
use crate::modes::{Jamming, Method, Modes, enumerate, only_mode, painleve, sealed, solved};

/// The contacts of a mechanism in its posture, at rest or sliding, under its load: which of them separate, stay fixed or slide?
///
/// Words, forces and margins are those of a [`ContactProblem`](crate::modes::ContactProblem); the acceleration of a mode has an entry for each
/// coordinate, zero where it is locked.
///
/// ```
/// use standfast::body::{ContactRows, Mechanism, MechanismFields};
/// use standfast::modes::{MechanismProblem, Method, Status, contact_modes};
///
/// // Two carts on level ground, 1 kg each, pushed apart by 3 N; friction of 4.905 N holds each.
/// let cart = |k: usize| {
///     let row = |axis: usize| (0..4).map(|j| f64::from(u8::from(j == axis))).collect();
///     ContactRows { tangential: row(2 * k), normal: row(2 * k + 1), friction: 0.5, ..ContactRows::default() }
/// };
/// let carts = |push: f64| {
///     Mechanism::new(MechanismFields {
///         mass_matrix: (0..4).map(|i| (0..4).map(|j| f64::from(u8::from(i == j))).collect()).collect(),
///         load: vec![-push, -9.81, push, -9.81],
///         contacts: vec![cart(0), cart(1)],
///         ..MechanismFields::default()
///     })
/// };
/// let modes = contact_modes(&MechanismProblem::at_rest(&carts(3.0)?), Method::Auto)?;
/// assert_eq!(modes.status(), Status::Unique);
/// assert_eq!(modes.answers().len(), 16); // all words are motions
/// let held = modes.consistent().next().expect("one mode");
/// assert_eq!(held.word.to_string(), "FF");
/// assert!((held.forces[0][0] - 3.0).abs() < 1e-14);
///
/// let modes = contact_modes(&MechanismProblem::at_rest(&carts(6.0)?), Method::Auto)?;
/// let apart = modes.consistent().next().expect("one mode");
/// assert_eq!(apart.word.to_string(), "LR");
/// assert!((apart.acceleration[2] - (6.0 - 4.905)).abs() < 1e-14);
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MechanismProblem {
    mechanism: Mechanism,
    sliding: Vec<Option<i8>>,
    inside: Inside,
}

/// The scaled problem.
#[derive(Debug, Clone, PartialEq)]
enum Inside {
    /// Up to three coordinates.
    Three(Scaled<Vector3<f64>>),
    /// More.
    Any(Scaled<Coordinates>),
}

impl MechanismProblem {
    /// The problem of a mechanism whose contacts slide with these signs: 1 along +t, −1 along −t, 0 not at all; `None` where the contact is
    /// separated.
    ///
    /// ```
    /// use standfast::body::Mechanism;
    /// use standfast::modes::{MechanismProblem, Method, contact_modes};
    /// use standfast::{Lamina, Posture};
    ///
    /// // A rod that slides to the right on both ends is held back by μ g.
    /// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, gravity: 10.0, ..Lamina::default() })?;
    /// let sliding = MechanismProblem::new(&Mechanism::of_posture(&rod)?, &[Some(1), Some(1)])?;
    /// let modes = contact_modes(&sliding, Method::Auto)?;
    /// let mode = modes.consistent().next().expect("one mode");
    /// assert_eq!(mode.word.to_string(), "RR");
    /// assert!((mode.acceleration[0] + 5.0).abs() < 1e-14);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `sliding` if it has not one sign for each contact.
    pub fn new(mechanism: &Mechanism, sliding: &[Option<i8>]) -> Result<Self, Error> {
        let n = mechanism.contacts().len();
        if sliding.len() != n {
            return Err(Error::Unusable {
                field: "sliding".into(),
                value: format!("[{} entries]", sliding.len()),
                allowed: format!("one for each of the {n} contacts"),
            });
        }
        for (i, sign) in sliding.iter().enumerate() {
            if let Some(sign) = sign
                && !(-1..=1).contains(sign)
            {
                return Err(Error::Unusable {
                    field: format!("sliding.{}", i + 1),
                    value: sign.to_string(),
                    allowed: "1, -1, 0, or none where the contact is separated".into(),
                });
            }
        }
        Ok(Self::of(mechanism, sliding.to_vec()))
    }

    /// The problem of a mechanism at rest on all its contacts.
    ///
    /// ```
    /// use standfast::body::Mechanism;
    /// use standfast::modes::{MechanismProblem, Method, contact_modes};
    /// use standfast::{Lamina, Posture};
    ///
    /// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, gravity: 10.0, ..Lamina::default() })?;
    /// let modes = contact_modes(&MechanismProblem::at_rest(&Mechanism::of_posture(&rod)?), Method::Auto)?;
    /// let mode = modes.consistent().next().expect("one mode");
    /// assert_eq!(mode.word.to_string(), "FF");
    /// assert!((mode.forces[0][1] - 5.0).abs() < 1e-14);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn at_rest(mechanism: &Mechanism) -> Self {
        Self::of(mechanism, vec![Some(0); mechanism.contacts().len()])
    }

    fn of(mechanism: &Mechanism, sliding: Vec<Option<i8>>) -> Self {
        let space = mechanism.contact_space();
        let friction: Vec<f64> = mechanism.contacts().iter().map(|k| k.friction).collect();
        let inside = if space.pull().len() <= 3 {
            Inside::Three(Scaled::of(space, &friction, &sliding))
        } else {
            Inside::Any(Scaled::of(space, &friction, &sliding))
        };
        Self { mechanism: mechanism.clone(), sliding, inside }
    }

    /// The mechanism.
    #[must_use]
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// The signs of sliding, by contact.
    #[must_use]
    pub fn sliding(&self) -> &[Option<i8>] {
        &self.sliding
    }

    /// How close sliding contacts are to jamming: one entry for each closed contact and each direction in which it slides or may begin to
    /// slide. A unit normal force with its friction changes a_n by P(μ) = N M⁻¹Nᵀ − σμ N M⁻¹Tᵀ.
    ///
    /// ```
    /// use standfast::body::Mechanism;
    /// use standfast::modes::MechanismProblem;
    /// use standfast::{Lamina, Posture};
    ///
    /// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
    /// let rod = MechanismProblem::new(&Mechanism::of_posture(&rod)?, &[Some(1), None])?;
    /// let [one] = &rod.jamming()[..] else { unreachable!("one contact slides, in one direction") };
    /// assert_eq!(one.margin, 1.0); // friction acts through the centre of mass
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn jamming(&self) -> Vec<Jamming> {
        match &self.inside {
            Inside::Three(problem) => painleve::jamming(&problem.rows),
            Inside::Any(problem) => painleve::jamming(&problem.rows),
        }
    }
}

impl sealed::Solved for MechanismProblem {
    fn modes(&self, method: Method) -> Result<Modes, Error> {
        let mut modes = match &self.inside {
            Inside::Three(problem) => solved(problem, method, pair::answers),
            Inside::Any(problem) => solved(problem, method, |_| None),
        }?;
        let dof = self.mechanism.dof();
        for answer in &mut modes.answers {
            answer.acceleration = if answer.determined == Forces::Impossible {
                vec![f64::NAN; dof]
            } else {
                let y = Coordinates::from_iter(answer.acceleration.iter().copied());
                self.mechanism.contact_space().acceleration(dof, &y)
            };
        }
        Ok(modes)
    }
}

/// The scaled problem of the contacts of a mechanism. Its accelerations are those of the coordinates y.
#[derive(Debug, Clone, PartialEq)]
struct Scaled<V: MassVector> {
    rows: Vec<Row<V>>,
    load: V,
    scale: f64,
    /// Number of coordinates, without those added for padding.
    coordinates: usize,
}

impl<V: MassVector> Scaled<V> {
    fn of(space: &ContactSpace, friction: &[f64], sliding: &[Option<i8>]) -> Self {
        let coordinates = space.pull().len();
        let mut load = V::of(coordinates, space.pull().iter());
        let rows = friction.iter().zip(sliding).enumerate();
        let mut rows: Vec<_> = rows.map(|(i, (mu, sign))| row(space, i, *mu, *sign)).collect();
        let scale = scale(&mut rows, load.norm());
        load = load.divided(scale);
        Self { rows, load, scale, coordinates }
    }
}

/// A row of a contact space, scaled.
fn row<V: MassVector>(
    space: &ContactSpace,
    contact: usize,
    friction: f64,
    sliding: Option<i8>,
) -> Row<V> {
    let [tangent, normal] = [space.tangent(contact), space.normal_row(contact)];
    let stretch = normal.norm();
    let scaled = |row: &Coordinates| V::of(row.len(), row.iter()).divided(stretch);
    let (normal, tangent) = (scaled(normal), scaled(tangent));
    Row { normal, tangent, arm: None, bias: [0.0; 2], friction, sliding, stretch }
}

impl<V: MassVector> Problem for Scaled<V> {
    type V = V;

    fn rows(&self) -> &[Row<V>] {
        &self.rows
    }

    fn load(&self) -> &V {
        &self.load
    }

    fn coordinates(&self) -> usize {
        self.coordinates
    }

    fn acceleration(&self, y: &V) -> Vec<f64> {
        y.components().take(self.coordinates).map(|part| part * self.scale).collect()
    }

    /// From F = ν f/scale.
    fn force(&self, index: usize, scaled: [f64; 2]) -> [f64; 2] {
        scaled.map(|part| part * self.scale / self.rows[index].stretch)
    }

    fn internal_force(&self, scaled: f64) -> f64 {
        scaled * self.scale
    }

    fn squeeze(&self, closed: [usize; 2], rest: &V) -> Squeeze {
        Squeeze::spanned(closed.map(|i| &self.rows[i]), rest)
    }
}

/// A word with which the motion may go on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Onward {
    pub(crate) word: ContactLetters<Mode>,
    /// ÿ, in the coordinates of the contact space.
    pub(crate) acceleration: Coordinates,
    /// Whether the motion depends on forces that the law does not determine.
    pub(crate) undetermined: bool,
}

impl Onward {
    fn of(answer: &ModeAnswer) -> Self {
        Self {
            word: answer.word.modes().collect(),
            acceleration: Coordinates::from_iter(answer.acceleration.iter().copied()),
            undetermined: answer.determined == Forces::Undetermined,
        }
    }
}

/// The consistent words of contacts that slide with these signs (`None`: separated): all of them, or one if there are too many to enumerate.
///
/// # Errors
///
/// As [`contact_modes`](crate::modes::contact_modes).
pub(crate) fn onward(
    space: &ContactSpace,
    friction: &[f64],
    sliding: &[Option<i8>],
) -> Result<Vec<Onward>, Error> {
    if space.pull().len() > 3 {
        return all_onward(&Scaled::<Coordinates>::of(space, friction, sliding));
    }
    if let Some(only) = only_onward(space, friction, sliding) {
        return Ok(vec![only]);
    }
    all_onward(&Scaled::<Vector3<f64>>::of(space, friction, sliding))
}

fn all_onward<P: Problem>(problem: &P) -> Result<Vec<Onward>, Error> {
    let all = solved(problem, Method::Enumerate, |_| None);
    let modes = match all {
        Err(_) if cfg!(feature = "qp") => solved(problem, Method::Qp, |_| None)?,
        all => all?,
    };
    Ok(modes.consistent().map(Onward::of).collect())
}

/// The only consistent word, if at most two contacts are closed and it has a closed form.
fn only_onward(space: &ContactSpace, friction: &[f64], sliding: &[Option<i8>]) -> Option<Onward> {
    let mut rows = [Row::ABSENT; 2];
    let mut closed = [0; 2];
    let mut n = 0;
    for (i, sign) in sliding.iter().enumerate().filter(|(_, sign)| sign.is_some()) {
        *rows.get_mut(n)? = row(space, i, friction[i], *sign);
        closed[n] = i;
        n += 1;
    }
    let pull: Vector3<f64> = MassVector::of(3, space.pull().iter());
    let mut word = ContactLetters::from_elem(Mode::Separate, sliding.len());
    let mut acceleration = pull;
    if n > 0 {
        let scale = scale(&mut rows[..n], pull.norm());
        let (letters, y) = only_mode(&rows[..n], pull / scale)?;
        closed[..n].iter().zip(letters).for_each(|(&i, mode)| word[i] = mode);
        acceleration = y * scale;
    }
    let acceleration = acceleration.components().take(space.pull().len());
    Some(Onward { word, acceleration: Coordinates::from_iter(acceleration), undetermined: false })
}

/// The forces (tangential, normal) of the contacts in this word, in N, whatever the tests of the word say: the smallest where the equations
/// allow several. `None`: no forces cause the motion of the word.
pub(crate) fn forces(space: &ContactSpace, friction: &[f64], word: Word) -> Option<Vec<[f64; 2]>> {
    let sliding: ContactLetters<Option<i8>> = word
        .modes()
        .map(|mode| (mode != Mode::Separate).then_some(mode.direction() as i8))
        .collect();
    let answer = if space.pull().len() > 3 {
        enumerate::solve(&Scaled::<Coordinates>::of(space, friction, &sliding), word)
    } else {
        enumerate::solve(&Scaled::<Vector3<f64>>::of(space, friction, &sliding), word)
    };
    (answer.determined != Forces::Impossible).then_some(answer.forces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{ContactRows, MechanismFields};
    use crate::math::random::Random;
    use crate::modes::contact_modes;

    /// Coordinates with little coupling, and rows that point in all directions.
    fn mechanism(random: &mut Random, dof: usize, count: usize) -> Result<Mechanism, Error> {
        let mut row = || (0..dof).map(|_| random.between(-1.0, 1.0)).collect::<Vec<f64>>();
        let rows: Vec<[Vec<f64>; 2]> = (0..count).map(|_| [row(), row()]).collect();
        let down = |k: usize| rows.iter().map(|[normal, _]| normal[k]).sum::<f64>();
        let load = row().iter().enumerate().map(|(k, side)| side - 2.0 * down(k)).collect();
        let mass = |i: usize, j: usize| if i == j { 1.0 + 0.2 * i as f64 } else { 0.1 };
        let contacts = rows.into_iter().map(|[normal, tangential]| ContactRows {
            normal,
            tangential,
            friction: 0.6,
            ..ContactRows::default()
        });
        Mechanism::new(MechanismFields {
            mass_matrix: (0..dof).map(|i| (0..dof).map(|j| mass(i, j)).collect()).collect(),
            contacts: contacts.collect(),
            load,
            ..MechanismFields::default()
        })
    }

    #[test]
    fn a_simulation_goes_on_with_the_consistent_words() {
        let mut random = Random(8);
        let (mut cases, mut several, mut fast) = (0, 0, 0);
        for case in 0..400 {
            let (dof, count) = (2 + case % 4, 1 + case % 3);
            let Ok(mechanism) = mechanism(&mut random, dof, count) else { continue };
            let signs = [Some(0), Some(0), Some(1), Some(-1), None];
            let sign = |_| signs[(random.between(0.0, 5.0) as usize).min(4)];
            let sliding: Vec<Option<i8>> = (0..count).map(sign).collect();
            let problem = MechanismProblem::new(&mechanism, &sliding).unwrap();
            let modes = contact_modes(&problem, Method::Enumerate).unwrap();
            let (space, friction) = (mechanism.contact_space(), vec![0.6; count]);
            let found = onward(space, &friction, &sliding).unwrap();
            let consistent: Vec<_> = modes.consistent().collect();
            assert_eq!(found.len(), consistent.len(), "{case}");
            for (one, answer) in found.iter().zip(consistent) {
                assert!(one.word.iter().copied().eq(answer.word.modes()), "{case}");
                assert_eq!(one.undetermined, answer.determined == Forces::Undetermined, "{case}");
                let forces = forces(space, &friction, answer.word).unwrap();
                let size = forces.iter().flatten().fold(10.0_f64, |most, f| most.max(f.abs()));
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * size * size;
                let acceleration = space.acceleration(dof, &one.acceleration);
                let same = acceleration.iter().zip(&answer.acceleration).all(|(a, b)| near(*a, *b));
                assert!(same, "{case}: {acceleration:?} {answer:?}");
                let flat = |of: &[[f64; 2]]| of.iter().flatten().copied().collect::<Vec<_>>();
                let mut both = flat(&forces).into_iter().zip(flat(&answer.forces));
                assert!(both.all(|(a, b)| near(a, b)), "{case}: {forces:?} {answer:?}");
            }
            cases += 1;
            several += usize::from(found.len() > 1);
            fast += usize::from(dof <= 3 && only_onward(space, &friction, &sliding).is_some());
        }
        assert!(cases > 300 && several > 5 && fast > 50, "{cases} {several} {fast}");
    }
}

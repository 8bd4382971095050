//! Small motions of an assembly.

use crate::assembly::excitation::SystemExcitation;
use crate::assembly::system::System;
use crate::error::Error;
use crate::options::Options;
use crate::simulate::simulate_mechanism_until;
use crate::simulate::trajectory::Trajectory;

impl System {
    /// The motion from this displacement and these rates of its bodies, as [`simulate_mechanism_until`]. The contacts keep their places on the bodies: it warns of a
    /// joint of two bodies that have slid past each other at the end.
    ///
    /// ```
    /// use standfast::assembly::{Rigid, System, SystemExcitation, SystemFields};
    /// use standfast::{Options, Outcome};
    ///
    /// // Two bricks are dropped by a millimetre, the upper one by two.
    /// let brick = |y| Rigid::block(1.0, 1.0, [0.0, y], 0.0, 1.0);
    /// let bodies = vec![("low".into(), brick(0.0)?), ("high".into(), brick(1.0)?)];
    /// let stack = System::new(SystemFields { bodies, ..SystemFields::default() })?;
    /// let (q, still) = ([0.0, 0.001, 0.0, 0.0, 0.002, 0.0], [0.0; 6]);
    /// let run = stack.simulate_until(&q, &still, &Options::default(), &SystemExcitation::default(), &|| false)?;
    /// assert_eq!(run.outcome(), Outcome::Rest);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`System::mechanism`], [`System::excitation`] and [`simulate_mechanism_until`].
    pub fn simulate_until(
        &self,
        q: &[f64],
        qdot: &[f64],
        options: &Options,
        excitation: &SystemExcitation,
        cancel: &dyn Fn() -> bool,
    ) -> Result<Trajectory, Error> {
        let acting = self.excitation(excitation, options.time)?;
        let run = simulate_mechanism_until(&self.mechanism()?, q, qdot, options, &acting, cancel)?;
        let past = run.coordinates().and_then(|[end, _]| self.slid_past(&end));
        Ok(match past {
            Some(name) => run.warned(format!(
                "{name}: the bodies have slid past each other; contacts keep their places on the bodies, so the motion is that of small displacements only"
            )),
            None => run,
        })
    }

    /// The first contact of a flush joint of two bodies that has slid by more than the length of the joint.
    fn slid_past(&self, q: &[f64]) -> Option<String> {
        let contacts = self.contacts();
        let slid = |k: usize| {
            let [tangential, _] = self.rows(&contacts[k]);
            let parts = tangential.iter().map(|(body, row)| {
                row.iter().zip(&q[3 * body..]).map(|(part, value)| part * value).sum::<f64>()
            });
            parts.sum::<f64>().abs()
        };
        let joint = |k: usize| (contacts[k].body, contacts[k].on, contacts[k].slope.to_bits());
        let apart = |k: usize, l: usize| {
            let [a, b] = [k, l].map(|at| nalgebra::Vector2::from(contacts[at].point));
            (a - b).norm()
        };
        let length = |k: usize| {
            let others = (0..contacts.len()).filter(|&l| joint(l) == joint(k));
            others.map(|l| apart(k, l)).fold(0.0, f64::max)
        };
        let past = |&k: &usize| contacts[k].on.is_some() && length(k) > 0.0 && slid(k) > length(k);
        (0..contacts.len()).find(past).map(|k| self.contact_names()[k].clone())
    }
}

//! Kicks, forces and a motion of the ground on the bodies of an assembly.

use crate::assembly::rigid::Rigid;
use crate::assembly::system::System;
use crate::error::Error;
use crate::excitation::{
    Excitation, Force, GroundMotion, Interpolation, Kick, MechanismExcitation,
};

/// What acts on the bodies of an assembly during a run besides gravity and contact. Bodies count from 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SystemExcitation {
    /// The kicks, each on a body; its point in the posture.
    pub kicks: Vec<(usize, Kick)>,
    /// The forces, each through the centre of mass of a body.
    pub forces: Vec<(usize, Force)>,
    /// The motion of the ground, in steps.
    pub ground_motion: Option<GroundMotion>,
}

impl System {
    /// The same in the coordinates of the mechanism, relative to the ground. `start`: time on the clock at the start of the run, in s.
    ///
    /// ```
    /// use standfast::assembly::{Rigid, System, SystemExcitation, SystemFields};
    /// use standfast::excitation::GroundMotion;
    ///
    /// // The ground accelerates to the right for a second: −m A acts on a block of 2 kg.
    /// let bodies = vec![("block".into(), Rigid::block(1.0, 2.0, [0.0, 0.0], 0.0, 1.0)?)];
    /// let system = System::new(SystemFields { bodies, ..SystemFields::default() })?;
    /// let (times, acceleration) = (vec![0.0, 1.0], vec![[3.0, 0.0], [0.0, 0.0]]);
    /// let shake = GroundMotion { times, acceleration, ..GroundMotion::default() };
    /// let shaken = SystemExcitation { ground_motion: Some(shake), ..SystemExcitation::default() };
    /// assert_eq!(system.excitation(&shaken, 0.0)?.loads[0], (0.0, vec![-6.0, 0.0, 0.0]));
    /// // There is no second body.
    /// let kicked = SystemExcitation { kicks: vec![(1, Default::default())], ..Default::default() };
    /// assert!(system.excitation(&kicked, 0.0).is_err());
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`] naming the field; a body that is not there; a linear motion of the ground.
    pub fn excitation(
        &self,
        given: &SystemExcitation,
        start: f64,
    ) -> Result<MechanismExcitation, Error> {
        let (bodies, gravity) = (&self.fields().bodies, self.fields().gravity);
        let linear = |motion: &GroundMotion| motion.interpolation == Interpolation::Linear;
        if given.ground_motion.as_ref().is_some_and(linear) {
            return Err(Error::Unusable {
                field: "ground_motion.interpolation".into(),
                value: "\"linear\"".into(),
                allowed:
                    "an assembly takes only \"steps\", as of GroundMotion(times, acceleration)"
                        .into(),
            });
        }
        let check = |k: usize, of: &Excitation| match bodies.get(k) {
            Some((_, body)) => of.validate(start, body.mass, gravity),
            None => Err(Error::Unusable {
                field: if of.kicks.is_empty() { "forces.1.body" } else { "kicks.1.body" }.into(),
                value: k.to_string(),
                allowed: format!("a body, from 0 to {}", bodies.len() - 1),
            }),
        };
        for (n, (k, kick)) in given.kicks.iter().enumerate() {
            let one = Excitation { kicks: vec![*kick], ..Excitation::default() };
            check(*k, &one).map_err(|e| e.renamed(|field| numbered(field, n)))?;
        }
        for (n, (k, force)) in given.forces.iter().enumerate() {
            let one = Excitation { forces: vec![*force], ..Excitation::default() };
            check(*k, &one).map_err(|e| e.renamed(|field| numbered(field, n)))?;
        }
        let own = |k: usize| Excitation {
            kicks: Vec::new(),
            forces: given.forces.iter().filter(|of| of.0 == k).map(|of| of.1).collect(),
            ground_motion: given.ground_motion.clone(),
        };
        let of_bodies: Vec<Excitation> = (0..bodies.len()).map(own).collect();
        of_bodies.iter().enumerate().try_for_each(|(k, own)| check(k, own))?;
        let motion = given.ground_motion.iter().flat_map(|motion| &motion.times);
        let forces = given.forces.iter().flat_map(|(_, force)| [&force.start, &force.end]);
        let mut times: Vec<f64> = motion.chain(forces).copied().collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let load = |time: f64| {
            let wrench = |(own, (_, body)): (&Excitation, &(String, Rigid))| {
                own.wrench(time, body.mass, gravity)
            };
            of_bodies.iter().zip(bodies).flat_map(wrench).collect()
        };
        let impulse = |(k, kick): &(usize, Kick)| {
            let center = bodies[*k].1.center_of_mass;
            let [x, y] = kick.impulse;
            let [px, py] = kick.point.unwrap_or(center);
            let mut all = vec![0.0; 3 * bodies.len()];
            let moment = (px - center[0]) * y - (py - center[1]) * x;
            all[3 * k..3 * k + 3].copy_from_slice(&[x, y, moment]);
            (kick.time, all)
        };
        Ok(MechanismExcitation {
            kicks: given.kicks.iter().map(impulse).collect(),
            loads: times.into_iter().map(|time| (time, load(time))).collect(),
        })
    }
}

/// A field of the first of a list as that of number `n`, from 0.
fn numbered(field: &str, n: usize) -> String {
    field.replacen(".1.", &format!(".{}.", n + 1), 1)
}

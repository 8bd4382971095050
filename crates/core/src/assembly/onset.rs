//! One contact mode of an assembly at rest, of any size: it holds, or this is how it begins to move.
//!
//! Up to six contacts the modes of its mechanism are enumerated. Beyond, modes are fixed points of convex programmes [De Saxcé 1998], of which the first decides whether
//! forces hold the assembly: with s_i = μ_i|a_t,i| given, the acceleration is the y nearest to the load with
//!
//! ```text
//! (n_i ± μ_i t_i)·y + s_i ≥ 0
//! ```
//!
//! and the multipliers are the forces along these edges of the cones. The next s is extrapolated from the last ones [Anderson 1965]. The word of a solution
//! near a fixed point is solved anew, as equations of its letters, and Coulomb's law is checked for the solution.

use serde::Serialize;

use crate::assembly::scaled::Scaled;
use crate::assembly::system::{Load, System};
use crate::body::{MAX_CONTACTS, MAX_DOF, Mechanism};
use crate::error::{Error, finite};
use crate::modes::{MAX_ENUMERATED, MechanismProblem, Method, Mode, ModeAnswer, contact_modes};

/// A contact mode of an assembly at rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SystemMode {
    /// A letter for each contact.
    #[serde(serialize_with = "text")]
    pub word: Vec<Mode>,
    /// The multiple of the load that acts beside gravity.
    pub factor: f64,
    /// q̈: x, y and θ of each body, in m/s² and rad/s².
    pub acceleration: Vec<f64>,
    /// (tangential, normal) of each contact, in N: where the law allows several, one of them.
    pub forces: Vec<[f64; 2]>,
}

fn text<S: serde::Serializer>(word: &[Mode], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&word.iter().map(|mode| mode.letter()).collect::<String>())
}

impl System {
    /// One contact mode at rest under gravity and `factor` times a load; `None` if none was found. Forces that hold the assembly come first; with several other
    /// modes it is one of them.
    ///
    /// ```
    /// use standfast::assembly::{Load, Rigid, System, SystemFields};
    ///
    /// // A brick on friction 1/2 under .7 g sideways slides with .2 g.
    /// let bodies = vec![("brick".into(), Rigid::block(2.0, 1.0, [0.0, 0.0], 0.0, 1.0)?)];
    /// let brick = System::new(SystemFields { bodies, gravity: 10.0, ..SystemFields::default() })?;
    /// let mode = brick.onset(Some(&Load::Acceleration([1.0, 0.0])), 7.0)?.expect("one mode");
    /// assert!((mode.acceleration[0] - 2.0).abs() < 1e-12);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`System::generalised`]; a factor that is not finite; [`Error::Solver`] if Clarabel refuses a programme of [`contact_modes`]. A build without the cargo feature `qp`
    /// finds none with more than [`MAX_CONTACTS`] contacts.
    pub fn onset(&self, load: Option<&Load>, factor: f64) -> Result<Option<SystemMode>, Error> {
        finite("factor", factor)?;
        let none = || vec![0.0; 3 * self.fields().bodies.len()];
        let load = load.map_or_else(|| Ok(none()), |load| self.generalised(load))?;
        self.begins(&load, factor)
    }

    /// As [`onset`](Self::onset), with a generalised load.
    pub(super) fn begins(&self, load: &[f64], factor: f64) -> Result<Option<SystemMode>, Error> {
        if self.is_large() || self.contacts().len() > MAX_ENUMERATED {
            let found = self.by_programmes(load, factor);
            if found.is_some() || self.is_large() {
                return Ok(found);
            }
        }
        let mut fields = self.mechanism()?.fields().clone();
        fields.load.iter_mut().zip(load).for_each(|(own, more)| *own += factor * more);
        let problem = MechanismProblem::at_rest(&Mechanism::new(fields)?);
        let modes = contact_modes(&problem, Method::Auto)?;
        let holds = |mode: &&ModeAnswer| mode.word.modes().all(|letter| letter == Mode::Fixed);
        let found = modes.consistent().find(holds).or_else(|| modes.consistent().next());
        Ok(found.map(|mode| SystemMode {
            word: mode.word.modes().collect(),
            factor,
            acceleration: mode.acceleration.clone(),
            forces: mode.forces.clone(),
        }))
    }

    /// Whether it has too many contacts or bodies for a mechanism.
    pub(super) fn is_large(&self) -> bool {
        self.contacts().len() > MAX_CONTACTS || 3 * self.fields().bodies.len() > MAX_DOF
    }

    #[cfg(not(feature = "qp"))]
    fn by_programmes(&self, _: &[f64], _: f64) -> Option<SystemMode> {
        None
    }

    #[cfg(feature = "qp")]
    fn by_programmes(&self, load: &[f64], factor: f64) -> Option<SystemMode> {
        let scaled = Scaled::new(self, load);
        let multiple = factor / scaled.unit;
        let found = programmes::search(&scaled, multiple);
        let found = found.or_else(|| programmes::by_pivots(&scaled, multiple));
        let (word, forces) = found?;
        Some(scaled.mode(word, factor, &forces))
    }
}

impl Scaled {
    /// The mode of this word with these forces.
    pub(super) fn mode(&self, word: Vec<Mode>, factor: f64, forces: &[[f64; 2]]) -> SystemMode {
        let y = self.motion(factor / self.unit, forces);
        let acceleration = self.acceleration(&y);
        SystemMode { word, factor, acceleration, forces: self.forces(forces) }
    }
}

#[cfg(feature = "qp")]
mod programmes {
    use nalgebra::{DMatrix, DVector};

    use super::{Mode, Scaled};
    use crate::math::Sparse;
    use crate::math::sparse::Programme;
    use crate::modes::{Pivoted, by_pivoting};
    use crate::tolerance::{DEPENDENT_STEP, LAW, NEAR_FIXED_POINT, SPARSE_ACCURACY, SPARSE_FINEST};

    /// Shifts, and their change by a programme.
    type Step = (DVector<f64>, DVector<f64>);
    /// y, its word, and the forces.
    type Near = (Vec<f64>, Vec<Mode>, Vec<[f64; 2]>);

    /// Largest number of programmes.
    const ROUNDS: usize = 40;
    /// Largest number of contacts of a dense tableau. With 120 contacts it takes .1 s.
    const PIVOTED: usize = 160;
    /// Number of programmes from which the next one is extrapolated.
    const MEMORY: usize = 5;
    /// Largest number of words that are solved.
    const WORDS: usize = 12;

    /// A word and forces that obey Coulomb's law, if they are found.
    pub(super) fn search(scaled: &Scaled, multiple: f64) -> Option<(Vec<Mode>, Vec<[f64; 2]>)> {
        let n = scaled.count();
        let mut tried: Vec<Vec<Mode>> = Vec::new();
        let mut shift = vec![0.0; n];
        let mut history: Vec<Step> = Vec::new();
        for _ in 0..ROUNDS {
            let (y, word, forces) = nearest(scaled, multiple, &shift, SPARSE_ACCURACY)?;
            if breach(scaled, &y, &word, &forces) <= LAW {
                return Some((word, forces));
            }
            let slides = |i: usize| scaled.friction[i] * scaled.along(i, 0, &y).abs();
            let change = DVector::from_iterator(n, (0..n).map(|i| slides(i) - shift[i]));
            if change.amax() <= NEAR_FIXED_POINT && tried.len() < WORDS && !tried.contains(&word) {
                let found = solve(scaled, multiple, &word).filter(|forces| {
                    breach(scaled, &scaled.motion(multiple, forces), &word, forces) <= LAW
                });
                if let Some(forces) = found {
                    return Some((word, forces));
                }
                tried.push(word);
            }
            if change.amax() <= LAW {
                let (y, word, forces) = nearest(scaled, multiple, &shift, SPARSE_FINEST)?;
                return (breach(scaled, &y, &word, &forces) <= LAW).then_some((word, forces));
            }
            history.push((DVector::from_vec(shift), change));
            if history.len() > MEMORY {
                history.remove(0);
            }
            shift = extrapolated(&history);
        }
        None
    }

    /// The same by pivoting, in a dense tableau: to more digits, such as those of an assembly that hardly begins to move.
    pub(super) fn by_pivots(scaled: &Scaled, multiple: f64) -> Option<(Vec<Mode>, Vec<[f64; 2]>)> {
        if scaled.count() > PIVOTED {
            return None;
        }
        let contacts = (0..scaled.count()).map(|i| {
            let mut effects = vec![[[0.0; 2]; 2]; scaled.count()];
            for axis in [0, 1] {
                scaled.effects(i, axis).for_each(|(j, effect)| effects[j][axis] = effect);
            }
            let pull = [0, 1].map(|axis| {
                let [gravity, load] = scaled.pulls(i, axis);
                gravity + multiple * load
            });
            Pivoted { friction: scaled.friction[i], sliding: Some(0), pull, effects }
        });
        let forces = by_pivoting(&contacts.collect::<Vec<_>>())?;
        let y = scaled.motion(multiple, &forces);
        let word = read(scaled, &y, &forces);
        (breach(scaled, &y, &word, &forces) <= LAW).then_some((word, forces))
    }

    /// The next shifts: s + d of the combination of the last steps whose change d is least.
    fn extrapolated(history: &[Step]) -> Vec<f64> {
        let Some(((shift, change), before)) = history.split_last() else { return Vec::new() };
        let mut next = shift + change;
        if !before.is_empty() {
            let columns = |of: &dyn Fn(&Step) -> DVector<f64>| {
                DMatrix::from_columns(&before.iter().map(of).collect::<Vec<_>>())
            };
            let changes = columns(&|(_, earlier)| change - earlier);
            let shifts = columns(&|(earlier, _)| shift - earlier);
            let mut squares = changes.tr_mul(&changes);
            let zero = DEPENDENT_STEP * squares.trace();
            (0..before.len()).for_each(|k| squares[(k, k)] += zero);
            if let Some(squares) = squares.cholesky() {
                let weights = squares.solve(&changes.tr_mul(change));
                next -= (shifts + changes) * weights;
            }
        }
        next.iter().map(|value| value.max(0.0)).collect()
    }

    /// y and the forces with which the acceleration is nearest to the load for these shifts, and their word.
    fn nearest(scaled: &Scaled, multiple: f64, shift: &[f64], accuracy: f64) -> Option<Near> {
        let free = scaled.motion(multiple, &vec![[0.0; 2]; scaled.count()]);
        let edges = scaled.edges();
        let above = edges.iter().map(|(i, edge)| (scaled.pushed(*i, *edge), -shift[*i]));
        let programme = Programme {
            squares: vec![1.0; free.len()],
            costs: free.iter().map(|part| -part).collect(),
            above: above.collect(),
            equal: Vec::new(),
            accuracy,
        };
        let forces = scaled.sum(&edges, &programme.minimise()?.multipliers);
        let y = scaled.motion(multiple, &forces);
        let word = read(scaled, &y, &forces);
        Some((y, word, forces))
    }

    /// The word of an approximate solution: of two quantities of which one must vanish, the smaller one does.
    fn read(scaled: &Scaled, y: &[f64], forces: &[[f64; 2]]) -> Vec<Mode> {
        let letter = |(i, [f_t, f_n]): (usize, &[f64; 2])| {
            let [tangential, normal] = [0, 1].map(|axis| scaled.along(i, axis, y));
            let slack = scaled.friction[i] * f_n - f_t.abs();
            if normal > *f_n {
                Mode::Separate
            } else if tangential.abs() <= slack && scaled.friction[i] > 0.0 {
                Mode::Fixed
            } else if tangential > 0.0 {
                Mode::Right
            } else {
                Mode::Left
            }
        };
        forces.iter().enumerate().map(letter).collect()
    }

    /// The least forces with which this word is a solution.
    fn solve(scaled: &Scaled, multiple: f64, word: &[Mode]) -> Option<Vec<[f64; 2]>> {
        let n = word.len();
        let free = scaled.motion(multiple, &vec![[0.0; 2]; n]);
        let dof = free.len();
        // Unknowns: y, then the forces: of a fixed contact f_t and f_n, of a sliding one f_n.
        let mut unknown: Vec<(usize, [f64; 2])> = Vec::new();
        let mut programme = Programme {
            squares: vec![0.0; dof],
            accuracy: SPARSE_ACCURACY,
            ..Programme::default()
        };
        let mut closed: Vec<(Sparse, f64)> = Vec::new();
        for (i, mode) in word.iter().enumerate() {
            let [tangent, normal] = &scaled.rows[i];
            let (at, mu) = (dof + unknown.len(), scaled.friction[i]);
            match mode {
                Mode::Separate => programme.above.push((normal.clone(), 0.0)),
                Mode::Fixed => {
                    unknown.extend([(i, [1.0, 0.0]), (i, [0.0, 1.0])]);
                    closed.extend([(tangent.clone(), 0.0), (normal.clone(), 0.0)]);
                    let edge = |side: f64| (vec![(at, side), (at + 1, mu)], 0.0);
                    programme.above.extend([1.0, -1.0].map(edge));
                }
                Mode::Right | Mode::Left => {
                    let way = mode.direction();
                    unknown.push((i, [-way * mu, 1.0]));
                    closed.push((normal.clone(), 0.0));
                    let along = tangent.iter().map(|(k, value)| (*k, way * value)).collect();
                    programme.above.extend([(along, 0.0), (vec![(at, 1.0)], 0.0)]);
                }
            }
        }
        programme.costs = vec![0.0; dof + unknown.len()];
        programme.squares.extend(unknown.iter().map(|(_, [t, n])| t * t + n * n));
        let coordinates = free.iter().enumerate();
        programme.equal = coordinates.map(|(k, pull)| (vec![(k, 1.0)], *pull)).collect();
        for (at, (i, force)) in unknown.iter().enumerate() {
            for (k, value) in scaled.pushed(*i, *force) {
                programme.equal[k].0.push((dof + at, -value));
            }
        }
        programme.equal.append(&mut closed);
        let found = programme.minimise()?;
        Some(scaled.sum(&unknown, &found.x[dof..]))
    }

    /// The largest breach of Coulomb's law by this word.
    fn breach(scaled: &Scaled, y: &[f64], word: &[Mode], forces: &[[f64; 2]]) -> f64 {
        let of = |(i, (mode, [f_t, f_n])): (usize, (&Mode, &[f64; 2]))| {
            let [tangential, normal] = [0, 1].map(|axis| scaled.along(i, axis, y));
            let most = scaled.friction[i] * f_n;
            match mode {
                Mode::Separate => f_n.abs().max(f_t.abs()).max(-normal),
                Mode::Fixed => normal.abs().max(tangential.abs()).max(-f_n).max(f_t.abs() - most),
                Mode::Right | Mode::Left => {
                    let way = mode.direction();
                    let slips = (f_t + way * most).abs();
                    normal.abs().max(-f_n).max(-way * tangential).max(slips)
                }
            }
        };
        word.iter().zip(forces).enumerate().map(of).fold(0.0, f64::max)
    }
}

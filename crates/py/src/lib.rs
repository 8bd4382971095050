//! The Python binding of standfast: it converts arguments, calls the core and maps errors.

use pyo3::prelude::*;

// In the order of use: a module uses only the modules above it.
mod error;
mod files;
mod convert;
mod interrupt;
mod holding;
mod input;
mod lists;
mod options;
mod posture;
mod mechanism;
mod assembly;
mod chain;
mod excitation;
mod modes;
mod enclosure;
mod run;
mod reduced;
mod local_model;
mod batch;
mod mechanism_scene;
mod scene;
mod stability;
mod push;
mod robustness;
mod sweep;
mod ask;

#[pymodule]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::ask::ask;
    #[pymodule_export]
    use crate::assembly::{
        PyLoadFactor, PyRigid, PySystem, PySystemContact, PySystemMode, block, load_factor, onset,
    };
    #[pymodule_export]
    use crate::batch::{PyRuns, simulate_many};
    #[pymodule_export]
    use crate::chain::{PyChain, PyFoot, PyJoint, PyLink};
    #[pymodule_export]
    use crate::enclosure::PyEnclosure;
    #[pymodule_export]
    use crate::error::SolverError;
    #[pymodule_export]
    use crate::excitation::{PyForce, PyGroundMotion, PyKick};
    #[pymodule_export]
    use crate::files::write_whole;
    #[pymodule_export]
    use crate::holding::PyHoldingTorques;
    #[pymodule_export]
    use crate::local_model::PyLocalModel;
    #[pymodule_export]
    use crate::mechanism::{PyContactRows, PyContactSpace, PyMechanism};
    #[pymodule_export]
    use crate::mechanism_scene::PyMechanismScene;
    #[pymodule_export]
    use crate::modes::{
        PyContactMode, PyContactProblem, PyMechanismProblem, PyModes, contact_modes,
    };
    #[pymodule_export]
    use crate::posture::{PyContact, PyPosture};
    #[pymodule_export]
    use crate::push::{PySmallestPush, smallest_push};
    #[pymodule_export]
    use crate::reduced::{
        PyExponents, PyFate, PyOrbit, PySelfSimilar, chatter_bound, chatter_restitution,
        clattering_bound, clattering_restitution, neimark_sacker, self_similar,
    };
    #[pymodule_export]
    use crate::robustness::{PyRobustness, robustness};
    #[pymodule_export]
    use crate::run::{PyPhase, PyRun, PyRunContact, PyZenoPoint};
    #[pymodule_export]
    use crate::scene::{PyScene, load, load_any, schema};
    #[pymodule_export]
    use crate::stability::{
        PyVerdict, equilibrium_region, friction_margin, stability, static_forces,
    };
    #[pymodule_export]
    use crate::sweep::PySweep;

    use pyo3::types::PyDict;

    use crate::input;
    use crate::options::of_call;
    use crate::run::interruptible_run;
    use crate::stability::{Standing, standing};
    use standfast::simulate::simulate_mechanism_until;
    use standfast::{Options, Simulation, State};

    /// The motion of a posture from a state on, event by event.
    ///
    /// Parameters
    /// ----------
    /// posture : Posture or Mechanism or System
    /// q : array_like, default (0, 0, 0)
    ///     Of a body (3,): displacement of the centre of mass and rotation, m, m, rad. Of a mechanism (dof,):
    ///     displacement from its posture, m or rad.
    /// qdot : array_like, default (0, 0, 0)
    ///     Its rate: (3,) m/s, m/s, rad/s; of a mechanism (dof,).
    /// kicks : sequence of Kick, default ()
    ///     Impulses on the body. Of a System a dict: one or a list for each name of a body. Of a Mechanism
    ///     pairs (time, impulse (dof,)).
    /// forces : sequence of Force, default ()
    ///     Forces through the centre of mass, each for a time. Of a System a dict, as for kicks. Of a Mechanism
    ///     pairs (time, load (dof,)): each acts beside its load until the next one.
    /// ground_motion : GroundMotion or None, default None
    ///     The motion of the ground; not for a Mechanism.
    /// model : {"auto", "local", "full"}
    ///     * "local": all Jacobian rows frozen at q = 0; only for contacts on straight lines without ends, and
    ///       the only model of a mechanism.
    ///     * "full": finite rotation.
    ///     * "auto": the local model where it is exact, because nothing turns the body, else the full model;
    ///       the full model with kicks, forces or a motion of the ground. `run.model` and `run.model_reason`
    ///       have the model and the reason.
    /// impact : {"auto", "newton", "moreau", "poisson", "stronge", "chatterjee-ruina"}
    ///     The law of impact.
    ///
    ///     * "auto": "newton" where no contact has friction, "moreau" where one has; `run.impact` has the law
    ///       that acted.
    ///     * "newton": without friction in impacts; `run.warnings` reports where a contact with friction is hit.
    ///     * the others: with friction.
    /// simultaneous : {None, "together", "first-contact-first", "last-contact-first"}
    ///     The rule for contacts that arrive at the same instant: all at once ("newton" and "moreau" only), or
    ///     one after the other. None: "together" with these two laws, "first-contact-first" with the others.
    /// stop : {"rest", "zeno", "time"}
    ///     Where the run ends: at rest, at the first Zeno point, or at time_limit.
    /// time : float, s, default 0.0
    ///     Clock at the start.
    /// time_limit : float or None, s, default None
    ///     Clock at which the run ends at the latest.
    /// event_limit : int, default 1_000_000
    ///     Largest number of events; each collision and each change of the contact modes is one event. With
    ///     record at most 20 000 000 divided by the number of contacts.
    /// sensitivity_limit : float or None, default None
    ///     Growth of a small change of the start at which the run ends, see `run.sensitivity`. With 4.5e15 it
    ///     ends where not one digit is determined any more. None: no limit.
    /// neighbourhood : float, m, default inf
    ///     Displacement of the centre of mass beyond which the body has escaped; it is checked when the kind of
    ///     motion changes.
    /// edges : {"contact", "ignore"}
    ///     What happens where a corner of the ground meets a side of a body with an outline: they touch, see
    ///     `run.contacts`; or the corner passes through, with a warning for each: the motion from then on is
    ///     not that of the whole body.
    /// jams : {"none", "impact"}
    ///     What happens where a contact slides and no contact mode is consistent (Painlevé).
    ///
    ///     * "none": with Poisson's and Stronge's law an impact without collision follows, with the others the
    ///       run is "inconsistent".
    ///     * "impact": with the others a plastic impact follows. It stops all closed contacts if their friction
    ///       can, else the one that jams.
    /// record : bool, default True
    ///     Whether the trajectory is stored.
    /// certify : bool, default False
    ///     Whether to compute intervals that are proved to contain the times of the collisions and, in the local
    ///     model, of the first Zeno point (`run.enclosure`). For one or two contacts, impacts without friction
    ///     and terrain without ends.
    ///
    /// Returns
    /// -------
    /// Run
    ///     With any kicks, forces or motion of the ground, a state of rest is left at the next kick, or change of
    ///     the forces or of the ground.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Names the field, its value and the allowed range.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> ball = sf.Posture(mass=1, gyration_radius=1, center_of_mass=(0, 0),
    /// ...                   contacts=[sf.Contact(point=(0, 0))], restitution=0.5, gravity=10)
    /// >>> sf.simulate(ball, q=(0, 5, 0), qdot=(0, 0, 0)).time     # √(2h/g)(1+e)/(1−e)
    /// 3.0
    #[pyfunction]
    #[allow(clippy::too_many_arguments, reason = "the keywords of the function in Python")]
    #[pyo3(signature = (posture, q=None, qdot=None, *, kicks=None, forces=None, ground_motion=None, **options), text_signature = "(posture, q=(0, 0, 0), qdot=(0, 0, 0), *, kicks=(), forces=(), ground_motion=None, model=\"auto\", impact=\"auto\", simultaneous=None, stop=\"rest\", time=0.0, time_limit=None, event_limit=1_000_000, sensitivity_limit=None, neighbourhood=1e999, edges=\"contact\", jams=\"none\", record=True, certify=False)")]
    fn simulate(
        py: Python<'_>,
        posture: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = input::given)] q: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = input::given)] qdot: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = input::given)] kicks: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = input::given)] forces: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = input::given)] ground_motion: Option<Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyRun> {
        let options = of_call("simulate", Options::default(), &[], options)?;
        let (q, qdot) = (q.as_ref(), qdot.as_ref());
        let given = [kicks, forces, ground_motion];
        let system = posture.cast::<PySystem>().ok();
        let posture = match standing(posture)? {
            Standing::Body(posture) => posture.0,
            Standing::Mechanism(mechanism) => {
                let still = vec![0.0; mechanism.0.dof()];
                let q = q.map_or(Ok(still.clone()), input::coordinates)?;
                let qdot = qdot.map_or(Ok(still), input::coordinate_rates)?;
                if let Some(system) = system {
                    let system = &system.get().0;
                    let excitation = crate::excitation::of_system(system, &given)?;
                    return interruptible_run(py, |cancel| {
                        system.simulate_until(&q, &qdot, &options, &excitation, cancel)
                    });
                }
                let excitation = crate::excitation::of_mechanism(&given)?;
                return interruptible_run(py, |cancel| {
                    simulate_mechanism_until(&mechanism.0, &q, &qdot, &options, &excitation, cancel)
                });
            }
        };
        let excitation = &crate::excitation::of_body(&given)?;
        let (q, qdot) =
            (q.map_or(Ok([0.0; 3]), input::q)?, qdot.map_or(Ok([0.0; 3]), input::qdot)?);
        let (start, posture) = (State::new(q, qdot), &posture);
        interruptible_run(py, |cancel| {
            Simulation { posture, start, options, excitation, cancel }.run()
        })
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

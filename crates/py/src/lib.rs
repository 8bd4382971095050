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
    /// posture : Posture or Mechanism. q, qdot : (3,) m, m, rad and per second; of a mechanism (dof,), the displacement from its posture, m or
    /// rad, and its rate. A mechanism has the model "local" only, and neither kicks nor ground_motion.
    ///
    /// model : "local" (all Jacobian rows frozen at q = 0; only for contacts on straight lines without ends), "full" (finite rotation) or
    /// "auto" (the local model where it is exact, because nothing turns the body, else the full model; run.model and run.model_reason have
    /// the model and the reason).
    ///
    /// impact : "auto" ("newton" where no contact has friction, "moreau" where one has; run.impact has the law that acted), "newton" (without
    /// friction in impacts; run.warnings reports where a contact with friction is hit), or with friction "moreau", "poisson", "stronge" or
    /// "chatterjee-ruina". simultaneous : the rule for contacts that arrive at the same instant: "together" (all at once; with "newton" and
    /// "moreau" only), "first-contact-first" or "last-contact-first". None takes "together" with these two laws and "first-contact-first" with
    /// the others.
    ///
    /// stop : "rest", "zeno" (at the first Zeno point) or "time" (at time_limit). time : clock at the start, s. time_limit : clock at
    /// which the run ends at the latest, s. event_limit : largest number of events; each collision and each change of the contact
    /// modes is one event; with record at most 20 000 000 divided by the number of contacts. sensitivity_limit : growth of a small
    /// change of the start at which the run ends, see `run.sensitivity`; with 4.5e15 it ends where not one digit is determined any more; None: no
    /// limit. neighbourhood : displacement of the
    /// centre of mass, m, beyond which the body has escaped; it is checked when the kind of motion changes.
    ///
    /// edges : what happens where a corner of the ground meets a side of a body with an outline: "contact" (they touch, see `run.contacts`) or
    /// "ignore" (the corner passes through, with a warning for each: the motion from then on is not that of the whole body).
    ///
    /// jams : what happens where a contact slides and no contact mode is consistent (Painlevé): "none" (with Poisson's and Stronge's law an
    /// impact without collision follows, with the others the run is "inconsistent") or "impact" (with the others a plastic impact
    /// follows: it stops all closed contacts if their friction can, else the one that jams).
    ///
    /// record : whether the trajectory is stored. certify : whether to
    /// compute intervals that are proved to contain the times of the collisions and, in the local model, of the first Zeno point
    /// (run.enclosure); for one or two contacts, impacts without friction and terrain without ends.
    ///
    /// kicks : sequence of Kick, impulses on the body. forces : sequence of Force, through its centre of mass, each for a time. ground_motion :
    /// GroundMotion, the motion of the ground, or None. Of a System `kicks` and `forces` are dicts, one or a list for each name of a body; of a Mechanism
    /// kicks are pairs (time, impulse (dof,)), and forces pairs (time, load (dof,)): each acts beside its load until the next one. Of a body, with any of them, "auto" takes the full model, and a state of rest is left at the
    /// next kick, or change of the forces or of the ground.
    ///
    /// Raises ValueError naming the field, its value and the allowed range.
    ///
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

"""Exact motion of planar rigid bodies on frictional contacts, through every impact.

A body dropped on its contacts bounces and clatters, infinitely often in finite time.
Every collision is computed as an event of its own. Where infinitely many collisions
accumulate, they are summed to their limit, the *Zeno point*.

>>> import math
>>> import standfast as sf
>>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
>>> run = sf.simulate(rod, q=(0, 0.011, math.asin(0.002)), qdot=(0, 0, 0))
>>> run.outcome
'rest'
>>> zeno = run.zeno_points[0]
>>> zeno.kind, zeno.contacts, f"{zeno.time:.12f} s"
('2-zeno', (1, 2), '0.047784807064 s')

Units are SI, angles are in rad, counterclockwise. Pairs have the order (tangential,
normal). Contacts are numbered from 1.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from standfast._core import (
    Block,
    Chain,
    Contact,
    ContactProblem,
    ContactRows,
    Foot,
    Force,
    GroundMotion,
    Joint,
    Kick,
    Link,
    LocalModel,
    Mechanism,
    MechanismProblem,
    MechanismScene,
    Posture,
    Rigid,
    Run,
    Scene,
    SolverError,
    System,
    SystemContact,
    Verdict,
    __version__,
    ask,
    contact_modes,
    equilibrium_region,
    friction_margin,
    load,
    load_factor,
    onset,
    schema,
    simulate,
    simulate_many,
    smallest_push,
    stability,
    static_forces,
)
from standfast.explorer import explore
from standfast.kicks import robustness
from standfast.maps import plot_map, sweep
from standfast.records import read_record

if TYPE_CHECKING:
    from standfast import certificate, results, robots, theory


#: Modules that are imported when they are first used: that of certificates alone is a quarter of the time of `import standfast`.
_LATER = ("certificate", "results", "robots", "theory")


def __getattr__(name: str) -> Any:
    """Imports a module when it is first used, and says where a name is that `results` or `theory` has."""
    if name in _LATER:
        return import_module(f"standfast.{name}")
    for holder in ("results", "theory"):
        if name in import_module(f"standfast.{holder}").__all__:
            raise AttributeError(
                f"module 'standfast' has no attribute {name!r}: it is standfast.{holder}.{name}"
            )
    raise AttributeError(f"module 'standfast' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


__all__ = [
    "Block",
    "Chain",
    "Contact",
    "ContactProblem",
    "ContactRows",
    "Foot",
    "Force",
    "GroundMotion",
    "Joint",
    "Kick",
    "Link",
    "LocalModel",
    "Mechanism",
    "MechanismProblem",
    "MechanismScene",
    "Posture",
    "Rigid",
    "Run",
    "Scene",
    "SolverError",
    "System",
    "SystemContact",
    "Verdict",
    "__version__",
    "ask",
    "certificate",
    "contact_modes",
    "equilibrium_region",
    "explore",
    "friction_margin",
    "load",
    "load_factor",
    "onset",
    "plot_map",
    "read_record",
    "results",
    "robots",
    "robustness",
    "schema",
    "simulate",
    "simulate_many",
    "smallest_push",
    "stability",
    "static_forces",
    "sweep",
    "theory",
]

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
    ContactMode,
    ContactProblem,
    ContactRows,
    ContactSpace,
    Enclosure,
    Exponents,
    Fate,
    Foot,
    Force,
    GroundMotion,
    HoldingTorques,
    Joint,
    Kick,
    Link,
    LoadFactor,
    LocalModel,
    Mechanism,
    MechanismProblem,
    MechanismScene,
    Modes,
    Orbit,
    Phase,
    Posture,
    Rigid,
    Robustness,
    Run,
    RunContact,
    Runs,
    Scene,
    SelfSimilar,
    SmallestPush,
    SolverError,
    System,
    SystemContact,
    SystemMode,
    Verdict,
    ZenoPoint,
    __version__,
    ask,
    chatter_bound,
    chatter_restitution,
    clattering_bound,
    clattering_restitution,
    contact_modes,
    equilibrium_region,
    friction_margin,
    load,
    load_factor,
    neimark_sacker,
    onset,
    schema,
    self_similar,
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
    from standfast import certificate, robots


def __getattr__(name: str) -> Any:
    """Modules that are imported when they are first used: that of certificates is a quarter of the time of `import standfast`."""
    if name in ("certificate", "robots"):
        return import_module(f"standfast.{name}")
    raise AttributeError(f"module 'standfast' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


__all__ = [
    "Block",
    "Chain",
    "Contact",
    "ContactMode",
    "ContactProblem",
    "ContactRows",
    "ContactSpace",
    "Enclosure",
    "Exponents",
    "Fate",
    "Foot",
    "Force",
    "GroundMotion",
    "HoldingTorques",
    "Joint",
    "Kick",
    "Link",
    "LoadFactor",
    "LocalModel",
    "Mechanism",
    "MechanismProblem",
    "MechanismScene",
    "Modes",
    "Orbit",
    "Phase",
    "Posture",
    "Rigid",
    "Robustness",
    "Run",
    "RunContact",
    "Runs",
    "Scene",
    "SelfSimilar",
    "SmallestPush",
    "SolverError",
    "System",
    "SystemContact",
    "SystemMode",
    "Verdict",
    "ZenoPoint",
    "__version__",
    "ask",
    "certificate",
    "chatter_bound",
    "chatter_restitution",
    "clattering_bound",
    "clattering_restitution",
    "contact_modes",
    "equilibrium_region",
    "explore",
    "friction_margin",
    "load",
    "load_factor",
    "neimark_sacker",
    "onset",
    "plot_map",
    "read_record",
    "robots",
    "robustness",
    "schema",
    "self_similar",
    "simulate",
    "simulate_many",
    "smallest_push",
    "stability",
    "static_forces",
    "sweep",
]

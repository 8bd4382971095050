"""Types of results that functions and methods return. They are for annotations and `isinstance`: nobody constructs them.

>>> import standfast as sf
>>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
>>> isinstance(sf.contact_modes(rod), sf.results.Modes)
True
"""

from standfast._core import (
    ContactMode,
    ContactSpace,
    Enclosure,
    HoldingTorques,
    LoadFactor,
    Modes,
    Phase,
    Robustness,
    RunContact,
    Runs,
    SmallestPush,
    SystemMode,
    ZenoPoint,
)

__all__ = [
    "ContactMode",
    "ContactSpace",
    "Enclosure",
    "HoldingTorques",
    "LoadFactor",
    "Modes",
    "Phase",
    "Robustness",
    "RunContact",
    "Runs",
    "SmallestPush",
    "SystemMode",
    "ZenoPoint",
]


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})

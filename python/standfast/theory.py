"""The theory of two contacts in clattering: orbits of the local model up to scale, its bounds in closed form, and its self-similar orbit.

>>> import standfast as sf
>>> round(sf.theory.clattering_bound(0.125), 15)         # (1/2 + 1/4)/(9/8)
0.666666666666667
"""

from standfast._core import (
    Exponents,
    Fate,
    Orbit,
    SelfSimilar,
    chatter_bound,
    chatter_restitution,
    clattering_bound,
    clattering_restitution,
    neimark_sacker,
    self_similar,
)

__all__ = [
    "Exponents",
    "Fate",
    "Orbit",
    "SelfSimilar",
    "chatter_bound",
    "chatter_restitution",
    "clattering_bound",
    "clattering_restitution",
    "neimark_sacker",
    "self_similar",
]


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})

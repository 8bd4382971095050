"""The atlas: scenes at which methods fail. Each entry has, for its scene, the result of a usual method, computed by code; the
exact result, from a source other than standfast; and the result of standfast."""

from . import (
    accumulations,
    clocks,
    extremes,
    friction,
    impacts,
    modes,
    roots,
    stability,
    steps,
    terrain,
)

FAMILIES = tuple(
    module.FAMILY
    for module in (
        clocks,
        roots,
        steps,
        accumulations,
        impacts,
        friction,
        terrain,
        modes,
        stability,
        extremes,
    )
)
ATLAS = [entry for family in FAMILIES for entry in family]

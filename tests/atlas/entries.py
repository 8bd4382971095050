"""The atlas: scenes at which methods fail. Each entry holds what a usual method makes of its scene, by code; what is true of it,
from a source that is not standfast; and what standfast answers."""

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

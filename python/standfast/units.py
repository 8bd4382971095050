"""The parameters and quantities of maps in words, with their units."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray

#: Description and unit of each parameter and quantity.
UNITS = {
    "mass": ("mass", "kg"),
    "gyration_radius": ("radius of gyration", "m"),
    "gravity": ("gravity", "m/s²"),
    "restitution": ("restitution", ""),
    "friction": ("friction", ""),
    "tangential_restitution": ("tangential restitution", ""),
    "slope": ("slope", "rad"),
    "radius": ("radius", "m"),
    "angle": ("angle", "rad"),
    "torque": ("torque", "N m"),
    "armature": ("armature", "kg m²"),
    "base.angle": ("angle of the base", "rad"),
    "center_of_mass.x": ("centre of mass x", "m"),
    "center_of_mass.y": ("centre of mass y", "m"),
    "point.x": ("x", "m"),
    "point.y": ("y", "m"),
    "stability": ("frictional stability", ""),
    "frictional_stability": ("frictional stability", ""),
    "by": ("argument of the verdict", ""),
    "reason": ("reason why undecided", ""),
    "stays": ("stands in a well", ""),
    "theorem_3": ("kinematic-strong and clattering (Theorem 3)", ""),
    "equilibrium": ("equilibrium", ""),
    "equilibrium_margin": ("margin of equilibrium", "m"),
    "kinematic_strong": ("kinematic-strong equilibrium", ""),
    "kinematic_strong_strict": ("kinematic-strong equilibrium, strict", ""),
    "kinematic_margin": ("margin of kinematic-strong equilibrium", ""),
    "unambiguous": ("no word but FF is consistent", ""),
    "coupling": ("coupling ψ", ""),
    "clattering": ("clattering converges (10)", ""),
    "clattering_margin": ("coupling above the bound (10)", ""),
    "chatter": ("Goyal's bound holds", ""),
    "chatter_margin": ("coupling above Goyal's bound", ""),
    "energy": ("frictionless motion comes to rest", ""),
    "delicate": ("undecided only because of the width", ""),
    "amplification": ("bound on the largest motion relative to the kick", ""),
    "fate": ("outcome of the run", ""),
    "zeno_time": ("first Zeno point", "s"),
    "size": ("size of the kick", "m/s"),
    "share": ("share of kicks withstood", ""),
    "largest_displacement": ("largest displacement of a body that comes back", "m"),
}


#: What is counted in a path, in words.
NUMBERED = {"contacts": "contact", "joint": "joint", "foot": "foot"}


def described(name: str) -> tuple[str, str]:
    """The description of a path or a quantity, and its unit.

    >>> described("contacts.2.slope"), described("gyration_radius")
    (('contact 2 slope', 'rad'), ('radius of gyration', 'm'))
    """
    kind, *rest = name.split(".", 2)
    if kind in NUMBERED:
        number, field = rest
        text, unit = UNITS[field]
        return f"{NUMBERED[kind]} {number} {text}", unit
    return UNITS[name]


def quantities(grid: "xarray.Dataset") -> list[str]:
    """The names of the quantities of a sweep, without the variables that have the numbers of words."""
    names = [str(name) for name in grid.data_vars]
    return [name for name in names if name not in {f"{of}_code" for of in names}]


def plain(value: float, form: str = "g") -> str:
    """A formatted number; zero has no sign. Python 3.10 has not the format option z."""
    text = format(value, form)
    return text[1:] if text.startswith("-") and float(text) == 0 else text

"""Messages for mistyped keywords, with the nearest keyword that the function has."""

import inspect
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from operator import attrgetter

from standfast import _core

#: Names of a time step in other programs.
STEPS = ("dt", "timestep", "time_step", "step", "h")
#: Words for a parameter in other programs and in papers.
OTHER_WORDS = {
    "friction": ("mu", "friction_coefficient", "coefficient_of_friction"),
    "restitution": ("e", "eps", "epsilon", "cor", "coefficient_of_restitution"),
    "tangential_restitution": ("e_t", "et"),
    "impact": ("law", "impact_law", "contact_law", "restitution_law"),
    "time_limit": ("t_end", "t_max", "tmax", "tf", "T", "duration", "t_final"),
    "event_limit": ("max_events", "max_steps", "max_iter", "maxiter"),
    "time": ("t0", "t_start", "start_time"),
    "gyration_radius": ("rho", "radius_of_gyration", "k"),
    "mass": ("m",),
    "gravity": ("g",),
    "center_of_mass": ("com", "cog", "center_of_gravity"),
    "slope": ("angle", "incline"),
    "qdot": ("v", "dq", "qd", "v0", "velocity", "qvel"),
    "q": ("q0", "x0", "position", "qpos"),
}


def parameters(function: Callable[..., object]) -> list[str]:
    """The names of the parameters of a function, without `self` and `options`."""
    names = inspect.signature(function).parameters
    return [name for name in names if name not in ("self", "options")]


def keywords(function: str) -> list[str]:
    """The names of the parameters of a function of the compiled module.

    >>> keywords("stability")
    ['posture', 'jams', 'width', 'trials', 'seed', 'threads', 'progress']
    """
    return parameters(attrgetter(function)(_core))


def nearest(name: str, names: Iterable[str]) -> str:
    """A question for the name that is meant; empty if none is near.

    >>> nearest("modle", ["impact", "model"]), nearest("colour", ["impact", "model"])
    ("; did you mean 'model'?", '')
    >>> nearest("dt", ["qdot", "time_limit"])
    "; there is no time step, every event is computed; 'time_limit' ends a run"
    >>> nearest("slope", ["width", "height", "terrain"])
    '; on a slope it is a polygon with turned corners on a terrain: see "A block on a slope" in the documentation'
    """
    names = list(names)
    if (
        name in ("slope", *OTHER_WORDS["slope"])
        and "terrain" in names
        and "slope" not in names
    ):
        return '; on a slope it is a polygon with turned corners on a terrain: see "A block on a slope" in the documentation'
    if name in STEPS and "time_limit" in names:
        return (
            "; there is no time step, every event is computed; 'time_limit' ends a run"
        )
    meant = [other for other, words in OTHER_WORDS.items() if name in words]
    near = [*filter(names.__contains__, meant), *get_close_matches(name, names, 1)]
    return f"; did you mean {near[0]!r}?" if near else ""


def unexpected(function: str, name: str) -> str:
    """The message for a keyword that a function does not have.

    >>> unexpected("Contact", "slop")
    "Contact() got an unexpected keyword argument 'slop'; did you mean 'slope'?"
    """
    meant = nearest(name, keywords(function))
    return f"{function}() got an unexpected keyword argument {name!r}{meant}"


def no_option(name: str) -> str:
    """What is allowed instead of an unknown option of a run: the other keywords of `simulate`.

    >>> no_option("modle")
    "the options of simulate are model, impact, ..., certify; did you mean 'model'?"
    """
    not_an_option = ("posture", "q", "qdot", "kicks", "forces", "ground_motion")
    options = [one for one in keywords("simulate") if one not in not_an_option]
    return f"the options of simulate are {', '.join(options)}{nearest(name, options)}"

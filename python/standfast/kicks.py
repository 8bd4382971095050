"""How hard a posture may be kicked: the shares of random kicks that it withstands, of one posture or over a grid of parameters."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from itertools import product
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from standfast import _core
from standfast._core import Mechanism, Posture, Robustness, Sweep
from standfast.maps import (
    attributes,
    bar,
    checked_over,
    checked_progress,
    xarray_or_not,
)
from standfast.signatures import with_names_only

if TYPE_CHECKING:
    import xarray

#: Largest number of points of a map.
MOST_POINTS = 1_000_000
#: Largest number of kicks at all points of a map together: hours.
MOST_KICKS = 1_000_000_000


@overload
def robustness(
    posture: Posture | Mechanism,
    sizes: npt.ArrayLike,
    trials: int = 1000,
    seed: int = 0,
    model: str = "full",
    *,
    over: None = None,
    threads: int | None = None,
    progress: bool | None = None,
    **options: Any,
) -> Robustness: ...
@overload
def robustness(
    posture: Posture,
    sizes: npt.ArrayLike,
    trials: int = 1000,
    seed: int = 0,
    model: str = "full",
    *,
    over: Mapping[str, npt.ArrayLike],
    threads: int | None = None,
    progress: bool | None = None,
    **options: Any,
) -> "xarray.Dataset": ...
@with_names_only
def robustness(
    posture: Posture | Mechanism,
    sizes: npt.ArrayLike,
    trials: int = 1000,
    seed: int = 0,
    model: str = "full",
    *,
    over: Mapping[str, npt.ArrayLike] | None = None,
    threads: int | None = None,
    progress: bool | None = None,
    **options: Any,
) -> "Robustness | xarray.Dataset":
    """How hard a posture may be kicked: of random kicks of each size, the share from which the body comes back.

    A kick is a velocity given to the body at rest in its posture, q = 0. Its size is √(ẋ² + ẏ² + ρ²θ̇²) = √(2 · kinetic energy / mass);
    its direction is uniform on the sphere in (ẋ, ẏ, ρθ̇). A horizontal push of impulse p through the centre of mass has the size p/mass.
    Contacts that the kick drives into the ground are hit at once, by the law of impact.

    The body comes back if it comes to rest, on no other contacts than those that touch at q = 0; if each of these touches the straight line of
    ground on which it stood, or hovers over it at less than a tenth of the size of the body (three feet on uneven ground touch together in
    one placement only); and if the body has turned by less than a quarter turn. So a box that has slid along a floor is back: see
    `largest_displacement`. A box that lies on another side, stands on a lower step, leans on a wall or has turned a somersault is not.

    Parameters
    ----------
    posture : Posture or Mechanism
        At least one contact touches at q = 0; any number of contacts, any ground. All joints of a Mechanism are locked.
    sizes : (k,) array_like, m/s, > 0
    trials : int, default 1000
        Number of kicks of each size. The directions are the same for all sizes, so that shares can be compared; those of
        more trials begin with those of fewer.
    seed : int, default 0
        Of the directions; the same seed has the same result on every machine, with any number of threads.
    model : {"full", "local", "auto"}
        As for `simulate`.
    over : mapping from str to array_like, or None, default None
        The values of parameters by their paths, as for `sweep`.
    threads : int or None, default None
        Number of threads; None uses every core.
    progress : bool or None, default None
        Whether a progress bar is shown; None shows it on a terminal if tqdm is installed.
    **options : keyword of simulate
        impact, simultaneous, time_limit, event_limit (100 000 unless given), neighbourhood, edges, jams. A body whose run
        ends at a limit, or that rests beyond the neighbourhood, is not back.

    Returns
    -------
    Robustness
        With `over` an xarray.Dataset with the variables share and largest_displacement over these parameters and size
        (needs xarray: the extra `map`).

    Raises
    ------
    ValueError
        Names the field, its value and the allowed range.

    Examples
    --------
    >>> import standfast as sf
    >>> box = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)
    >>> result = sf.robustness(box, [0.1, 1.0, 3.0])
    >>> result.share, result.interval.round(3).tolist()
    (array([1.   , 0.905, 0.231]), [[0.996, 1.0], [0.885, 0.922], [0.206, 0.258]])
    """
    checked_progress(progress)
    keywords = {
        "trials": trials,
        "seed": seed,
        "threads": threads,
        "model": model,
        **options,
    }
    if over is None:
        total = np.size(sizes) * trials if isinstance(trials, int) else 0
        with _bar(total, progress) as done:
            return _core.robustness(posture, sizes, done=done, **keywords)
    if isinstance(posture, Mechanism):
        posture = posture.posture()
    return _mapped(posture, sizes, over, progress, keywords)


def _mapped(
    posture: Posture,
    sizes: npt.ArrayLike,
    over: Mapping[str, npt.ArrayLike],
    progress: bool | None,
    keywords: dict[str, Any],
) -> "xarray.Dataset":
    """The shares over a grid of parameters."""
    package = xarray_or_not("robustness with over")
    axes = checked_over(over)
    grid = Sweep(posture, axes, ["equilibrium"])  # checks the paths and their values
    if grid.size > MOST_POINTS:
        raise ValueError(
            f"over = a grid of {grid.size} points cannot be used: at most {MOST_POINTS} points are allowed"
        )
    paths = [path for path, _ in axes]
    shape = [len(values) for _, values in axes]
    found = []
    trials = keywords["trials"]
    total = grid.size * np.size(sizes) * trials if isinstance(trials, int) else 0
    if total > MOST_KICKS:
        raise ValueError(
            f"trials = {trials} cannot be used: at most {MOST_KICKS} kicks of all sizes at all points together are allowed"
        )
    with _bar(total, progress) as done:
        for point in product(*(values.tolist() for _, values in axes)):
            parameters = dict(zip(paths, point, strict=True))
            try:
                here = posture.replace(**parameters)
                found.append(_core.robustness(here, sizes, done=done, **keywords))
            except (ValueError, _core.SolverError) as error:
                place = ", ".join(f"{path} = {v!r}" for path, v in parameters.items())
                raise type(error)(f"{error} (at {place})") from error
    variables = {
        name: (
            [*paths, "size"],
            np.array([getattr(one, name) for one in found]).reshape([*shape, -1]),
            attributes(name),
        )
        for name in ("share", "largest_displacement")
    }
    coordinates = {
        path: (path, np.asarray(values, dtype=np.float64), attributes(path))
        for path, values in axes
    }
    coordinates["size"] = ("size", found[0].sizes, attributes("size"))
    about = {
        "posture": repr(posture),
        "standfast": _core.__version__,
        "trials": found[0].trials,
        "seed": found[0].seed,
        "options": repr(found[0].options),
    }
    dataset: xarray.Dataset = package.Dataset(variables, coordinates, about)
    return dataset


@contextmanager
def _bar(total: int, progress: bool | None) -> Iterator[Callable[[int], object] | None]:
    """What counts finished kicks in a progress bar; None if there is none."""
    shown = bar(total, " kicks", progress)
    if shown is None:
        yield None
        return
    with shown:
        yield shown.update

"""Maps: quantities of a posture over a grid of its parameters.

A grid is computed in chunks, which are ranges of its points in array order. Each chunk is a picklable
call, so that any executor can run it, and its result can be saved to disk.
"""

import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, as_completed
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import numpy as np
import numpy.typing as npt

from standfast import _core
from standfast._core import Chain, Joint, Posture, Sweep, write_whole
from standfast.signatures import with_names_only
from standfast.suggest import nearest, parameters
from standfast.units import described

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Number of chunks of a grid, unless they would then have fewer than `SMALLEST` points.
CHUNKS, SMALLEST = 128, 256

#: The torques of a chain at each point of a grid, and which of the torques that hold it they are.
TORQUES: dict[str, Literal["middle", "least"] | None] = {
    "holding": "middle",
    "least": "least",
    "given": None,
}

#: Length of a hash, in bytes.
HASH = hashlib.sha256().digest_size

#: Keywords of `simulate` that `sweep` passes on for "fate" and "zeno_time".
OPTIONS = {
    "model",
    "impact",
    "simultaneous",
    "stop",
    "time",
    "time_limit",
    "event_limit",
    "sensitivity_limit",
    "neighbourhood",
    "edges",
    "record",
    "certify",
}

_Columns: TypeAlias = list[npt.NDArray[Any]]


@with_names_only
def sweep(
    posture: Posture | Chain,
    over: Mapping[str, npt.ArrayLike],
    quantity: str | Sequence[str] = "stability",
    *,
    q: npt.ArrayLike | None = None,
    qdot: npt.ArrayLike | None = None,
    threads: int | None = None,
    executor: Executor | None = None,
    cache: str | os.PathLike[str] | None = None,
    chunk: int | None = None,
    progress: bool | None = None,
    jams: str = "none",
    width: float = 1e-12,
    torques: npt.ArrayLike | None = None,
    **options: Any,
) -> "xarray.Dataset":
    """Quantities of a posture, or of a chain, over a grid of its parameters, as an xarray.Dataset.

    The result does not depend, to the bit, on threads, executor or chunks. Margins and "theorem_3" take
    microseconds a point. "stability", "by", "reason", "energy", "stays" and "delicate" may need the corner map, which takes
    longer; "amplification" (NaN where the field is None) always needs it. Needs xarray: the extra `map`.

    Parameters
    ----------
    posture : Posture or Chain
    over : mapping from str to array_like
        The values of each parameter, by its path: mass, gyration_radius, gravity, restitution, friction (of all
        contacts), center_of_mass.x, center_of_mass.y; for contact 1 (2, …) contacts.1.point.x, point.y, slope, friction,
        restitution, tangential_restitution, radius. Of a chain: gravity, restitution, friction (of all feet), armature
        (of all joints with torques), base.angle; joint.1.angle, joint.1.torque, joint.1.armature; foot.1.slope,
        foot.1.friction, and so on for other joints and feet.
    quantity : str or sequence of str, default "stability"
        * every field of a Verdict: "stability" is its frictional_stability; "by" is "undecided" where the field is None;
        * "theorem_3": kinematic_strong and clattering;
        * "fate": the outcome of a run from q, qdot;
        * "zeno_time": time of its first Zeno point in s, NaN if there is none.

        The last two are not offered for a chain. Of a chain a flag is False, and a number NaN, where the field of the
        Verdict is None.
    q, qdot : (3,) array_like or None, default None
        Start for "fate" and "zeno_time", m, m, rad and per second. Of a chain q (dof,) is its configuration.
    threads : int or None, default None
        Number of threads; None uses all cores.
    executor : concurrent.futures.Executor or None, default None
        It computes instead of threads, such as a ProcessPoolExecutor or that of a Dask client.
    cache : path_like or None, default None
        Folder for finished chunks; a later call with the same arguments reads them and computes only the missing ones.
    chunk : int or None, default None
        Number of points in a chunk.
    progress : bool or None, default None
        Whether a progress bar is shown; None shows it on a terminal if tqdm is installed.
    jams : {"none", "impact"}
        As in `stability` and `simulate`.
    width : float, from 0 to 0.1, default 1e-12
        That of the numbers, as in `stability`.
    torques : {None, "holding", "least", "given"} or array_like, N m
        The torques of the joints of a chain at each point: "holding" or "least", those of `Chain.holding_torques`, its
        choice or the least ones (where there are none, it is unstable by "not-equilibrium"); "given", those of its
        joints; an array, one for each joint of kind "torque". None is "given" if a torque varies, and "holding"
        otherwise.
    **options : keyword of simulate
        For "fate" and "zeno_time".

    Returns
    -------
    xarray.Dataset
        A variable for each quantity. A quantity of words has a second variable with their numbers, such as
        "stability_code" (int8; its attributes flag_values and flag_meanings have the words):
        `grid["stability_code"].plot()` draws it.

    Examples
    --------
    >>> import numpy as np
    >>> import standfast as sf
    >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)
    >>> grid = sf.sweep(rod, over={"gyration_radius": [0.2, 0.25, 0.3]}, quantity=["stability", "by", "coupling"])
    >>> print(grid["by"].values, grid["coupling"].values.round(3))
    ['theorem-3' 'goyal' 'neutral'] [0.724 0.6   0.471]
    """
    xarray_or_not("sweep")
    axes = checked_over(over)
    if not (executor is None or isinstance(executor, Executor)):
        raise TypeError(
            f"executor = {executor!r} cannot be used: None or a concurrent.futures.Executor is allowed"
        )
    unknown = sorted(set(options) - OPTIONS)
    if unknown:
        raise TypeError(
            f"{unknown[0]} = {options[unknown[0]]!r} cannot be used: no keyword of sweep; those of simulate are"
            f" {', '.join(sorted(OPTIONS))}{nearest(unknown[0], [*parameters(sweep), *OPTIONS])}"
        )
    if not (
        cache is None or (isinstance(cache, str | os.PathLike) and os.fspath(cache))
    ):
        kind = ValueError if cache == "" else TypeError
        raise kind(f"cache = {cache!r} cannot be used: None or a folder is allowed")
    checked_progress(progress)
    one = isinstance(quantity, str) or not isinstance(quantity, Iterable)
    names: list[Any] = [quantity] if one else list(quantity)
    if not all(isinstance(name, str) for name in names):
        raise TypeError(
            f"quantity = {quantity!r} cannot be used: a name, or a sequence of names, is allowed"
        )
    if len(set(names)) < len(names):
        raise ValueError(
            f"quantity = {names!r} cannot be used: each name is allowed only once"
        )
    hold = held(posture, axes, torques)
    posture = under(posture, torques)
    question = Sweep(posture, axes, names, q, qdot, options or None, jams, hold, width)
    parts = _divided(question.size, chunk)
    answers = _answers(question, parts, threads, executor, cache)
    columns: list[list[npt.NDArray[Any]]] = [[] for _ in names]
    found: dict[int, _Columns] = {}
    for start, answer in _shown(answers, question, parts, progress):
        found[start] = answer
    for start, _ in parts:
        for column, values in zip(columns, found.pop(start), strict=True):
            column.append(values)
    return _dataset(posture, axes, names, question, columns)


def under(posture: Any, torques: npt.ArrayLike | None) -> Any:
    """The chain whose joints of kind "torque" have these torques, unless they are a word or None."""
    if torques is None or isinstance(torques, str) or not isinstance(posture, Chain):
        return posture
    values = np.asarray(torques, dtype=float)
    moved = [k for k, joint in enumerate(posture.joints) if joint.kind == "torque"]
    if values.shape != (len(moved),):
        raise ValueError(
            f"torques = array of shape {list(values.shape)} cannot be used: one entry for each of the {len(moved)} joints with a torque"
        )
    joints = list(posture.joints)
    for k, torque in zip(moved, values.tolist(), strict=True):
        joint = joints[k]
        joints[k] = Joint(
            joint.kind,
            torque=torque,
            armature=joint.armature,
            parent=joint.parent,
            at=joint.at,
            angle=joint.angle,
        )
    return Chain(
        posture.base,
        posture.links,
        joints,
        posture.feet,
        gravity=posture.gravity,
        restitution=posture.restitution,
    )


def held(
    posture: object,
    axes: list[tuple[str, npt.NDArray[Any]]],
    torques: npt.ArrayLike | None,
) -> Literal["middle", "least"] | None:
    """Which of the torques that hold a chain its joints have at each point; None: their own."""
    if torques is not None and not isinstance(posture, Chain):
        raise ValueError(
            f"torques = {torques!r} cannot be used: only a Chain has torques"
        )
    if not isinstance(posture, Chain) or not (
        torques is None or isinstance(torques, str)
    ):
        return None
    if torques is not None and torques not in TORQUES:
        raise ValueError(
            f"torques = {torques!r} cannot be used: None, 'holding', 'least', 'given' or an array is allowed"
        )
    varies = any(path.endswith(".torque") for path, _ in axes)
    return TORQUES[torques or ("given" if varies else "holding")]


def xarray_or_not(what: str) -> Any:
    """The module xarray, which this needs; raises ImportError without it."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError(f"{what} needs xarray: pip install xarray") from error
    return xarray


def checked_over(over: object) -> list[tuple[str, npt.NDArray[Any]]]:
    """The paths of the parameters of a grid and their values; raises TypeError for anything else."""
    if not (isinstance(over, Mapping) and all(isinstance(path, str) for path in over)):
        raise TypeError(
            f"over = {over!r} cannot be used: values by the path of their parameter are allowed"
        )
    return [(path, np.asanyarray(values)) for path, values in over.items()]


def checked_progress(progress: object) -> None:
    """Raises TypeError unless it is None, True or False."""
    if not (progress is None or isinstance(progress, bool)):
        raise TypeError(
            f"progress = {progress!r} cannot be used: None, True or False is allowed"
        )


def _divided(size: int, chunk: int | None) -> list[tuple[int, int]]:
    """The chunks: ranges of points that are computed in one call.

    >>> _divided(600, None), _divided(5, 2)
    ([(0, 256), (256, 512), (512, 600)], [(0, 2), (2, 4), (4, 5)])
    """
    if chunk is None:
        chunk = max(SMALLEST, -(-size // CHUNKS))
    elif isinstance(chunk, bool) or not isinstance(chunk, int) or chunk < 1:
        raise ValueError(
            f"chunk = {chunk!r} cannot be used: None or an integer >= 1 is allowed"
        )
    return [(start, min(start + chunk, size)) for start in range(0, size, chunk)]


def answer(question: Sweep, start: int, stop: int, threads: int | None = 1) -> _Columns:
    """The call that an executor runs: the quantities at the points from `start` up to `stop`."""
    return question.run(start, stop, threads)


def _answers(
    question: Sweep,
    parts: list[tuple[int, int]],
    threads: int | None,
    executor: Executor | None,
    cache: str | os.PathLike[str] | None,
) -> Iterator[tuple[int, _Columns]]:
    """The results of all chunks with their starts; those found in the cache come first."""
    kept = None if cache is None else Kept(Path(cache), question)
    missing = []
    for part in parts:
        known = None if kept is None else kept.read(part)
        if known is None:
            missing.append(part)
        else:
            yield part[0], known
    computed: Iterable[tuple[tuple[int, int], _Columns]]
    if executor is None:
        computed = ((part, answer(question, *part, threads)) for part in missing)
    else:
        if threads is not None:
            raise ValueError(
                f"threads = {threads!r} cannot be used: with an executor only None is allowed"
            )
        store = (lambda *_: None) if kept is None else kept.write
        computed = _submitted(question, missing, executor, store)
    for part, columns in computed:
        if kept is not None and executor is None:
            kept.write(part, columns)
        yield part[0], columns


def _submitted(
    question: Sweep,
    parts: list[tuple[int, int]],
    executor: Executor,
    store: Callable[[tuple[int, int], _Columns], None],
) -> Iterator[tuple[tuple[int, int], _Columns]]:
    """Results from an executor, in the order in which they are finished. If one fails, those under way are still stored."""
    futures: dict[Future[_Columns], tuple[int, int]] = {}
    try:
        for part in parts:
            futures[executor.submit(answer, question, *part)] = part
        for future in as_completed(futures):
            columns = future.result()
            part = futures.pop(future)
            store(part, columns)
            yield part, columns
    except BaseException as error:
        under_way = [future for future in futures if not future.cancel()]
        for future in under_way:
            # After an interrupt (not an Exception) do not wait for chunks that are still running.
            if isinstance(error, Exception) or future.done():
                try:
                    columns = future.result()
                except BaseException:  # the first error is the one that is raised
                    continue
                store(futures[future], columns)
        raise


class Kept:
    """Finished chunks on disk, in one folder for each set of arguments. A chunk is stored whole or not at all.

    The file of a chunk has a hash and then the columns, one after the other. A file whose hash does not match counts as
    missing.
    """

    def __init__(self, cache: Path, question: Sweep) -> None:
        posture, over, names, q, qdot, options, jams, hold, width = (
            question.__reduce__()[1]
        )
        asked = {
            "standfast": _core.__version__,
            "build": _build(),
            "posture": repr(posture),
            "over": [(path, np.asarray(values).tolist()) for path, values in over],
            "quantity": names,
            "jams": jams,
            "hold": hold,
            "width": width,
            "q": None if q is None else np.asarray(q).tolist(),
            "qdot": None if qdot is None else np.asarray(qdot).tolist(),
            "options": None
            if options is None
            else {k: repr(v) for k, v in options.items()},
        }
        text = json.dumps(asked, indent=1, allow_nan=False)
        self.folder: Path = cache / hashlib.sha256(text.encode()).hexdigest()[:32]
        self.folder.mkdir(parents=True, exist_ok=True)
        self.dtypes: list[np.dtype[Any]] = [
            column.dtype for column in question.run(0, 0, 1)
        ]
        if not (self.folder / "question.json").exists():
            write_whole(self.folder / "question.json", text.encode())

    def read(self, part: tuple[int, int]) -> _Columns | None:
        """The result of a chunk; None if it is missing or incomplete."""
        path, count = self._path(part), part[1] - part[0]
        size = HASH + count * sum(dtype.itemsize for dtype in self.dtypes)
        # Reading a pipe would block, and a file of another size was not written here.
        if not (path.is_file() and path.stat().st_size == size):
            return None
        data = path.read_bytes()
        if data[:HASH] != _hash(path, data[HASH:]):
            return None
        columns, start = [], HASH
        for dtype in self.dtypes:
            columns.append(np.frombuffer(data, dtype, count, start))
            start += count * dtype.itemsize
        return columns

    def write(self, part: tuple[int, int], columns: _Columns) -> None:
        """Store the result of a chunk."""
        data = b"".join(column.tobytes() for column in columns)
        path = self._path(part)
        if path.exists() and not path.is_file():
            path.unlink()
        write_whole(path, _hash(path, data) + data)

    def _path(self, part: tuple[int, int]) -> Path:
        return self.folder / f"{part[0]:09d}-{part[1]:09d}.part"


def _hash(path: Path, data: bytes) -> bytes:
    """The hash of a chunk and of its file name."""
    return hashlib.sha256(f"{path.parent.name}/{path.name}\n".encode() + data).digest()


def _build() -> str:
    """A hash of the compiled module, so that results of another build are not reused."""
    return hashlib.sha256(Path(_core.__file__).read_bytes()).hexdigest()


def _shown(
    answers: Iterator[tuple[int, _Columns]],
    question: Sweep,
    parts: list[tuple[int, int]],
    progress: bool | None,
) -> Iterator[tuple[int, _Columns]]:
    """The results, with a progress bar over the points if `progress` asks for it."""
    shown = bar(question.size, " points", progress)
    if shown is None:
        yield from answers
        return
    sizes = {start: stop - start for start, stop in parts}
    with shown:
        for start, columns in answers:
            shown.update(sizes[start])
            yield start, columns


def bar(total: int, unit: str, progress: bool | None, delay: float = 0.0) -> Any:
    """A progress bar of tqdm if `progress` asks for it, else None. `progress` None asks for it on a terminal if tqdm is installed.

    delay : time before it is shown, s.
    """
    if progress is None:
        wanted = sys.stderr is not None and sys.stderr.isatty()
    else:
        wanted = progress
    if not wanted:
        return None
    try:
        from tqdm import tqdm  # type: ignore[import-untyped]
    except ImportError as error:
        if progress is None:
            return None
        raise ImportError("progress=True needs tqdm: pip install tqdm") from error
    return tqdm(total=total, unit=unit, unit_scale=True, delay=delay)


@overload
def plot_map(
    dataset: "xarray.Dataset",
    ax: None = None,
    colors: Mapping[str, Any] | None = None,
    labels: Mapping[str, str] | None = None,
    *,
    posture: Posture | None = None,
) -> "Figure": ...
@overload
def plot_map(
    dataset: "xarray.Dataset",
    ax: "Axes",
    colors: Mapping[str, Any] | None = None,
    labels: Mapping[str, str] | None = None,
    *,
    posture: Posture | None = None,
) -> "Axes": ...
@with_names_only
def plot_map(
    dataset: "xarray.Dataset",
    ax: "Axes | None" = None,
    colors: Mapping[str, Any] | None = None,
    labels: Mapping[str, str] | None = None,
    *,
    posture: Posture | None = None,
) -> "Figure | Axes":
    """Draw the quantities of a sweep over one or two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        The result of `sweep`. Its first parameter is on the horizontal axis. Words and flags are drawn as areas; the
        legend has the share of the points of each. Numbers are drawn as colours, with a line where they change their
        sign, or as a curve if there is one parameter.
    ax : matplotlib Axes or None, default None
        For a dataset of one quantity, such as `grid[["stability"]]`. Without it every quantity has a panel of 3.4 inches
        (one column of a paper) in a new figure.
    colors : mapping or None, default None
        For a word ("yes" and "no" for flags) a colour, for a quantity of numbers a map of colours, as matplotlib takes
        them. The defaults can be told apart with every kind of colour vision.
    labels : mapping or None, default None
        Texts for names of parameters, quantities and words.
    posture : Posture or None, default None
        Its contacts are drawn, too, if the parameters are center_of_mass.x and center_of_mass.y.

    Returns
    -------
    matplotlib Figure or Axes
        The figure, which a notebook shows once: it is not left open in pyplot, so that `plt.show()` does not show it; or
        `ax` if it is given.

    Raises
    ------
    ValueError
        For more than two parameters, for several quantities with `ax`, for a name in `colors` or `labels` that the
        dataset does not have, and for a word without a colour.
    TypeError
        For another kind of argument.
    ImportError
        Without matplotlib (extra `plot`).

    Examples
    --------
    >>> import numpy as np
    >>> import standfast as sf
    >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)
    >>> places = {"center_of_mass.x": np.linspace(-0.6, 0.6, 25), "center_of_mass.y": np.linspace(0, 1, 20)}
    >>> figure = sf.plot_map(sf.sweep(rod, places), colors={"stable": "teal"}, labels={"stable": "returns to rest"})
    >>> figure.savefig("map.png")                                        # doctest: +SKIP
    """
    try:
        from standfast import map_plot
    except ImportError as error:
        raise ImportError(
            "plot_map needs matplotlib: pip install matplotlib"
        ) from error
    return map_plot.draw(dataset, ax, colors, labels, posture)


def attributes(name: str) -> dict[str, str]:
    text, unit = described(name)
    return {"long_name": text, "units": unit or "1"}


def _flags(name: str, words: Sequence[str]) -> dict[str, Any]:
    """The attributes of a variable with the numbers of words, as the conventions CF have them (section 3.5, "Flags").

    The long name has the words, too, so that xarray writes them beside the scale of colours.
    """
    numbered = ", ".join(f"{code}={word}" for code, word in enumerate(words))
    return {
        "long_name": f"{described(name)[0]}: {numbered}",
        "flag_values": np.arange(len(words), dtype=np.int8),
        "flag_meanings": " ".join(words),
    }


def _dataset(
    posture: Posture | Chain,
    axes: list[tuple[str, npt.NDArray[Any]]],
    names: list[str],
    question: Sweep,
    columns: list[list[npt.NDArray[Any]]],
) -> "xarray.Dataset":
    paths = [path for path, _ in axes]
    shape = tuple(len(values) for _, values in axes)
    variables: dict[str, tuple[list[str], npt.NDArray[Any], dict[str, Any]]] = {}
    for name, words, parts in zip(names, question.words, columns, strict=True):
        values = np.concatenate(parts).reshape(shape)
        about_it = attributes(name)
        if name == "equilibrium_margin" and isinstance(posture, Chain):
            about_it["units"] = "1"
        if words is not None or values.dtype == bool:
            del about_it["units"]
        if words is None:
            variables[name] = (paths, values, about_it)
        else:
            variables[name] = (paths, np.array(words)[values], about_it)
            codes = values.astype(np.int8)
            variables[f"{name}_code"] = (paths, codes, _flags(name, words))
    coordinates = {
        path: (path, np.asarray(values, dtype=np.float64), attributes(path))
        for path, values in axes
    }
    kind = "chain" if isinstance(posture, Chain) else "posture"
    about = {kind: repr(posture), "standfast": _core.__version__}
    dataset: xarray.Dataset = xarray_or_not("sweep").Dataset(
        variables, coordinates, about
    )
    return dataset

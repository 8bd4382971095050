"""Records of the acceleration of the ground, from files."""

import re
from os import PathLike, fspath
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from standfast.signatures import with_names_only

_Floats = npt.NDArray[np.float64]

#: Standard gravity, in m/s²: the g of records.
STANDARD_GRAVITY = 9.80665
#: m/s² of one unit of a record.
UNITS = {"g": STANDARD_GRAVITY, "m/s^2": 1.0, "cm/s^2": 0.01}
#: Line of a PEER file with the number of samples and their interval, in either order of the words and the numbers.
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
WORDS_FIRST = re.compile(rf"NPTS\s*=\s*(\d+).*?DT\s*=\s*({NUMBER})", re.IGNORECASE)
NUMBERS_FIRST = re.compile(rf"^\s*(\d+)\s+({NUMBER})\s.*NPTS.*DT", re.IGNORECASE)
#: Lines before the samples of a PEER file.
HEADER = 4


@with_names_only
def read_record(
    path: str | PathLike[str], unit: Literal["g", "m/s^2", "cm/s^2"] = "g"
) -> tuple[_Floats, _Floats]:
    """Times (k,) s and acceleration (k,) m/s² of a record of the motion of the ground.

    `GroundMotion.from_record(path)` is the motion that is linear between these samples. With steps, `GroundMotion(times, acceleration)`, each
    sample holds until the next one: that moves the record by half an interval, an error of first order in it.

    Parameters
    ----------
    path : path_like
        A file of PEER (`.AT2`: four lines, of which the last has NPTS and DT, then the samples), or two columns, time in s
        and acceleration, separated by commas, semicolons or blanks; lines before the first number are skipped, and what
        follows a #.
    unit : {"g", "m/s^2", "cm/s^2"}
        Of the accelerations in the file; "g" is 9.80665 m/s².

    Returns
    -------
    (ndarray, ndarray)
        Times (k,) in s, and accelerations (k,) in m/s².

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        Names the file, the line and what was expected.

    Examples
    --------
    >>> import tempfile, numpy as np, standfast as sf
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = folder + "/pulse.csv"
    ...     with open(path, "w") as file:
    ...         _ = file.write("time, acceleration\\n0.0, 0.0\\n0.1, 0.2\\n0.2, 0.0\\n")
    ...     times, acceleration = sf.read_record(path)
    >>> acceleration.round(4).tolist()
    [0.0, 1.9613, 0.0]
    >>> sf.GroundMotion.from_record((times, acceleration), scale=1.5)
    <GroundMotion: acceleration linear between 3 times>
    """
    if unit not in UNITS:
        allowed = ", ".join(map(repr, UNITS))
        raise ValueError(f"unit = {unit!r} cannot be used: one of {allowed}")
    name = fspath(path)
    lines = Path(path).read_text(encoding="utf-8", errors="replace").splitlines()
    if name.lower().endswith(".at2"):
        times, samples = _of_peer(name, lines)
    else:
        times, samples = _of_columns(name, lines)
    return times, samples * UNITS[unit]


def _of_peer(name: str, lines: list[str]) -> tuple[_Floats, _Floats]:
    heads = lines[:HEADER]
    found = [m for line in heads for form in (WORDS_FIRST, NUMBERS_FIRST) if (m := form.search(line))]  # fmt: skip
    if not found:
        raise ValueError(
            f"{name}: the first {HEADER} lines have no NPTS= and DT=, as a file of PEER has"
        )
    count, interval = int(found[0][1]), float(found[0][2])
    samples: list[float] = []
    for number, line in enumerate(lines[HEADER:], start=HEADER + 1):
        samples += [_number(name, number, word) for word in line.split()]
    if len(samples) != count:
        raise ValueError(f"{name}: {len(samples)} samples, but NPTS = {count}")
    if not interval > 0:
        raise ValueError(f"{name}: DT = {interval} s is outside its range: > 0")
    times = np.linspace(0.0, (count - 1) * interval, count)
    return times, np.array(samples)


def _of_columns(name: str, lines: list[str]) -> tuple[_Floats, _Floats]:
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        words = re.split(r"[,;\s]+", line.partition("#")[0].strip().strip(",;"))
        if words == [""] or (not rows and not _is_number(words[0])):
            continue
        if len(words) != 2:
            raise ValueError(
                f"{name}, line {number}: {len(words)} columns; two are needed, time in s and acceleration"
            )
        row = [_number(name, number, word) for word in words]
        if rows and row[0] <= rows[-1][0]:
            raise ValueError(
                f"{name}, line {number}: time {row[0]} s after {rows[-1][0]} s; increasing times are needed"
            )
        rows.append(row)
    if not rows:
        raise ValueError(f"{name}: no line begins with a number")
    table = np.array(rows)
    return table[:, 0], table[:, 1]


def _is_number(word: str) -> bool:
    return re.fullmatch(NUMBER, word) is not None


def _number(name: str, line: int, word: str) -> float:
    if not _is_number(word):
        raise ValueError(f"{name}, line {line}: {word!r} is no number")
    return float(word)

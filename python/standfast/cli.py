"""The command line: `standfast run SCENE`, `animate`, `explore`, `modes`, `stability`, `check`, `robustness`, `map`, `schema`.

`EXIT_CODES` has the exit codes.
"""

import math
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from json import dumps, loads
from pathlib import Path
from typing import Annotated, Any, Protocol, cast

import numpy as np
from cyclopts import (
    App,
    CycloptsError,
    MissingArgumentError,
    Parameter,
    Token,
    UnusedCliTokensError,
)

import standfast as sf
from standfast._core import load_any, write_whole
from standfast.animation import NEEDS, SUFFIXES
from standfast.report import account
from standfast.table import map_table

#: Formats of a picture.
PICTURES = (".png", ".pdf", ".svg")

#: Largest number of values of a parameter of a map. More values are a mistake, and their array would fill the memory.
MOST_VALUES = 10_000_000

#: Options of a scene that its kicks take over. Limits of time belong to the motion of the scene.
KICKED = (
    "impact",
    "simultaneous",
    "event_limit",
    "neighbourhood",
    "edges",
    "jams",
)

#: The path that stands for standard output.
STDOUT = Path("-")

#: What a command needs, in words, by the name of the argument.
NEEDED = {
    "--out": "a file for the film, such as film.gif or film.mp4",
    "--scene": "a scene file, TOML or JSON, such as examples/stairs.toml",
    "--certificate": "a certificate, which standfast stability SCENE --certificate FILE writes",
    "--sizes": "--sizes SIZE,SIZE,... in m/s, such as --sizes 0.1,0.2,0.5",
    "--over": "--over PATH=LOW:HIGH:COUNT, such as --over center_of_mass.x=-1:1:200",
}

#: The end of every help page.
EXIT_CODES = """Exit codes:
  0: there is a result, whatever its outcome.
  1: a solver failed, or the reader of standard output closed it.
  2: wrong input; one line on standard error names it.
  130: interrupted."""

app: App = App(
    name="standfast",
    help="Exact motion of planar rigid bodies on frictional contacts, and the stability of their postures.",
    version=sf.__version__,
    help_epilogue=EXIT_CODES,
    help_format="plaintext",
    help_formatter="plain",
    suppress_keyboard_interrupt=False,
)
app.register_install_completion_command(
    help="Install the completion of commands and options for bash, zsh, fish or PowerShell. This adds a line to the start file of"
    " the shell."
)


def _path(_: object, tokens: Sequence[Token]) -> Path:
    """The path as given. An empty path is refused, because `Path("")` is the current folder."""
    if not tokens[0].value:
        raise ValueError("the path is empty")
    return Path(tokens[0].value)


def _output(hint: object, tokens: Sequence[Token]) -> Path:
    """As `_path`; "-" is standard output, and "./-" a file of that name. A forgotten path must not make a path of the next option."""
    path, text = _path(hint, tokens), tokens[0].value
    if text != "-" and text.startswith("-"):
        raise ValueError(f"{text} is an option; a path is needed, or -")
    return path.absolute() if path == STDOUT and text != "-" else path


#: The option --json.
_JSON = Parameter(negative=(), converter=_output, allow_leading_hyphen=True)


def _whole(_: object, tokens: Sequence[Token]) -> int:
    """An integer in decimal digits; other numbers are refused and not rounded."""
    text = tokens[0].value
    if not (text.isascii() and text.isdigit()):
        raise ValueError(f"{text!r} is not an integer >= 0")
    return int(text)


def _numbers(_: object, tokens: Sequence[Token]) -> list[float]:
    """Numbers between commas."""
    found = []
    for token in tokens:
        for text in token.value.split(","):
            try:
                found.append(float(text))
            except ValueError:
                raise ValueError(f"{text!r} is not a number") from None
    return found


@app.command
def run(
    scene: Annotated[Path, Parameter(converter=_path)],
    *,
    json: Annotated[Path | None, _JSON] = None,
    plot: Annotated[Path | None, Parameter(negative=(), converter=_path)] = None,
) -> None:
    """Simulate a scene and print a report of the run.

    Parameters
    ----------
    scene
        Scene file, TOML or JSON.
    json
        Write the whole run to this file, as JSON. With "-" the JSON goes to standard output and the report to standard error.
    plot
        Draw the run into this file: .png, .pdf or .svg. Needs matplotlib.
    """
    _writable(json, "--json", scene)
    _drawable(plot, scene)
    if json is not None and plot is not None and json.resolve() == plot.resolve():
        raise ValueError(f"--plot {plot}: is also the file of --json")
    loaded = load_any(scene)
    with _of(scene):
        result = loaded.simulate(**({} if plot is None else {"record": True}))
    _tell(result, account(result, scene.name), json)
    if plot is not None:
        result.plot(plot)
        _report(f"wrote {plot}", json)


@app.command
def animate(
    scene: Annotated[Path, Parameter(converter=_path)],
    out: Annotated[Path, Parameter(converter=_path)],
    *,
    fps: Annotated[float, Parameter(negative=())] = 30.0,
    speed: Annotated[float, Parameter(negative=())] = 1.0,
    clock: Annotated[str, Parameter(negative=())] = "real",
) -> None:
    """Simulate a scene and write a film of the run.

    Parameters
    ----------
    scene
        Scene file, TOML or JSON.
    out
        File of the film: .gif or .mp4, which need matplotlib, and .mp4 the program ffmpeg; or .html, a page that plays it.
    fps
        Frames per second.
    speed
        Seconds of the run in one second of the film; with --clock zeno decades of the time left to the next Zeno point.
    clock
        "real", or "zeno": the impacts before a Zeno point are evenly spaced.
    """
    _writable(out, "out", scene)
    if out.suffix.lower() not in NEEDS:
        raise ValueError(f"out {out}: the name must end in {SUFFIXES}")
    loaded = sf.load(scene)
    with _of(scene):
        result = loaded.simulate(record=True)
    try:
        result.animate(out, fps, speed, cast(Any, clock))
    except ImportError as error:
        raise ValueError(str(error)) from error
    except ValueError as error:
        raise ValueError(f"{_of_film(str(error), scene)}: {error}") from error
    _say(f"wrote {out}")


def _of_film(problem: str, scene: Path) -> str:
    """The option of a film that was refused, or the scene file if it is none of the options."""
    name = problem.partition(" = ")[0]
    return f"--{name}" if name in ("fps", "speed", "clock") else str(scene)


@app.command
def explore(
    scene: Annotated[Path | None, Parameter(converter=_path)] = None,
    *,
    port: Annotated[int, Parameter(converter=_whole)] = 0,
    browser: bool = True,
) -> None:
    """Open a page in the browser, to drag and kick a body and see at once whether it stands and how it moves.

    The page is served on this machine only, under an address that is printed. The command ends when the page is closed, or with Ctrl-C.

    Parameters
    ----------
    scene
        Scene file, TOML or JSON. Without one, the page begins with an example.
    port
        Port on 127.0.0.1. 0: one that is free.
    browser
        Whether to open the address in the browser.
    """
    import webbrowser

    from standfast.page import PATIENCE, explorer_page
    from standfast.server import serve

    if port > 65535:
        raise ValueError(f"--port {port}: at most 65535")
    begin: Any = None
    if scene is not None:
        sf.load(scene)
        begin = scene.read_text(encoding="utf-8-sig")
        if scene.suffix.lower() == ".json":
            begin = loads(begin)

    def opened(address: str) -> None:
        _say(f"{address}\nends when the page is closed, or with Ctrl-C")
        if browser:
            webbrowser.open(address)

    # A page that is left ends the command, however it is left.
    with suppress(KeyboardInterrupt):
        serve(
            explorer_page(begin),
            lambda question: sf.ask(question, seconds=PATIENCE),
            port=port,
            opened=opened,
        )


@app.command
def modes(
    scene: Annotated[Path, Parameter(converter=_path)],
    *,
    json: Annotated[Path | None, _JSON] = None,
) -> None:
    """Print the contact modes that Coulomb's law allows at the start of a scene, before kicks; of a mechanism or an assembly, at rest in its posture.

    Of an assembly of more than 64 contacts or 33 bodies it is one mode, that of `standfast.onset`.

    Parameters
    ----------
    scene
        Scene file, TOML or JSON.
    json
        Write the modes with their motion, forces and margins to this file, as JSON. With "-" the JSON goes to standard output
        and the report to standard error.
    """
    _writable(json, "--json", scene)
    start = load_any(scene)
    if isinstance(start, sf.MechanismScene):
        with _of(scene):
            if start.system is not None and _is_large(start.system):
                if json is not None:
                    raise ValueError("--json: at most 64 contacts and 33 bodies")
                one = sf.onset(start.system)
                _report(f"{scene.name}\n{one or 'no mode was found'}", json)
                return
            at_rest = sf.contact_modes(start.mechanism)
        _tell(at_rest, f"{scene.name}\n{at_rest}", json)
        return
    asked = (start.posture, start.q, start.qdot)
    with _of(scene):
        found = sf.contact_modes(*asked, wrench=start.wrench)
        if found.status == "found":  # a search gives one word; the table needs all
            found = sf.contact_modes(*asked, method="enumerate", wrench=start.wrench)
    _tell(found, f"{scene.name}\n{found}", json)


def _is_large(system: sf.System) -> bool:
    """Whether an assembly is too large for the questions to a mechanism."""
    try:
        _ = system.mechanism
    except ValueError:
        return True
    return False


def _standing(scene: sf.Scene | sf.MechanismScene) -> sf.Posture | sf.Mechanism:
    """What stands in a scene."""
    return scene.mechanism if isinstance(scene, sf.MechanismScene) else scene.posture


@app.command
def stability(
    scene: Annotated[Path, Parameter(converter=_path)],
    *,
    jams: Annotated[str | None, Parameter(negative=())] = None,
    width: float = 1e-12,
    trials: Annotated[int, Parameter(converter=_whole)] = 0,
    seed: Annotated[int, Parameter(converter=_whole)] = 0,
    json: Annotated[Path | None, _JSON] = None,
    certificate: Annotated[Path | None, Parameter(negative=(), converter=_path)] = None,
) -> None:
    """Print whether the posture of a scene is stable, with the reason.

    Parameters
    ----------
    scene
        Scene file, TOML or JSON.
    jams
        What happens where a contact jams, "none" or "impact". Without this option, what the scene says.
    width
        The verdict holds for all scenes whose numbers differ from those of the file by at most this share: 1e-3, say, for a body that was
        measured.
    trials
        Number of random small kicks to simulate as well.
    seed
        Seed of the random numbers of these kicks.
    json
        Write the verdict with its evidence to this file, as JSON. With "-" the JSON goes to standard output and the report to
        standard error.
    certificate
        Write a certificate of the verdict to this file, as JSON: `standfast check` proves the verdict again from it.
    """
    _writable(json, "--json", scene)
    _writable(certificate, "--certificate", scene)
    if (
        json is not None
        and certificate is not None
        and json.resolve() == certificate.resolve()
    ):
        raise ValueError(f"--certificate {certificate}: is also the file of --json")
    loaded = load_any(scene)
    with _of(scene):
        verdict = sf.stability(
            _standing(loaded),
            jams=cast(Any, jams or loaded.options["jams"]),
            width=width,
            trials=trials,
            seed=seed,
        )

    def certify() -> None:
        if certificate is not None:
            with _of(scene):
                found = verdict.certificate()
            write_whole(certificate, f"{dumps(found, indent=1)}\n".encode())

    with _also_if_closed(certify):
        _tell(verdict, f"{scene.name}\n{verdict}", json)
    if certificate is not None:
        _report(f"wrote {certificate}", json)


@app.command
def check(
    certificate: Annotated[Path, Parameter(converter=_path)],
    scene: Annotated[Path | None, Parameter(converter=_path)] = None,
) -> None:
    """Prove a verdict again from its certificate, in exact arithmetic and without the core. Print the claim and its scene.

    Parameters
    ----------
    certificate
        File that `standfast stability SCENE --certificate FILE` has written.
    scene
        Scene file that the certificate has to be of: the same doubles, and the same contacts that touch the ground.
    """
    with _of(certificate):
        found = sf.certificate.read(certificate)
        sf.certificate.check(found)
    if scene is not None:
        from standfast.certificate_maker import same_scene, scene_of

        loaded = load_any(scene)
        with _of(scene):
            verdict = sf.stability(_standing(loaded))
        with _of(certificate):
            same_scene(found["scene"], scene_of(verdict), scene)
    same = "" if scene is None else f"\n  the scene of {scene.name}"
    _say(f"{certificate.name}: {sf.certificate.summary(found)}{same}")


@app.command
def robustness(
    scene: Annotated[Path, Parameter(converter=_path)],
    *,
    sizes: Annotated[list[float], Parameter(negative=(), converter=_numbers)],
    trials: Annotated[int, Parameter(converter=_whole)] = 1000,
    seed: Annotated[int, Parameter(converter=_whole)] = 0,
    json: Annotated[Path | None, _JSON] = None,
    plot: Annotated[Path | None, Parameter(negative=(), converter=_path)] = None,
) -> None:
    """Print how hard the posture of a scene may be kicked: the share of random kicks from which the body comes back.

    Parameters
    ----------
    scene
        Scene file, TOML or JSON. Its posture and law of impact are used, not its start, kicks, ground motion and limits of time.
    sizes
        Sizes of the kicks in m/s, such as 0.1,0.2,0.5.
    trials
        Number of kicks of each size.
    seed
        Seed of the random directions of the kicks.
    json
        Write the result to this file, as JSON. With "-" the JSON goes to standard output and the report to standard error.
    plot
        Draw the share over the size into this file: .png, .pdf or .svg. Needs matplotlib.
    """
    _writable(json, "--json", scene)
    _drawable(plot, scene)
    if json is not None and plot is not None and json.resolve() == plot.resolve():
        raise ValueError(f"--plot {plot}: is also the file of --json")
    loaded = sf.load(scene)
    options = {name: loaded.options[name] for name in KICKED}
    model = "local" if loaded.options["model"] == "local" else "full"
    try:
        result = sf.robustness(loaded.posture, sizes, trials, seed, model, **options)
    except ValueError as error:
        name = str(error).partition(" = ")[0].partition(".")[0]
        culprit = f"--{name}" if name in ("sizes", "trials", "seed") else scene
        raise ValueError(f"{culprit}: {error}") from error
    _tell(result, f"{scene.name}\n{result}", json)
    if plot is not None:
        result.plot(plot)
        _report(f"wrote {plot}", json)


@app.command(name="map")
def sweep(
    scene: Annotated[Path, Parameter(converter=_path)],
    *,
    over: Annotated[list[str], Parameter(negative=())],
    quantity: Annotated[list[str] | None, Parameter(negative=())] = None,
    plot: Annotated[Path | None, Parameter(negative=(), converter=_path)] = None,
    netcdf: Annotated[Path | None, Parameter(negative=(), converter=_path)] = None,
    cache: Annotated[Path | None, Parameter(negative=(), converter=_path)] = None,
) -> None:
    """Map a quantity of a scene over one or more of its parameters.

    Parameters
    ----------
    scene
        Scene file, TOML or JSON.
    over
        PATH=LOW:HIGH:COUNT, such as center_of_mass.x=-1:1:200; repeat the option for another parameter.
    quantity
        Such as stability, theorem_3, clattering_margin, fate; repeat the option for another quantity.
    plot
        Draw the map into this file: .png, .pdf or .svg. Needs matplotlib.
    netcdf
        Write the map to this file, as NetCDF, for xarray and other programs. Needs scipy.
    cache
        Folder for finished parts; the same command then computes only the missing parts.
    """
    _drawable(plot, scene)
    _writable(netcdf, "--netcdf", scene)
    if netcdf is not None:
        try:
            import scipy  # type: ignore[import-untyped]  # noqa: F401
        except ImportError as error:
            raise ValueError("--netcdf needs scipy: pip install scipy") from error
    axes: dict[str, np.ndarray[Any, Any]] = {}
    for text in over:
        path, values = _axis(text)
        if path in axes:
            raise ValueError(f"--over {text}: {path} is given twice")
        axes[path] = values
    names = quantity or ["stability"]
    if plot is not None:
        from standfast.map_plot import refuse
        from standfast.plot import save

        refuse(list(axes))
    loaded = sf.load(scene)
    start: dict[str, Any] = {"jams": loaded.options["jams"]}
    if {"fate", "zeno_time"} & set(names):
        start = {"q": loaded.q, "qdot": loaded.qdot, **loaded.options}
    try:
        grid = sf.sweep(loaded.posture, axes, names, cache=cache, **start)
    except ImportError as error:
        raise ValueError(str(error)) from error
    except ValueError as error:
        raise ValueError(f"{_culprit(str(error), over, scene)}: {error}") from error
    _say("\n".join([scene.name, *map_table(grid)]))
    if plot is not None:
        save(sf.plot_map(grid, posture=loaded.posture), plot)
        _say(f"wrote {plot}")
    if netcdf is not None:
        write_whole(netcdf, bytes(grid.to_netcdf(engine="scipy")))
        _say(f"wrote {netcdf}")


def _culprit(problem: str, over: Sequence[str], scene: Path) -> str:
    """The option that was refused, or the scene file if it is none of the options."""
    if problem.startswith("quantity = "):
        return "--quantity"
    for text in over:
        path = text.partition("=")[0]
        if problem.startswith((f"{path} = ", f'over = "{path}" ')):
            return f"--over {text}"
    return "--over" if problem.startswith("over = ") else str(scene)


def _axis(text: str) -> tuple[str, np.ndarray[Any, Any]]:
    """The path of a parameter and its values.

    >>> _axis("center_of_mass.x=-1:1:5")
    ('center_of_mass.x', array([-1. , -0.5,  0. ,  0.5,  1. ]))
    """
    path, _, numbers = text.partition("=")
    try:
        low, high, count = numbers.split(":")
        ends = float(low), float(high)
        points = int(count)
    except ValueError:
        points = 0
        ends = (math.nan, math.nan)
    if not (points >= 1 and all(map(math.isfinite, (*ends, ends[1] - ends[0])))):
        raise ValueError(
            f"--over {text}: PATH=LOW:HIGH:COUNT is needed, such as center_of_mass.x=-1:1:200"
        )
    if points > MOST_VALUES:
        raise ValueError(f"--over {text}: at most {MOST_VALUES} values")
    return path, np.linspace(*ends, points)


@app.command
def schema() -> None:
    """Print the JSON Schema of scene files."""
    _say(sf.schema().rstrip())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    try:
        with _printing():
            if isinstance(sys.stdout, TextIOWrapper):
                # A character that the encoding of the terminal lacks must not stop the output.
                sys.stdout.reconfigure(errors="replace")
            app(
                arguments,
                exit_on_error=False,
                print_error=False,
                result_action="return_value",
            )
    except KeyboardInterrupt:
        return _complain("interrupted", 130)
    except SystemExit:
        # --install-completion does not know the shell, and has said so.
        return 2
    except BrokenPipeError:
        # The reader has closed the pipe, as in `standfast ... | head`.
        return 1
    except sf.SolverError as error:
        return _complain(str(error), 1)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _complain(f"{where}{error.strerror or error}", 2)
    except UnusedCliTokensError as error:
        return _complain(
            f"too many arguments: {' '.join(error.unused_tokens or [])}", 2
        )
    except MissingArgumentError as error:
        needed = NEEDED.get(error.argument.name if error.argument else "")
        command = " ".join(error.command_chain or ())
        text = f"{command} needs {needed}; standfast {command} --help says more"
        return _complain(text if needed else str(error), 2)
    except (CycloptsError, ValueError) as error:
        return _complain(str(error), 2)
    return 0


@contextmanager
def _of(scene: Path) -> Iterator[None]:
    """Put the path of the scene before the message of an error."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{scene}: {error}") from error


@contextmanager
def _printing() -> Iterator[None]:
    """Name standard output in the error if it cannot be written."""
    try:
        yield
        if sys.stdout is not None:  # None: it was closed from the start.
            sys.stdout.flush()
    except OSError as error:
        if error.filename is not None:
            raise
        # Discard the buffered output; otherwise the interpreter would try to write it again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        raise OSError(error.errno, error.strerror, "standard output") from error


def _say(text: str) -> None:
    print(text, flush=True)


class _Result(Protocol):
    """A run, modes or a verdict."""

    def to_dict(self) -> dict[str, Any]: ...
    def to_json(self, path: Path) -> None: ...


@contextmanager
def _also_if_closed(write: Callable[[], object]) -> Iterator[None]:
    """Calls `write` after its block, also if the reader of standard output has closed it."""
    try:
        yield
    except BrokenPipeError:
        write()
        raise
    write()


def _tell(result: _Result, report: str, json: Path | None) -> None:
    """Print a report, and write the result to the file of --json if there is one."""

    def write() -> None:
        if json is not None and json != STDOUT:
            result.to_json(json)

    with _also_if_closed(write):
        _report(report, json)
    if json == STDOUT:
        _say(dumps(result.to_dict(), indent=2))
    elif json is not None:
        _say(f"wrote {json}")


def _report(text: str, json: Path | None) -> None:
    """Print a text on standard output, or on standard error if the JSON is on standard output."""
    if json != STDOUT:
        _say(text)
    elif sys.stderr is not None:
        print(text, file=sys.stderr, flush=True)


def _complain(problem: str, code: int) -> int:
    if sys.stderr is not None:
        print(f"standfast: {_one_line(problem)}", file=sys.stderr)
    return code


def _one_line(text: str) -> str:
    """A message of several lines as one."""
    return ": ".join(line.strip().rstrip(":") for line in text.splitlines() if line)


def _writable(path: Path | None, option: str, scene: Path) -> None:
    """Refuse an output file that cannot be written, or that is the scene file, before the computation starts."""
    if path is None or path == STDOUT:
        return
    if path.exists() and scene.exists() and path.samefile(scene):
        raise ValueError(f"{option} {path}: is the scene file")
    if path.is_dir():
        raise ValueError(f"{option} {path}: is a directory")
    if not path.parent.is_dir():
        raise ValueError(f"{option} {path}: {path.parent} is not a directory")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise ValueError(f"{option} {path}: cannot be written")


def _drawable(path: Path | None, scene: Path) -> None:
    if path is None:
        return
    if path.suffix.lower() not in PICTURES:
        raise ValueError(f"--plot {path}: the name must end in {', '.join(PICTURES)}")
    _writable(path, "--plot", scene)
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise ValueError("--plot needs matplotlib: pip install matplotlib") from error


if __name__ == "__main__":
    sys.exit(main())

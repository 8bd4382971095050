"""The command line: its output, its files and its error messages."""

import json
import math
import os
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import standfast as sf
from bodies import paper_vee
from cyclopts.completion import ShellDetectionError
from standfast.cli import EXIT_CODES, main
from standfast.report import decimal

EXAMPLES = Path(__file__).parents[2] / "examples"
ROD = EXAMPLES / "clattering_rod.toml"
ENDLESS = """
restitution = 0.05
gravity = 9.81
[body]
mass = 1.0
gyration_radius = 0.5
center_of_mass = [0.0, 0.2]
[[contact]]
point = [-1.0, 0.0]
slope = -0.35
[[contact]]
point = [1.0, 0.0]
slope = 0.35
[start]
q = [0.001, 0.01, 0.0]
qdot = [0.0, 0.0, 0.0]
[run]
model = "full"
stop = "time"
time_limit = 1e12
event_limit = 1000000000000
record = false
"""


def refusal(capsys, *arguments, code=2):
    """The one line on stderr for arguments that are refused."""
    assert main([str(argument) for argument in arguments]) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.endswith("\n")
    assert captured.err.count("\n") == 1, captured.err
    assert captured.err.startswith("standfast: ")
    return captured.err


def scene(tmp_path, *, old="", new=""):
    """The scene file of the clattering rod with one text replaced."""
    text = ROD.read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "scene.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def test_run_prints_the_events(capsys):
    assert main(["run", str(ROD)]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    run = sf.load(ROD).simulate()
    for word in ("clattering_rod.toml", "full", "2-zeno", "clatter", "certified"):
        assert word in captured.out
    assert "outcome     rest at 0.0477848070642202" in captured.out
    for impact in run.impacts:
        assert decimal(impact["time"]) in captured.out


def test_times_are_decimal_and_lose_nothing(capsys):
    main(["run", str(ROD)])
    told = capsys.readouterr().out
    run = sf.load(ROD).simulate()
    times = [decimal(time) for time in (*run.impacts["time"], run.time)]
    assert all(time in told for time in times)
    assert not re.search(r"\de[-+]?\d+ s\b", told)
    for time in times:
        assert re.fullmatch(r"\d+\.\d{12,}", time), time
    for value in (0.1, 1 / 3, 1e-5, 5e-324, 12345.678, 0.0, 1e22, 0.04778480706422020):
        assert float(decimal(value)) == value
        assert re.fullmatch(r"\d+\.\d{12,}", decimal(value))


def test_a_long_table_says_what_it_leaves_out(tmp_path, capsys):
    # Restitution .5 is above the bound of clattering: many impacts are simulated one by one.
    path = scene(tmp_path, old="restitution = 0.1", new="restitution = 0.5")
    count = len(sf.load(path).simulate().impacts)
    assert count > 20
    assert main(["run", str(path)]) == 0
    assert f"... and {count - 20} more" in capsys.readouterr().out


def test_outputs_are_written(tmp_path, capsys):
    out, picture = tmp_path / "run.json", tmp_path / "run.png"
    assert main(["run", str(ROD), "--json", str(out), "--plot", str(picture)]) == 0
    assert f"wrote {out}" in capsys.readouterr().out
    run = json.loads(out.read_text(encoding="utf-8"))
    assert run == sf.load(ROD).simulate().to_dict()
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.json", "run.png"]


@pytest.mark.parametrize("command", ["run", "modes", "stability"])
def test_json_alone_on_standard_output(tmp_path, capsys, command):
    path = scene(tmp_path, old="q = [0.0, 0.011, 0.0020000013333357335]", new="")
    loaded = sf.load(path)
    result = {
        "run": lambda: loaded.simulate(),
        "modes": lambda: sf.contact_modes(loaded.posture),
        "stability": lambda: sf.stability(loaded.posture),
    }[command]().to_dict()
    assert main([command, str(path)]) == 0
    report = capsys.readouterr().out
    assert main([command, str(path), "--json", "-"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out) == result
    assert captured.err == report
    out = tmp_path / "result.json"
    assert main([command, str(path), "--json", str(out)]) == 0
    assert json.loads(out.read_text(encoding="utf-8")) == result
    assert capsys.readouterr().out == f"{report}wrote {out}\n"


def test_no_other_text_beside_the_json(tmp_path):
    done = command("run", ROD, "--json", "-", "--plot", "run.png", cwd=tmp_path)
    assert done.returncode == 0
    assert json.loads(done.stdout)["outcome"] == "rest"
    assert done.stderr.endswith(b"wrote run.png\n")
    closed = command("run", ROD, "--json", "-", preexec_fn=lambda: os.close(2))
    assert json.loads(closed.stdout)["outcome"] == "rest"
    # A file of this name.
    done = command("run", ROD, "--json", "./-", cwd=tmp_path)
    assert json.loads((tmp_path / "-").read_bytes())["outcome"] == "rest"
    assert b"clattering_rod.toml" in done.stdout


@pytest.mark.parametrize("command", [[], ["run"], ["modes"], ["map"], ["stability"]])
def test_help_has_the_exit_codes(capsys, command):
    assert main([*command, "--help"]) == 0
    told = capsys.readouterr().out
    for code in (0, 1, 2, 130):
        assert f"\n  {code}: " in told


def test_the_exit_codes_are_on_the_page():
    page = (EXAMPLES.parent / "docs" / "cli.md").read_text(encoding="utf-8")
    for line in EXIT_CODES.splitlines()[1:]:
        code, meaning = line.strip().rstrip(".").split(": ")
        assert f"{code} ({meaning})" in " ".join(page.split())


def test_completion_is_installed(tmp_path):
    script = tmp_path / "standfast.bash"
    home = {**os.environ, "HOME": str(tmp_path)}
    done = command("--install-completion", "--shell=bash", "--output", script, env=home)
    assert done.returncode == 0
    assert str(script) in (tmp_path / ".bashrc").read_text(encoding="utf-8")
    for words, expected in [("standfast ma", "map"), ("standfast run --j", "--json")]:
        *before, last = words.split()
        asked = f"""
            . {script}
            COMP_WORDS=({words}) COMP_CWORD={len(before)}
            _standfast standfast '{last}' '{before[-1]}'
            echo "${{COMPREPLY[*]}}"
        """
        said = subprocess.run(
            ["bash", "-c", asked], env=home, capture_output=True, text=True, check=True
        )
        assert said.stdout.strip() == expected


def test_completion_for_an_unknown_shell(capsys, monkeypatch):
    def unknown():
        raise ShellDetectionError

    monkeypatch.setattr("cyclopts.completion.detect.detect_shell", unknown)
    assert main(["--install-completion"]) == 2
    assert "specify --shell" in capsys.readouterr().err


def test_a_device_that_fails_is_named():
    done = command("run", ROD, "--json", "/dev/full")
    assert done.returncode == 2
    assert done.stderr.count(b"\n") == 1
    assert done.stderr.startswith(b"standfast: /dev/full: No space")


def test_standard_output_that_fails_is_named():
    for arguments in (["run", ROD], ["--version"], ["--help"]):
        with open("/dev/full", "w") as full:
            done = command(*arguments, stdout=full)
        assert done.returncode == 2
        assert done.stderr.startswith(b"standfast: standard output: ")
        assert done.stderr.count(b"\n") == 1


def test_a_closed_standard_output_is_left_alone():
    for arguments in (["run", ROD], ["--version"], ["--help"]):
        done = command(*arguments, preexec_fn=lambda: os.close(1))
        assert (done.returncode, done.stderr) == (0, b"")


def test_a_closed_standard_error_stays_closed():
    done = command("run", "nowhere.toml", preexec_fn=lambda: os.close(2))
    assert (done.returncode, done.stdout) == (2, b"")


def test_a_run_without_record_counts_its_impacts(tmp_path, capsys):
    path = scene(tmp_path, old='model = "full"', new="record = false")
    assert main(["run", str(path)]) == 0
    told = capsys.readouterr().out
    assert "impacts simulated one by one: 9, not recorded" in told
    assert "no impact" not in told


def test_what_is_proved_is_told(tmp_path, capsys):
    path = scene(tmp_path, old='model = "full"', new='model = "local"\ncertify = true')
    assert main(["run", str(path), "--json", str(tmp_path / "run.json")]) == 0
    told = capsys.readouterr().out
    enclosure = sf.load(path).simulate().enclosure
    low, high = enclosure.zeno
    assert f"{len(enclosure.impacts)} impacts within bounds" in told
    assert f"of contacts 1 and 2: from {decimal(low)} to {decimal(high)} s" in told
    written = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert written["enclosure"]["zeno"]["elapsed"] == {"low": low, "high": high}
    bounds = [impact["elapsed"]["low"] for impact in written["enclosure"]["impacts"]]
    assert bounds == list(enclosure.impacts["low"])


def test_files_are_written_though_the_report_is_not_read(tmp_path):
    files = [tmp_path / "verdict.json", tmp_path / "certificate.json"]
    read, write = os.pipe()
    os.close(read)
    with open(write, "w") as closed:
        command(
            "stability",
            ROD,
            "--json",
            files[0],
            "--certificate",
            files[1],
            stdout=closed,
        )
    for file in files:
        json.loads(file.read_text(encoding="utf-8"))


def test_an_output_may_be_a_pipe(capsys):
    done = command("run", ROD, "--json", "/dev/stderr")
    assert json.loads(done.stderr)["outcome"] == "rest"
    assert done.stdout.endswith(b"wrote /dev/stderr\n")


def test_schema_is_the_published_one(capsys):
    assert main(["schema"]) == 0
    published = Path(__file__).parents[2] / "docs" / "scene.schema.json"
    printed = capsys.readouterr().out
    assert json.loads(printed) == json.loads(published.read_text(encoding="utf-8"))


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == sf.__version__


def test_missing_file(tmp_path, capsys):
    assert "nowhere.toml" in refusal(capsys, "run", tmp_path / "nowhere.toml")


def test_directory(tmp_path, capsys):
    assert str(tmp_path) in refusal(capsys, "run", tmp_path)


def test_file_that_is_not_text(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_bytes(bytes(range(256)))
    assert "scene.toml" in refusal(capsys, "run", path)


def test_huge_file(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    with path.open("wb") as file:
        file.truncate(100_000_000)
    message = refusal(capsys, "run", path)
    assert "scene.toml" in message
    assert "MiB" in message


def test_empty_file(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.touch()
    assert refusal(capsys, "run", path) == (f"standfast: {path}: is empty\n")


def test_pipes_and_devices_are_no_scene_files(tmp_path, capsys):
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    for path in (pipe, "/dev/zero", "/dev/null"):
        message = refusal(capsys, "run", path)
        assert f"{path}: is a pipe or a device" in message


@pytest.mark.parametrize("arguments", [[""], [ROD, "--json", ""], [ROD, "--plot", ""]])
def test_an_empty_path_is_refused(capsys, arguments):
    assert "path is empty" in refusal(capsys, "run", *arguments)


def test_a_long_wrong_word_is_shortened(tmp_path, capsys):
    for old, new in [
        ('"full"', f'"{"x" * 5000}"'),
        ("gravity", "x" * 100_000),
        ("0.011", "[" * 200_000),
    ]:
        message = refusal(capsys, "run", scene(tmp_path, old=old, new=new))
        assert len(message) < 400


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("gravity = 9.81", "gravity = ", ["line"]),
        ("gravity = 9.81", "gravity = 9.81\ngravitas = 1.0", ["gravitas", "unknown"]),
        ("mass = 1.0", "mass = 1.0\ncolour = 'red'", ["colour", "unknown"]),
        ("mass = 1.0", "mass = '1'", ["line 6, column 8, body.mass: ", "a number\n"]),
        ("mass = 1.0", f"mass = {10**30}", ["body.mass", f"{10**30}`, expected a num"]),
        ("[0.0, 0.0]", "[0.0, 0.0, 0.0]", ["center_of_mass", "length 2\n"]),
        ("q = [0.0,", "q = [0.0, 0.0,", ["start.q", "length 4", "of length 3\n"]),
        ('model = "full"', "model = 3", ["line 17", "run.model", "a string"]),
        ('model = "full"', "record = 0", ["run.record", "true or false\n"]),
        ('model = "full"', "neighbourhood = 'x'", ["neighbourhood", "a number"]),
        ("[run]", "[[run]]", ["run"]),
        ('model = "full"', 'model = "ful"', ["ful", "auto", "local"]),
        ("restitution = 0.1", "restitution = 1.5", ["restitution", "1.5", "<= 1"]),
        ("restitution = 0.1", "restitution = nan", ["restitution", "nan"]),
        ("gyration_radius = 0.2", "gyration_radius = 0.0", ["gyration_radius", "> 0"]),
        ("mass = 1.0", "mass = 0.0", ["mass", "> 0"]),
        ("mass = 1.0", "mass = inf", ["mass", "inf", "finite"]),
        ("gravity = 9.81", "gravity = -1.0", ["gravity", "-1", ">= 0"]),
        ("point = [0.5, 0.0]", "point = [0.5]", ["point"]),
        (
            "point = [0.5, 0.0]",
            "point = [0.5, 0.0]\nslope = 4.0",
            ["slope", "4", "pi"],
        ),
        (
            "point = [0.5, 0.0]",
            "point = [0.5, 0.0]\nfriction = -0.5",
            ["friction", "-0.5"],
        ),
        ("q = [0.0, 0.011,", "q = [0.0, -0.011,", ["contact 1", "terrain"]),
        ("q = [0.0, 0.011,", "q = [0.0, nan,", ["q", "nan"]),
        ("q = [0.0, 0.011,", "q = [0.0, 'high',", ["q"]),
        ('model = "full"', "time_limit = -1.0", ["time_limit", "-1"]),
        ('model = "full"', "event_limit = -1", ["event_limit", "an integer >= 0\n"]),
    ],
)
def test_wrong_scenes(tmp_path, capsys, old, new, words):
    message = refusal(capsys, "run", scene(tmp_path, old=old, new=new))
    for word in words:
        assert word.lower() in message.lower(), message


@pytest.mark.parametrize("option", ["--json", "--plot"])
def test_unwritable_outputs(tmp_path, capsys, option):
    inside = tmp_path / "nowhere" / "run.png"
    assert str(inside) in refusal(capsys, "run", ROD, option, inside)
    folder = tmp_path / "folder.png"
    folder.mkdir()
    assert "directory" in refusal(capsys, "run", ROD, option, folder)


def test_no_output_replaces_the_scene_or_another_output(tmp_path, capsys):
    mine = scene(tmp_path)
    before = mine.read_bytes()
    link = tmp_path / "link.toml"
    link.symlink_to(mine)
    for command in ("run", "stability"):
        for target in (mine, link):
            assert "scene file" in refusal(capsys, command, mine, "--json", target)
    twice = tmp_path / "twice.png"
    assert "--json" in refusal(capsys, "run", mine, "--json", twice, "--plot", twice)
    assert mine.read_bytes() == before
    assert not twice.exists()


@pytest.mark.parametrize("option", ["--trials", "--seed"])
@pytest.mark.parametrize("value", ["1.5", "-1", "1e3", "many", ""])
def test_kicks_and_seeds_are_whole_numbers(tmp_path, capsys, option, value):
    message = refusal(capsys, "stability", scene(tmp_path), f"{option}={value}")
    assert option in message
    assert "integer" in message


@pytest.mark.parametrize("name", ["run.jpg", "run", "run.png.txt"])
def test_wrong_suffix_of_a_picture(tmp_path, capsys, name):
    message = refusal(capsys, "run", ROD, "--plot", tmp_path / name)
    assert ".png" in message
    assert not list(tmp_path.iterdir())


def test_missing_matplotlib(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    message = refusal(capsys, "run", ROD, "--plot", tmp_path / "run.png")
    assert "matplotlib" in message


@pytest.mark.parametrize(
    "arguments",
    [
        ["run"],
        ["walk"],
        ["run", ROD, "--colour"],
        ["run", ROD, ROD],
        ["run", ROD, "--json"],
    ],
)
def test_wrong_usage(capsys, arguments):
    refusal(capsys, *arguments)


def test_interrupt(tmp_path, capsys):
    path = tmp_path / "endless.toml"
    path.write_text(ENDLESS, encoding="utf-8")
    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    # A signal raised in a thread is handled by the main one, during the run.
    timer.start()
    message = refusal(capsys, "run", path, code=130)
    timer.join()
    assert message == "standfast: interrupted\n"


def command(*arguments, **options):
    """The installed command, in a separate process."""
    program = Path(sys.executable).with_name("standfast")
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.run(
        [program, *arguments], timeout=60, check=False, **(streams | options)
    )


@pytest.mark.parametrize("option", ["--json", "--plot"])
def test_a_pipe_without_a_reader_is_interrupted(tmp_path, option):
    pipe = tmp_path / "pipe.png"
    os.mkfifo(pipe)
    program = [sys.executable, "-m", "standfast.cli", "run", ROD, option, pipe]
    with subprocess.Popen(
        program, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        # The messages are printed; only the file is left to write.
        while not running.stdout.readline().startswith(b"  gap rates"):
            pass
        running.send_signal(signal.SIGINT)
        _, said = running.communicate(timeout=60)
    assert (running.returncode, said) == (130, b"standfast: interrupted\n")


def test_the_installed_command(tmp_path):
    done = command("run", ROD, cwd=tmp_path)
    assert done.returncode == 0
    assert b"2-zeno" in done.stdout
    done = command("run", "nowhere.toml", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr.count(b"\n") == 1


def test_the_account_is_plain_ascii():
    done = command("run", ROD, env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert done.returncode == 0
    assert done.stdout.isascii()


def test_a_reader_that_goes_away_is_no_error():
    program = Path(sys.executable).with_name("standfast")
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [program, "run", ROD],
        stdout=write,
        stderr=subprocess.PIPE,
        timeout=60,
        check=False,
    )
    os.close(write)
    assert done.stderr == b""


def test_a_run_without_an_answer_shows_the_modes(tmp_path, capsys):
    """Two contacts at rest on one slope, with three consistent modes."""
    scene = tmp_path / "scene.toml"
    slope = -math.atan2(3, 4)
    feet = [
        sf.Contact(point=point, slope=slope, friction=1) for point in ((-1, -3), (1, 0))
    ]
    posture = sf.Posture(
        mass=1,
        gyration_radius=math.sqrt(0.5),
        center_of_mass=(0, 0),
        contacts=feet,
        restitution=0,
        gravity=10,
    )
    sf.Scene(posture, (0, 0, 0), (0, 0, 0)).save(scene)
    assert main(["run", str(scene)]) == 0
    out = capsys.readouterr().out
    assert "outcome     ambiguous" in out
    assert "status  ambiguous: SF, FS, FF" in out
    run = sf.load(scene).simulate()
    assert [point.method for point in run.zeno_points] == ["rest"]
    assert sf.contact_modes(run.undecided).consistent == ["SF", "FS", "FF"]


def test_the_rule_for_jams_comes_from_the_option_or_the_scene(tmp_path, capsys):
    path = tmp_path / "jams.toml"
    posture = paper_vee(0.5, 2.5)
    sf.Scene(posture, (0, 0, 0), (0, 0, 0)).save(path)
    assert main(["stability", str(path)]) == 0
    assert "unstable, by no-solution" in capsys.readouterr().out
    assert main(["stability", str(path), "--jams", "impact"]) == 0
    assert "stable, by corner-map" in capsys.readouterr().out
    sf.Scene(posture, (0, 0, 0), (0, 0, 0), {"jams": "impact"}).save(path)
    assert main(["stability", str(path)]) == 0
    assert "stable, by corner-map" in capsys.readouterr().out
    assert main(["map", str(path), "--over", "mass=1:2:2"]) == 0
    assert "stable" in capsys.readouterr().out
    assert main(["stability", str(path), "--jams", "maybe"]) == 2
    assert "maybe" in capsys.readouterr().err

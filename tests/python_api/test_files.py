"""Files are written complete or not at all, and existing files keep their attributes."""

import os
import stat

import pytest
import standfast as sf
from matplotlib.figure import Figure

FEET = [sf.Contact(point=(x, 0.0), friction=0.5) for x in (-0.5, 0.5)]
BODY = sf.Posture(
    mass=1.0,
    gyration_radius=0.2,
    center_of_mass=(0.0, 0.0),
    contacts=FEET,
    restitution=0.1,
)
SCENE = sf.Scene(BODY, q=(0.0, 0.011, 0.002), qdot=(0.0, 0.0, 0.0))
RUN = SCENE.simulate()
WRITERS = {
    "scene.toml": SCENE.save,
    "scene.json": SCENE.save,
    "run.json": RUN.save,
    "verdict.json": sf.stability(BODY).to_json,
    "run.svg": RUN.plot,
}
each = pytest.mark.parametrize(("name", "write"), WRITERS.items(), ids=WRITERS)


@each
def test_a_file_keeps_its_permissions(tmp_path, name, write):
    path = tmp_path / name
    path.write_text("old", encoding="utf-8")
    path.chmod(0o600)
    write(path)
    assert path.stat().st_size > 100
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert os.listdir(tmp_path) == [name]


@each
def test_a_file_that_is_read_only_stays(tmp_path, name, write):
    path = tmp_path / name
    path.write_text("old", encoding="utf-8")
    path.chmod(0o400)
    with pytest.raises(PermissionError, match="denied") as error:
        write(path)
    assert error.value.filename == str(path)
    assert path.read_text(encoding="utf-8") == "old"
    assert os.listdir(tmp_path) == [name]


@each
def test_a_link_keeps_pointing_where_it_does(tmp_path, name, write):
    target, link = tmp_path / "target", tmp_path / name
    link.symlink_to(target)
    with pytest.raises(FileNotFoundError, match="link to a file that is not there"):
        write(link)
    target.write_text("old", encoding="utf-8")
    write(link)
    assert link.readlink() == target
    assert target.stat().st_size > 100
    assert sorted(os.listdir(tmp_path)) == sorted([name, "target"])


@each
def test_what_keeps_a_file_from_being_written_is_an_os_error(tmp_path, name, write):
    for path, kind in [
        (tmp_path / "nowhere" / name, FileNotFoundError),
        (tmp_path / name, IsADirectoryError),
        (tmp_path / "file" / name, NotADirectoryError),
    ]:
        (tmp_path / name).mkdir(exist_ok=True)
        (tmp_path / "file").touch()
        with pytest.raises(kind) as error:
            write(path)
        assert error.value.filename == str(path)


def test_a_scene_that_is_not_there_is_an_os_error(tmp_path):
    path = tmp_path / "nowhere.toml"
    with pytest.raises(FileNotFoundError) as error:
        sf.load(path)
    assert error.value.filename == str(path)
    assert str(error.value) == f"[Errno 2] No such file or directory: '{path}'"


def test_half_a_picture_is_none(tmp_path, monkeypatch):
    def half(self, file, **options):
        file.write(b"half")
        raise KeyboardInterrupt

    path = tmp_path / "run.png"
    path.write_text("old", encoding="utf-8")
    monkeypatch.setattr(Figure, "savefig", half)
    with pytest.raises(KeyboardInterrupt):
        RUN.plot(path)
    assert path.read_text(encoding="utf-8") == "old"
    assert os.listdir(tmp_path) == ["run.png"]

"""Other processes, folders, locales and damaged files: what is wrong is told by a CradleError, and nothing is left."""

import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from zipfile import ZipFile

import newtons_cradle as nc
import pytest
from conftest import ROOT, ended

posix = pytest.mark.skipif(os.name == "nt", reason="this system has no fork, or no such folders")


def script(code: str, *arguments, **environment) -> str:
    """What a program says that has the package and this code."""
    known = os.environ | {"PYTHONPATH": str(ROOT / "python")} | environment
    return ended(sys.executable, "-c", code, *arguments, env=known).stdout


@pytest.fixture
def empty(tmp_path, monkeypatch):
    """An empty folder for temporary files."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def changed(fmu: Path, out: Path, change) -> Path:
    """An FMU whose files are changed: `change(name, data)` returns both, or None to leave it out."""
    with ZipFile(fmu) as source, ZipFile(out, "w") as target:
        for name in source.namelist():
            if (kept := change(name, source.read(name))) is not None:
                target.writestr(*kept)
    return out


def simulated(fmu: nc.Fmu) -> bytes:
    return fmu.simulate(stop=1.0).pulses.tobytes()


def test_process_opens_the_file_of_a_pickled_fmu(fmu, fmu3):
    for either in (fmu, fmu3):
        copy = pickle.loads(pickle.dumps(either))
        assert copy.path == either.path.absolute() and copy.folder != either.folder
        copy.close()
        assert either.folder.is_dir()
        with ProcessPoolExecutor(1) as pool:
            assert pool.submit(simulated, either).result() == simulated(either)


@posix
def test_process_leaves_the_files_of_its_parent_alone(fmu_path):
    """It closes what it has, and ends as programs end; then the parent goes on."""
    code = """
import os, sys
import newtons_cradle as nc

fmu = nc.Fmu(sys.argv[1])
run = fmu.start()
fmu.simulate(stop=0.1)
if (child := os.fork()) == 0:
    assert len(fmu.simulate(stop=1.0)) > 1
    fmu.close()
    sys.exit(0)
assert os.waitpid(child, 0)[1] == 0
run.step(1.0)
assert len(list((fmu.folder / "binaries").glob("*/*"))) > 0
assert len(fmu.simulate(stop=1.0).pulses) == 6
folder = fmu.folder
fmu.close()
print(folder.exists())
"""
    assert script(code, fmu_path) == "False\n"


def test_folders_that_take_no_files_are_named(fmu_path, tmp_path, monkeypatch):
    missing = tmp_path / "missing"
    monkeypatch.setattr(tempfile, "tempdir", str(missing))
    for make in (nc.Fmu, lambda path: nc.build(balls=3, binaries=path)):
        with pytest.raises(nc.FmuError, match=f"{missing} takes no files: .*; set TMPDIR to a folder that does"):
            make(fmu_path)
    full = Path("/dev/full")
    if full.exists():
        with pytest.raises(nc.FmuError, match=r"cannot be unpacked: .*\(in the folder /dev/full\)"):
            nc.Fmu(fmu_path, full)


def mounted(folder: Path, *options: str) -> bool:
    """Whether a file system in memory could be mounted there."""
    command = ["mount", "-t", "tmpfs", "-o", ",".join(options), "tmpfs", str(folder)]
    return os.name != "nt" and subprocess.run(command, capture_output=True).returncode == 0


@pytest.mark.parametrize(
    ("options", "complaint"),
    [(["noexec"], "no program may run from the folder {}"), (["size=64k"], "cannot be unpacked: ")],
)
def test_folders_that_are_full_or_run_nothing_are_named(fmu_path, empty, options, complaint):
    if shutil.which("mount") is None or not mounted(empty, *options):
        pytest.skip("no file system can be mounted")
    try:
        with pytest.raises(nc.FmuError) as caught:
            nc.Fmu(fmu_path).start()
        assert complaint.format(empty) in str(caught.value) and str(empty) in str(caught.value)
    finally:
        ended("umount", "--lazy", empty)


def test_archives_that_are_damaged_leave_no_folder(fmu_path, empty, tmp_path):
    data, out = fmu_path.read_bytes(), tmp_path / "damaged.fmu"
    inside = ZipFile(fmu_path).getinfo("modelDescription.xml").header_offset + 500
    damages = [b"", b"PK\x03\x04", data[: len(data) // 2], data[:inside] + 64 * b"\xff" + data[inside + 64 :]]
    for damaged in damages:
        out.write_bytes(damaged)
        with pytest.raises(nc.FmuError, match="is not an FMU that can be read"):
            nc.Fmu(out).start()
    for text in (
        b"",
        b"<",
        b"<fmiModelDescription/>",
        b"\xff\xfe<",
        b'<f fmiVersion="2.0"><ModelVariables></ModelVariables>',
    ):

        def description(name, data, text=text):
            return name, text if name == "modelDescription.xml" else data

        with pytest.raises(nc.FmuError, match=r"its modelDescription\.xml"):
            nc.Fmu(changed(fmu_path, out, description))
    no_description = changed(fmu_path, out, lambda name, data: None if name == "modelDescription.xml" else (name, data))
    with pytest.raises(nc.FmuError, match=r"it has no modelDescription\.xml"):
        nc.Fmu(no_description)
    assert list(empty.iterdir()) == []


@pytest.mark.parametrize("name", ["../outside", "resources/../../outside", "/outside", "C:/outside", "a\\..\\outside"])
def test_archives_with_paths_outside_are_refused(fmu_path, empty, tmp_path, name):
    out = tmp_path / "evil.fmu"
    shutil.copy(fmu_path, out)
    with ZipFile(out, "a") as target:
        target.writestr(name, "outside")
    with pytest.raises(nc.FmuError, match="in it is no path within an FMU"):
        nc.Fmu(out)
    assert list(empty.iterdir()) == [] and not (tmp_path / "outside").exists()


def test_binaries_that_are_broken_or_missing_are_told(fmu_path, tmp_path):
    out = tmp_path / "other.fmu"
    of_binaries = "binaries/"
    for change, complaint in (
        (lambda name, data: (name, b"no library" if name.startswith(of_binaries) else data), "cannot be loaded: "),
        (lambda name, data: (name + ".txt" * name.startswith(of_binaries), data), "is incomplete: its binaries"),
        (lambda name, data: (name.replace(of_binaries, "binaries/mars-"), data), "has binaries for mars-"),
        (lambda name, data: None if name.startswith(of_binaries) else (name, data), "has binaries for no machine only"),
    ):
        here = Path.cwd()
        with nc.Fmu(changed(fmu_path, out, change)) as fmu, pytest.raises(nc.FmuError) as caught:
            fmu.start()
        assert complaint in str(caught.value) and Path.cwd() == here


@posix
def test_current_folder_that_is_gone_is_told(fmu_path, tmp_path):
    code = "import os, sys, newtons_cradle as nc; fmu = nc.Fmu(sys.argv[1]); os.rmdir(os.getcwd()); fmu.start()"
    gone = tmp_path / "gone"
    gone.mkdir()
    environment = os.environ | {"PYTHONPATH": str(ROOT / "python")}
    done = ended(sys.executable, "-c", code, fmu_path, code=1, cwd=gone, env=environment)
    assert "FmuError: the current folder is not there any more" in done.stderr


def test_locale_does_not_matter_for_names_and_output(fmu_path, tmp_path):
    folder = tmp_path / "Kugelstoßpendel µ"
    folder.mkdir()
    path = shutil.copy(fmu_path, folder / "ö.fmu")
    code = """
import sys
import newtons_cradle as nc

for fmi in (2, 3):
    with nc.build(balls=3, fmi=fmi, binaries=sys.argv[1], out=sys.argv[2]) as fmu:
        print(fmu.simulate(stop=1.0, record=["x[1]"]), ascii(fmu), fmu.parameters)
"""
    for language in (
        {"LC_ALL": "C"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
        {"LC_ALL": "C.UTF-8"},
    ):
        environment = {"TMPDIR": str(folder)} | language
        said = script(code, path, folder / "ü.fmu", **environment)
        assert said.count("Result(101 samples from 0 s to 1 s of x") == 2 and "3 balls, FMI 3.0" in said


def test_imports_are_lazy(fmu_path):
    """NumPy and FMPy take a while; the plugin for pytest is loaded in every session."""
    code = (
        "import sys, {}; print(sorted(name for name in ('numpy', 'fmpy', 'pandas', 'difflib') if name in sys.modules))"
    )
    for module in ("newtons_cradle", "newtons_cradle.testing"):
        assert script(code.format(module)) == "[]\n"
    code = "import newtons_cradle as nc, sys; nc.Fmu(sys.argv[1]).parameters; print('fmpy' in sys.modules)"
    assert script(code, fmu_path) == "False\n"


def test_folder_of_ones_own_is_kept(fmu_path, tmp_path, monkeypatch):
    """It may be relative. Only what was unpacked goes; files of another FMU are not mixed with those of this one."""
    monkeypatch.chdir(tmp_path)
    for made in (False, True):
        folder = tmp_path / f"unpacked {made}"
        if made:
            folder.mkdir()
        with nc.Fmu(fmu_path, folder=folder.name) as fmu:
            assert fmu.folder == folder and (folder / "modelDescription.xml").is_file()
            assert len(fmu.simulate(stop=1.0).pulses) == 6
            with pytest.raises(nc.InvalidValue, match="has files in it; allowed: a new folder, or an empty one"):
                nc.Fmu(fmu_path, folder)
            (folder / "binaries/own.txt").write_text("own")
        assert [path.name for path in folder.rglob("*")] == ["binaries", "own.txt"]
        (folder / "binaries/own.txt").unlink()
        (folder / "binaries").rmdir()
        with nc.Fmu(fmu_path, folder):
            pass
        assert folder.is_dir()
        folder.rmdir()
        with nc.Fmu(fmu_path, folder):
            assert folder.is_dir()
        assert not folder.exists()
    (tmp_path / "mine").mkdir()
    with nc.Fmu(fmu_path, "mine/new/deep") as fmu:
        assert fmu.folder.is_dir()
    assert list((tmp_path / "mine").iterdir()) == []


def test_current_folder_may_change(fmu_path, tmp_path, monkeypatch):
    shutil.copy(fmu_path, tmp_path / "copy.fmu")
    monkeypatch.chdir(tmp_path)
    with nc.Fmu("copy.fmu") as fmu:
        monkeypatch.chdir("/")
        assert len(fmu.simulate(stop=1.0).pulses) == 6 and (fmu.folder / "modelDescription.xml").is_file()
        assert fmu.path == tmp_path / "copy.fmu" and fmu.provenance()["fmu"] == "copy.fmu" and fmu.description
        with pickle.loads(pickle.dumps(fmu)) as again:
            assert again.simulate(stop=1.0) == fmu.simulate(stop=1.0)

"""A copy of the tree with its own Python environment: changes in it never reach the tree."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import venv
from pathlib import Path

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / ".cache" / "mutants"


def copy_tree(commit: str | None, to: Path) -> Path:
    """Copy a commit, or the tree as it is now, to a new folder; return the folder's Python.

    That Python finds `improv_core` in the copy, however it is started, and all else where ours finds it. The programs
    in `.cache` are shared.
    """
    to.mkdir()
    if commit:
        archive = subprocess.run(["git", "archive", commit], cwd=ROOT, check=True, capture_output=True).stdout
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(to, filter="data")
    else:
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT, check=True, capture_output=True, text=True,
        ).stdout  # fmt: skip
        for name in filter(None, listed.split("\0")):
            if (ROOT / name).is_file():
                (to / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, to / name)
    shutil.copytree(Path(__file__).parent, to / "tests" / "mutants", dirs_exist_ok=True)
    (to / ".cache").mkdir()
    for program in (ROOT / ".cache").iterdir():
        if program != RESULTS:
            (to / ".cache" / program.name).symlink_to(program.resolve())
    return _environment(to)


def _environment(copy: Path) -> Path:
    venv.create(copy / ".venv", symlinks=True)
    ours, own = Path(sysconfig.get_path("scripts")), copy / ".venv" / "bin"
    for script in ours.iterdir():
        if not (own / script.name).exists() and script.is_file():
            text = script.read_bytes()
            if text.startswith(b"#!" + os.fsencode(ours)):
                shutil.copy2(script, own)
                (own / script.name).write_bytes(text.replace(os.fsencode(ours), os.fsencode(own), 1))
            else:
                (own / script.name).symlink_to(script)
    packages = Path(sysconfig.get_path("purelib"))
    _site(copy / ".venv").joinpath("copy.pth").write_text(f"{copy}\n{packages}\n" + _MEASURED)
    return own / "python"


def measure_ros(copy: Path) -> None:
    """Let ROS's Python measure, too: a copy of it in which `coverage` is installed."""
    shared = copy / ".cache" / "ros"
    if not shared.exists():
        return
    original = shared.resolve()
    shared.unlink()
    shutil.copytree(original, shared, symlinks=True)
    shutil.copytree(Path(sysconfig.get_path("platlib")) / "coverage", _site(shared) / "coverage")
    _site(shared).joinpath("measured.pth").write_text(_MEASURED)


def _site(environment: Path) -> Path:
    return next(environment.glob("lib/python3*/site-packages"))


_MEASURED = (
    "import os; 'COVERAGE_PROCESS_START' in os.environ and exec('import coverage; coverage.process_startup()')\n"
)

assert sys.prefix != sys.base_prefix, "start this in the environment in which Improv is installed"

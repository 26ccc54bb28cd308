"""The bundle for another machine: all modules that a stage there imports, and none that it doesn't need."""

from __future__ import annotations

import ast
import io
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from improv_core.hosts.bundle import PACKAGE, boot_line, bundle
from tests.test_architecture import name, ours

BEGIN = ("improv_core.hosts.__main__", "improv_core.hosts.far", "improv_core.stage.__main__")
STARTED = tuple(
    f"improv_core.outputs.ros.{helper}"
    for helper in ("standby.process", "sensors.process", "publisher.process", "graph", "opening")
)


def test_it_has_every_module_that_a_stage_there_imports() -> None:
    modules = {name(path): path for path in PACKAGE.rglob("*.py")}
    carried = {entry.filename for entry in zipfile.ZipFile(io.BytesIO(bundle().data)).infolist()}
    waiting, needed = [*BEGIN, *STARTED], set[str]()
    while waiting:
        module = waiting.pop()
        if module not in needed:
            needed.add(module)
            waiting += ours(modules[module])
    paths = {modules[module].relative_to(PACKAGE.parent).as_posix() for module in needed}
    assert paths - carried == set()


def test_it_is_the_same_for_the_same_modules_and_small() -> None:
    first = bundle()
    bundle.cache_clear()
    assert bundle() == first
    assert len(first.data) < 500_000


def test_it_runs_without_anything_else_of_ours(tmp_path: Path) -> None:
    zipfile.ZipFile(io.BytesIO(bundle().data)).extractall(tmp_path)
    code = f"import sys; sys.path.append({str(tmp_path)!r}); import {', '.join(BEGIN)}; print(improv_core.__file__)"
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(str(tmp_path))


def test_old_pythons_can_read_the_first_line_and_the_bootstrap() -> None:
    line = boot_line(bundle(), ["--from", "ada@läptop\n"])
    assert line.count(b"\n") == 1
    assert line.isascii()
    ast.parse(line, feature_version=(3, 6))
    ast.parse((PACKAGE / "hosts" / "bootstrap.py").read_text(encoding="utf-8"), feature_version=(3, 6))


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (["hosts", "far", "--look"], b'"python"'),
        (["stage", "--sink", "ros", "--no-standby"], b"No module named 'rclpy'"),
        (["stage", "outputs.ros.standby.process", "improv_standby"], b"No module named 'rclpy'"),
    ],
    ids=lambda command: command[0] if isinstance(command, list) else "",
)
def test_another_version_that_is_installed_there_is_not_used(tmp_path: Path, command: list[str], says: bytes) -> None:
    zipfile.ZipFile(io.BytesIO(bundle().data)).extractall(tmp_path / "ours")
    installed = tmp_path / "theirs" / "improv_core"
    installed.mkdir(parents=True)
    (installed / "__init__.py").write_text("raise SystemExit('another version')")
    env = {**os.environ, "PYTHONPATH": str(installed.parent), "IMPROV_ROS_PYTHON": ""}
    folder, *arguments = command
    done = subprocess.run(
        [sys.executable, tmp_path / "ours" / "improv_core" / folder, *arguments],
        env=env,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    assert says in done.stdout + done.stderr
    assert b"another version" not in done.stderr

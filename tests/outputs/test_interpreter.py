"""The choice of the Python for ROS."""

from __future__ import annotations

from pathlib import Path

import pytest

from improv_core.outputs.ros.setup import interpreter
from improv_core.outputs.ros.setup.interpreter import Interpreter, InterpreterError, find_ros_python


@pytest.fixture(autouse=True)
def bare_machine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Hide every ROS of this machine."""
    for name in ("IMPROV_ROS_PYTHON", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setattr(interpreter, "_INSTALLED", str(tmp_path / "opt"))
    monkeypatch.setattr(interpreter, "_SYSTEM_PYTHON", str(tmp_path / "system-python"))
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)


def fake(path: Path, script: str = "exit 0") -> str:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return str(path)


def found(setting: str | None = None) -> str | None:
    result = find_ros_python(setting)
    return result.python if result else None


def test_without_ros_nothing_is_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("subprocess.run", lambda *_, **__: pytest.fail("a process was started"))
    assert found() is None


def test_a_requested_python_comes_first(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    own = fake(tmp_path / "data/improv/ros/bin/python")
    assert found() is None  # `improv ros setup` was interrupted
    (tmp_path / "data/improv/ros/proven").touch()
    assert found() == own
    (tmp_path / "opt/jazzy").mkdir(parents=True)
    (tmp_path / "opt/jazzy/setup.bash").write_text("export SOURCED=yes\n")
    system = fake(tmp_path / "system-python", '[ "$SOURCED" = yes ]')
    assert found() == system
    sourced = fake(tmp_path / "bin/python3")
    monkeypatch.setenv("AMENT_PREFIX_PATH", "/somewhere")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=":")
    assert found() == sourced
    named = fake(tmp_path / "named")
    monkeypatch.setenv("IMPROV_ROS_PYTHON", named)
    assert found() == named
    setting = fake(tmp_path / "setting")
    assert found(setting) == setting


@pytest.mark.parametrize("said", [{}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF", "ROS_LOCALHOST_ONLY": "1"}])
def test_installed_ros_is_sourced_but_does_not_decide_how_far_discovery_reaches(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, said: dict[str, str]
) -> None:
    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in said.items():
        monkeypatch.setenv(name, value)
    (tmp_path / "opt/jazzy").mkdir(parents=True)
    script = "export ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET ROS_LOCALHOST_ONLY=0 SOURCED='two\nlines'\n"
    (tmp_path / "opt/jazzy/setup.bash").write_text(script)
    fake(tmp_path / "system-python")
    result = find_ros_python(None)
    assert isinstance(result, Interpreter)
    assert (result.env["SOURCED"], result.origin) == ("two\nlines", str(tmp_path / "opt/jazzy"))
    reach = {name: value for name, value in result.env.items() if "DISCOVERY" in name or "LOCALHOST" in name}
    assert reach == said


@pytest.mark.parametrize(
    ("script", "why"),
    [
        ("echo Traceback >&2; echo 'No module named rclpy' >&2; exit 1", "No module named rclpy"),
        ("exit 3", "no error message"),
        ("kill -BUS $$", "Bus error"),  # an import with a full /dev/shm
        (None, "no such file or directory"),
    ],
)
def test_a_requested_interpreter_must_work(tmp_path: Path, script: str | None, why: str) -> None:
    python = fake(tmp_path / "python", script) if script else str(tmp_path / "none")
    with pytest.raises(InterpreterError) as raised:
        find_ros_python(python)
    assert find_ros_python(python, proves=False)
    assert str(raised.value) == (
        f"{python} cannot import rclpy ({why}): correct the setting improv.ros.python or clear it"
    )

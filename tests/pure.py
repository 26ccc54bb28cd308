"""`pytest --pure` runs the quick tests that start nothing: no process, browser, editor, or ROS. They take seconds."""

from __future__ import annotations

import sys
from collections.abc import Generator
from pathlib import Path

import pytest
from hypothesis import settings

TESTS = Path(__file__).parent
PURE = {
    *(
        "hosts",
        "ide",
        "ipc",
        "music",
        "outputs",
        "player",
        "preview",
        "program",
        "protocol",
        "robots",
        "safety",
        "score",
    ),
    *("session", "stage", "syntax", "test_plain.py", "test_text.py"),
}
NOT_PURE = {
    "music/test_clock_process.py",
    "outputs/test_interpreter.py",
    "session/test_start.py",
    "ipc/test_helper.py",
    "ipc/test_child.py",
    "ipc/test_stage_process.py",
    "safety/test_stop_socket.py",
    "program/test_fuzz.py",
    "program/test_huge.py",
    "hosts/test_bundle.py",
    "hosts/test_ssh.py",
    "robots/test_schema.py",
    "outputs/test_publisher_client.py",
    "outputs/test_sensors_client.py",
    "outputs/test_thymio.py",
    "music/test_osc_process.py",
    "stage/test_process.py",
    "outputs/test_standby_process.py",
}
"""Files in the folders of the pure tests that start something, or take long."""
EXAMPLES = 10
"""Random examples that each test tries: enough to see a slip at once. The whole suite tries more."""
STARTS = {"subprocess.Popen", "os.system", "os.spawn", "os.exec", "os.fork", "os.forkpty", "os.posix_spawn"}

_in_pure_test = False


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--pure", action="store_true", help="run only the tests that start nothing")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    if not config.getoption("pure") or collection_path == TESTS:
        return None
    name = collection_path.relative_to(TESTS)
    return name.parts[0] not in PURE or name.as_posix() in NOT_PURE or None


def pytest_sessionstart(session: pytest.Session) -> None:
    if session.config.getoption("pure"):
        session.config.option.markexpr = session.config.option.markexpr or "not slow"
        settings.register_profile("pure", settings.default, max_examples=EXAMPLES)
        settings.load_profile("pure")
        sys.addaudithook(_refuse)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, bool, bool]:
    global _in_pure_test
    _in_pure_test = item.config.getoption("pure")
    try:
        return (yield)
    finally:
        _in_pure_test = False


def _refuse(event: str, arguments: tuple[object, ...]) -> None:
    """Fail a pure test when it starts anything."""
    if _in_pure_test and event in STARTS:
        raise AssertionError(f"not a pure test: {event}{arguments}")

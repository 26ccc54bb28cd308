"""What all tests share: folders and a ROS domain of each worker's own, so that tests can run side by side, and what is
reported at the end."""

import gc
import os
import signal
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, settings

from tests.budget import (
    pytest_collection_modifyitems,
    pytest_configure,
    pytest_runtest_makereport,
    pytest_terminal_summary,
)
from tests.pure import pytest_addoption, pytest_ignore_collect, pytest_runtest_protocol, pytest_sessionstart
from tests.strange_files import KINDS, StrangeFile

__all__ = [  # hooks of pytest
    "pytest_addoption",
    "pytest_collection_modifyitems",
    "pytest_configure",
    "pytest_ignore_collect",
    "pytest_runtest_makereport",
    "pytest_runtest_protocol",
    "pytest_sessionstart",
    "pytest_terminal_summary",
]

pytest.register_assert_rewrite("tests.program.drawing")

# Machines that build other things meanwhile are slow now and then; pytest's own timeout is the limit. CI tries the same
# examples each time, so that what it says depends on the change alone; people at work try others, and fewer, each time.
IN_CI = "IMPROV_REQUIRE_ALL" in os.environ
settings.register_profile(
    "improv",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],  # it counts 30 s of a busy machine as a fault of the test
    derandomize=IN_CI,
    max_examples=50 if IN_CI else 20,
)
settings.load_profile("improv")

# Tests start Python hundreds of times. It must not compile all modules each time, even where it is told to keep none.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# As in our processes. All that is collected stays until the end: looking for garbage in it takes time and finds none.
gc.set_threshold(50_000, 20, 50)

# A shell has what it starts in the background ignore Ctrl-C, and what tests start would ignore it, too.
signal.signal(signal.SIGINT, signal.default_int_handler)

# No test may write into the history of the person who runs it or stop what that person plays, nor may what tests start.
# Neither may the tests of another worker. Set before they are imported: some copy the environment then.
_own = TemporaryDirectory(prefix="improv-tests-")
os.environ["XDG_STATE_HOME"] = f"{_own.name}/state"
os.environ["XDG_RUNTIME_DIR"] = f"{_own.name}/runtime"
Path(os.environ["XDG_RUNTIME_DIR"]).mkdir(mode=0o700)


def pytest_collection_finish() -> None:
    gc.freeze()


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Most tests wait for something: twice as many workers as processors keep these busy. Pure tests never wait."""
    return (1 if config.getoption("pure") else 2) * (os.cpu_count() or 1)


@pytest.fixture
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a history of its own, also for what the test starts."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "improv" / "history"


@pytest.fixture(params=KINDS)
def strange_file(request: pytest.FixtureRequest, tmp_path: Path) -> StrangeFile:
    folder = tmp_path / "folder"
    folder.mkdir()
    return StrangeFile(folder, request.param)

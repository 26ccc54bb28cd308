"""Setup that all tests share: folders and a ROS domain for each worker, so that tests can run side by side, and the
report at the end."""

import asyncio
import gc
import inspect
import os
import signal
import sys
from contextlib import suppress
from importlib import import_module
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
# examples each time, so that its result depends on the change alone; people at work try others each time.
IN_CI = "IMPROV_REQUIRE_ALL" in os.environ
settings.register_profile(
    "improv",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],  # it counts 30 s of a busy machine as a fault of the test
    derandomize=IN_CI,
    max_examples=20,
)
settings.load_profile("improv")

# Tests start Python hundreds of times. It must not compile all modules each time, even if it should keep no bytecode.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# As in our processes. All objects of the collection stay until the end: looking for garbage in them takes time and
# finds none.
gc.set_threshold(50_000, 20, 50)

# A shell makes its background processes ignore Ctrl-C, and the tests' own processes would ignore it, too.
signal.signal(signal.SIGINT, signal.default_int_handler)

# No test may write into the history of the person who runs it or stop that person's performances, nor may the processes
# of tests. Neither may the tests of another worker. Set before our modules are imported: some copy the environment
# then.
_own = TemporaryDirectory(prefix="improv-tests-")
os.environ["XDG_STATE_HOME"] = f"{_own.name}/state"
os.environ["XDG_RUNTIME_DIR"] = f"{_own.name}/runtime"
Path(os.environ["XDG_RUNTIME_DIR"]).mkdir(mode=0o700)


def pytest_collection(session: pytest.Session) -> None:
    """Have each worker import other tests first if it collects all: in a new clone, all would compile the same ones."""
    own = getattr(session.config, "workerinput", None)
    if own and session.config.args_source is pytest.Config.ArgsSource.TESTPATHS:
        tests = Path(__file__).parent
        for path in sorted(tests.rglob("test_*.py"))[int(own["workerid"][2:]) :: own["workercount"]]:
            with suppress(Exception, pytest.skip.Exception):  # collection reports it
                import_module(".".join(path.relative_to(tests.parent).with_suffix("").parts))


def pytest_collection_finish() -> None:
    gc.freeze()


def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Run a test that is a coroutine in an event loop of its own."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    given = {name: pyfuncitem.funcargs[name] for name in inspect.signature(pyfuncitem.obj).parameters}
    asyncio.run(pyfuncitem.obj(**given))
    return True


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Most tests wait for something: twice as many workers as processors keep these busy. Pure tests never wait."""
    return (1 if config.getoption("pure") else 2) * (os.cpu_count() or 1)


@pytest.fixture
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Set the folder of a separate history, also for the processes of the test."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "state" / "improv" / "history"


@pytest.fixture(params=KINDS)
def strange_file(request: pytest.FixtureRequest, tmp_path: Path) -> StrangeFile:
    folder = tmp_path / "folder"
    folder.mkdir()
    return StrangeFile(folder, request.param)

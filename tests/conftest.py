"""What all tests share."""

import os
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import settings

from tests.strange_files import KINDS, StrangeFile

pytest.register_assert_rewrite("tests.program.drawing")

# Machines that build other things meanwhile are slow now and then; pytest's own timeout is the limit. CI tries the same
# examples each time, so that what it says depends on the change alone; people at work try others in each run.
settings.register_profile("improv", deadline=None, derandomize="IMPROV_REQUIRE_ALL" in os.environ)
settings.load_profile("improv")

# No test may write into the history of the person who runs it, nor may what tests start. Set before they are imported:
# some copy the environment then.
_state = TemporaryDirectory(prefix="improv-state-")
os.environ["XDG_STATE_HOME"] = _state.name


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

"""What all tests share."""

from pathlib import Path

import pytest
from hypothesis import settings

from tests.strange_files import KINDS, StrangeFile

pytest.register_assert_rewrite("tests.program.drawing")

# Machines that build other things meanwhile are slow now and then; pytest's own timeout is the limit.
settings.register_profile("improv", deadline=None)
settings.load_profile("improv")


@pytest.fixture(params=KINDS)
def strange_file(request: pytest.FixtureRequest, tmp_path: Path) -> StrangeFile:
    folder = tmp_path / "folder"
    folder.mkdir()
    return StrangeFile(folder, request.param)

"""What all tests share."""

import pytest
from hypothesis import settings

pytest.register_assert_rewrite("tests.program.drawing")

# Machines that build other things meanwhile are slow now and then; pytest's own timeout is the limit.
settings.register_profile("improv", deadline=None)
settings.load_profile("improv")

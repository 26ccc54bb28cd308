"""Each test is held against what docs/lsp.md says that it proves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import pytest

from tests import lsp_table
from tests.ls.client import Client

_claims = cache(lsp_table.claims)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    Client.of_test.clear()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    yield
    missing = _claims().get(lsp_table.name_of(item), set()) - lsp_table.proved(Client.of_test)
    assert not missing, f"docs/lsp.md says that this test proves {missing}: run python -m tests.lsp_table"

"""The browser of the page's tests."""

from tests.page.conftest import browser, chromium, keep, page, window

__all__ = ["browser", "chromium", "keep", "page", "window"]

"""The browser of the page's tests."""

from tests.stage.viewer.conftest import browser, chromium, keep, page, window

__all__ = ["browser", "chromium", "keep", "page", "window"]

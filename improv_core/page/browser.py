"""Looks for a browser on this machine that can show the page."""

from __future__ import annotations

import os
import sys
import webbrowser


def has_browser() -> bool:
    """Return whether a browser can open in a window, or `BROWSER` names one."""
    if not (has_screen() or os.environ.get("BROWSER")):
        # Python would start a text browser, which takes over the terminal: Ctrl-C would no longer stop the robots.
        return False
    try:
        webbrowser.get()
    except webbrowser.Error:
        return False
    return True


def has_screen() -> bool:
    """True if windows can open on this machine, which they can't over SSH."""
    if sys.platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in os.environ
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))

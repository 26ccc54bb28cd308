"""Shows the simulator's page."""

from __future__ import annotations

import asyncio
import webbrowser

from lsprotocol import types
from pygls.exceptions import JsonRpcException

from improv_core.page.browser import has_screen
from improv_core.session.session import Playback
from improv_ls.editor import ANSWER_LIMIT, Editor


async def show_page(editor: Editor, playback: Playback) -> None:
    """Have the editor show the page, or else a browser; print its URL if neither does."""
    url = playback.link(own=True)
    if url is None:  # the performance was closed meanwhile
        return
    # Without a screen, a browser would be one for the terminal, on top of the editor. Helix reports that it has shown
    # the page before it looks for a browser, and if it finds none, prints that in the place of our URL.
    shows = editor.can("window.show_document.support") and (editor.takes_own_messages or has_screen())
    if shows:
        answer = editor.server.window_show_document_async(types.ShowDocumentParams(uri=url, external=True))
        try:
            # Shielded: an editor may ask the person first, and pygls fails on an answer to a canceled request.
            shown = (await asyncio.wait_for(asyncio.shield(answer), ANSWER_LIMIT)).success
        except (JsonRpcException, TimeoutError):
            shown = False
    else:
        shown = has_screen() and await asyncio.to_thread(webbrowser.open, url)
    if not shown:
        # Another URL, as the first one may have been seen by others.
        editor.say(f"page: {playback.link()}", stays=True)

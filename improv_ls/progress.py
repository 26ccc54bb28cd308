"""Shows the beat that plays as work-done progress, if the client supports that."""

from __future__ import annotations

import asyncio
from uuid import uuid4

from lsprotocol import types

from improv_core.protocol.messages import TransportMessage
from improv_core.protocol.transport import silenced
from improv_core.session.shown_beats import each_beat
from improv_ls.editor import ANSWER_LIMIT, Editor


class Progress:
    """Shows the beat that plays as work-done progress."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._task: asyncio.Task[None] | None = None

    def follow(self, transport: TransportMessage) -> None:
        """Note that the playback has changed."""
        self.stop()
        if transport["state"] == "playing" and self._editor.can("window.work_done_progress"):
            self._task = asyncio.create_task(self._show(transport))

    def stop(self) -> None:
        if self._task:
            self._task.cancel()
            self._task = None

    async def _show(self, transport: TransportMessage) -> None:
        """Show each beat, until canceled."""
        token, begun = f"improv-{uuid4()}", False
        try:
            async for beat in each_beat(transport):
                if not self._editor.is_read:  # Helix shows the beat in the line of the message
                    continue
                beat = ", ".join(filter(None, (beat, silenced(transport["muted"], transport["soloed"]))))
                if begun:
                    self._report(token, types.WorkDoneProgressReport(message=beat))
                elif await self._creates(token):
                    begun = True
                    self._begin(token, beat)
                else:
                    return
        finally:
            if begun:
                self._report(token, types.WorkDoneProgressEnd())

    async def _creates(self, token: str) -> bool:
        """Return whether the client shows this progress. If nobody needs the answer any more, the progress ends, too:
        Helix shows that it works from here on."""
        made = self._editor.server.window_work_done_progress_create_async(types.WorkDoneProgressCreateParams(token))
        try:
            # Shielded: pygls fails on a late answer to a request that was canceled here.
            await asyncio.wait_for(asyncio.shield(made), ANSWER_LIMIT)
        except asyncio.CancelledError:
            self._begin(token, "")
            self._report(token, types.WorkDoneProgressEnd())
            raise
        except Exception:  # no answer or a refusal: this client shows no progress
            return False
        return True

    def _begin(self, token: str, beat: str) -> None:
        self._report(token, types.WorkDoneProgressBegin(title="Improv", message=beat, cancellable=False))

    def _report(
        self,
        token: str,
        value: types.WorkDoneProgressBegin | types.WorkDoneProgressReport | types.WorkDoneProgressEnd,
    ) -> None:
        self._editor.server.progress(types.ProgressParams(token, value))

"""The editor at the other end: its capabilities, its settings, and messages to the person who uses it."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Coroutine
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lsprotocol import types
from pygls.capabilities import get_capability
from pygls.uris import to_fs_path

from improv_core.plain import message_without_links
from improv_ls.framing import StdioServer
from improv_ls.positions import Encoding
from improv_ls.settings import Settings

if TYPE_CHECKING:
    from improv_ls.to_lsp import DiagnosticSupport

ANSWER_LIMIT = 2.0
"""Seconds to wait for a client's answer: some never answer."""
READING = 5.0
"""Seconds for which nothing should overwrite a warning, in editors that show messages and progress in one line."""
SHOWN = {
    "code_lens": types.WORKSPACE_CODE_LENS_REFRESH,
    "diagnostics": types.WORKSPACE_DIAGNOSTIC_REFRESH,
    "inlay_hint": types.WORKSPACE_INLAY_HINT_REFRESH,
    "semantic_tokens": types.WORKSPACE_SEMANTIC_TOKENS_REFRESH,
}
"""Things that an editor shows beside the text, and the request that has it ask for each again."""


def _member(given: object, name: str) -> object:
    """Return a member of a JSON value that LSP doesn't define; None if there is none."""
    return given.get(name) if isinstance(given, dict) else getattr(given, name, None)


class Editor:
    """One editor, for as long as its session lasts."""

    def __init__(self, server: StdioServer) -> None:
        self.server = server
        self.settings = Settings()
        self.wrong_settings: list[str] = []
        """Errors in the latest settings."""
        self.pulls = self.pulled = 0
        """Times that we have asked the client for its settings, and the latest question that it has answered."""
        self.refusals = 0
        """The number of programs that were shown to be refused, by the editor's own checks or by the stages."""
        self._read = -math.inf  # the time at which a person has read the last warning, on the clock of `time.monotonic`
        self._tasks: set[asyncio.Task[None]] = set()  # the loop itself keeps no reference to them

    @property
    def capabilities(self) -> types.ClientCapabilities:
        return self.server.client_capabilities

    def can(self, capability: str) -> Any:
        """Return the client's value of a capability, such as `workspace.configuration`; None if it sent none."""
        return get_capability(self.capabilities, capability)

    @property
    def encoding(self) -> Encoding:
        """Unit of the columns, as agreed with the client."""
        return self.server.server_capabilities.position_encoding or types.PositionEncodingKind.Utf16

    @property
    def folders(self) -> list[Path]:
        """Folders that the editor works in, as far as they are on this machine."""
        workspace = self.server.workspace
        uris = [folder.uri for folder in workspace.folders.values()] or [workspace.root_uri or ""]
        return [Path(path) for uri in uris if uri.startswith("file:") and (path := to_fs_path(uri))]

    @property
    def takes_own_messages(self) -> bool:
        """True if the client has asked for our own messages, by `experimental: {"improv": true}`."""
        return bool(_member(self.capabilities.experimental, "improv"))

    @property
    def keeps_settings(self) -> bool:
        """True if the client changes its own settings for us, and a message with a button is in nobody's way there, by
        `experimental: {"improv": {"settings": true}}`."""
        return bool(_member(_member(self.capabilities.experimental, "improv"), "settings"))

    @property
    def hints_playing(self) -> bool:
        """True if hints show which beats play: by default in editors that don't light up words, and ask again."""
        asks = bool(self.can("workspace.inlay_hint.refresh_support")) and not self.takes_own_messages
        return asks if self.settings.inlay_hints_playing is None else self.settings.inlay_hints_playing

    @cached_property
    def pulls_diagnostics(self) -> bool:
        """True if the client asks for diagnostics, and does so again on request when `improv.toml` has changed."""
        return self.can("text_document.diagnostic") is not None and bool(
            self.can("workspace.diagnostics.refresh_support")
        )

    @cached_property
    def diagnostic_support(self) -> DiagnosticSupport:
        """The parts of a diagnostic that the client supports. Clients that pull may list them in the same place as
        others."""
        from improv_ls.to_lsp import DiagnosticSupport

        def said(what: str) -> bool:
            places = ("publish_diagnostics", "diagnostic")
            return any(self.can(f"text_document.{place}.{what}") for place in places)

        return DiagnosticSupport(said("related_information"), said("tag_support"), said("code_description_support"))

    def refresh(self, feature: str) -> None:
        """Have the client ask again for a feature's data, if it supports that."""
        if self.can(f"workspace.{feature}.refresh_support"):
            self.server.protocol.send_request(SHOWN[feature])

    def soon(self, work: Coroutine[Any, Any, None]) -> None:
        """Run a coroutine after the current message. pygls starts asynchronous handlers later, too, but then messages
        that come in the meantime would overtake the first steps of a handler."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._done)

    @property
    def is_read(self) -> bool:
        """True once a person has had time to read the last line that stays, such as a warning."""
        return time.monotonic() >= self._read

    def say(self, message: str, *, stays: bool = False) -> None:
        """Show one line to the person at the editor; several lines would block Neovim until a key is pressed. One that
        `stays` can be read like a warning."""
        self._show(message, types.MessageType.Info, stays)

    def warn(self, message: str) -> None:
        self._show(message, types.MessageType.Warning)

    def report(self, error: str) -> None:
        self._show(error, types.MessageType.Error)

    async def offer(
        self, message: str, *buttons: str, instead: str, kind: types.MessageType = types.MessageType.Warning
    ) -> str | None:
        """Show a message with buttons, and return the one that the person presses, if any. Many editors would ask with
        a prompt that takes the keys of somebody who types, so those whose buttons are in the way show a line
        `instead`."""
        if not self.keeps_settings:
            self._show(instead, kind)
            return None
        self._read = time.monotonic() + READING
        actions = [types.MessageActionItem(button) for button in buttons]
        shown = types.ShowMessageRequestParams(kind, message_without_links(message), actions)
        pressed = await self.server.window_show_message_request_async(shown)
        return pressed.title if pressed else None

    def _done(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()):
            self.report(f"Improv: internal error: {error}")

    def _show(self, message: str, kind: types.MessageType, stays: bool = True) -> None:
        self._read = time.monotonic() + READING if stays else -math.inf
        self.refusals += message.startswith("✗")
        self.server.window_show_message(types.ShowMessageParams(kind, message_without_links(message)))

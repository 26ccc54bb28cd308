"""initialize and initialized: the features for this client, and the requests to it."""

from __future__ import annotations

import asyncio
import os
from importlib import import_module

from lsprotocol import types

from improv_ls.handlers.did_change_configuration import pull
from improv_ls.session import Session
from improv_ls.settings import read_settings

PARENT_PERIOD = 1.0
"""Seconds between two checks that the editor's process is still alive."""

UNTIL_SHOWN = 1.0
"""Seconds in which the editor shows the first document. Code for later features is loaded after that."""


def initialize(ls: Session, params: types.InitializeParams) -> None:
    # Wrong settings are reported in `initialized`, because the client gets no messages before it.
    editor = ls.editor
    editor.settings, editor.wrong_settings = read_settings(params.initialization_options, editor.settings)
    if not editor.can("text_document.code_action.code_action_literal_support"):
        ls.withdraw(types.TEXT_DOCUMENT_CODE_ACTION)  # all our actions are such literals
    if not editor.pulls_diagnostics:  # a client that got both would show everything twice
        ls.withdraw(types.TEXT_DOCUMENT_DIAGNOSTIC)
        ls.withdraw(types.WORKSPACE_DIAGNOSTIC)
    elif _asks_only_about_files(params.client_info):
        ls.withdraw(types.WORKSPACE_DIAGNOSTIC)
    if params.process_id and os.name == "posix":
        editor.soon(_watch_parent(ls, params.process_id))


def _asks_only_about_files(client: types.ClientInfo | None) -> bool:
    """Return whether a client asks only for the diagnostics of all files when it should ask again, if it can get them.

    Neovim 0.12 does, and ignores the part of the answer about open programs: late findings would never be shown there.
    """
    return client is not None and client.name == "Neovim" and (client.version or "").startswith("0.12.")


def initialized(ls: Session, params: types.InitializedParams) -> None:
    ls.listen()
    # Load code for the first document now, while the person is still opening it.
    for handler in ("text_document_sync", "semantic_tokens"):
        asyncio.get_running_loop().call_soon(import_module, f"improv_ls.handlers.{handler}")
    ls.editor.soon(_prepare())
    for problem in ls.editor.wrong_settings:
        ls.editor.warn(problem)
    files = [types.FileSystemWatcher(f"**/{name}") for name in ("improv.toml", "*.improv", "*.urdf")]
    watching = types.DidChangeWatchedFilesRegistrationOptions(files)
    _register(ls, types.WORKSPACE_DID_CHANGE_WATCHED_FILES, "did_change_watched_files", watching)
    section = types.DidChangeConfigurationRegistrationOptions(section="improv")
    _register(ls, types.WORKSPACE_DID_CHANGE_CONFIGURATION, "did_change_configuration", section)
    ls.editor.soon(pull(ls))


def _register(ls: Session, method: str, capability: str, options: object) -> None:
    if ls.editor.can(f"workspace.{capability}.dynamic_registration"):
        registration = types.Registration(id=method, method=method, register_options=options)
        ls.client_register_capability(types.RegistrationParams([registration]))


async def _prepare() -> None:
    """Load code for the first hover and the first error on a thread, once the first document has been shown."""
    await asyncio.sleep(UNTIL_SHOWN)
    for module in ("hover", "code_action", "completion"):
        await asyncio.to_thread(import_module, f"improv_ls.handlers.{module}")
    derivation = await asyncio.to_thread(import_module, "improv_core.syntax.derivation")
    await asyncio.to_thread(derivation.prepare)


async def _watch_parent(ls: Session, process: int) -> None:
    """End when the editor has ended: a process that it started may still hold our standard input open."""
    while True:
        await asyncio.sleep(PARENT_PERIOD)
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            ls.end()
            return
        except PermissionError:
            pass  # the process is alive, and belongs to another user

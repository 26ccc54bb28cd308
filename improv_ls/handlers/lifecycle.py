"""initialize, and the settings."""

from __future__ import annotations

import asyncio
import os
from importlib import import_module
from typing import Any

from lsprotocol import types
from pygls.capabilities import get_capability

from improv_ls.session import ANSWER_LIMIT, Session
from improv_ls.settings import read_settings

PARENT_PERIOD = 1.0
"""Seconds between two looks at whether the editor's process is still there."""


def initialize(ls: Session, params: types.InitializeParams) -> None:
    # What is wrong with these settings is told once the client may be told anything: in `initialized`.
    ls.settings, ls.wrong_settings = read_settings(params.initialization_options, ls.settings)
    if not get_capability(params.capabilities, "text_document.code_action.code_action_literal_support"):
        ls.protocol.fm.features.pop(types.TEXT_DOCUMENT_CODE_ACTION)  # all that is offered are such literals
    if not ls.pulls:  # who were offered both would show everything twice
        del ls.protocol.fm.features[types.TEXT_DOCUMENT_DIAGNOSTIC]
    if params.process_id and os.name == "posix":
        ls.soon(_watch_parent(ls, params.process_id))


def initialized(ls: Session, params: types.InitializedParams) -> None:
    # What the first document will need is brought in now, while the person at the editor still looks for it.
    asyncio.get_running_loop().call_soon(import_module, "improv_ls.handlers.documents")
    for problem in ls.wrong_settings:
        ls.say(problem, types.MessageType.Warning)
    workspace = ls.client_capabilities.workspace
    if not workspace:
        return
    if workspace.did_change_configuration and workspace.did_change_configuration.dynamic_registration:
        options = types.DidChangeConfigurationRegistrationOptions(section="improv")
        method = types.WORKSPACE_DID_CHANGE_CONFIGURATION
        registration = types.Registration(id=method, method=method, register_options=options)
        ls.client_register_capability(types.RegistrationParams([registration]))
    if workspace.did_change_watched_files and workspace.did_change_watched_files.dynamic_registration:
        watching = types.DidChangeWatchedFilesRegistrationOptions([types.FileSystemWatcher("**/improv.toml")])
        method = types.WORKSPACE_DID_CHANGE_WATCHED_FILES
        registration = types.Registration(id=method, method=method, register_options=watching)
        ls.client_register_capability(types.RegistrationParams([registration]))
    ls.soon(_pull(ls))


async def _watch_parent(ls: Session, process: int) -> None:
    """End when the editor has ended: something that it started may still hold our standard input open."""
    while True:
        await asyncio.sleep(PARENT_PERIOD)
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            ls.ended.set()
            return
        except PermissionError:
            pass  # it lives, and is somebody else's


def did_change_configuration(ls: Session, params: types.DidChangeConfigurationParams) -> None:
    if params.settings:
        _take(ls, params.settings)
    else:
        ls.soon(_pull(ls))


async def _pull(ls: Session) -> None:
    """Ask the client for the section, where it can be asked."""
    workspace = ls.client_capabilities.workspace
    if not (workspace and workspace.configuration):
        return
    asked = types.ConfigurationParams([types.ConfigurationItem(section="improv")])
    try:
        answer = await asyncio.wait_for(asyncio.shield(ls.workspace_configuration_async(asked)), ANSWER_LIMIT)
    except Exception:  # no answer, or a refusal: the settings stay as they are
        return
    if answer and answer[0]:
        _take(ls, answer[0])


def _take(ls: Session, given: Any) -> None:
    before, told = ls.settings, ls.wrong_settings
    ls.settings, ls.wrong_settings = read_settings(given, before)
    for problem in ls.wrong_settings:
        if problem not in told:  # clients send all settings whenever one of them changes
            ls.say(problem, types.MessageType.Warning)
    if ls.settings.hints_beats != before.hints_beats:
        ls.ask_again("inlay_hint")
    if ls.settings.code_lens != before.code_lens:
        ls.ask_again("code_lens")

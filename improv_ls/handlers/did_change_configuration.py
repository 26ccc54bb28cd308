"""workspace/didChangeConfiguration, and workspace/configuration to ask for the settings."""

from __future__ import annotations

from typing import Any

from lsprotocol import types

from improv_ls.session import Session
from improv_ls.settings import read_settings


def did_change_configuration(ls: Session, params: types.DidChangeConfigurationParams) -> None:
    if params.settings:
        _take(ls, params.settings)
    else:
        ls.editor.soon(pull(ls))


async def pull(ls: Session) -> None:
    """Ask the client for the settings, if it takes questions. A late answer counts, unless the client has answered a
    later question by then."""
    editor = ls.editor
    if not editor.can("workspace.configuration"):
        return
    editor.pulls = number = editor.pulls + 1
    asked = types.ConfigurationParams([types.ConfigurationItem(section="improv")])
    try:
        answer = await ls.workspace_configuration_async(asked)
    except Exception:  # a refusal: the settings stay as they are
        return
    if answer and answer[0] and number > editor.pulled:
        editor.pulled = number
        _take(ls, answer[0])


def _take(ls: Session, given: Any) -> None:
    editor = ls.editor
    before, told = editor.settings, editor.wrong_settings
    editor.settings, editor.wrong_settings = read_settings(given, before)
    for problem in editor.wrong_settings:
        if problem not in told:  # clients send all settings whenever one of them changes
            editor.warn(problem)
    shown = [(each.inlay_hints_beats, each.inlay_hints_playing) for each in (before, editor.settings)]
    if shown[0] != shown[1]:
        editor.refresh("inlay_hint")
    if editor.settings.code_lens != before.code_lens:
        editor.refresh("code_lens")

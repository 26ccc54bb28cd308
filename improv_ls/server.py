"""The server on one screen: which method of LSP goes to which handler."""

from __future__ import annotations

import logging

from lsprotocol import types

from improv_ls.handlers import documents, language, lifecycle, playback
from improv_ls.session import Session


def create_server() -> Session:
    """A server with every feature; it waits for a client."""
    server = Session()
    feature, command = server.feature, server.command

    feature(types.INITIALIZE)(lifecycle.initialize)
    feature(types.INITIALIZED)(lifecycle.initialized)
    feature(types.WORKSPACE_DID_CHANGE_CONFIGURATION)(lifecycle.did_change_configuration)
    feature(types.SHUTDOWN)(lifecycle.shutdown)

    feature(types.TEXT_DOCUMENT_DID_OPEN)(documents.did_open)
    feature(types.TEXT_DOCUMENT_DID_CHANGE)(documents.did_change)
    feature(types.TEXT_DOCUMENT_DID_CLOSE)(documents.did_close)

    feature(types.TEXT_DOCUMENT_HOVER)(language.hover)
    feature(types.TEXT_DOCUMENT_COMPLETION)(language.completion)

    feature(types.TEXT_DOCUMENT_DID_SAVE)(playback.did_save)
    command(playback.PLAY)(playback.play)
    command(playback.HUSH)(playback.hush)
    return server


def serve() -> None:
    """Serve one editor over standard input and output."""
    # Editors show standard error as errors, and every message that matters reaches the person through LSP.
    logging.basicConfig(level=logging.CRITICAL)
    create_server().start_io()

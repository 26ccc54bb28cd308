"""textDocument/declaration: the definition, except that a robot in `improv.toml` is declared by its section."""

from __future__ import annotations

from lsprotocol import types

from improv_ls.handlers import robots_file
from improv_ls.handlers.definition import definition
from improv_ls.session import Session


def declaration(ls: Session, params: types.DeclarationParams) -> list[types.Location]:
    if file := ls.robots_files.get(params.text_document.uri):
        return robots_file.declaration(ls, file, params)
    return definition(ls, types.DefinitionParams(params.text_document, params.position))

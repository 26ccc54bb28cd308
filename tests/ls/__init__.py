"""Tests of the language server, with the types of LSP as it loads them."""

from improv_ls import lazy_types

lazy_types.load()

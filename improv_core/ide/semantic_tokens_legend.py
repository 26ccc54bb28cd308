"""The kinds of colored words, in LSP's standard names, so that every theme has colors for them."""

TYPES = ("comment", "keyword", "function", "variable", "class", "enumMember", "number", "operator", "modifier")
MODIFIERS = ("definition", "defaultLibrary")

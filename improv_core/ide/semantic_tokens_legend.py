"""Token types and modifiers, with LSP's standard names, so every theme has colors for them."""

TYPES = (
    "comment",
    "keyword",
    "function",
    "variable",
    "class",
    "enumMember",
    "number",
    "operator",
    "modifier",
    "parameter",
    "property",
)
MODIFIERS = ("definition", "defaultLibrary")

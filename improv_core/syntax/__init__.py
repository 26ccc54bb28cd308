"""Text to trees: statements, tokens, and the parser, which never raises; the vocabulary, and the formatter.

It may import `score`, `diagnostics`, `slices`, and `text`. Begin with `statements`, then `parser`; each word of the
language is a row of `vocabulary`.
"""

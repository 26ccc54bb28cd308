"""Which bracket closes which; what is missing or too much is said on the bracket itself, and mended."""

from __future__ import annotations

from collections.abc import Sequence

from improv_core.diagnostics import Diagnostic
from improv_core.syntax.lexer import Token

_CLOSER = {"LPAR": "RPAR", "LSQB": "RSQB"}
_TEXT = {"LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]"}


def close_brackets(tokens: Sequence[Token]) -> tuple[list[Token], list[Diagnostic]]:
    """The tokens with every bracket matched, and what had to be done for it."""
    mended: list[Token] = []
    diagnostics: list[Diagnostic] = []
    opened: list[Token] = []

    def close(opener: Token, place: int) -> None:
        closer = _CLOSER[opener.type]
        message = f"close this bracket with `{_TEXT[closer]}`"
        diagnostics.append(Diagnostic("unclosed-bracket", opener.span, message))
        mended.append(Token(closer, "", place, place))

    for token in tokens:
        if token.type in _CLOSER:
            opened.append(token)
        elif token.type in _CLOSER.values():
            if not opened:
                message = f"remove this `{token.text}`, or write the bracket it should close"
                diagnostics.append(Diagnostic("unmatched-bracket", token.span, message))
                continue
            if any(_CLOSER[opener.type] == token.type for opener in opened):
                while _CLOSER[opened[-1].type] != token.type:
                    close(opened.pop(), mended[-1].end)
            else:
                wanted = _CLOSER[opened[-1].type]
                message = f"write `{_TEXT[wanted]}` here: the bracket it closes is `{opened[-1].text}`"
                diagnostics.append(Diagnostic("unmatched-bracket", token.span, message))
                token = token._replace(type=wanted)
            opened.pop()
        mended.append(token)
    while opened:
        close(opened.pop(), mended[-1].end)
    return mended, sorted(diagnostics, key=lambda diagnostic: diagnostic.span)

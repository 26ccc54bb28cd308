"""Match brackets: repair missing and extra ones, and report each at the bracket itself.

Only the writer knows the place of a missing bracket, so all fixes are guesses.
"""

from __future__ import annotations

from collections.abc import Sequence

from improv_core.diagnostics import Diagnostic, replace
from improv_core.syntax.lexer import Token
from improv_core.text import Span

BRACKETS = frozenset({"LPAR", "RPAR", "LSQB", "RSQB"})
_CLOSER = {"LPAR": "RPAR", "LSQB": "RSQB"}
_TEXT = {"LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]"}


def close_brackets(tokens: Sequence[Token]) -> tuple[list[Token], list[Diagnostic]]:
    """Return the tokens with every bracket matched, and a diagnostic for each repair."""
    repaired: list[Token] = []
    diagnostics: list[Diagnostic] = []
    opened: list[Token] = []

    def close(opener: Token, place: int) -> None:
        closer = _CLOSER[opener.type]
        message = f"close this bracket with `{_TEXT[closer]}`"
        fixes = replace(f"Insert {_TEXT[closer]}", Span(place, place), _TEXT[closer], guess=True)
        diagnostics.append(Diagnostic("unclosed-bracket", opener.span, message, fixes))
        repaired.append(Token(closer, "", place, place))

    for token in tokens:
        if token.type in _CLOSER:
            opened.append(token)
        elif token.type in _CLOSER.values():
            if not opened:
                message = f"remove this `{token.text}` or add the bracket it should close"
                fixes = replace("Remove it", token.span, "", guess=True)
                diagnostics.append(Diagnostic("unmatched-bracket", token.span, message, fixes))
                continue
            if any(_CLOSER[opener.type] == token.type for opener in opened):
                while _CLOSER[opened[-1].type] != token.type:
                    close(opened.pop(), repaired[-1].end)
            else:
                wanted = _CLOSER[opened[-1].type]
                message = f"write `{_TEXT[wanted]}` here to close `{opened[-1].text}`"
                fixes = replace(f"Change to {_TEXT[wanted]}", token.span, _TEXT[wanted], guess=True)
                diagnostics.append(Diagnostic("unmatched-bracket", token.span, message, fixes))
                token = token._replace(type=wanted)
            opened.pop()
        repaired.append(token)
    while opened:
        close(opened.pop(), repaired[-1].end)
    return repaired, sorted(diagnostics, key=lambda diagnostic: diagnostic.span)

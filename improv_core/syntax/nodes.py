"""The tree of a statement. Spans count from the start of the statement, so trees stay valid when statements move."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from typing import TypeAlias

from improv_core.diagnostics import Diagnostic
from improv_core.score.movement import Movement
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.vocabulary import WORDS
from improv_core.syntax.word import Word
from improv_core.text import Span
from improv_core.values import value

LONGEST = 100_000
"""The most characters of a statement that is parsed: pasting a huge text must not freeze the editor."""


@value(frozen=True, slots=True)
class Primitive:
    span: Span
    word: Word
    movement: Movement


@value(frozen=True, slots=True)
class MeasuredWord:
    """A primitive with its measure, and with the radius of the circle along which it drives, if it has one."""

    span: Span
    primitive: Primitive
    measure: Number | None
    radius: Number | None

    @property
    def word(self) -> Word:
        return self.primitive.word


@value(frozen=True, slots=True)
class Name:
    span: Span
    text: str


@value(frozen=True, slots=True)
class Number:
    """A number, or a product of numbers and parameters: the tokens of its factors, with `*` or `/` between them, and
    the units of a measure.

    `text` is without spaces. If the number is missing, its only factor has no text, and the parser has reported it.
    """

    span: Span
    text: str
    tokens: tuple[Token, ...]

    @property
    def parameters(self) -> Iterator[Token]:
        return (token for token in self.tokens if token.type == "PARAM")

    @property
    def is_signed(self) -> bool:
        return any(token.text[:1] in ("+", "-") for token in self.tokens)

    @property
    def units(self) -> Sequence[Token]:
        return [token for token in self.tokens if token.type == "UNIT"]


@value(frozen=True, slots=True)
class Call:
    """A use of a phrase: its name and its arguments. The parser leaves `movements` empty; `gather` fills them in."""

    span: Span
    name: Name
    numbers: tuple[Number, ...]
    movements: tuple[Node, ...] = ()


@value(frozen=True, slots=True)
class Missing:
    """A movement that is missing here. The parser has reported it."""

    span: Span


@value(frozen=True, slots=True)
class Series:
    span: Span
    items: tuple[Node, ...]


@value(frozen=True, slots=True)
class Parallel:
    span: Span
    voices: tuple[Node, ...]


@value(frozen=True, slots=True)
class Bracket:
    """`( )`, or `[ ]`, which squeezes its items."""

    span: Span
    squeezes: bool
    body: Node | None


@value(frozen=True, slots=True)
class Condition:
    """The name of a sense, negated if `not` stands before it."""

    span: Span
    is_negated: bool
    sense: Token


@value(frozen=True, slots=True)
class Apply:
    """A transformer, its arguments, and the term that it applies to."""

    span: Span
    word: Token
    body: Node
    numbers: tuple[Number, ...] = ()
    across: Token | None = None
    condition: Condition | None = None

    @property
    def plane(self) -> Word | None:
        return WORDS.get(self.across.text) if self.across else None


@value(frozen=True, slots=True)
class PartTerm:
    """A word for a body part and the term that it performs. Only `gather` makes it, out of a name."""

    span: Span
    name: Name
    body: Node


@value(frozen=True, slots=True)
class PoseTerm:
    """`to POSE`. Only `gather` makes it, of two names. The name of the pose is not a name of the program."""

    span: Span
    word: Name
    pose: Name


@value(frozen=True, slots=True)
class Choice:
    """`if condition then else otherwise`. `then` must be one term."""

    span: Span
    word: Token
    condition: Condition
    then: Node
    otherwise: Node


@value(frozen=True, slots=True)
class AtPoint:
    """`at x y facing d`: in meters and degrees, unless they have units."""

    x: Number
    y: Number
    facing: Number | None = None


@value(frozen=True, slots=True)
class InFormation:
    """`at circle n facing out around x y`: `size` is the radius of a circle, or the distance between neighbors."""

    shape: Token
    size: Number
    facing: Token | None = None
    around: tuple[Number, Number] | None = None


@value(frozen=True, slots=True)
class OfKind:
    """`is PROFILE`."""

    profile: Token


@value(frozen=True, slots=True)
class FloorSize:
    """`room w h`: meters along x and y."""

    width: Number
    height: Number


@value(frozen=True, slots=True)
class BarLength:
    """`bar n`."""

    beats: Number


OpeningNode: TypeAlias = AtPoint | InFormation | OfKind | FloorSize | BarLength

Node: TypeAlias = (
    Primitive
    | MeasuredWord
    | Name
    | Call
    | Missing
    | Series
    | Parallel
    | Bracket
    | Apply
    | Choice
    | PartTerm
    | PoseTerm
)


@value(frozen=True, slots=True)
class Parameter:
    """A parameter in the head of a definition: `n` is a number, `(m)` is a movement."""

    token: Token
    is_number: bool

    @property
    def name(self) -> str:
        return self.token.text


@value(frozen=True, slots=True)
class Statement:
    """A statement's tree and syntax errors."""

    text: str
    diagnostics: tuple[Diagnostic, ...]
    sign: Token | None
    """The `beat`, `=`, `$`, or `---` that makes it a tempo, a definition, a play statement, or a new scene, or the
    `at`, `is`, `room`, or `bar` of a line of the opening; None if it has none."""
    heads: tuple[Token, ...] = ()
    """The names before the sign (after `---`)."""
    body: Node | None = None
    """The movement before `gather` has given names their movements."""
    number: Number | None = None
    """The tempo."""
    defines: str | None = None
    """The name that it defines, if that name is allowed."""
    uses: tuple[str, ...] = ()
    """The names in the movement that are not parameters, each once."""
    has_voices: bool = False
    """True if it contains `||`."""
    by_robot: bool = False
    """True if it contains a word that means something else for each robot."""
    has_senses: bool = False
    """True if it contains a condition."""
    has_arguments: bool = False
    """True if it contains numbers after a name."""
    has_measures: bool = False
    """True if it contains measures."""
    parameters: tuple[Parameter, ...] = ()
    """The parameters of a phrase."""
    opening: OpeningNode | None = None
    """The node of a line of the opening."""
    words: tuple[Token, ...] = ()
    """Its words that are names elsewhere: those of a line of the opening, units, and `radius`."""
    as_names: Statement | None = None
    """The same text as it is read where `radius` is a name, if that may be another program; both have the `uses` of
    either."""

    @property
    def kind(self) -> str:
        """The type of its sign, such as DOLLAR if robots play; empty if it has no sign."""
        return self.sign.type if self.sign else ""

    @property
    def tokens(self) -> list[Token]:
        """All tokens, lexed again: many statements are cached, and few need their tokens. Empty if it is too long."""
        return lex(self.text) if len(self.text) <= LONGEST else []


def use_name(use: Name | Call) -> Name:
    """Return the name in a use of a name or a phrase."""
    return use.name if isinstance(use, Call) else use


def voices(node: Node) -> tuple[Node, ...]:
    """Return the voices of a movement; the movement itself if it has no `||`."""
    return node.voices if isinstance(node, Parallel) else (node,)


def inside_parentheses(node: Node) -> Node:
    """Return the node inside of all parentheses around it."""
    while isinstance(node, Bracket) and not node.squeezes and node.body:
        node = node.body
    return node


def children(node: Node) -> tuple[Node, ...]:
    """Return the nodes directly inside."""
    if isinstance(node, Series):
        return node.items
    if isinstance(node, Parallel):
        return node.voices
    if isinstance(node, (Apply, PartTerm)):
        return (node.body,)
    if isinstance(node, Bracket) and node.body:
        return (node.body,)
    if isinstance(node, Call):
        return (node.name, *node.movements)
    if isinstance(node, Choice):
        return (node.then, node.otherwise)
    return ()


def nodes(node: Node) -> Iterator[Node]:
    """Yield a node and all nodes inside it, in the order of the text."""
    yield node
    for child in children(node):
        yield from nodes(child)


def names(node: Node) -> Iterator[Name]:
    """Return the names inside a node, in the order of the text."""
    return (each for each in nodes(node) if isinstance(each, Name))


def numbers(node: Node) -> tuple[Number, ...]:
    """Return the numbers that belong to a node itself."""
    if isinstance(node, MeasuredWord):
        return tuple([each for each in (node.measure, node.radius) if each])
    return node.numbers if isinstance(node, (Apply, Call)) else ()


def mentions(node: Node | Number, movements: Container[str]) -> Iterator[str]:
    """Yield the parameters that a node or a number mentions, in order. `movements` names those that are movements."""
    if isinstance(node, Number):
        yield from (token.text for token in node.parameters)
        return
    for each in nodes(node):
        for number in numbers(each):
            yield from mentions(number, movements)
        if isinstance(each, Name) and each.text in movements:
            yield each.text


def items(voice: Node) -> int:
    """Return the number of items that a bracket counts in one of its voices."""
    return len(voice.items) if isinstance(voice, Series) else 1

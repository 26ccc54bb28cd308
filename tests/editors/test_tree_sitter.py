"""The tree-sitter grammar reads programs as our parser does; of a program with mistakes, all correct statements."""

from __future__ import annotations

import ctypes
import json
import os
import random
import re
import subprocess
from collections.abc import Collection, Iterator
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from improv_core.syntax.characters import COMMENT, is_name
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import (
    Apply,
    Bracket,
    Call,
    Choice,
    Condition,
    MeasuredWord,
    Name,
    Node,
    Number,
    OfKind,
    Statement,
    children,
    numbers,
)
from improv_core.syntax.opening import FACINGS, SHAPES
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.syntax.vocabulary import TRANSFORMERS, WORDS
from improv_core.syntax.word import Kind
from tests.editors.editors import ROOT, find, follow
from tests.needs import lacking

pytestmark = pytest.mark.slow("compiles the grammar")

if TYPE_CHECKING:
    import tree_sitter

GRAMMAR = ROOT / "editors" / "tree-sitter-improv"
FOR_NEOVIM, FOR_HELIX = GRAMMAR / "queries" / "improv", ROOT / "editors" / "helix" / "runtime" / "queries" / "improv"

CONFORMANCE = [
    case["program"] for case in json.loads((ROOT / "tests" / "conformance.json").read_text("utf-8"))["cases"]
]
PROGRAMS = [
    *(program for program in CONFORMANCE if "left = " not in program),  # built-in words can no longer be defined
    *(path.read_text("utf-8") for path in sorted((ROOT / "examples").glob("*.improv"))),
    *(f"r $ {word.usage.replace('movement', '(up)')}" for word in WORDS.values() if word.kind != Kind.BEAT),
    "x = forward # an (open [bracket\n\n\n# in a comment = $\ny = x\r\nr $ y\rs $ x",
    "größe_1 = (\n\n  left # one\n  # two\n\n  [ up\r\n\tdown ]\n) x\n\ufeff r $ größe_1",
    "r $ repeat repeat 2 fast -1/2 scale .5 reflect XZ slow 1.5 (()[[]])",
    "ada ＄ repeat ４（forward　left）＃ note\n－－－\nada $ scale 2×３÷4 [left\u00a0right ｜｜ up]\n",
    "आगे_चलो ｎ = repeat n (forward left)\nनम‌स्ते＝आगे_चलो\nada at −1 ０．5\nada $ नम‌स्ते",
    "forwards = left repeats\nlefts = repeat\tforwards\n",
    "f n k (m)( w ) = repeat n*2/3 m fast 2/n/k f 2 n (m w) m nn n2\nn m $ f 1/2 3 left (n) m",
    "r $ left # one\n\n# two\n  || right # three\n# four\n||up\n# five\n\n---\n-----\n# six\nx = up",
    "f near n (not_) = until near (not_) if not near not_ f n\n  else repeat n not_\nelse_ = left",
    "f (m) = [\n  if near f m f else pause not cue m\n  || x\n]\nelse_ $ if near (\nleft)\n# why\nelse right",
    "ada at 1 2\nbo at-1.5 +.5 facing -90 # $ =\nat at 1/2*3 2\nada at at grid 1 around 1 2\n circle is at circle 1",
    "a b at circle 1.5 facing out around 2 -0\na at circle 1 around 2 0 facing in\na at line 1/2\nb at grid 2",
    "room 6 4.5\nbar 3\n--- finale\n----room # why\nada bo is puppet\nis is is\nada at circle is nao--v6_2# y\na is at",
    "room is puppet\nbar at 1 2\nroom $ left\nbar is at $ left\nat = left\nis n = left\nx = bar 3\nx = (\nbar 3\nat\n)",
    "r $ if near left\nelse at 3\n|| bar 3\nroom 1 2\nr $ [at 1\n(room 2 left)\nroom]\nbar 3\ncircle line $ in",
    "p n side = repeat n (forward side*1m left 360deg/n)||up 1/2m*3\nm = up\nr $ fast 2m repeat 3m left 2m m right 90°",
    "r $ left 180deg radius 60cm halfleft radius 2 left 90deg\n|| right radius 1.5m(down)\nroom 6m 400cm",
    "a at 50cm -1m facing 90deg\nb c at circle 1/2m around 2m 0\nradius = up\nr $ radius",
    "f (\n# why\n  m\n) = m\nf\tn = ramp .5*n n m\nm = n\ng (n) = n repeat n\nbeat 30*2",
]
"""Programs without mistakes."""


class Tree(NamedTuple):
    """A piece of a program: its kind, its place, and its parts."""

    kind: str
    start: int
    end: int
    parts: tuple[Tree, ...] = ()


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a home in which the grammar is installed for Neovim, as its page says."""
    home = tmp_path_factory.mktemp("grammar")
    (install,) = re.findall(r"```sh\n(.*?)```", (GRAMMAR / "README.md").read_text("utf-8"), re.DOTALL)
    follow(install, environment_in(home))
    return home


def environment_in(home: Path) -> dict[str, str]:
    return {"HOME": str(home)} | {f"XDG_{kind}_HOME": str(home / kind) for kind in ("CONFIG", "DATA", "STATE")}


@pytest.fixture(scope="module")
def parser(home: Path) -> tree_sitter.Parser:
    try:
        import tree_sitter
    except ImportError:
        lacking("tree-sitter is not installed: pip install -e '.[test]'")
    improv = ctypes.CDLL(str(home / "DATA" / "nvim" / "site" / "parser" / "improv.so")).tree_sitter_improv
    improv.restype = ctypes.c_void_p
    capsule = ctypes.pythonapi.PyCapsule_New
    capsule.restype, capsule.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)
    return tree_sitter.Parser(tree_sitter.Language(capsule(improv(), b"tree_sitter.Language", None)))


def test_programs_are_read_alike(parser: tree_sitter.Parser) -> None:
    assert [program for program in PROGRAMS if check(parser, program)] == []


@pytest.mark.parametrize(
    ("program", "mistakes"),
    [
        ("x = (forward\n\ny = left", 1),
        ("x = (forward # (\n# (\nr1 r2 $ left", 1),
        ("x = [forward\n  beat 60", 1),
        ("x = (forward\nbeats = left\nz = up)\nr $ x", 2),
        ("r\n\ns $ left\nx\ny = up", 2),
        ("r $ reflect\nx = fast\ny = repeat 2\nbeat\ns $ y", 4),
        ("r $ forward)\ns $ left", 1),
        ("r $ ((forward]\ns $ (left)", 1),
        ("left right\nx\nturtle forward x || up\nleft = up\nup $ left\nr $ left", 5),
        ("r $ , forward\n- $ up\ns $ up | left\nt $ left", 3),
        ("f n = n\ng (m) = repeat m\nh n = repeat n m\ny n (m) = fast m n", 2),
        ("x = (left\nf n (m) = m\ny = [up\n---\nr $ left\nz = [up\n|| r $ left\ns $ left", 3),
        ("r $ left ---\n--- left\n--\nr $ left\n||\ns $ up\n|| else left\nelse $ up\nt $ up", 5),
        ("r $ if near left\ns $ if left else right\nt $ until not left\nu $ ramp 2 left\nv $ poly 2* 3", 4),
        ("ada at\nada bo is\nroom\nbar\nroom 6\nada at 1\nbo at circle 1 facing\n--- x y\nroom 6 4 2\nada at 1 2", 9),
        (
            "at 1 2\nr $ left\na at line 1 facing in\nb at grid\nc at circle at 1 2\nd at 1 2 is x\ne is x- y\nbar 3",
            6,
        ),
        ("room 6 = left\nr $ left\nat line 1 $ left\nbar 3 4\nbo at 1 2 3\n|| up\nx = up\n(bar 3\ny = left\nbar 3", 5),
        ("r $ if near left right else up else down\ns $ not near\nf (m) n = m\nf [m] = m\nf (m n) = m", 5),
    ],
)
def test_a_mistake_stays_in_its_statement(program: str, mistakes: int, parser: tree_sitter.Parser) -> None:
    assert check(parser, program) == mistakes


def test_random_typos_rarely_affect_other_statements(parser: tree_sitter.Parser) -> None:
    """Tree-sitter's recovery from a wrong line rarely breaks a neighbor: in 8 of 18,000 such programs.

    Four of the 8 are here.
    """
    chance = random.Random(1)
    pieces = [*"()[]\n\n\r$=|,#2- ", "||", "repeat ", "fast", "forward", "x", "beat ", "YZ", "r $ ", "x = "]
    pieces += ["f n (m) = ", " n", "m ", "---", "if near ", "else ", "until not ", "ramp ", "*", "/"]
    pieces += [" at ", " is ", "room ", "bar ", "circle ", "facing in", "é", "\ud7ff"]
    mistakes, spoiled = 0, []
    for _ in range(1_500):
        program = chance.choice(PROGRAMS)
        for _ in range(chance.choice([1, 1, 2, 4])):
            place = chance.randrange(len(program) + 1)
            inserted, removed = chance.choice(["", *pieces]), chance.choice([0, 0, 1, 3])
            program = program[:place] + inserted + program[place + removed :]
        try:
            mistakes += check(parser, program)
        except AssertionError:
            spoiled.append(program)
    assert mistakes > 600
    assert len(spoiled) <= 4, spoiled


@pytest.mark.parametrize("program", PROGRAMS[-20:])
def test_a_program_typed_letter_by_letter_is_read_alike(program: str, parser: tree_sitter.Parser) -> None:
    """As in editors, each tree is made from the one before."""
    source = program.encode()
    tree = parser.parse(b"")
    for end in range(1, len(source) + 1):
        before, after = (_point(source[:place]) for place in (end - 1, end))
        tree.edit(end - 1, end - 1, end, before, before, after)
        tree = parser.parse(source[:end], tree)
    assert _drawn(tree) == _drawn(parser.parse(source))


def _point(source: bytes) -> tuple[int, int]:
    return source.count(b"\n"), len(source) - source.rfind(b"\n") - 1


def _drawn(tree: tree_sitter.Tree) -> str:
    def drawn(node: tree_sitter.Node) -> str:
        return f"({node.type} {node.start_byte} {node.end_byte} {' '.join(map(drawn, node.children))})"

    return drawn(tree.root_node)


COLORED = """beat 60 # why
sq = slow 3/2 (left) || [up]
poly n (m) = ramp 2*n 3/2 m
--- finale
r1 r2 $ reflect YZ sq poly 4 left
  || if not near up else until cue left 90deg radius 1.5m
room 6 4
bar 60
at r1 at circle 4 facing in around -1 6
at is nao-v6"""
COLORS = [
    ("attribute", "keyword", {"beat", "at", "is", "room", "bar", "facing", "around"}),
    ("label", "label", {"finale"}),
    ("number", "constant.numeric", {"60", "3/2", "4", "2*n", "6", "-1", "90deg", "1.5m"}),
    ("variable", "variable", {"sq", "poly"}),
    ("variable.parameter", "variable.parameter", {"n", "m"}),
    ("operator", "operator", {"=", "||", "$", "*", "/"}),
    ("operator", "punctuation.special", {"---"}),
    ("punctuation.bracket", "punctuation.bracket", set("()[]")),
    ("keyword", "keyword.control", {"slow", "reflect", "ramp", "until", "radius"}),
    ("keyword.conditional", "keyword.control.conditional", {"if", "else"}),
    ("keyword.operator", "keyword.operator", {"not"}),
    ("variable.member", "variable.other.member", {"near", "cue"}),
    ("constant", "constant.builtin", {"YZ", "circle", "in", "nao-v6"}),
    ("function.builtin", "function.builtin", {"up", "left"}),
    ("type", "type", {"r1", "r2", "at"}),
    ("comment", "comment.line", {"# why"}),
]
"""The color of words in Neovim, and in Helix."""


@pytest.mark.parametrize("queries", [FOR_NEOVIM, FOR_HELIX])
def test_colors_of_words(queries: Path, parser: tree_sitter.Parser) -> None:
    expected: dict[str, set[str]] = {}
    for in_neovim, in_helix, texts in COLORS:
        expected.setdefault(in_neovim if queries == FOR_NEOVIM else in_helix, set()).update(texts)
    found = captures(parser, queries / "highlights.scm", COLORED)
    found.pop("spell", None)  # comments have it in Neovim
    assert {name: set(texts) for name, texts in found.items()} == expected


QUERIED = "# a\n# b", "x = (up\n[left]\n)", "y n (m) = m repeat n m", "r $ y 4 up\n  || if not near x else y 2"
BRACKETS = "(up\n[left]\n)", "[left]"


@pytest.mark.parametrize(
    ("file", "capture", "texts"),
    [
        (FOR_NEOVIM / "folds.scm", "fold", [*QUERIED[:2], *BRACKETS, *QUERIED[2:]]),
        (FOR_NEOVIM / "indents.scm", "indent.begin", [QUERIED[1], *BRACKETS, *QUERIED[2:]]),
        (FOR_NEOVIM / "locals.scm", "local.definition.var", ["x", "y"]),
        (FOR_NEOVIM / "locals.scm", "local.definition.parameter", ["n", "m"]),
        (FOR_NEOVIM / "locals.scm", "local.reference", [*"xynmmnmyxy"]),
        (FOR_NEOVIM / "textobjects.scm", "call.outer", ["y 4", "y 2"]),
        (FOR_NEOVIM / "textobjects.scm", "conditional.inner", ["not near", "x", "y 2"]),
        (FOR_HELIX / "indents.scm", "indent", [QUERIED[1], *BRACKETS, *QUERIED[2:]]),
        (FOR_HELIX / "indents.scm", "outdent", ["]", ")", ")"]),
        (FOR_HELIX / "locals.scm", "local.definition.variable", ["x", "y"]),
        (FOR_HELIX / "textobjects.scm", "function.inside", [BRACKETS[0], "m repeat n m", QUERIED[3][4:]]),
        (FOR_HELIX / "textobjects.scm", "entry.inside", ["up", "[left]", "m", "repeat n m", "y 4", "up"]),
        (FOR_HELIX / "textobjects.scm", "parameter.inside", ["n", "m", "n", "4", "not near", "2"]),
    ],
    ids=lambda value: f"{value.parents[1].parent.name}-{value.stem}" if isinstance(value, Path) else None,
)
def test_other_queries(file: Path, capture: str, texts: list[str], parser: tree_sitter.Parser) -> None:
    assert captures(parser, file, "\n".join(QUERIED))[capture] == texts


@pytest.mark.parametrize(("variable", "fetched"), [("NVIM", "nvim-0.10"), ("NVIM_0_12", "nvim-0.12")])
def test_colors_in_neovim(variable: str, fetched: str, home: Path, tmp_path: Path) -> None:
    neovim = find(variable, f"{fetched}/usr/bin/nvim")
    program, script = tmp_path / "dance.improv", tmp_path / "colors.lua"
    program.write_text("--- finale\nr $ reflect YZ up # why\n", "utf-8")
    script.write_text(WORDS_TO_GROUPS, "utf-8")
    plugin = f"set runtimepath^={ROOT / 'editors' / 'neovim'}"
    command = [neovim, "--headless", "-i", "NONE", "-n", "--cmd", plugin, "-c", f"luafile {script}", str(program)]
    done = subprocess.run(
        command, env={**os.environ, **environment_in(home)}, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {
        **dict.fromkeys(["---", "$"], "@operator"),
        **dict.fromkeys(["#", "why"], "@comment"),
        "finale": "@label",
        "r": "@type",
        "reflect": "@keyword",
        "YZ": "@constant",
        "up": "@function.builtin",
    }


WORDS_TO_GROUPS = """
vim.treesitter.get_parser(0):parse()
local found = {}
for row, line in ipairs(vim.api.nvim_buf_get_lines(0, 0, -1, true)) do
  for column, word in line:gmatch("()(%S+)") do
    for _, color in ipairs(vim.inspect_pos(0, row - 1, column - 1).treesitter) do
      if color.capture ~= "spell" then
        found[word] = color.hl_group:gsub("%.improv$", "")
      end
    end
  end
end
io.stdout:write(vim.json.encode(found))
vim.cmd("qa!")
"""
"""A script that writes the group that colors each word on the screen, as Neovim's :Inspect shows it."""

LEAVES = {
    *("beat", "name", "robot", "parameter", "sense", "transformer", "primitive", "plane", "comment"),
    *("title", "formation", "direction", "profile"),
}
SIGNS = {
    *("=", "$", "||", "(", ")", "[", "]", "if", "else", "not"),
    *("---", "at", "is", "room", "bar", "facing", "around"),
}
LINES = {"BEAT": "tempo", "SCENE": "scene", "AT": "placing", "IS": "kind", "ROOM": "room", "BAR_LENGTH": "bar"}
HEADS = {"EQUAL": "name", "SCENE": "title"}
KINDS = {
    "BEAT": "beat",
    "NAME": "name",
    "PRIMITIVE": "primitive",
    "PLANE": "plane",
    "SCENE": "---",
    **{kind.value: "transformer" for kind in TRANSFORMERS},
}
"""Our tokens in the kinds of the grammar. The kind of a sign or a bracket is its text."""


def check(parser: tree_sitter.Parser, program: str) -> int:
    """Check that both read the program alike. Return the number of statements with mistakes, which may differ."""
    trees, words, comments = theirs(parser, program)
    assert comments == [comment.span() for comment in re.finditer(COMMENT, program)]
    mistakes = 0
    for start, text in split(program):
        statement, here = parse_statement(text), range(start, start + len(text))
        if is_right(statement):
            assert [tree for tree in trees if tree.start in here] == [tree_of(statement, start)], program
            assert [word for word in words if word.start in here] == words_of(statement, start), program
        else:
            mistakes += 1
    return mistakes


def is_right(statement: Statement) -> bool:
    """Return whether it has the form of a statement. Our parser doesn't check the words before the sign."""
    heads = [*(head.text for head in statement.heads), *(parameter.name for parameter in statement.parameters)]
    return not statement.diagnostics and all(is_name(head) and head not in WORDS for head in heads)


def tree_of(statement: Statement, start: int) -> Tree:
    """Return our tree of a statement, in the kinds of the grammar."""
    assert statement.sign
    words = words_of(statement, start)
    if kind := LINES.get(statement.sign.type, ""):
        parts = [word for word in words if word.kind not in SIGNS]
        return Tree(kind, words[0].start, words[-1].end, tuple(parts))
    assert statement.body
    movements = {each.name for each in statement.parameters if not each.is_number}
    kind = "definition" if statement.sign.type == "EQUAL" else "play"
    heads = [word for word in words if word.start < start + statement.sign.start and word.kind not in SIGNS]
    parts = [*heads, _node(statement.body, movements, start)]
    return Tree(kind, parts[0].start, parts[-1].end, tuple(parts))


def _node(node: Node, movements: Collection[str], start: int) -> Tree:
    """Return our tree of a movement. `movements` are the parameters that are movements."""
    kind = type(node).__name__.lower()
    parts = [_node(child, movements, start) for child in children(node)]
    if isinstance(node, Name) and node.text in movements:
        kind = "parameter"
    elif isinstance(node, Bracket):
        kind = "squeeze" if node.squeezes else "group"
    elif isinstance(node, MeasuredWord):
        kind = "measured"
        parts = [_node(node.primitive, movements, start), *(_number(number, start) for number in numbers(node))]
    elif isinstance(node, Call):
        parts += [_number(number, start) for number in node.numbers]
    elif isinstance(node, Choice):
        kind = "conditional"
        parts = [_condition(node.condition, start), *parts]
    elif isinstance(node, Apply):
        kind = "transformation"
        before = [_word("transformer", node.word, start), *(_number(number, start) for number in node.numbers)]
        if node.across:
            before.append(_word("plane", node.across, start))
        if node.condition:
            before.append(_condition(node.condition, start))
        parts = [*before, *parts]
    return Tree(kind, start + node.span.start, start + node.span.end, tuple(parts))


def _number(number: Number, start: int) -> Tree:
    parameters = tuple(_word("parameter", token, start) for token in number.parameters)
    return Tree("number", start + number.span.start, start + number.span.end, parameters)


def _condition(condition: Condition, start: int) -> Tree:
    span = condition.span
    return Tree("condition", start + span.start, start + span.end, (_word("sense", condition.sense, start),))


def words_of(statement: Statement, start: int) -> list[Tree]:
    """Return all words of a statement, and their kinds. A number is one word, even if it has several tokens."""
    found = [*_all_in(statement)]
    head = HEADS.get(statement.sign.type, "robot") if statement.sign else "robot"
    kinds = {token.span: head for token in statement.heads}
    kinds |= {each.sense.span: "sense" for each in found if isinstance(each, Condition)}
    for token in statement.words:
        kind = "formation" if token.text in SHAPES else "direction" if token.text in FACINGS else token.text
        kinds[token.span] = kind
    parameters = {each.name for each in statement.parameters}
    words = [_number(each, start) for each in found if isinstance(each, Number)]
    words += [_word("profile", each.profile, start) for each in found if isinstance(each, OfKind)]
    in_words = {place for word in words for place in range(word.start, word.end)}
    for token in statement.tokens:
        if start + token.start not in in_words:
            plain = "parameter" if token.text in parameters else KINDS.get(token.type, token.text)
            words.append(_word(kinds.get(token.span, plain), token, start))
    return sorted(words, key=lambda word: word.start)


def _all_in(value: object) -> Iterator[object]:
    """Yield all parts of a statement, however deep."""
    yield value
    parts = (
        value
        if isinstance(value, tuple)
        else [getattr(value, name) for name in getattr(value, "__slots__", ()) if name != "as_names"]
    )
    for part in () if isinstance(value, Token) else parts:
        yield from _all_in(part)


def _word(kind: str, token: Token, start: int) -> Tree:
    return Tree(kind, start + token.start, start + token.end)


def theirs(parser: tree_sitter.Parser, program: str) -> tuple[list[Tree], list[Tree], list[tuple[int, int]]]:
    """Return the grammar's trees of the statements, all words, and the comments."""
    source = program.encode()
    offsets = {place: index for index, place in enumerate(accumulate((len(c.encode()) for c in program), initial=0))}
    words: list[Tree] = []
    comments: list[tuple[int, int]] = []

    def tree(node: tree_sitter.Node, inside: str = "") -> Tree:
        start, end = offsets[node.start_byte], offsets[node.end_byte]
        inside_it = [] if node.type in LEAVES else node.children
        parts = [tree(child, node.type) for child in inside_it]
        kept = tuple(
            part for child, part in zip(inside_it, parts, strict=True) if child.is_named and not child.is_extra
        )
        found = Tree(f"missing {node.type}" if node.is_missing else node.type, start, end, kept)
        if node.type == "comment":
            comments.append((start, end))
        elif inside != "number" and start < end and (node.type == "number" or not parts):
            words.append(found)
        return found

    return list(tree(parser.parse(source).root_node).parts), words, comments


def captures(parser: tree_sitter.Parser, query: Path, program: str) -> dict[str, list[str]]:
    """Return the names in a query's matches, and the texts that have each name."""
    from tree_sitter import Query, QueryCursor

    assert parser.language
    cursor = QueryCursor(Query(parser.language, query.read_text("utf-8")))
    found: dict[str, list[str]] = {}
    for _, captured in cursor.matches(parser.parse(program.encode()).root_node):
        for name, several in captured.items():
            text = program[several[0].start_byte : several[-1].end_byte]
            found.setdefault(name, []).append(text)
    return found

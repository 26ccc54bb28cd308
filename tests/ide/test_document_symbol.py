"""The outline, a line for each entry: its name, its kind, its length, and the text that is marked when it is chosen."""

from __future__ import annotations

from improv_core.diagnostics import MAX_SHOWN
from improv_core.ide.document_symbol import OutlineEntry, names_in, outline
from improv_core.program.analysis import analyze


def check(program: str, *lines: str) -> None:
    found = []
    for entry in outline(analyze(program)):
        found += drawn(entry, "")
    assert found == list(lines)


def drawn(entry: OutlineEntry, indent: str) -> list[str]:
    assert entry.span.start <= entry.name_span.start < entry.name_span.end <= entry.span.end
    assert all(entry.span.start <= part.span.start <= part.span.end <= entry.span.end for part in entry.parts)
    line = f"{indent}{entry.name}: {entry.kind} {entry.detail}".rstrip()
    return [line, *(each for part in entry.parts for each in drawn(part, indent + "  "))]


def test_statements_have_entries() -> None:
    check(
        "# a dance\nbeat 30\nsquare = repeat 4 (forward left)\nr s $ square\nr $ repeat square",
        "beat 30: tempo",
        "square: name 8 beats",
        "r s: robots 8 beats",
        "  r: robot 8 beats",
        "  s: robot 8 beats",
        "r: robot ∞",
    )


def test_scenes_contain_their_entries() -> None:
    check(
        "f n = repeat n up\nr s $ up\n---\n# only a comment\n----\nr $ left\n\n",
        "scene 1: scene",
        "  f: phrase",
        "  r s: robots 1 beat",
        "    r: robot 1 beat",
        "    s: robot 1 beat",
        "scene 2: scene from beat 2",
        "scene 3: scene from beat 2",
        "  r: robot 1 beat",
    )
    check("---\nr $ up", "scene 2: scene from beat 1", "  r: robot 1 beat")
    check(
        "r $ slow 3/2 up\n---\nr $ repeat up\n---\n",
        "scene 1: scene",
        "  r: robot 1.5 beats",
        "scene 2: scene from beat 3",
        "  r: robot ∞",
        "scene 3: scene never performed",
    )


def test_broken_statements_as_far_as_they_go() -> None:
    check("x = (left\nr $\nleft left\n= up\nbeat\n$ up", "x: name 1 beat", "r: robot 0 beats")


def test_names_are_marked_in_the_outline() -> None:
    text = "\n r  s $ (left\n up)"
    (entry,) = outline(analyze(text))
    assert text[slice(*entry.span)] == "r  s $ (left\n up)"
    assert text[slice(*entry.name_span)] == "r  s"
    assert [text[slice(*part.name_span)] for part in entry.parts] == ["r", "s"]


def test_names_of_a_program_that_is_only_searched() -> None:
    found = names_in("beat 30\nx = (\nr s $ x\nr $ up")
    assert [(entry.name, entry.kind) for entry in found] == [
        ("x", "name"),
        ("r", "robot"),
        ("s", "robot"),
        ("r", "robot"),
    ]


def test_lines_with_syntax_errors_are_listed_as_far_as_they_are_marked() -> None:
    entries = outline(analyze("r $ up\nwrong = (\n" + "wrong = (\n" * MAX_SHOWN + "s $ up\n"))
    assert [entries[0].name, entries[-1].name, len(entries)] == ["r", "s", MAX_SHOWN + 2]

"""Definition, references and rename, as an editor sees them: its columns, its versions, files that are not open."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.ls.client import CAPABILITIES, Client, place

URI = "untitled:Untitled-1"
PROGRAM = "# 🐢\r\n𝑥 = left\r\nr s $ 𝑥 || 𝑥 # 🐢\r\ns $ up\r\n"
VERSIONED = {
    **CAPABILITIES,
    "workspace": {**CAPABILITIES["workspace"], "workspaceEdit": {"documentChanges": True}},
    "textDocument": {"rename": {"prepareSupport": True}},
}


def spot(found: dict[str, Any]) -> tuple[int, int, int]:
    """Return line, first and last column."""
    start, end = found["range"]["start"], found["range"]["end"]
    assert start["line"] == end["line"]
    return start["line"], start["character"], end["character"]


def spots(client: Client, method: str, asked: dict[str, Any]) -> list[tuple[str, tuple[int, int, int]]]:
    """Return the places that a request finds: the file of each, its line, first and last column."""
    return [(each["uri"], spot(each)) for each in client.request(f"textDocument/{method}", asked)]


def new_texts(changes: list[dict[str, Any]]) -> list[tuple[int, int, int, str]]:
    return [(*spot(edit), edit["newText"]) for edit in changes]


def test_a_name_in_utf_16_and_crlf() -> None:
    with Client() as client:
        client.open(URI, PROGRAM)
        assert spots(client, "definition", place(URI, 2, 13)) == [(URI, (1, 0, 2))]
        asked = place(URI, 2, 6, context={"includeDeclaration": False})
        assert spots(client, "references", asked) == [(URI, (2, 6, 8)), (URI, (2, 12, 14))]
        asked = place(URI, 1, 1, context={"includeDeclaration": True})
        assert len(client.request("textDocument/references", asked)) == 3
        found = client.request("textDocument/documentHighlight", place(URI, 1, 2))
        assert [(*spot(each), each["kind"]) for each in found] == [(1, 0, 2, 3), (2, 6, 8, 2), (2, 12, 14, 2)]
        assert client.request("textDocument/definition", place(URI, 0, 2)) == []


def test_uses_and_definitions_of_a_name_are_listed() -> None:
    with Client() as client:
        client.open(URI, PROGRAM.replace("left", "up") + "𝑦 = 𝑥 𝑥\r\n")
        (item,) = client.request("textDocument/prepareCallHierarchy", place(URI, 2, 13))
        assert (item["name"], item["uri"], item["selectionRange"]["start"]) == ("𝑥", URI, {"line": 1, "character": 0})
        client.change(URI, 2, {"text": PROGRAM + "𝑦 = 𝑥 𝑥\r\n"})
        line, definition = client.request("callHierarchy/incomingCalls", {"item": item})
        assert (line["from"]["name"], definition["from"]["name"]) == ("r s", "𝑦")
        assert [spot({"range": each}) for each in line["fromRanges"]] == [(2, 6, 8), (2, 12, 14)]
        (used,) = client.request("callHierarchy/outgoingCalls", {"item": definition["from"]})
        assert used["to"]["name"] == "𝑥"
        assert [spot({"range": each}) for each in used["fromRanges"]] == [(4, 5, 7), (4, 8, 10)]
        assert client.request("textDocument/prepareCallHierarchy", place(URI, 0, 1)) == []
        client.notify("textDocument/didClose", {"textDocument": {"uri": URI}})
        assert client.request("callHierarchy/incomingCalls", {"item": item}) == []


def test_a_name_is_renamed_in_the_text_as_it_is_now() -> None:
    with Client(capabilities=VERSIONED) as client:
        client.open(URI, "r $ 𝑥\r\n")
        client.change(URI, 2, {"text": PROGRAM})
        prepared = client.request("textDocument/prepareRename", place(URI, 2, 14))
        assert (spot(prepared), prepared["placeholder"]) == ((2, 12, 14), "𝑥")
        (change,) = client.request("textDocument/rename", place(URI, 2, 14, newName="turn"))["documentChanges"]
        assert change["textDocument"] == {"uri": URI, "version": 2}
        assert new_texts(change["edits"]) == [(1, 0, 2, "turn"), (2, 6, 8, "turn"), (2, 12, 14, "turn")]


def test_a_refusal_says_why_in_one_line() -> None:
    with Client(capabilities=VERSIONED) as client:
        client.open(URI, PROGRAM)
        refused = client.refusal("textDocument/prepareRename", place(URI, 1, 6))
        assert (refused["code"], refused["message"].count("\n")) == (-32803, 0)
        client.refusal("textDocument/rename", place(URI, 2, 0, newName="s"))
        assert not any(message["method"] == "window/showMessage" for message in client.notifications)


def test_a_robot_is_renamed_in_improv_toml_and_in_all_programs_that_share_it(tmp_path: Path) -> None:
    (tmp_path / "improv.toml").write_text('[robots.r]\r\nprofile = "turtlesim"\r\n[robots.s]\r\n', newline="")
    (tmp_path / "part").mkdir()
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "improv.toml").write_text("[robots.r]\n")
    here, opened, closed, apart = (
        tmp_path / name for name in ("here.improv", "opened.improv", "part/clo sed.improv", "own/apart.improv")
    )
    for path in (here, opened, closed, apart):
        path.write_text("r $ up\n")
    with Client(capabilities=VERSIONED) as client:
        client.open(opened.as_uri(), "s $ up\nr $ up\n")
        client.open(here.as_uri(), "r s $ left\n")
        client.open(URI, "r $ left\n")
        section = (tmp_path / "improv.toml").as_uri(), (0, 8, 9)
        assert spots(client, "definition", place(here.as_uri(), 0, 1)) == [section]
        asked = place(here.as_uri(), 0, 0, context={"includeDeclaration": True})
        assert len(client.request("textDocument/references", asked)) == 2

        changes = client.request("textDocument/rename", place(here.as_uri(), 0, 0, newName="anna"))["documentChanges"]
        assert {
            (change["textDocument"]["uri"], change["textDocument"]["version"]): new_texts(change["edits"])
            for change in changes
        } == {
            (here.as_uri(), 1): [(0, 0, 1, "anna")],
            ((tmp_path / "improv.toml").as_uri(), None): [(0, 8, 9, "anna")],
            (opened.as_uri(), 1): [(1, 0, 1, "anna")],
            (closed.as_uri(), None): [(0, 0, 1, "anna")],
        }
        client.refusal("textDocument/rename", place(opened.as_uri(), 0, 0, newName="r"))
        closed.write_text("r $ up\nbob $ up\n")
        refused = client.refusal("textDocument/rename", place(here.as_uri(), 0, 0, newName="bob"))
        assert refused["message"].startswith("in clo sed.improv: ")


def test_an_editor_asks_before_a_rename_changes_files_that_are_not_open(tmp_path: Path) -> None:
    (tmp_path / "improv.toml").write_text("[robots.r]\n")
    here, opened, closed = (tmp_path / f"{name}.improv" for name in ("here", "opened", "closed"))
    for path in (here, opened, closed):
        path.write_text("r $ up\n")
    edits = {"documentChanges": True, "changeAnnotationSupport": {}}
    with Client(capabilities={"workspace": {"workspaceEdit": edits}}) as client:
        client.open(opened.as_uri(), "r $ up\n")
        client.open(here.as_uri(), "r $ up\n")
        answer = client.request("textDocument/rename", place(here.as_uri(), 0, 0, newName="anna"))
        asked = {
            change["textDocument"]["uri"].rpartition("/")[2]: [
                answer["changeAnnotations"][edit["annotationId"]]["needsConfirmation"]
                for edit in change["edits"]
                if "annotationId" in edit
            ]
            for change in answer["documentChanges"]
        }
        assert asked == {"here.improv": [], "opened.improv": [], "improv.toml": [True], "closed.improv": [True]}
        client.notify("textDocument/didClose", {"textDocument": {"uri": opened.as_uri()}})
        (tmp_path / "improv.toml").unlink()
        answer = client.request("textDocument/rename", place(here.as_uri(), 0, 0, newName="anna"))
        assert "changeAnnotations" not in answer


BODY = """[profiles.dog]
step = 1
[profiles.dog.body.tail]
left = { joint = "tail", degrees = 10 }
[profiles.dog.body.tail.poses]
tucked = { left = -30 }
[robots.rex]
profile = "dog"
"""


def test_body_parts_and_poses_lead_to_their_declarations(tmp_path: Path) -> None:
    (tmp_path / "improv.toml").write_text(BODY, encoding="utf-8")
    program = tmp_path / "dance.improv"
    with Client() as client:
        client.open(program.as_uri(), "rex $ tail to tucked\nrex $ tail to start\ntail = up\nrex $ tail\n")

        def found(line: int, character: int) -> list[tuple[str, tuple[int, int, int]]]:
            places = spots(client, "definition", place(program.as_uri(), line, character))
            return [(Path(uri).name, where) for uri, where in places]

        assert found(0, 7) == [("improv.toml", (2, 19, 23))]
        assert found(0, 16) == [("improv.toml", (5, 0, 6))]
        assert found(0, 11) == []  # `to`
        assert found(1, 16) == []  # all parts have it
        assert found(3, 7) == [("dance.improv", (2, 0, 4))]  # the program's own name


def test_a_robot_that_no_file_mentions_belongs_to_its_program(tmp_path: Path) -> None:
    one, other = tmp_path / "one.improv", tmp_path / "other.improv"
    with Client() as client:
        for path in (one, other):
            client.open(path.as_uri(), "r $ up\n")
        changes = client.request("textDocument/rename", place(one.as_uri(), 0, 0, newName="anna"))["changes"]
        assert {uri: new_texts(edits) for uri, edits in changes.items()} == {one.as_uri(): [(0, 0, 1, "anna")]}

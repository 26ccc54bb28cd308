"""Help inside an improv.toml, in an editor: its text while somebody types, and the programs that share it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.ls.client import CAPABILITIES, QUIET, Client, place, span
from tests.ls.test_navigation import new_texts, spot, spots

ROBOTS = '# 🐢 𝑥\n[profiles.rover]\nstep = 1\n[robots.anna]\nprofile = "rover"\n'
CAPABLE = {
    **CAPABILITIES,
    "workspace": {**CAPABILITIES["workspace"], "workspaceEdit": {"documentChanges": True}},
    "textDocument": {
        **CAPABILITIES["textDocument"],
        "rename": {"prepareSupport": True},
        "hover": {"contentFormat": ["plaintext"]},
        "completion": {"completionItem": {"snippetSupport": True}},
    },
}


class Folder:
    """An improv.toml, open or not, and two programs, of which one is open."""

    def __init__(self, folder: Path) -> None:
        self.robots, self.opened, self.closed = (folder / name for name in ("improv.toml", "a.improv", "b.improv"))
        self.robots.write_text(ROBOTS, encoding="utf-8")
        self.opened.write_text("anna $ forward\n", encoding="utf-8")
        self.closed.write_text("x = left\nanna $ x\nanna $ x\n", encoding="utf-8")

    def open(self, client: Client, text: str = ROBOTS) -> str:
        client.open(self.opened.as_uri(), "anna bert $ forward\n")
        client.open(self.robots.as_uri(), text, "toml")
        return self.robots.as_uri()


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path)


def test_improv_toml_is_completed_explained_and_checked_while_typing(folder: Folder) -> None:
    with Client(QUIET, capabilities=CAPABLE) as client:
        uri = folder.open(client)
        client.wait("textDocument/publishDiagnostics", lambda params: params["uri"] == uri)
        client.change(uri, 2, {"text": ROBOTS + 'mess\n[robots.b]\nprofile = "rovr"\n'})
        found = client.request("textDocument/completion", place(uri, 5, 4))["items"]
        assert [each["label"] for each in found][:3] == ["start", "namespace", "topic"]
        (message,) = (each for each in found if each["label"] == "message")
        assert message["textEdit"]["newText"] == 'message = ${1|"auto","Twist","TwistStamped"|}'
        assert spot(message["textEdit"]) == (5, 0, 4)
        by_a_space = {"context": {"triggerKind": 2, "triggerCharacter": " "}}  # which offers only values
        assert client.request("textDocument/completion", place(uri, 5, 4, **by_a_space)) is None
        said = client.request("textDocument/hover", place(uri, 2, 1))
        assert said["contents"]["value"].startswith("step: the distance of forward")

        # A syntax error shows while somebody types, and the misspelled profile once the text is valid.
        text = ROBOTS + '[robots.b]\nprofile = "rovr"\n'
        client.change(uri, 3, {"text": text})
        published = client.wait("textDocument/publishDiagnostics", lambda params: params.get("version") == 3)
        assert len(published["diagnostics"]) == 1
        (fix,) = client.actions(uri, 6, 12, only=["quickfix"])
        assert fix["title"] == 'Change to "rover"'
        assert new_texts(fix["edit"]["documentChanges"][0]["edits"]) == [(6, 10, 16, '"rover"')]

        # After it is closed, the file on disk counts, which has no errors.
        client.notify("textDocument/didClose", {"textDocument": {"uri": uri}})
        published = client.wait("textDocument/publishDiagnostics", lambda params: params["uri"] == uri)
        assert published["diagnostics"] == []


def test_robots_are_completed_from_programs(folder: Folder) -> None:
    with Client(QUIET, capabilities=CAPABLE) as client:
        uri = folder.open(client, ROBOTS + "[robots.")
        found = client.request("textDocument/completion", place(uri, 5, 8))["items"]
        assert [each["label"] for each in found] == ["bert"]


def test_robots_are_completed_in_a_new_file_before_it_is_saved(folder: Folder) -> None:
    folder.robots.unlink()
    with Client(QUIET, capabilities=CAPABLE) as client:
        uri = folder.open(client, "[robots.")
        found = client.request("textDocument/completion", place(uri, 0, 8))["items"]
        assert [each["label"] for each in found] == ["anna", "bert"]


def test_from_a_section_to_the_lines_that_play_it_and_back(folder: Folder) -> None:
    with Client(QUIET, capabilities=CAPABLE) as client:
        uri = folder.open(client)
        played = [(folder.opened.as_uri(), (0, 0, 4)), *((folder.closed.as_uri(), (line, 0, 4)) for line in (1, 2))]
        section, program = [(uri, (3, 8, 12))], folder.opened.as_uri()
        assert spots(client, "definition", place(uri, 3, 9)) == played
        asked = place(uri, 3, 9, context={"includeDeclaration": True})
        assert spots(client, "references", asked) == [*section, *played]
        assert spots(client, "declaration", place(uri, 3, 9)) == section
        assert spots(client, "declaration", place(program, 0, 1)) == section
        assert spots(client, "definition", place(program, 0, 1)) == section
        assert spots(client, "definition", place(uri, 4, 12)) == [(uri, (1, 10, 15))]
        assert spots(client, "definition", place(uri, 0, 0)) == []
        assert client.request("textDocument/hover", place(uri, 0, 0)) is None


def test_a_robot_is_renamed_in_all_programs_and_a_profile_in_the_file(folder: Folder) -> None:
    with Client(QUIET, capabilities=CAPABLE) as client:
        uri = folder.open(client, ROBOTS + "\n")
        prepared = client.request("textDocument/prepareRename", place(uri, 3, 9))
        assert (spot(prepared), prepared["placeholder"]) == ((3, 8, 12), "anna")
        changes = client.request("textDocument/rename", place(uri, 3, 9, newName="ada"))["documentChanges"]
        assert {each["textDocument"]["uri"]: new_texts(each["edits"]) for each in changes} == {
            uri: [(3, 8, 12, "ada")],
            folder.opened.as_uri(): [(0, 0, 4, "ada")],
            folder.closed.as_uri(): [(1, 0, 4, "ada"), (2, 0, 4, "ada")],
        }
        assert [each["textDocument"]["version"] for each in changes] == [1, 1, None]
        (change,) = client.request("textDocument/rename", place(uri, 1, 12, newName="cart"))["documentChanges"]
        assert new_texts(change["edits"]) == [(1, 10, 15, "cart"), (4, 11, 16, "cart")]
        client.refusal("textDocument/rename", place(uri, 3, 9, newName="left"))
        client.refusal("textDocument/prepareRename", place(uri, 2, 1))


def test_a_body_part_is_found_and_renamed_in_all_programs(folder: Folder) -> None:
    folder.closed.write_text("anna $ mast up\n", encoding="utf-8")
    with Client(QUIET, capabilities=CAPABLE) as client:
        uri = folder.open(client, ROBOTS + '[profiles.rover.body.mast]\nup = { joint = "mast", meters = 0.1 }\n')
        places = [(uri, (5, 21, 25)), (folder.closed.as_uri(), (0, 7, 11))]
        assert spots(client, "references", place(uri, 5, 22, context={"includeDeclaration": True})) == places
        changes = client.request("textDocument/rename", place(uri, 5, 22, newName="pole"))["documentChanges"]
        assert [each["textDocument"]["uri"] for each in changes if each["edits"]] == [where for where, _ in places]


def test_everything_else_is_answered_from_the_file_and_not_from_a_program(folder: Folder) -> None:
    options = {"tabSize": 2, "insertSpaces": True}
    with Client(QUIET, capabilities=CAPABLE) as client:
        uri = folder.open(client, ROBOTS.replace("step = 1", "step=1 # 𝑥 "))
        document = {"textDocument": {"uri": uri}}
        found = client.request("textDocument/documentSymbol", document)
        assert [each["name"] for each in found] == ["profiles.rover", "step", "robots.anna", "profile"]
        found = client.request("textDocument/foldingRange", document)
        assert [(each["startLine"], each["endLine"]) for each in found] == [(1, 2), (3, 4)]
        found = client.request("textDocument/documentHighlight", place(uri, 4, 12))
        assert [(spot(each), each["kind"]) for each in found] == [((1, 10, 15), 3), ((4, 11, 16), 2)]
        (found,) = client.request(
            "textDocument/selectionRange", {**document, "positions": [{"line": 4, "character": 12}]}
        )
        assert spot(found) == (4, 11, 16)
        found = client.request("textDocument/formatting", {**document, "options": options})
        assert new_texts(found) == [(2, 4, 5, " = "), (2, 11, 12, ""), (3, 0, 0, "\n")]
        line = span(2, 0, 1)
        found = client.request("textDocument/rangeFormatting", {**document, "range": line, "options": options})
        assert new_texts(found) == [(2, 4, 5, " = "), (2, 11, 12, "")]
        assert client.request("textDocument/onTypeFormatting", place(uri, 2, 0, ch="\n", options=options)) == []


def test_an_unknown_robot_is_added(folder: Folder) -> None:
    with Client(QUIET, capabilities=CAPABLE) as client:
        uri = folder.open(client)
        client.change(folder.robots.as_uri(), 2, {"text": ROBOTS + "# typed\n"})
        found = client.actions(folder.opened.as_uri(), 0, 6, only=["quickfix"])
        (fix,) = [each for each in found if "Add" in each["title"]]
        assert fix["title"] == "Add bert to improv.toml"
        (change,) = fix["edit"]["documentChanges"]
        assert change["textDocument"] == {"uri": uri, "version": 2}
        assert new_texts(change["edits"]) == [(6, 0, 0, '\n[robots.bert]\nprofile = "rover"\n')]


def test_a_fix_of_a_closed_file_is_for_its_latest_save(folder: Folder) -> None:
    with Client(QUIET, capabilities=CAPABLE) as client:
        client.open(folder.opened.as_uri(), "anna bert $ forward\n")
        for saved, line in ((ROBOTS, 5), ("# mine\n" + ROBOTS, 6)):
            folder.robots.write_text(saved)
            found = client.actions(folder.opened.as_uri(), 0, 6, only=["quickfix"])
            (change,) = next(each["edit"]["documentChanges"] for each in found if "Add" in each["title"])
            assert new_texts(change["edits"]) == [(line, 0, 0, '\n[robots.bert]\nprofile = "rover"\n')]
        folder.robots.write_bytes(b"\xff")
        found = client.actions(folder.opened.as_uri(), 0, 6, only=["quickfix"])
        assert not [each for each in found if "Add" in each["title"]]


def listing(client: Client, program: Path) -> list[dict[str, Any]]:
    """Return the changes of the action that lists a program's robots; none if it is not offered."""
    found = client.actions(program.as_uri(), 0, 1)
    changes = [each["edit"]["documentChanges"] for each in found if each["title"].startswith("List these robots in ")]
    return [change for each in changes for change in each]


def test_robots_are_listed_in_a_file_that_may_not_exist_yet(tmp_path: Path) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    operations = {"workspaceEdit": {"documentChanges": True, "resourceOperations": ["create"]}}
    creates = {**CAPABLE, "workspace": {**CAPABLE["workspace"], **operations}}
    with Client(QUIET, capabilities=creates) as client:
        client.open(program.as_uri(), "anna bert $ forward\n")
        create, change = listing(client, program)
        assert (create["kind"], create["uri"]) == ("create", robots.as_uri())
        assert change["textDocument"] == {"uri": robots.as_uri(), "version": None}
        assert new_texts(change["edits"]) == [(0, 0, 0, "[robots.anna]\n\n[robots.bert]\n")]
        robots.write_text("[world]\n")
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": robots.as_uri(), "type": 1}]})
        (change,) = listing(client, program)
        assert new_texts(change["edits"]) == [(1, 0, 0, "\n[robots.anna]\n\n[robots.bert]\n")]
        client.open(robots.as_uri(), "[robots.anna]\n", "toml")  # typed, but not saved
        assert listing(client, program) == []
    with Client(QUIET, capabilities=CAPABLE) as client:  # which cannot create files
        robots.unlink()
        client.open(program.as_uri(), "anna bert $ forward\n")
        assert listing(client, program) == []

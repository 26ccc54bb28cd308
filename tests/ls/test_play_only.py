"""`improv.play` with a range, a name, or a line, among all that dances; and `improv.only`, which stops all else."""

from __future__ import annotations

from pathlib import Path

from tests.ls.client import QUIET, TOLD, Client, Message, span

URI = "file:///my%20dance.improv"
PROGRAM = "beat 240\n𝑥 = repeat up\nanna $ repeat left\nbert $ repeat forward\nanna $ lft\n"
RIGHT = PROGRAM.replace("lft", "left")


def see_playing(client: Client, generation: int, robots: list[str], ranges: list[list[int]]) -> None:
    """Wait until these robots play a generation, and these words are lit."""
    client.wait("improv/lit", lambda params: params["ranges"] == ranges)
    told = client.wait("improv/transport", lambda params: params["generation"] == generation)
    assert told["robots"] == robots


def test_only_the_requested_selection_plays_and_a_save_edits_it() -> None:
    with Client({**QUIET, "onSave": "continue", "switchAt": "beat"}, TOLD) as client:
        client.open(URI, PROGRAM)
        client.save(URI)
        client.wait_for_line("✗ line 5: `lft` is not defined")
        client.command("only", URI, span(3, 0, 0))
        assert client.wait_for_line("▶") == "▶ line 4: bert ∞, endless at beat 240, simulator"
        see_playing(client, 1, ["bert"], [[3, 14, 3, 21]])

        client.change(URI, 2, {"text": RIGHT})
        client.save(URI)
        assert client.wait_for_line("▶").startswith("▶ anna ∞ · bert ∞, ")
        see_playing(client, 2, ["anna", "bert"], [[2, 14, 2, 18], [3, 14, 3, 21]])

        client.command("only", URI, span(1, 5, 14))  # a robot that does not play
        assert client.wait_for_line("▶") == "▶ 𝑥: ghost ∞, endless at beat 240, simulator"
        see_playing(client, 3, ["ghost"], [[1, 12, 1, 14]])
        client.command("restart")
        assert client.wait_for_line("▶").startswith("▶ 𝑥: ghost")


def test_a_line_plays_among_the_others_and_editors_can_show_it() -> None:
    changed = PROGRAM.replace("repeat forward", "repeat right")
    with Client(QUIET, TOLD) as client:
        client.play(URI, RIGHT.replace("anna $ left", "# anna"))
        see_playing(client, 1, ["anna", "bert"], [[2, 14, 2, 18], [3, 14, 3, 21]])
        client.change(URI, 2, {"text": changed})  # with an error in another line
        client.command("play", URI, span(3, 2, 2))
        assert client.wait("improv/evaluated") == {"uri": URI, "version": 2, "range": [3, 0, 3, 19]}
        assert client.wait_for_line("▶") == "▶ line 4: bert ∞, endless at beat 240, simulator"
        see_playing(client, 2, ["anna", "bert"], [[2, 14, 2, 18], [3, 14, 3, 19]])
        client.command("restart")
        assert client.wait("improv/transport", lambda told: told["generation"] == 3)["robots"] == ["anna", "bert"]
        client.command("play", URI, "𝑥")
        see_playing(client, 4, ["anna", "bert", "ghost"], [[1, 12, 1, 14], [2, 14, 2, 18], [3, 14, 3, 19]])
        client.command("stop")
        client.wait("improv/transport", lambda told: told["state"] == "stopped")
        client.command("play", URI, 4)
        see_playing(client, 5, ["bert"], [[3, 14, 3, 19]])


def test_a_name_or_lines_are_enough_if_one_program_is_open() -> None:
    with Client(QUIET) as client:
        client.open(URI, PROGRAM)
        for arguments, expected in (
            (["𝑥"], "▶ 𝑥: ghost ∞, "),
            ([URI, "𝑥"], "▶ 𝑥: ghost ∞, "),
            ([4], "▶ line 4: bert ∞, "),
            (["~/../my dance.improv", 3, 4], "▶ lines 3 to 4: anna ∞ · bert ∞, "),
        ):
            client.command("play", *arguments)
            assert client.wait_for_line("▶").startswith(expected)


def test_the_line_of_what_plays_names_robots_that_stand_because_they_are_silenced() -> None:
    with Client(QUIET) as client:
        client.play(URI, RIGHT.replace("anna $ left", "# anna"))
        client.command("mute", "anna")
        client.command("only", URI, 4)
        assert client.wait_for_line("▶") == "▶ line 4: bert ∞, endless at beat 240, simulator"
        client.command("only", URI, 3)
        assert client.wait_for_line("▶") == "▶ line 3: anna ∞, endless at beat 240, simulator; anna muted"
        client.command("solo", "bert")
        client.command("only", URI, 3)
        assert client.wait_for_line("▶").endswith("simulator; only bert may move")


def test_an_unplayable_selection_is_refused_in_one_line_and_nothing_stops(tmp_path: Path) -> None:
    program = tmp_path / "dance.improv"
    program.write_text(RIGHT, encoding="utf-8")
    with Client(QUIET) as client:
        uri = program.as_uri()
        client.open(uri, RIGHT)
        client.command("play")
        client.wait_for_line("▶")
        keeps = "; the previous dance keeps playing"
        for arguments, expected in (
            ([uri, span(5, 0, 0)], keeps),
            ([uri, 1], keeps),
            ([uri, "square"], keeps),
            (["file:///gone.improv", span(0, 0, 0)], "improv.play: expected the URI of an open program"),
        ):
            client.command("play", *arguments)
            assert client.wait("window/showMessage")["message"].endswith(expected)
        wrong: list[list[object]] = [
            [uri, {"start": 3}],
            [uri, 0],
            [uri, [1]],
            [{}],
            [uri, span(-1, 0, 0)],
            [uri, "x", "y"],
        ]
        for each in wrong:
            client.command("play", *each)
            client.wait_for_line("improv.play: expected a program, then nothing, a range, a name, or a line counted")
        client.command("only", uri)
        client.wait_for_line("improv.only: expected a program, then a range, a name, or a line counted from 1")
        program.unlink()  # the editor still has it
        client.command("play", uri, span(3, 0, 0))
        client.wait_for_line("▶ line 4: bert")
        (tmp_path / "improv.toml").write_text("[robots.carl]\n")
        client.command("play", uri, span(3, 0, 0))
        client.wait_for_line("✗ line 4: `bert` is not in improv.toml")


def test_a_robot_takes_a_step_from_its_section() -> None:
    uri = "file:///nowhere/improv.toml"
    robots = '[robots.anna]\nprofile = "turtlebot3_burger"\n'
    with Client(QUIET, TOLD) as client:
        client.open(uri, robots, "toml")
        step, stop = offered(client, uri, 0, 10)
        assert (step["title"], stop["title"]) == ("Try forward with anna", "Stop all robots")
        assert offered(client, uri, 1, 0) == []
        client.request("workspace/executeCommand", step)
        assert client.wait_for_line("▶") == "▶ anna 1 beat, 1.0 s at beat 60, simulator"
        assert client.wait("improv/transport", lambda told: told["state"] == "playing")["uri"] != uri
        client.request("workspace/executeCommand", stop)
        client.change(uri, 2, {"text": robots.replace("burger", "burgr")})
        client.request("workspace/executeCommand", step)
        client.wait_for_line("✗ improv.toml has errors")
        client.command("play", uri, "bert")
        client.wait_for_line("improv.play: expected a robot of this improv.toml")


def offered(client: Client, uri: str, line: int, column: int) -> list[Message]:
    """Return the commands of the actions at a place that play or stop."""
    return [each["command"] for each in client.actions(uri, line, column) if each["kind"].startswith("improv.")]


def test_scenes_play_from_where_robots_are_when_they_begin() -> None:
    uri = "file:///dance.improv"
    with Client(QUIET, TOLD) as client:
        client.open(uri, "r at 0 0\nr $ forward\n--- on\nr $ repeat left\n")
        client.command("play", uri, {"from": "on"})
        client.wait_for_line("▶ scene on: r ∞, endless")
        client.command("play", uri, {"from": "onn"})
        client.wait_for_line("no scene is called `onn`: did you mean `on`?; the previous dance keeps playing")
        client.change(uri, 2, {"text": "r $ repeat up\n---\nr $ repeat up\n"})
        only = next(each for each in offered(client, uri, 2, 0) if each["title"].startswith("Play only scene 2"))
        client.request("workspace/executeCommand", only)
        client.wait_for_line("▶ scene 2: r ∞, endless")
        client.wait_for_line("robots begin at their starts, since scene 1 never ends")

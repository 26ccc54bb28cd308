"""workspace/executeCommand: one function for each `improv.` command."""

from __future__ import annotations

import asyncio
import shutil
import sys
from asyncio.subprocess import DEVNULL, PIPE
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

from improv_core.ide.code_action_play import trial
from improv_core.ide.rehearsal import rehearse, scenes_named
from improv_core.ide.selection import select
from improv_core.plain import printable
from improv_core.protocol.fields import FASTEST, LAST_BEAT, SLOWEST
from improv_core.robots.config import read_robots
from improv_core.text import Span
from improv_ls.documents import Document, RobotsFile, path_of
from improv_ls.handlers.text_document_sync import refresh_robots
from improv_ls.positions import range_of, scenes_of, to_span
from improv_ls.session import Session


def play(ls: Session, *arguments: Any) -> None:
    """Play an open program, or some of it while all other robots keep dancing.

    The first argument is its URI or the end of its path, which is optional if only one program is open. Then come
    nothing, a range, a name, a line or two, counted from 1, or the scenes `from` one `to` another, by name or counted
    from 1: only these play. For an `improv.toml`, the arguments are its URI and a robot, which takes a step.
    """
    _play(ls, "play", arguments)


def only(ls: Session, *arguments: Any) -> None:
    """Play some of an open program, and stop all other robots. The arguments are as for `play`."""
    _play(ls, "only", arguments)


def _play(ls: Session, command: str, arguments: tuple[Any, ...]) -> None:
    refresh_robots(ls)
    if file := ls.robots_files.get(ls.as_opened(_path(arguments))):
        _play_trial(ls, file, arguments[1:])
        return
    document, rest = _program(ls, arguments)
    if not document:
        ls.editor.warn(f"improv.{command}: expected the URI of an open program")
    elif not rest and command == "play":
        ls.editor.soon(ls.performance.play(document, ls.arrival.stops))
    elif len(rest) == 1 and (ends := scenes_of(rest[0])):
        ls.editor.soon(
            ls.performance.play(
                document, ls.arrival.stops, lambda analysis: rehearse(analysis, scenes_named(analysis, *ends))
            )
        )
    elif rest and (wanted := _wanted(ls, document, rest)) is not None:
        choose = partial(select, wanted=wanted)
        ls.editor.soon(ls.performance.play(document, ls.arrival.stops, choose, joins=command == "play"))
    else:
        nothing = "nothing, " if command == "play" else ""
        ls.editor.warn(f"improv.{command}: expected a program, then {nothing}a range, a name, or a line counted from 1")


def before(ls: Session, *arguments: Any) -> None:
    """Play the version of a document that played before; arguments name the document, as for `play`."""
    refresh_robots(ls)
    document, rest = _program(ls, arguments)
    if document and not rest:
        ls.editor.soon(ls.performance.play_before(document, ls.arrival.stops))
    else:
        ls.editor.warn("improv.before: expected the URI of an open program")


async def history(ls: Session, *arguments: Any) -> list[Mapping[str, str]] | str | None:
    """Return the programs that played, the latest first; with an ID of one, its text."""
    kept = await ls.records.history()
    if not arguments:
        if kept.complaint:
            ls.editor.warn(kept.complaint)
        return [
            {"id": each.id, "played": each.when, "name": each.name, "line": printable(kept.news(each))}
            for each in kept.programs
        ]
    found = next((each.text for each in kept.programs if each.id == arguments[0]), None)
    if found is None:
        ls.editor.warn("improv.history: expected no argument, or the id of a program in the history")
    return found


async def page(ls: Session, *arguments: Any) -> str | None:
    """Show the simulator's page. The answer, its URL, waits until there is a page."""
    return await ls.performance.show_page()


def restart(ls: Session, *arguments: Any) -> None:
    """Play the last dance again from beat 0, with the robots at their start poses."""
    ls.editor.soon(ls.performance.restart(ls.arrival.stops))


def stop(ls: Session, *arguments: Any) -> None:
    if not ls.arrival.is_stop:  # otherwise the reader has obeyed it
        ls.stops.stop()


def pause(ls: Session, *arguments: Any) -> None:
    if not ls.arrival.is_stop:
        ls.stops.stop({"type": "pause"})


def resume(ls: Session, *arguments: Any) -> None:
    """Continue after a pause, or from a beat that is offered after a stop that nobody asked for."""
    if not arguments:
        ls.performance.ask({"type": "resume"}, ls.arrival.stops)
    elif arguments[0] in ls.performance.playing.resumes.values():
        ls.performance.ask({"type": "resume", "beat": float(arguments[0])}, ls.arrival.stops)
    else:
        ls.editor.warn("improv.resume: robots can't resume from there now")


def anyway(ls: Session, *arguments: Any) -> None:
    """Begin, or resume, even if robots are not in their places."""
    ls.performance.ask({"type": "resume", "anyway": True}, ls.arrival.stops)


def cue(ls: Session, *arguments: Any) -> None:
    """Give the cue that robots wait for, and say so if none can."""
    played = ls.performance.state.played if ls.performance.state.is_on else None
    if not played or not any("cue" in part.senses for part in played.score.parts.values()):
        ls.editor.warn("improv.cue: no robot waits for the cue")
    ls.performance.ask({"type": "cue"})


def calibrate(ls: Session, *arguments: Any) -> None:
    """Show how to calibrate a robot: that takes a conversation, so it needs a terminal."""
    refresh_robots(ls)
    configs = [document.analysis.config for document in ls.documents.values()]
    listed = next((config for config in configs if config.path and config.robots), None)
    if not listed or not listed.path:
        ls.editor.warn("improv.calibrate: list your robots in improv.toml first, and open a program that they play")
        return
    own = Path(sys.executable).with_name("improv")
    improv = "improv" if shutil.which("improv") or not own.exists() else str(own)
    names = ", ".join(sorted(listed.robots))
    ls.editor.say(f"in a terminal in {listed.path.parent}, run `{improv} calibrate NAME` (one of {names})")


async def transcribe(ls: Session, *arguments: Any) -> str | None:
    """Return the program for the paths that were recorded or drawn in these files.

    The command line writes it, in the folder of the first file: it may take many seconds of a processor.
    """
    if not arguments or not all(isinstance(each, str) and Path(each).is_absolute() for each in arguments):
        ls.editor.warn("improv.transcribe: expected the full paths of recordings or drawings")
        return None
    command = [sys.executable, "-P", "-m", "improv_core", "transcribe", "--", *arguments]
    folder = Path(arguments[0]).parent
    process = await asyncio.create_subprocess_exec(*command, cwd=folder, stdin=DEVNULL, stdout=PIPE, stderr=PIPE)
    program, lines = await process.communicate()
    for line in lines.decode(errors="replace").splitlines():
        (ls.editor.warn if process.returncode else ls.editor.say)(line.removeprefix("improv: "))
    return None if process.returncode else program.decode()


def key(ls: Session, *arguments: Any) -> None:
    """Hold the key of a sense, or release it."""
    ls.performance.keys.toggle(str(arguments[0]) if len(arguments) == 1 else "")


def seek(ls: Session, *arguments: Any) -> None:
    """Continue from the beat in the argument, counted from 0."""
    if len(arguments) == 1 and _is_number(arguments[0]) and 0 <= arguments[0] <= LAST_BEAT:
        ls.performance.ask({"type": "seek", "beat": float(arguments[0])})
    else:
        ls.editor.warn("improv.seek: expected a beat, counted from 0")


def speed(ls: Session, *arguments: Any) -> None:
    """Play faster or slower, by the factor in the argument."""
    if len(arguments) == 1 and _is_number(arguments[0]) and SLOWEST <= arguments[0] <= FASTEST:
        ls.performance.ask({"type": "speed", "factor": float(arguments[0])})
    else:
        ls.editor.warn(f"improv.speed: expected a number from {SLOWEST:g} to {FASTEST:g}")


def mute(ls: Session, *arguments: Any) -> None:
    """Mute a robot, so that it stands still while the others play, or unmute it."""
    _silence(ls, "mute", arguments)


def solo(ls: Session, *arguments: Any) -> None:
    """Solo a robot, so that all that are not soloed stand still, or undo that."""
    _silence(ls, "solo", arguments)


def on_save(ls: Session, *arguments: Any) -> None:
    """Have saves continue the dance, or start it over, in an editor whose settings don't say that."""
    if set_there := ls.editor.settings.on_save:
        ls.editor.warn(f"improv.onSave: the editor's settings say {set_there}: change them there")
    elif arguments in (("continue",), ("restart",)):
        ls.performance.offers.set_on_save(arguments[0])
    else:
        ls.editor.warn("improv.onSave: expected continue or restart")


def _path(arguments: Sequence[Any]) -> str:
    """Return the first argument, if it is text: the URI of a file, or the end of its path."""
    return arguments[0] if arguments and isinstance(arguments[0], str) else ""


def _program(ls: Session, arguments: Sequence[Any]) -> tuple[Document | None, Sequence[Any]]:
    """Return the program to play, and the arguments that select a part of it."""
    path = _path(arguments)
    folders = (part for part in PurePosixPath(path).parts if part not in ("~", "..", "/"))  # as Helix shortens it
    end = "/".join(folders)
    ending = [document for uri, document in ls.documents.items() if unquote(uri).endswith(f"/{end}")]
    named = ls.documents.get(ls.as_opened(path)) or (ending[0] if len(ending) == 1 and path else None)
    if named or (path and not path.isidentifier()):
        return named, arguments[1:]
    return next(iter(ls.documents.values())) if len(ls.documents) == 1 else None, arguments


def _wanted(ls: Session, document: Document, rest: Sequence[Any]) -> Span | str | None:
    """Return the part of a program to play; None if no argument selects one."""
    lines, last = document.lines, rest[-1]
    if all(type(each) is int and each > 0 for each in rest) and len(rest) <= 2:
        first = lines.start(min(rest) - 1)
        return Span(first, lines.end(max(rest) - 1) if rest[0] != last else first)
    if len(rest) == 1 and isinstance(last, str) and last:
        return last
    place = range_of(last) if len(rest) == 1 else None
    return to_span(lines, place, ls.editor.encoding) if place else None


def _play_trial(ls: Session, file: RobotsFile, rest: Sequence[Any]) -> None:
    """Have a robot of an `improv.toml` take a step."""
    if len(rest) == 1 and isinstance(rest[0], str) and rest[0] in read_robots(file.lines.text).robots:
        analysis = trial(file.lines.text, path_of(file.uri), rest[0])
        # A URI of its own, and no place in the history: the text of the file doesn't contain what plays.
        ls.editor.soon(
            ls.performance.play(Document(f"{file.uri}#{rest[0]}", None, analysis), ls.arrival.stops, keep=False)
        )
    else:
        ls.editor.warn("improv.play: expected a robot of this improv.toml")


def _silence(ls: Session, command: str, arguments: tuple[Any, ...]) -> None:
    if not (len(arguments) == 1 and isinstance(arguments[0], str) and arguments[0]):
        ls.editor.warn(f"improv.{command}: expected a robot's name")
    elif arguments[0] not in ls.performance.robots.union(*(each.analysis.robots for each in ls.documents.values())):
        # Soloing an unknown robot would make all others stand still.
        ls.editor.warn(f"improv.{command}: no robot is named `{arguments[0]}`")
    else:
        ls.performance.toggle(command, arguments[0])


def _is_number(value: object) -> bool:
    return type(value) in (int, float)

"""workspace/executeCommand: one function for each `improv.` command."""

from __future__ import annotations

from typing import Any

from improv_core.stage.protocol import FASTEST, LAST_BEAT, SLOWEST
from improv_ls.handlers.workspace_files import refresh_robots
from improv_ls.session import Session


def play(ls: Session, *arguments: Any) -> None:
    """Play the document whose URI is the first argument, or else the only open one."""
    refresh_robots(ls)
    uris = list(arguments[:1]) or list(ls.documents)
    document = ls.documents.get(str(uris[0])) if len(uris) == 1 else None
    if document:
        ls.editor.soon(ls.performance.play(document, ls.arrival.stops))
    else:
        ls.editor.warn("improv.play: expected the URI of an open program")


async def page(ls: Session, *arguments: Any) -> str | None:
    """Show the simulator's page. The answer, its URL, waits until there is a page."""
    return await ls.performance.show_page()


def restart(ls: Session, *arguments: Any) -> None:
    """Play the last dance again from beat 0, with the robots at their start poses."""
    ls.editor.soon(ls.performance.restart(ls.arrival.stops))


def hush(ls: Session, *arguments: Any) -> None:
    if not ls.arrival.is_stop:  # otherwise it has been obeyed as it arrived
        ls.stops.stop()


def pause(ls: Session, *arguments: Any) -> None:
    if not ls.arrival.is_stop:
        ls.stops.stop({"type": "pause"})


def resume(ls: Session, *arguments: Any) -> None:
    ls.performance.resume(ls.arrival.stops)


def cue(ls: Session, *arguments: Any) -> None:
    """Give the cue that robots wait for."""
    ls.performance.conduct({"type": "cue"})


def key(ls: Session, *arguments: Any) -> None:
    """Hold the key of a sense, or release it."""
    ls.performance.toggle_key(str(arguments[0]) if len(arguments) == 1 else "")


def seek(ls: Session, *arguments: Any) -> None:
    """Continue from the beat that is the argument, counted from 0."""
    if len(arguments) == 1 and _is_beat(arguments[0]):
        ls.performance.conduct({"type": "seek", "beat": float(arguments[0])})
    else:
        ls.editor.warn("improv.seek: expected a beat, counted from 0")


def speed(ls: Session, *arguments: Any) -> None:
    """Play faster or slower by the factor that is the argument."""
    if len(arguments) == 1 and _is_number(arguments[0]) and SLOWEST <= arguments[0] <= FASTEST:
        ls.performance.conduct({"type": "speed", "factor": float(arguments[0])})
    else:
        ls.editor.warn(f"improv.speed: expected a number from {SLOWEST:g} to {FASTEST:g}")


def mute(ls: Session, *arguments: Any) -> None:
    """Mute a robot, so that it stands still while the others play, or unmute it."""
    _silence(ls, "mute", arguments)


def solo(ls: Session, *arguments: Any) -> None:
    """Solo a robot, so that all that are not soloed stand still, or undo that."""
    _silence(ls, "solo", arguments)


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


def _is_beat(value: Any) -> bool:
    return _is_number(value) and 0 <= value <= LAST_BEAT

"""Saving plays; the commands conduct."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lsprotocol import types

from improv_core.diagnostics import Severity
from improv_core.stage.protocol import FASTEST, LAST_BEAT, SLOWEST, When
from improv_ls.documents import Document
from improv_ls.handlers.documents import refresh_robots
from improv_ls.session import Session


def will_save(ls: Session, params: types.WillSaveTextDocumentParams) -> None:
    """Remember a save that nobody asked for: robots must not move because somebody looked at another window."""
    if params.reason != types.TextDocumentSaveReason.Manual:
        ls.saved_by_themselves.add(params.text_document.uri)
    else:
        ls.saved_by_themselves.discard(params.text_document.uri)  # one before may have failed


def did_save(ls: Session, params: types.DidSaveTextDocumentParams) -> None:
    uri = params.text_document.uri
    if uri in ls.saved_by_themselves:
        ls.saved_by_themselves.remove(uri)
        return
    refresh_robots(ls)
    # What was saved is what plays, whatever is typed from here on.
    document = ls.documents.get(uri)
    if document and ls.settings.on_save != "off":
        ls.soon(_play(ls, document))


def play(ls: Session, *arguments: Any) -> None:
    """Play the document whose URI is the first argument, or the only one that is open."""
    refresh_robots(ls)
    uris = list(arguments[:1]) or list(ls.documents)
    document = ls.documents.get(str(uris[0])) if len(uris) == 1 else None
    if document:
        ls.soon(_play(ls, document))
    else:
        ls.say("improv.play: say which open document to play, by its URI", types.MessageType.Warning)


def restart(ls: Session, *arguments: Any) -> None:
    """Play what plays, or was played last, from beat 0 with robots at their start."""
    ls.soon(ls.performance.restart())


def hush(ls: Session, *arguments: Any) -> None:
    ls.performance.conduct({"type": "hush"})


def pause(ls: Session, *arguments: Any) -> None:
    ls.performance.conduct({"type": "pause"})


def resume(ls: Session, *arguments: Any) -> None:
    ls.performance.conduct({"type": "resume"})


def seek(ls: Session, *arguments: Any) -> None:
    """Go on from the beat that is the argument, counted from 0."""
    if len(arguments) == 1 and _is_beat(arguments[0]):
        ls.performance.conduct({"type": "seek", "beat": float(arguments[0])})
    else:
        ls.say("improv.seek: say a beat, counted from 0", types.MessageType.Warning)


def speed(ls: Session, *arguments: Any) -> None:
    """Play so many times as fast."""
    if len(arguments) == 1 and _is_number(arguments[0]) and SLOWEST <= arguments[0] <= FASTEST:
        ls.performance.conduct({"type": "speed", "factor": float(arguments[0])})
    else:
        ls.say(f"improv.speed: say a number from {SLOWEST:g} to {FASTEST:g}", types.MessageType.Warning)


def mute(ls: Session, *arguments: Any) -> None:
    """Have a robot stand still while the others play; once more, and it plays again."""
    _silence(ls, "mute", arguments)


def solo(ls: Session, *arguments: Any) -> None:
    """Have all robots but this one, and other soloed ones, stand still; once more, and they play again."""
    _silence(ls, "solo", arguments)


def moments(ls: Session, params: Any) -> Mapping[str, Any]:
    """What plays from a beat on: docs/protocol.md."""
    beat = getattr(params, "beat", 0.0)
    return ls.performance.moments(float(beat) if _is_beat(beat) else 0.0)


def _silence(ls: Session, command: str, arguments: tuple[Any, ...]) -> None:
    if not (len(arguments) == 1 and isinstance(arguments[0], str) and arguments[0]):
        ls.say(f"improv.{command}: say a robot's name", types.MessageType.Warning)
    elif arguments[0] not in ls.performance.robots.union(*(each.analysis.robots for each in ls.documents.values())):
        # Soloing a robot that is not there would have all others stand still.
        ls.say(f"improv.{command}: there is no robot `{arguments[0]}`", types.MessageType.Warning)
    else:
        ls.performance.toggle(command, arguments[0])


def _is_number(value: object) -> bool:
    return type(value) in (int, float)


def _is_beat(value: Any) -> bool:
    return _is_number(value) and 0 <= value <= LAST_BEAT


def _goes_on(ls: Session) -> str:
    return "; what plays goes on" if ls.performance.is_on else ""


async def _play(ls: Session, document: Document) -> None:
    if not document.analysis.cast.ok:
        ls.say(f"✗ improv.toml has errors{_goes_on(ls)}", types.MessageType.Warning)
        return
    errors = [each for each in document.analysis.diagnostics if each.severity is Severity.ERROR]
    if errors:
        first = errors[0]
        line = document.lines.position(first.span.start).line + 1
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        ls.say(f"✗ line {line}: {first.message}{more}{_goes_on(ls)}", types.MessageType.Warning)
        return
    when: When = ls.settings.switch_at if ls.settings.on_save == "continue" else "restart"
    await ls.performance.play(document, when)

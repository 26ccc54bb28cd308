"""The words of the language: one table for the lexer, the compiler, completion, hover, and the editors' grammars."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from improv_core.score.movement import SAME, Velocity
from improv_core.score.primitives import PRIMITIVES


class Kind(Enum):
    """The kind of a word. The value is its terminal in the grammar."""

    BEAT = "BEAT"
    PRIMITIVE = "PRIMITIVE"
    PLAIN = "PLAIN"  # a transformer without an argument
    REPEAT = "REPEAT"
    REFLECT = "REFLECT"
    FACTOR = "FACTOR"  # a transformer with a number
    RAMP = "RAMP"
    GUARD = "GUARD"  # a transformer with a condition
    IF = "IF"
    ELSE = "ELSE"
    NOT = "NOT"
    PLANE = "PLANE"


TRANSFORMERS = (Kind.PLAIN, Kind.REPEAT, Kind.REFLECT, Kind.FACTOR, Kind.RAMP, Kind.GUARD)
"""The kinds of words that apply to the one term after them and after their arguments."""


@dataclass(frozen=True, slots=True)
class Word:
    """A built-in word. `velocity` is the velocity of a primitive, or the gain of a reflection across a plane."""

    text: str
    kind: Kind
    usage: str
    about: str
    velocity: Velocity = SAME


def _primitive(text: str, about: str) -> Word:
    return Word(text, Kind.PRIMITIVE, text, about, PRIMITIVES[text])


def _plane(text: str, about: str, gain: Velocity) -> Word:
    return Word(text, Kind.PLANE, f"reflect {text} movement", about, gain)


_SAGITTAL = Velocity(1, -1, 1, -1)
_FRONTAL = Velocity(-1, 1, 1, 1)
_TRANSVERSE = Velocity(1, 1, -1, 1)

WORDS = {
    word.text: word
    for word in (
        Word("beat", Kind.BEAT, "beat 60", "Sets the tempo, in beats per minute."),
        _primitive("forward", "One step forward."),
        _primitive("backward", "One step backward."),
        _primitive("left", "A quarter turn to the left."),
        _primitive("right", "A quarter turn to the right."),
        _primitive("halfleft", "An eighth of a turn to the left."),
        _primitive("halfright", "An eighth of a turn to the right."),
        _primitive("rest", "Stands still for one beat."),
        _primitive("strafeleft", "One step sideways to the left."),
        _primitive("straferight", "One step sideways to the right."),
        _primitive("up", "One step up."),
        _primitive("down", "One step down."),
        Word("reverse", Kind.PLAIN, "reverse movement", "Plays the movements in reverse order."),
        Word("retrograde", Kind.PLAIN, "retrograde movement", "Retraces the path backward."),
        Word("repeat", Kind.REPEAT, "repeat 4 movement", "Repeats this many times; without a number, forever."),
        Word("reflect", Kind.REFLECT, "reflect YZ movement", "Mirrors the movement across a plane: YZ, XZ, or XY."),
        Word("fast", Kind.FACTOR, "fast 2 movement", "Plays the same path this many times as fast."),
        Word("slow", Kind.FACTOR, "slow 2 movement", "Plays the same path, taking this many times as long."),
        Word("scale", Kind.FACTOR, "scale 2 movement", "Makes the path this many times as large, in the same time."),
        Word("fit", Kind.FACTOR, "fit 4 movement", "Plays the same path in exactly this many beats."),
        Word(
            "ramp",
            Kind.RAMP,
            "ramp 1/2 2 movement",
            "Plays the same path faster and faster, or slower and slower.",
        ),
        Word("ease", Kind.PLAIN, "ease movement", "Plays the same path in the same time, but starts and stops gently."),
        Word("accumulate", Kind.PLAIN, "accumulate movement", "Plays the first item, the first two, and so on to all."),
        Word(
            "canon",
            Kind.FACTOR,
            "canon 2 movement",
            "Each robot starts this many beats after the one before it.",
        ),
        Word("choose", Kind.PLAIN, "choose movement", "Plays one of the items; dice decide which."),
        Word("shuffle", Kind.PLAIN, "shuffle movement", "Plays all items in an order that dice decide."),
        Word(
            "chance",
            Kind.FACTOR,
            "chance 1/2 movement",
            "Plays it with this probability, or rests for as long.",
        ),
        Word("seed", Kind.FACTOR, "seed 3 movement", "Gives the movement dice of its own: another number, other dice."),
        Word("until", Kind.GUARD, "until cue movement", "Plays until a sense is true."),
        Word("pause", Kind.GUARD, "pause near movement", "Stands still while a sense is true."),
        Word("if", Kind.IF, "if near movement else movement", "Plays one of two movements; a sense decides which."),
        Word("else", Kind.ELSE, "if near movement else movement", "What plays if the sense is false."),
        Word("not", Kind.NOT, "until not near movement", "Turns a sense around."),
        _plane("YZ", "Swaps left and right.", _SAGITTAL),
        _plane("XZ", "Swaps forward and backward.", _FRONTAL),
        _plane("XY", "Swaps up and down.", _TRANSVERSE),
        _plane("sagittal", "Swaps left and right (YZ).", _SAGITTAL),
        _plane("frontal", "Swaps forward and backward (XZ).", _FRONTAL),
        _plane("transverse", "Swaps up and down (XY).", _TRANSVERSE),
    )
}


def of_kind(*kinds: Kind) -> list[str]:
    """The words of these kinds, in the table's order."""
    return [word.text for word in WORDS.values() if word.kind in kinds]

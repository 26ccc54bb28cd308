"""The words of the language: one table for the lexer, the compiler, all checks, and all features of editors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache

from improv_core.score import algebra, dice, ramps, reactions
from improv_core.score.bounds import swaps_sides
from improv_core.score.movement import Factors, Movement, all_by, exact
from improv_core.score.primitives import PRIMITIVES
from improv_core.syntax.word import (
    Applied,
    Argument,
    Kind,
    Needs,
    Unit,
    Word,
    above_zero,
    at_least_zero,
    probability,
    whole,
)

TRANSFORMERS = (Kind.PLAIN, Kind.REPEAT, Kind.REFLECT, Kind.FACTOR, Kind.RAMP, Kind.GUARD)
"""Kinds of words that apply to the one term after them and after their arguments."""


_all_by = lru_cache(maxsize=1_000, typed=True)(all_by)  # the lines of a program scale by few numbers, and share them


def _primitive(text: str, about: str) -> Word:
    return Word(text, Kind.PRIMITIVE, about, velocity=PRIMITIVES[text])


def _plane(text: str, about: str, gain: Factors) -> Word:
    return Word(text, Kind.PLANE, about, shown=f"reflect {text} movement", gain=gain, poses=swaps_sides(gain))


def _paced(text: str, about: str, rate: Callable[[Fraction], Fraction]) -> Word:
    def make(it: Applied) -> Movement:
        return algebra.pace(it.body, rate(it.number))

    return Word(
        text,
        Kind.FACTOR,
        about,
        (_FACTOR,),
        make=make,
        rate=rate,
        needless=_by_one,
    )


def _inverse(number: Fraction) -> Fraction:
    return Fraction(number.denominator, number.numerator)  # `1 / number` takes twice as long


def _guard(text: str, about: str, example: str, make: Callable[[Movement, reactions.Condition], Movement]) -> Word:
    return Word(text, Kind.GUARD, about, (Argument("sense", example),), make=_reacting(make))


def _reacting(make: Callable[..., Movement]) -> Callable[[Applied], Movement]:
    def reacting(it: Applied) -> Movement:
        bodies = (it.body,) if it.otherwise is None else (it.body, it.otherwise)
        return make(*bodies, it.condition, it.span)

    return reacting


def _canon(it: Applied) -> Movement:
    if it.robots == 1:
        return it.body
    waits = (it.number * it.robot, it.number * (it.robots - 1 - it.robot))
    before, after = (algebra.stand(exact(beats)) for beats in waits)
    return algebra.series([before, it.body, after])


def _by_one(it: Applied) -> str | None:
    if it.number != 1 or not it.is_plain:  # 8/8 in a row of eighths is no error
        return None
    return "`{written}` changes nothing: remove it or use another number"


def _one_item(it: Applied) -> str | None:
    if len(it.items) != 1:
        return None
    return "there is one item to {written} here: write several in brackets or remove `{written}`"


def _without_dice(it: Applied) -> str | None:
    return None if it.body.dice else "nothing in it throws dice, so `seed` changes nothing: remove `{written}`"


def _alone(it: Applied) -> str | None:
    return "`canon` needs several robots before `$`: add one or remove `{written}`" if it.robots == 1 else None


def _never_moves(it: Applied) -> str | None:
    return None if any(it.numbers) else "write a number above 0 after `ramp`: with two zeros it never moves"


_FACTOR = Argument("k", "2", above_zero)
_PLANES = ("YZ", "XZ", "XY")
_SAGITTAL = Factors(y=-1, yaw=-1)
_FRONTAL = Factors(x=-1)
_TRANSVERSE = Factors(z=-1)

WORDS: Mapping[str, Word] = {
    word.text: word
    for word in (
        Word(
            "beat",
            Kind.BEAT,
            "Sets the tempo, in beats per minute.",
            (Argument("n", "60", above_zero, ("60", "30", "120"), "beats per minute"),),
        ),
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
        Word(
            "reverse",
            Kind.PLAIN,
            "Plays the movements in reverse order.",
            make=lambda it: algebra.reverse(it.body),
            needs=Needs.END,
            backward=True,
            poses=False,
        ),
        Word(
            "retrograde",
            Kind.PLAIN,
            "Retraces the path backward.",
            make=lambda it: algebra.gain(algebra.reverse(it.body), all_by(-1)),
            needs=Needs.END,
            backward=True,
            poses=False,
        ),
        Word(
            "repeat",
            Kind.REPEAT,
            "Repeats this many times; without a number, forever.",
            (Argument("n", "4", whole, ("2", "3", "4", "8"), "times"),),
            make=lambda it: algebra.repeat(it.body, *map(int, it.numbers)),
        ),
        Word(
            "reflect",
            Kind.REFLECT,
            "Mirrors the movement across a plane: YZ, XZ, or XY.",
            (Argument("PLANE", "YZ", choices=_PLANES),),
            make=lambda it: algebra.gain(it.body, it.plane),
        ),
        _paced("fast", "Plays the same path this many times as fast.", lambda k: k),
        _paced("slow", "Plays the same path, taking this many times as long.", _inverse),
        Word(
            "scale",
            Kind.FACTOR,
            "Makes the path this many times as large, in the same time.",
            (_FACTOR,),
            make=lambda it: algebra.gain(it.body, _all_by(it.number)),
            poses=False,
            needless=_by_one,
        ),
        Word(
            "fit",
            Kind.FACTOR,
            "Plays the same path in exactly this many beats.",
            (Argument("beats", "4", above_zero, ("4", "8", "16"), "beats"),),
            make=lambda it: algebra.fit(it.body, exact(it.number)),
            needs=Needs.END,
            spreads=True,
        ),
        Word(
            "ramp",
            Kind.RAMP,
            "Plays the same path faster and faster, or slower and slower, in 2/(a+b) of its time.",
            (Argument("a", "1/2", at_least_zero), Argument("b", "2", at_least_zero)),
            make=lambda it: ramps.ramp(it.body, *it.numbers),
            needs=Needs.END,
            spreads=True,
            wrong=_never_moves,
        ),
        Word(
            "ease",
            Kind.PLAIN,
            "Plays the same path in the same time, but starts and stops gently.",
            make=lambda it: ramps.ease(it.body),
            needs=Needs.END,
            spreads=True,
        ),
        Word(
            "accumulate",
            Kind.PLAIN,
            "Plays the first item, the first two, and so on to all.",
            make=lambda it: algebra.accumulate(it.items),
            of_items=True,
            needless=_one_item,
            removable=False,
        ),
        Word(
            "canon",
            Kind.FACTOR,
            "Each robot starts this many beats after the one before it.",
            (Argument("beats", "2", at_least_zero, ("1", "2", "4"), "beats"),),
            make=_canon,
            by_robot=True,
            needless=_alone,
        ),
        Word(
            "choose",
            Kind.PLAIN,
            "Plays one of the items; dice decide which.",
            make=lambda it: dice.choose(it.items),
            needs=Needs.FIXED,
            of_items=True,
            is_even=True,
            throws=True,
            needless=_one_item,
            removable=False,
        ),
        Word(
            "shuffle",
            Kind.PLAIN,
            "Plays all items in an order that dice decide.",
            make=lambda it: dice.shuffle(it.items),
            of_items=True,
            throws=True,
            needless=_one_item,
            removable=False,
        ),
        Word(
            "chance",
            Kind.FACTOR,
            "Plays it with this probability, or rests for as long.",
            (Argument("p", "1/2", probability, ("1/2", "1/3", "2/3"), "probability"),),
            make=lambda it: dice.chance(it.body, it.number, it.span),
            needs=Needs.FIXED,
            throws=True,
        ),
        Word(
            "seed",
            Kind.FACTOR,
            "Gives the movement dice of its own: another number, other dice.",
            (Argument("n", "3", above_zero, ("1", "2", "3")),),
            make=lambda it: dice.seed(it.body, it.number),
            throws=True,
            needless=_without_dice,
            removable=False,
        ),
        _guard("until", "Plays until a sense is true.", "cue", reactions.until),
        _guard("pause", "Stands still while a sense is true.", "near", reactions.pause),
        Word(
            "if",
            Kind.IF,
            "Plays one of two movements; a sense decides which.",
            (Argument("sense", "near"),),
            make=_reacting(reactions.if_else),
        ),
        Word(
            "else",
            Kind.ELSE,
            "Plays the movement after it if the sense is false.",
            shown="if near movement else movement",
        ),
        Word("not", Kind.NOT, "Turns a sense around.", shown="until not near movement"),
        _plane("YZ", "Swaps left and right.", _SAGITTAL),
        _plane("XZ", "Swaps forward and backward.", _FRONTAL),
        _plane("XY", "Swaps up and down.", _TRANSVERSE),
        _plane("sagittal", "Swaps left and right (YZ).", _SAGITTAL),
        _plane("frontal", "Swaps forward and backward (XZ).", _FRONTAL),
        _plane("transverse", "Swaps up and down (XY).", _TRANSVERSE),
    )
}


UNITS: Mapping[str, Unit] = {
    "m": Unit("meters", Fraction(1), "meters"),
    "cm": Unit("meters", Fraction(1, 100), "centimeters"),
    "mm": Unit("meters", Fraction(1, 1000), "millimeters"),
    "deg": Unit("degrees", Fraction(1), "degrees"),
    "°": Unit("degrees", Fraction(1), "degrees"),
}
"""The units of measures. They are units only directly behind a number, where a measure may stand."""
RADIUS = "radius"
"""The word before the radius of a circle. It is a word only behind a primitive and its measure."""


def of_kind(*kinds: Kind) -> list[str]:
    """Return the words of these kinds, in the table's order."""
    return [word.text for word in WORDS.values() if word.kind in kinds]

"""`improv place`: drives real robots to the start poses of a program."""

from __future__ import annotations

import asyncio
import math
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.answers import TypedAnswers
from improv_core.commands.exit_codes import FAILED, INTERRUPTED, PROBLEMS, CommandError
from improv_core.commands.parameters import LiveOptions
from improv_core.commands.programs import read_to_play
from improv_core.commands.settings import PlaySettings
from improv_core.commands.terminal import TerminalSession, first, performance, run
from improv_core.program.compiler import score_of
from improv_core.protocol.limits import MEASURED_AT_REST
from improv_core.routines.place_plan import Plan, Traveler, next_paths, too_near
from improv_core.routines.place_score import LEG, driving, looking, undrivable
from improv_core.safety.interlocks import pose_of
from improv_core.safety.stopping_distance import slow_coasting
from improv_core.score.motion import Pose
from improv_core.score.score import Score
from improv_core.session.start import Options
from improv_core.session.state import PlayScore

TRIES = 5
"""Attempts of a robot to get to its place, besides the drives that a long distance needs."""
PATIENCE, LOOK_PERIOD = 5.0, 0.25
"""Seconds for which robots stand before the command gives up, and between two checks of that."""
NAMED = 3
"""Robots that a line names at most."""


@click.command("place")
@parameters.file
@parameters.live
@click.option("--from", "scene", metavar="NAME", help="Where robots are when the scene of this name begins.")
@click.option("--yes", is_flag=True, help="Do not ask whether the floor is clear.")
def command(file: Path, live: LiveOptions, scene: str | None, yes: bool) -> None:
    """Drive real robots slowly to where a program has them. Ctrl-C stops them.

    It is known where they are from poses in the world: `odom_frame = "world"` in improv.toml.
    """
    if live.backend == "sim":
        raise CommandError("simulated robots begin in their places: there is nothing to drive")
    if not (analysis := read_to_play(file)):
        sys.exit(PROBLEMS)
    score = score_of(PlaySettings(first=scene).chosen(analysis).analysis)
    check(score)
    sys.exit(run(_place(score, file, live.options(file), browser=live.browser, yes=yes)))


def check(score: Score) -> None:
    """Raise CommandError if the robots of a score can't be driven to their places."""
    for robot, part in score.parts.items():
        if why := undrivable(part):
            raise CommandError(f"{robot} can't be driven to its place: {why}")
    places = {robot: Traveler(part.start, part.start, part.profile.radius) for robot, part in score.parts.items()}
    for one, other, gap in too_near(places, score.world.keep_apart)[:1]:
        line = f"the places of {one} and {other} are {gap:.2f} m apart, edge to edge"
        raise CommandError(f"{line}: start them farther apart, or make `keep_apart` smaller")


async def _place(score: Score, path: Path, options: Options, *, browser: bool, yes: bool) -> int:
    """Drive all robots and return the exit code. Raises StageError and CommandError."""
    named, hosts = path.name, score.hosts
    async with performance(options, browser=browser, hears_keys=False, begins_with=named, hosts=hosts) as performing:
        if not performing.playback.state.is_real:
            raise CommandError("no real robots can be reached: simulated ones begin in their places")
        performing.present(path)
        placing = asyncio.ensure_future(_Placing(performing, score, path.name).drive(yes=yes))
        await first(placing, performing.interrupted.wait())
        return INTERRUPTED if placing.cancelled() else placing.result()


class _Placing:
    """The drives of robots to their places, one after the other, until they are there."""

    def __init__(self, performing: TerminalSession, score: Score, name: str) -> None:
        self._performing = performing
        self._score = score
        self._name = name
        self._say = performing.screen.say

    async def drive(self, *, yes: bool) -> int:
        if (code := await self._play(looking(self._score))) is not None:
            return code
        travelers = self._travelers()
        if lines := [*distances(travelers)]:
            for line in lines:
                self._say(line)
            asked = "They drive there now. Is the floor clear, and a stop at hand? [y/N]"
            if not yes and (await TypedAnswers(self._say).to(asked)).lower() not in ("y", "yes"):
                self._say("no robot was moved")
                return PROBLEMS
            if not yes and (code := await self._play(looking(self._score))) is not None:  # they may have been moved
                return code
            if (code := await self._drive_all()) is not None:
                return code
        return self._conclude()

    async def _drive_all(self) -> int | None:
        """Drive until all robots are in their places or can't get there. Return the exit code if a stop ended that."""
        left = {robot: TRIES + math.ceil(2 * each.off[0] / LEG) for robot, each in self._travelers().items()}
        while (plan := self._plan(left)).paths:
            self._say(f"{_names(plan.paths)} {'drives' if len(plan.paths) == 1 else 'drive'}")
            poses = {robot: each.pose for robot, each in self._travelers().items()}
            if (code := await self._play(driving(self._score, poses, plan.paths))) is not None:
                return code
            left = {robot: count - (robot in plan.paths) for robot, count in left.items()}
        for robot, thing in plan.blocked.items():
            self._say(f"{robot} can't get to its place, because {thing} is in its way: move one of them by hand")
        return None

    def _plan(self, left: Mapping[str, int]) -> Plan:
        """Plan the next drives. A robot that has tried too often stays at its pose."""
        travelers = {
            robot: each if left[robot] > 0 else replace(each, place=each.pose)
            for robot, each in self._travelers().items()
        }
        return next_paths(travelers, self._score.world)

    def _travelers(self) -> Mapping[str, Traveler]:
        """Return the poses and the places of all robots. Raises CommandError if the poses are not in one frame."""
        measured = {robot: self._performing.results.measured[robot][1] for robot in self._score.parts}
        frames = {each["frame"]: robot for robot, each in measured.items()}
        if len(frames) > 1:
            (frame, robot), (another, other) = [*frames.items()][:2]
            raise CommandError(f"{robot} is measured in the frame {frame!r} and {other} in {another!r}: use one frame")
        return {
            robot: Traveler(
                Pose(**measured[robot]["pose"]), part.start, part.profile.radius, slow_coasting(part.profile)
            )
            for robot, part in self._score.parts.items()
        }

    async def _play(self, score: Score) -> int | None:
        """Play a score to its end, and until all robots have come to rest. Return the exit code if it was stopped
        before."""
        performing = self._performing
        performing.finished.clear()
        if not await performing.playback.play(PlayScore(score, self._name, 0, anyway=True)):
            return INTERRUPTED
        await first(performing.finished.wait(), self._lose_patience())
        if performing.stops.count:
            return INTERRUPTED
        if not performing.finished.is_set() or performing.broken.is_set() or performing.results.state != "ended":
            return FAILED
        await asyncio.sleep(MEASURED_AT_REST)
        if unseen := self._score.parts.keys() - performing.results.measured.keys():
            raise CommandError(f"no pose of {_names(sorted(unseen))} came: start the node that publishes them")
        return None

    async def _lose_patience(self) -> None:
        """Wait until robots have stood for too long: no pose of them comes, or they are too near to each other and
        there is no page on which somebody could resume."""
        performing, waited = self._performing, 0.0
        unseen = {*map(pose_of, self._score.parts)}
        ends = unseen if performing.has_page else unseen | self._score.parts.keys()
        while waited < PATIENCE:
            await asyncio.sleep(LOOK_PERIOD)
            waits = ends & {*performing.playback.state.waits_for}
            waited = waited + LOOK_PERIOD if waits else 0.0
        blind = f"no pose came for {PATIENCE:g} s: start the node that publishes them"
        why = blind if waits & unseen else "make room by hand"
        performing.screen.complain(f"improv: {why}, then place robots again")

    def _conclude(self) -> int:
        """Print the result and return the exit code."""
        travelers = self._travelers()
        if away := {robot: each for robot, each in travelers.items() if not each.is_as_promised}:
            for line in distances(away):
                self._say(line)
            self._say(f"not in place: {_names(away)}")
            return PROBLEMS
        far, turned = (max(each.off[which] for each in travelers.values()) for which in (0, 1))
        self._say(f"all robots are in their places, within {far:.2f} m and {math.degrees(turned):.1f}°")
        return 0


def distances(travelers: Mapping[str, Traveler]) -> Iterator[str]:
    """Yield lines about the distances of robots from their places, for people; none about robots that are there."""
    for robot, each in travelers.items():
        if not each.is_there:
            far, turned = each.off
            yield f"{robot} is {far:.2f} m and {math.degrees(turned):.0f}° from its place"


def _names(robots: Mapping[str, object] | list[str]) -> str:
    named = [*robots]
    more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
    return f"{', '.join(named[:NAMED])}{more}"

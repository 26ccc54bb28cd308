"""`improv calibrate`: plays two dances again and again, and offers the measured values as an edit of improv.toml."""

from __future__ import annotations

import asyncio
import contextlib
import difflib
import math
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.answers import TypedAnswers
from improv_core.commands.exit_codes import INTERRUPTED, PROBLEMS, CommandError
from improv_core.commands.parameters import LiveOptions
from improv_core.commands.terminal import TerminalSession, first, performance, run
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.program.files import robots_near
from improv_core.robots.config import FILE_NAME, Robots
from improv_core.robots.edits import calibrate as edited
from improv_core.robots.schema import known
from improv_core.routines.calibration import (
    MAX_ROUNDS,
    MIN_ROUNDS,
    QUARTERS,
    Goal,
    MeasuredSettings,
    Round,
    Straight,
    are_whole,
    calibrate,
    doubtful_distance,
    doubtful_turn,
    errors,
    goal_in,
    room_for,
    settings_of,
    straight_by_poses,
    straight_by_tape,
    straight_dance,
    turn_by_poses,
    turning_dance,
    with_settings,
)
from improv_core.safety.odometry import CONTINUOUS
from improv_core.score.motion import Pose
from improv_core.score.profiles import Profile
from improv_core.score.score import Score
from improv_core.session.start import Options
from improv_core.storage.atomic_write import why
from improv_core.storage.compare_and_swap import swap_text

USUAL_ROOM = 2.0
"""Meters straight ahead: errors of a percent are easy to measure there, and many floors have them."""
MAX_ROOM = 100.0


@click.command("calibrate")
@click.argument("robot")
@parameters.live
@click.option("--tempo", type=click.IntRange(1, 1000), default=60, show_default=True, help="Play at this tempo.")
@click.option("--tape", is_flag=True, help="Ask you to measure with a tape, even if the robot's pose can be read.")
@click.option("--write", is_flag=True, help="Write the result into improv.toml without asking.")
def command(robot: str, live: LiveOptions, tempo: int, tape: bool, write: bool) -> None:
    """Measure how far a robot really drives and turns, and correct its profile. Ctrl-C stops the robot."""
    options, robots = live.options(Path(FILE_NAME)), _robots_with(robot)
    sys.exit(run(_calibrate(robots, robot, options, browser=live.browser, tempo=tempo, tape=tape, write=write)))


def _robots_with(robot: str) -> Robots:
    """Read the nearest improv.toml, which must list this robot. Raises ReadError and CommandError."""
    robots = robots_near(Path.cwd())
    if not robots.path:
        raise CommandError(f"there is no {FILE_NAME} here: write one with a section [robots.{robot}]")
    if not robots.ok:
        raise CommandError(f"{robots.path} has errors: fix them first (`improv check` shows them in a program)")
    if robot not in robots.robots:
        raise CommandError(f"{robots.path} lists no robot `{robot}`: add a section [robots.{robot}] with its profile")
    if not {"forward", "turn"} <= {*robots.robots[robot].profile.motions}:
        raise CommandError(f"{robot} can't be calibrated: its profile lacks the motions `forward` or `turn`")
    return robots


async def _calibrate(
    robots: Robots, robot: str, options: Options, *, browser: bool, tempo: int, tape: bool, write: bool
) -> int:
    """Hold the whole conversation and return the exit code. Raises StageError and CommandError."""
    hosts = score_of(analyze(f"{robot} $ forward\n", robots)).hosts
    async with performance(options, browser=browser, hears_keys=False, hosts=hosts) as performing:
        talk = _Conversation(performing, robots, robot, tempo, tape=tape)
        holding = asyncio.ensure_future(talk.hold(write=write))
        await first(holding, performing.interrupted.wait())
        if not holding.cancelled():
            return holding.result()
        performing.screen.complain(f"improv: interrupted: {FILE_NAME} was not changed")
        return INTERRUPTED


class _Conversation:
    """Questions and dances until the settings of a robot are known."""

    def __init__(self, performing: TerminalSession, robots: Robots, robot: str, tempo: int, *, tape: bool) -> None:
        self._performing = performing
        self._answers = TypedAnswers(performing.screen.say)
        # Following would hide the errors to measure, and the robot's place in the world makes no difference.
        alone = replace(robots.robots[robot], follow=False, odom_frame="own")
        self._robots = replace(robots, robots={**robots.robots, robot: alone})
        self._robot = robot
        self._counts_wheels = robots.robots[robot].odom_frame == "own"  # unless a person says otherwise
        self._tempo = tempo
        self._asks = tape or (performing.playback.state.is_real and not robots.robots[robot].odom)

    @property
    def _profile(self) -> Profile:
        return self._robots.robots[self._robot].profile

    async def hold(self, *, write: bool) -> int:
        before = self._profile
        goal = await self._goal()
        now = settings_of(before)
        rounds: list[Round] = []
        while len(rounds) < MAX_ROUNDS:
            self._say(f"round {len(rounds) + 1}")
            rounds.append(await self._round(goal))
            found = calibrate(now, goal, rounds, before.wheel_separation)
            if len(rounds) >= MIN_ROUNDS and found.is_known:
                break
        values, error = _written(found.settings), _written(found.error)
        check(values)
        vary = "" if found.is_known else ", but they still vary"
        named = ", ".join(f"{name} {value:.10g} ± {error[name]:.1g}" for name, value in values.items())
        self._say(f"the values after {len(rounds)} rounds{vary}: {named}")
        self._say(f"{self._robot} now plays again, with these values")
        robot = replace(self._robots.robots[self._robot], profile=with_settings(before, found.settings))
        self._robots = replace(self._robots, robots={**self._robots.robots, self._robot: robot})
        after = await self._round(goal)
        self._say(f"before: {errors(goal, rounds)}")
        self._say(f"after:  {errors(goal, [after])}")
        return await offer(self._robots, self._robot, values, self._answers, write=write)

    async def _goal(self) -> Goal:
        """Print the length of a step and the angle of a quarter turn, and ask for room."""
        self._say(f"{self._robot} will drive straight ahead and turn on the spot. Ctrl-C stops it.")
        profile, step = self._profile, room_for(self._profile)
        turn = math.degrees(profile.quarter_turn)
        self._say(f"In {FILE_NAME}, a step is {profile.step:g} m, and a quarter turn {turn:g}°.")
        ahead = f"How many meters of free floor are ahead of {self._robot}, at least a step of {step:g} m?"
        room = await self._number(ahead, (step, max(step, MAX_ROOM)), max(step, USUAL_ROOM))
        return goal_in(room, profile)

    async def _round(self, goal: Goal) -> Round:
        return Round(await self._straight(goal), await self._turn(goal))

    async def _straight(self, goal: Goal) -> Straight:
        told = goal.steps * settings_of(self._profile).commanded_step
        what = f"{self._robot} drives {told:.2f} m straight ahead"
        while True:
            moved = await self._dance(straight_dance(self._robot, self._profile, goal, self._tempo), what)
            if moved:
                straight = straight_by_poses(*moved)
            else:
                ahead = await self._number("How many meters is it ahead of its mark?")
                aside = await self._number("How many meters is it to the left of its line? Negative: to the right.")
                straight = straight_by_tape(ahead, aside)
            if not (why := doubtful_distance(straight, told)):
                return straight
            self._doubt(why)

    async def _turn(self, goal: Goal) -> float:
        while True:
            moved = await self._dance(
                turning_dance(self._robot, self._profile, self._tempo), f"{self._robot} turns left on the spot, twice"
            )
            if moved:
                turn = turn_by_poses(*moved, goal)
            else:
                beyond = await self._number("How many degrees beyond two full turns is it? Negative: short of them.")
                turn = 2 * math.tau + math.radians(beyond)
            told = QUARTERS * settings_of(self._profile).commanded_quarter_turn
            if not (why := doubtful_turn(turn, told)):
                return turn
            self._doubt(why)

    def _doubt(self, why: str) -> None:
        topic = self._robots.robots[self._robot].topic
        self._say(f"{why}: check the numbers, and that {self._robot} listens on {topic}; then play it again")

    async def _dance(self, program: str, what: str) -> tuple[Pose, Pose] | None:
        """Play a program once somebody has pressed Enter. Raises CommandError and StageError.

        Return the robot's poses before and after, or None if people have to measure.
        """
        performing = self._performing
        while True:
            mark = f"Put {self._robot} on its mark, along its line, and press" if self._asks else "Press"
            await self._answers.to(f"{mark} Enter: {what}.")
            asked, analysis = performing.stops.count, analyze(program, self._robots)
            began = await performing.play(analysis, Path(f"calibration of {self._robot}"), asked)
            await performing.finished.wait()
            try:
                if not (began and performing.results.state == "ended"):
                    raise _NothingMeasuredError("the dance was stopped, so nothing was measured: start again")
                return None if self._asks else self._moved(score_of(analysis))
            except _NothingMeasuredError as problem:
                self._say(str(problem))

    def _moved(self, score: Score) -> tuple[Pose, Pose]:
        """Return the robot's poses before and after a dance, as measured from outside. Raises _NothingMeasuredError."""
        if simulated := self._performing.results.simulated_move(self._robot):
            return simulated
        poses = f"the poses of {self._robot} on {self._robots.robots[self._robot].odom}"
        if self._robot not in self._performing.results.measured:
            raise _NothingMeasuredError(f"{poses} didn't arrive: check their publisher, or use `--tape`")
        first, last = self._performing.results.measured[self._robot]
        if first["source"] == CONTINUOUS and self._counts_wheels:
            self._asks = True
            raise _NothingMeasuredError(
                f"{poses} are {CONTINUOUS}: a base's own odometry counts how far its wheels turn, and is blind to their"
                " size, so measure with a tape"
            )
        if not are_whole(first, last, score.seconds(score.beats)):
            raise _NothingMeasuredError(f"{poses} were interrupted, so nothing was measured: check their publisher")
        return score.parts[self._robot].start, Pose(**last["pose"])

    async def _number(
        self, question: str, limits: tuple[float, float] = (-math.inf, math.inf), usual: float | None = None
    ) -> float:
        """Ask for a finite number within limits; Enter alone stands for the `usual` one."""
        answer = await self._answers.to(question if usual is None else f"{question} [{usual:.10g}]")
        bounds = f" from {limits[0]:g} to {limits[1]:g}" if math.isfinite(limits[0]) else ", such as 1.95"
        while answer or usual is None:
            with contextlib.suppress(ValueError):
                number = float(answer)
                if math.isfinite(number) and limits[0] <= number <= limits[1]:
                    return number
            answer = await self._answers.to(f"write a number{bounds}")
        return usual

    def _say(self, line: str) -> None:
        self._performing.screen.say(line)


async def offer(robots: Robots, robot: str, values: Mapping[str, float], answers: TypedAnswers, *, write: bool) -> int:
    """Show the edit of improv.toml, and make it if the person wants it. Return the exit code. Raises CommandError."""
    path, text = robots.path, edited(robots.text, robot, values)
    assert path
    if text is None:
        lines = "; ".join(f"{name} = {value:.10g}" for name, value in values.items())
        answers.say(f"{path} is written in an unusual form, so write this into the profile yourself: {lines}")
        return PROBLEMS
    before, after = robots.text.splitlines(), text.splitlines()
    for line in difflib.unified_diff(before, after, str(path), str(path), n=1, lineterm=""):
        answers.say(line)
    if not write and (await answers.to(f"Write this into {path}? [y/N]")).lower() not in ("y", "yes"):
        answers.say(f"{path} was not changed")
        return 0
    try:
        if not swap_text(path, robots.text, text):
            raise CommandError(f"{path} has changed since the calibration began, so it was not written")
    except OSError as error:
        raise CommandError(f"{path} was not written: {why(error)}") from None
    answers.say(f"{path} was written")
    return 0


class _NothingMeasuredError(Exception):
    """A dance has to be played again; the message is one plain line that says why."""


def _written(settings: MeasuredSettings) -> Mapping[str, float]:
    """Convert the settings to those of improv.toml, with as many digits as can be measured."""
    return {
        "commanded_step": float(f"{settings.commanded_step:.4g}"),
        "commanded_quarter_turn": round(math.degrees(settings.commanded_quarter_turn), 2),
        "left_right": round(settings.left_right, 4),
    }


def check(values: Mapping[str, float]) -> None:
    """Raise CommandError if a profile can't have one of these values."""
    for name, value in values.items():
        key = known(("profiles", "", name))
        if not key.least <= value <= key.most:
            range_ = f"{value:g} {key.unit}, which is not from {key.least:g} to {key.most:g}"
            raise CommandError(f"`{name}` would be {range_}: check the robot; {FILE_NAME} was not changed")

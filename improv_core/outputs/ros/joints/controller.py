"""The commands to one controller of a robot's joints, on its ROS 2 topic (passed in)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from improv_core.outputs.cdr import numbers_message
from improv_core.outputs.ros.joints.channels import WINDOW, Channel, joint_states_of
from improv_core.outputs.ros.joints.goals import Goals
from improv_core.outputs.ros.joints.trajectories import (
    Course,
    current_course,
    homing_channel,
    homing_course,
    leaves_out,
    let_go,
    message_of,
    stopped,
    turned,
)
from improv_core.outputs.ros.topic import Now, RosTopic
from improv_core.outputs.ros.zero_sender import PendingZeros
from improv_core.protocol.output import Unfollowed
from improv_core.safety.joint_following import JointWatch, unfollowed, watched
from improv_core.safety.joint_preflight import FRESH, JointOff, in_words, is_far, joints_off
from improv_core.safety.pending_zeros import LAST_ZEROS
from improv_core.score.joints import JointMotion
from improv_core.score.score import Part

SETTLED = 0.5
"""Seconds after which stopped joints have come to rest, so that their measured positions count."""
PERIOD = 0.05
"""Seconds between two messages to joints that move to their starts."""
LONGEST_GAP = 0.2
"""Seconds between two commands for which a joint counts as told to move, at most: the last one may be long ago."""
OFTEN = 0.75
"""Repeat a command only after this share of its period. Each body part asks for its own repeats, and a controller that
moves several gets all of them."""

Measured = Callable[[str], Mapping[str, tuple[float, float]]]
"""Returns the positions of a robot's joints, each with its time of arrival in monotonic seconds."""


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The facts that controllers share: ROS's clock, positions of joints, pending zeros, and the monotonic time."""

    clock: Any
    measured: Measured
    pending_zeros: PendingZeros
    now: Now


class RosController:
    """A controller of a robot and its latest course, which is None until the positions of its joints are known.

    Only velocity controllers never stop by themselves, so pending zeros are about their topics. A trajectory ends at
    rest, and a position is one at which a joint stands.
    """

    def __init__(
        self, part: Part, channel: Channel, topic: RosTopic, around: Surroundings, goals: Goals | None = None
    ) -> None:
        self.channel = channel
        self.topic = topic
        self._goals = goals
        self.homing: Channel | None = None
        """The channel that brings its joints to their starts, while they move there."""
        self._part = part
        self._window = channel.window
        self._around = around
        self._course: Course | None = None
        self._sent = -math.inf
        self._moved = -math.inf  # when it last got a command to move
        self._from_measured = True  # True if its next course starts at the measured positions of its joints
        self._homing_tried = False  # True after it has tried to bring its joints to their starts
        self._watches: dict[str, JointWatch] = {}  # the joints that it was told to move
        self._told: dict[str, float] = {}  # when each joint last got a command, sent or left out
        self._off: Mapping[str, float] = {}  # the joints that stand off the program, and how far, when that was told

    @property
    def moves(self) -> bool:
        """True if its joints move by its latest course."""
        return self._course is not None and self._course.moves

    @property
    def moves_home(self) -> bool:
        """True if `improv.toml` has its joints brought to their starts before beat 0."""
        body = self._part.profile.body
        return body is not None and body.home == "move"

    @property
    def needs_zeros(self) -> bool:
        """True if its joints keep moving until they get a zero."""
        return self.channel.interface == "velocity"

    @property
    def unfollowed(self) -> Unfollowed | None:
        """The joints that don't follow, and the likely cause."""
        joints, name = {joint.name: joint for joint in self.channel.joints}, self.channel.topic.rpartition("/")[0]
        if self._goals and self._goals.problem:
            return Unfollowed(0.0, f"{name} {self._goals.problem}")
        return unfollowed(self._watches, joints, self._fresh(), name, joint_states_of(self._part) or "")

    def missing(self) -> str | None:
        """The reason why it would not receive a command now, as `RosTopic.missing` has it."""
        line = self.topic.missing(self.moves)
        by_goals = line and self._goals and self._goals.serves and not self.topic.count_listeners()
        return None if by_goals else line

    def take(self, part: Part, restart: bool, window: float = WINDOW) -> None:
        """Perform this part from now on, smoothed over this `window` once its joints rest."""
        self._part, self._window = part, window
        if restart:
            self._watches, self._off = {}, {}
        self._from_measured = self._from_measured or restart
        self._homing_tried = self._homing_tried and not restart
        if not part.scenes:  # it only has to stop, because an earlier stage may have moved it
            zero = numbers_message([0.0] * len(self.channel.joints))
            self._around.pending_zeros.note_inherited(part.robot, self.topic, "", zero)

    def ask(self) -> None:
        """Have its listeners confirm a command that moves nothing."""
        if course := self._update(begins=False):
            self.topic.ask(message_of(self.channel, course), self._around.clock, "")

    def send(self, joints: Mapping[str, JointMotion], at: float, pace: float, until: float, late: float) -> str:
        """Publish the command for its joints among these from performance time `at` on, unless positions are unknown.

        `late` is its delay in seconds, and the velocities hold `until` then. Return a line if joints come to rest
        elsewhere than the program has them; "" if none does.
        """
        told = [joints[joint.name] for joint in self.channel.joints if joint.name in joints]
        if not told:
            return ""
        self.halt()
        begins = any(motion.velocity for motion in told)
        before = self._update(begins=begins)
        if before is None:
            return ""
        self._from_measured = self._from_measured and not begins
        wanted = turned(self.channel, before, joints, at, late, until)
        course = let_go(self.channel, before, wanted, self._recent())
        self._watch(before, joints)
        soon = self._around.now() < self._sent + OFTEN / self._part.profile.command_rate
        if leaves_out(before, course, course.since, soon):
            return ""
        self._course = course
        self._publish(message_of(self.channel, course, pace), stops=until <= at)
        return "" if course.moves or any(course.brakes) else self._off_line(course, joints)

    def steers_home(self) -> bool:
        """Update the course of joints that move to their starts, and return whether to `go_home` now. They try only
        once, because something may block them."""
        now = self._around.now()
        if self._homing_tried or now < self._sent + PERIOD or self.missing() is not None:
            return False
        if self.homing and self._course:
            wanted = turned(self.homing, self._course, {}, now)
            free = let_go(self.homing, self._course, wanted, self._recent())
            # If something holds one back, they all stay where they are.
            self._course = wanted if free == wanted else stopped(self.homing, free, 0.0)
            return True
        course = self._update(begins=False)
        if not course or not (homing := homing_channel(self.channel, course)):
            return False
        self.homing, self._course = homing, homing_course(homing, course, now)
        return True

    def go_home(self) -> None:
        """Send the course of joints that move to their starts."""
        assert self.homing
        assert self._course
        self._send(message_of(self.homing, self._course), stops=any(self._course.brakes))
        if self.moves:
            self._moved = self._sent
        else:
            self._homing_tried, self.homing = True, None

    def halt(self) -> None:
        """Stop joints that are on their way to their starts."""
        if self.homing and self._course:
            self._course = stopped(self.homing, self._course, self._around.now() - self._course.since)
            self.homing = None
            self._send(message_of(self.channel, self._course), stops=True)

    def leave(self) -> None:
        """Stop joints that another controller moves from now on, if they have got a command."""
        if self._course and self._sent > -math.inf:
            course = stopped(self.channel, self._course, max(self._around.now() - self._sent, 0.0))
            message = message_of(self.channel, course)
            self._course = course
            for _ in range(LAST_ZEROS):
                self._send(message, stops=True)
            if self.needs_zeros:
                self._around.pending_zeros.note_zero(self._part.robot, self.topic, "", message)

    def off(self) -> Sequence[JointOff]:
        """The joints that aren't at their starts or whose positions are unknown."""
        topic, needed = joint_states_of(self._part), self.channel.needs_positions
        if not self._part.scenes or not (topic or needed):
            return ()
        brought = self.moves_home and not self._homing_tried and needed
        found = joints_off(self._part.robot, self.channel.joints, topic, self._fresh(), brought)
        return [each for each in found if each.left is None or each.joint.name not in self.channel.held]

    def _watch(self, before: Course, told: Mapping[str, JointMotion]) -> None:
        """Watch whether joints follow that were told to move since the last command to each."""
        if not joint_states_of(self._part):
            return
        at, measured = self._around.now(), self._fresh()
        for joint, motion in zip(self.channel.joints, before.motions, strict=True):
            if now := told.get(joint.name):
                seconds = min(at - self._told.get(joint.name, at), LONGEST_GAP) if motion.velocity else 0.0
                self._told[joint.name] = at
                if now.velocity or motion.velocity:
                    watch = self._watches.get(joint.name, JointWatch())
                    self._watches[joint.name] = watched(
                        watch, joint, seconds, *now, measured.get(joint.name), self.channel.window
                    )

    def _off_line(self, course: Course, told: Mapping[str, JointMotion]) -> str:
        """Return a line about the joints that rest elsewhere than the program has them, unless they did so before."""
        before, self._off = (
            self._off,
            {
                joint.name: told[joint.name].position - motion.position
                for joint, motion in zip(self.channel.joints, course.motions, strict=True)
                if joint.name in told and is_far(joint, told[joint.name].position, motion.position)
            },
        )
        joints = {joint.name: joint for joint in self.channel.joints}
        new = {name: off for name, off in self._off.items() if is_far(joints[name], off, before.get(name, 0.0))}
        if not new:
            return ""
        named = ", ".join(f"{name} by {in_words(joints[name], -off)}" for name, off in new.items())
        return f"joints of {self._part.robot} rest off the program, {named}: play from beat 1 to bring them back"

    def _publish(self, message: bytes, stops: bool) -> None:
        """Send the latest course, and note zeros that it needs."""
        if self.needs_zeros and self.moves:
            self._around.pending_zeros.note_velocity(self.topic, "")
        self._send(message, stops)
        if self.moves:
            self._moved = self._sent
        elif self.needs_zeros:
            self._around.pending_zeros.note_zero(self._part.robot, self.topic, "", message)

    def _send(self, message: bytes, stops: bool) -> None:
        """Send the latest course. A stop waits for no action: it leaves on the topic, and goals are canceled once the
        joints have braked, or at once if nothing listens there. A canceled goal has joints stand where they are."""
        self._sent = self._around.now()
        if self._goals and not stops and self._goals.serves:
            self._goals.send(message)
            return
        self.topic.publish(message, self._around.clock, "")
        if self._goals and self._course:
            brakes = [brake.seconds for brake in self._course.brakes if brake] if self.topic.count_listeners() else []
            self._goals.stop(max(brakes, default=0.0))

    def _update(self, *, begins: bool) -> Course | None:
        """Return the current course, before a new command; None if unknown."""
        rests = self._around.now() >= self._moved + SETTLED + self.channel.window
        if rests and not self.moves:
            self.channel = replace(self.channel, window=self._window)
        self._course = current_course(
            self.channel, self._course, self._fresh(), begins=begins, from_measured=self._from_measured, rests=rests
        )
        return self._course

    def _fresh(self) -> dict[str, float]:
        """The known current positions of its joints."""
        return {joint: position for joint, (position, _) in self._recent().items()}

    def _recent(self) -> dict[str, tuple[float, float]]:
        """These positions, each with its age in seconds."""
        now, measured = self._around.now(), self._around.measured(self._part.robot)
        known = [(joint, *measured[joint.name]) for joint in self.channel.joints if joint.name in measured]
        return {
            joint.name: (position + joint.offset, max(now - at, 0.0))
            for joint, position, at in known
            if at >= now - FRESH
        }

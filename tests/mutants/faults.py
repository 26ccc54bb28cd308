"""Sixty faults of the heart, chosen by hand: each would be a real one, and each should be noticed by a test.

A row that no longer fits the source has to be brought up to date: keep the fault, and find the words that make it now.
"""

from __future__ import annotations

from typing import NamedTuple


class Fault(NamedTuple):
    """A change of a file of improv_core: `original`, which occurs there once, becomes `mutated`, and `breaks` that."""

    file: str
    original: str
    mutated: str
    breaks: str


STAGE = (
    Fault(
        "player/setpoint_queue.py",
        "for count in range(LAST_ZEROS))",
        "for count in range(LAST_ZEROS - 1))",
        "a robot's last zero is not sent",
    ),
    Fault(
        "player/setpoint_queue.py",
        "if moved or (not later and part.topic in taken):",
        "if moved:",
        "a robot that leaves is not stopped before another one takes its topic",
    ),
    Fault(
        "protocol/output.py",
        "            problems.append(problem)\n",
        "            problems.append(problem)\n            break\n",
        "after one robot that can't be stopped, no other one is",
    ),
    Fault(
        "player/repeats.py",
        "return [mover for mover, at in slot.items() if at <= before]",
        "return [mover for mover, at in slot.items() if at > before]",
        "robots that hold a velocity are not sent it again, and those that were just sent another one are",
    ),
    Fault(
        "safety/pending_zeros.py",
        "if facts.others - before or (joined and facts.others):",
        "if joined and facts.others:",
        "pending zeros disturb another node that moves the robot now",
    ),
    Fault(
        "safety/pending_zeros.py",
        "return DONE if facts.listeners >= pending.expected and not pending.inherited else FollowUp(pending)",
        "return DONE if not pending.inherited else FollowUp(pending)",
        "a zero counts as heard although a listener that had been there is out of reach",
    ),
    Fault(
        "outputs/ros/standby/client.py",
        "if not moving or ready:",
        "if not moving:",
        "robots are stopped although a standby is ready",
    ),
    Fault(
        "safety/heartbeat.py",
        "if now < max(at, self._since + DOUBT):",
        "if now < at:",
        "a loop that was busy takes its parent for silent, though what it said waits to be read",
    ),
    Fault(
        "ipc/arrivals.py",
        "if _kind(other) not in void:",
        "if _kind(other) in void:",
        "a stop keeps the requests that it makes void, and drops all others",
    ),
    Fault(
        "score/takeover.py",
        "if not before.is_over and _is_alike(part, scene, before) else beat",
        "if not before.is_over else beat",
        "a part that was edited does not start over, but continues in the middle",
    ),
    Fault(
        "safety/interlocks.py",
        "if self.on and not self.latest and now >= self.pressed + RELEASED:",
        "if self.on and not self.latest:",
        "one node that says false releases an emergency stop that another one presses",
    ),
    Fault(
        "stage/loop.py",
        "if slept > SLEPT and self._may_move:",
        "if slept > SLEPT and not self._may_move:",
        "robots that move keep moving after the machine has slept",
    ),
    Fault(
        "stage/loop.py",
        'fence.lose()\n        self._tell({"type": "error"',
        'fence\n        self._tell({"type": "error"',
        "what a parent sent before it hung moves robots after they were stopped",
    ),
    Fault(
        "player/apply.py",
        "tracks.queue.leave_topics(old, new, act.at)\n",
        "pass\n",
        "after an edit, a robot whose topic changes keeps moving there",
    ),
    Fault(
        "player/apply.py",
        "tracks.queue.still(tracks.queue.movers(robots), 0.0)",
        "pass",
        "robots keep moving while a restart waits for others",
    ),
    Fault(
        "player/subscribers.py",
        "now < self._met[robot] + PATIENCE or (line",
        "now > self._met[robot] + PATIENCE or (line",
        "beat 0 does not wait for a robot that will listen in a moment, but for one that never will",
    ),
    Fault(
        "player/run.py",
        "not self.has_next_scene else math.ceil(over)",
        "not self.has_next_scene else math.floor(over)",
        "a scene begins before the one above it is over",
    ),
    Fault(
        "score/performer.py",
        "return (STILL, ()) if waits else self._execution.velocity()",
        "return self._execution.velocity()",
        "a robot moves though the sense that decides is silent",
    ),
    Fault(
        "outputs/ros/standby/process.py",
        "(gone or now > self._hung)",
        "(now > self._hung)",
        "the standby does not stop the robots of a stage that has died",
    ),
    Fault(
        "outputs/ros/sensors/process.py",
        "if value is not None and now >= at + topic.timeout:",
        "if value is not None and now < at + topic.timeout:",
        "a sensor that has stopped sending counts as heard",
    ),
)

PLAYBACK = (
    Fault(
        "safety/stops.py",
        "if self._counted() != asked or self._unsettled:",
        "if self._counted() < asked or self._unsettled:",
        "what was asked for before a stop plays after it",
    ),
    Fault(
        "safety/stops.py",
        "now, again = time.monotonic(), None\n        with self._lock:\n",
        "now, again = time.monotonic(), None\n        if True:\n",
        "a score can slip in while stages are being stopped: a lock is left out",
    ),
    Fault(
        "safety/stops.py",
        "            self._slept = slept\n            self._note(stop=True)\n",
        "            self._slept = slept\n",
        "what was asked for before the machine slept plays after it",
    ),
    Fault(
        "safety/heartbeat.py",
        "HANG_LIMIT if real and self._plays else HARMLESS_HANG_LIMIT",
        "HANG_LIMIT if real or self._plays else HARMLESS_HANG_LIMIT",
        "a stage that does no harm is killed as soon as one that moves real robots",
    ),
    Fault(
        "safety/heartbeat.py",
        "return not self._moves and not self.waits and now",
        "return not self._moves and now",
        "a stage that has not answered is no longer pinged, nor found to hang",
    ),
    Fault(
        "safety/private_folder.py",
        " and found.st_uid == user and not found.st_mode & 0o077",
        " and found.st_uid == user",
        "a folder that other users can enter is trusted",
    ),
    Fault(
        "safety/stop_socket.py",
        'return answer or f"process {process} does not answer: end it with `kill`"',
        "return answer or IDLE",
        "`improv stop` does not say that a process did not answer",
    ),
    Fault(
        "ipc/stage_process.py",
        '{**message, "after": self._before}',
        '{**message, "after": self._before - 1}',
        "a stage takes what was asked for after a stop for older than the stop",
    ),
    Fault(
        "ipc/stage_process.py",
        'self._send_first({"type": "ping"})  # the stage must expect pings before it moves anything',
        "pass",
        "a stage whose parent hangs at once never expects a ping, and moves robots on",
    ),
    Fault(
        "session/on_report.py",
        '    if mode == "stopped":\n        return state, [*_to(state.twin, stop_of(transport)), *acts]\n',
        "",
        "the simulated robots dance on when the real ones were stopped",
    ),
    Fault(
        "session/state.py",
        "if movement is scene or same(movement, scene))",
        "if True)",
        "a part that was edited counts as unchanged",
    ),
    Fault(
        "session/session.py",
        "        else:\n            self._loads.forget(act.to)  # they lack this score\n",
        "",
        "a stage is sent a score that builds on one that it never got",
    ),
)

SCORE = (
    Fault(
        "score/motion.py",
        "dx = (twist.x * along - twist.y * across) * seconds",
        "dx = (twist.x * along + twist.y * across) * seconds",
        "robots that strafe while they turn end up elsewhere",
    ),
    Fault(
        "score/motion.py",
        "    return max(linear, angular)\n",
        "    return linear\n",
        "robots turn faster than their limit",
    ),
    Fault(
        "score/transport.py",
        "return near(float(min(passed, beats)))",
        "return near(float(passed))",
        "the beat counts on after the end of a score",
    ),
    Fault(
        "score/transport.py",
        'step = beats_per_bar if when == "bar" else 1',
        'step = 1 if when == "bar" else beats_per_bar',
        "a score takes over at a beat where it should at a bar, and the other way around",
    ),
    Fault(
        "score/transport.py",
        "max(math.ceil((performed - first) / seconds), 0)",
        "max(math.floor((performed - first) / seconds), 0)",
        "a score takes over at a beat that has passed",
    ),
    Fault(
        "score/algebra.py",
        "min(ending) if ending else",
        "max(ending) if ending else",
        "voices at once last as long as the longest",
    ),
    Fault(
        "score/score.py",
        "begin, starts = math.ceil(end), None",
        "begin, starts = math.floor(end), None",
        "a scene begins before the one above it is over",
    ),
    Fault(
        "score/ramps.py",
        "Fraction(2 * step + 1, 2 * self.steps)",
        "Fraction(2 * step, 2 * self.steps)",
        "each step of a ramp has the rate of its beginning, so robots fall short",
    ),
    Fault(
        "score/performing.py",
        "self._stands = whole if isinstance(self._left, float) else min(whole, self._left)",
        "self._stands = whole",
        "after `until`, a robot stands longer than its movement would have lasted",
    ),
    Fault(
        "score/performing.py",
        "return not self._voices or (bool(over) and not self._begins)",
        "return not self._voices or (len(over) == len(self._voices) and not self._begins)",
        "voices that senses decide continue after the first has ended",
    ),
    Fault(
        "score/performing.py",
        "return math.floor(beat) + 1 - beat",
        "return math.ceil(beat) - beat",
        "on a whole beat, a robot does not stand until the next one, but not at all",
    ),
    Fault(
        "score/throws.py",
        "* (last + 1) >> SIDES",
        "* last >> SIDES",
        "`shuffle` never leaves an item in its place",
    ),
    Fault(
        "score/following.py",
        "ahead = twist.x * (math.cos(turn) - 1) + GAIN * error.x",
        "ahead = twist.x * (math.cos(turn) - 1) - GAIN * error.x",
        "a robot that is behind is slowed down",
    ),
    Fault(
        "score/smoothing.py",
        "fastest[id(each)] = max(rate, fastest.get(id(each), rate))",
        "fastest[id(each)] = min(rate, fastest.get(id(each), rate))",
        "a phrase that is used twice is eased although one use would be too fast",
    ),
)

PROGRAM = (
    Fault(
        "syntax/word.py",
        "return None if 0 < value <= 1 else",
        "return None if 0 < value < 1 else",
        "`chance 1` is an error",
    ),
    Fault(
        "program/numbers.py",
        "total = total / factor if divides else total * factor",
        "total = total * factor if divides else total / factor",
        "`3/2` is 6",
    ),
    Fault(
        "program/bindings.py",
        "count = bisect_left(definers, before)",
        "count = bisect_right(definers, before)",
        "a definition is in force in its own line",
    ),
    Fault(
        "program/bindings.py",
        "if user == len(users) or (place + 1 < len(definers) and users[user] > definers[place + 1]):",
        "if user == len(users):",
        "a definition that is replaced before it is used counts as used",
    ),
    Fault(
        "program/analysis.py",
        "                    heappush(waiting, user)\n",
        "                    pass\n",
        "an edit of a definition does not reach the lines that use it",
    ),
    Fault(
        "program/analysis.py",
        "meaning.scope != tuple(scope.values()) or statement_id in waited:",
        "meaning.scope != tuple(scope.values()):",
        "a line that waited to be checked is never checked if another line is added meanwhile",
    ),
    Fault(
        "program/feasibility.py",
        "float(FASTEST_EASE) if profile.smooth else 1.0",
        "1.0 if profile.smooth else float(FASTEST_EASE)",
        "nobody hears that a smoothed movement would be too fast",
    ),
    Fault(
        "program/feasibility.py",
        "over.factor > fastest[0].factor",
        "over.factor < fastest[0].factor",
        "the advice fits the movement that is the least too fast, and does not suffice",
    ),
    Fault(
        "program/unreachable.py",
        "(begin >= window.end or end <= window.start)",
        "(begin > window.end or end <= window.start)",
        "nobody hears that an item right after the end is never reached",
    ),
    Fault(
        "program/unreachable.py",
        "yield part.body, _Window(latest - end, latest - start)",
        "yield part.body, _Window(start, end)",
        "in `reverse`, the wrong items count as never reached",
    ),
    Fault(
        "program/timing.py",
        "turn = f\"turns {abs(degrees):,g}° {'left' if degrees > 0 else",
        "turn = f\"turns {abs(degrees):,g}° {'left' if degrees < 0 else",
        "left and right are exchanged in what is said of a movement",
    ),
    Fault(
        "program/compiler.py",
        "self.stretches[-1] = last[0], last[1] + moment.duration, last[2]",
        "self.stretches[-1] = last[0], moment.duration, last[2]",
        "stretches of one velocity that follow one another get shorter",
    ),
    Fault(
        "program/program.py",
        "self.meanings[self.tempos[0]].tempo",
        "self.meanings[self.tempos[-1]].tempo",
        "the last tempo counts instead of the first",
    ),
    Fault(
        "program/files.py",
        "if len(data) > most:",
        "if len(data) >= most:",
        "a file that is as large as files may be is refused",
    ),
)

FAULTS = (*STAGE, *PLAYBACK, *SCORE, *PROGRAM)

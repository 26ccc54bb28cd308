"""The reports of the reader of sensors to the stage, given the topics' messages and the time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import pytest

from improv_core.outputs.ros.sensors.process import LOOK, HeardSenses
from improv_core.protocol.output import Edge
from improv_core.score.senses import RobotSense, Topic

HIT = Topic("/anna/hit", "std_msgs/Bool")
CHANGES = replace(HIT, timeout=0.0)
ANNA, BERT = RobotSense("anna", "bump"), RobotSense("bert", "bump")
Told = list[tuple[str, bool | None]]


class Reading:
    """Senses, checked as often as the reader does it; `told` are its reports: robot and value."""

    def __init__(self, sources: dict[RobotSense, Topic]) -> None:
        self.now = 0.0
        self.published = True
        self.told: Told = []
        self.senses = HeardSenses(self.now)
        self.read(sources)

    def read(self, sources: dict[RobotSense, Topic]) -> None:
        self.take(self.senses.read(sources, self.now))

    def hear(self, value: bool | None, topic: Topic = HIT) -> None:
        self.take(self.senses.take(topic, value, self.now))

    def wait(self, seconds: float, step: float = LOOK) -> None:
        for _ in range(round(seconds / step)):
            self.now += step
            self.take(self.senses.look(lambda topic: self.published, self.now))

    def take(self, edges: Iterable[Edge]) -> None:
        for edge in edges:
            assert isinstance(edge.what, RobotSense)
            assert edge.at == self.now
            self.told.append((edge.what.robot, edge.value))


Story = Sequence[float | bool | None]
"""The values that a sensor sends, and the seconds between them; it is not looked at for a negative time."""


@pytest.mark.parametrize(
    ("story", "values"),
    [
        ([True, 0.5, True, 0.5, False, 0.5, False, 0.5, None, 0.5, False, 0.5], [True, False]),
        ([True, 0.9, 0.2, 5.0, True], [True, None, True]),
        ([True, 0.5, None, 0.5, None, 0.5, None, 0.5, None, 0.5, None], [True, None]),
        ([True, -3.0, True, 0.5], [True]),
    ],
    ids=["steady", "silent", "without a value", "we stood still"],
)
def test_changes_are_reported_once_and_silence_as_unknown(story: Story, values: Sequence[bool | None]) -> None:
    reading = Reading({ANNA: HIT})
    for each in story:
        if isinstance(each, float):
            reading.wait(abs(each), abs(each) if each < 0 else LOOK)
        else:
            reading.hear(each)
    assert reading.told == [("anna", value) for value in values]


def test_another_program_reads_what_is_known_and_no_more_of_what_it_does_not_name() -> None:
    reading = Reading({ANNA: HIT})
    reading.hear(True)
    for sources in ({ANNA: HIT, BERT: HIT}, {BERT: HIT}, {}):
        reading.read(sources)
    assert reading.told == [("anna", True), ("bert", True), ("anna", None), ("bert", None)]


def test_a_sensor_that_sends_only_changes_counts_as_long_as_it_has_a_publisher() -> None:
    reading = Reading({ANNA: CHANGES})
    reading.published = False
    reading.wait(1)
    assert reading.told == []
    reading.published = True
    reading.wait(100)
    assert reading.told == [("anna", False)]
    reading.hear(True, CHANGES)
    reading.wait(100)
    assert reading.told[1:] == [("anna", True)]
    reading.published = False
    reading.wait(1)
    assert reading.told[2:] == [("anna", None)]


def test_another_source_of_a_sense_is_silent_at_first() -> None:
    reading = Reading({ANNA: HIT})
    reading.hear(True)
    other = replace(HIT, topic="/other")
    reading.read({ANNA: other})
    assert reading.told == [("anna", True), ("anna", None)]
    reading.hear(False)
    assert reading.told[2:] == []
    reading.hear(False, other)
    assert reading.told[2:] == [("anna", False)]

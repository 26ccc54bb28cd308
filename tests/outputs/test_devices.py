"""Robots moved by devices: commands, stops, lost connections, approval, and senses. Each robot has its own thread, so
the tests wait for what it does."""

from __future__ import annotations

import queue
import re
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from improv_core.outputs.devices import sink as module
from improv_core.outputs.devices.device import Device
from improv_core.outputs.devices.opening import device_class
from improv_core.outputs.devices.sink import COLORS, DeviceSink
from improv_core.protocol.output import Edge, RawPose, RawPoses
from improv_core.safety.allowed import approve
from improv_core.safety.pending_zeros import PERIOD
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import Profile
from improv_core.score.score import DeviceAddress, Host, Part, Score
from improv_core.score.senses import BUILT_IN, RobotSense, Senses, Topic
from tests.waiting import until

LIMIT = 60.0
"""Seconds to wait for a thread on a busy machine."""
ADDRESS = "tcp:127.0.0.1:4000"
SLOW = Profile("slow", 0.1, max_linear=0.5, linear_scale=2.0)


class FakeDevice(Device):
    """Puts all calls into a queue; a test sets what is wrong."""

    stops_after = 0.5
    calls: queue.SimpleQueue[Any]
    devices: queue.SimpleQueue[FakeDevice]
    wrong: list[Exception]
    """The errors of the next connections."""
    lost: str
    deaf: bool

    def connect(self) -> None:
        self.devices.put(self)
        if self.wrong:
            raise self.wrong.pop()
        self.calls.put("connect")

    def drive(self, twist: Twist) -> None:
        self.calls.put(twist)

    def stands(self) -> bool:
        return not self.deaf

    def check(self) -> None:
        if self.lost:
            type(self).lost, line = "", self.lost
            raise OSError(line)

    def close(self) -> None:
        self.calls.put("close")


class Stand:
    """A sink with fake devices, and what it reports. The test turns the clock."""

    def __init__(self) -> None:
        class Fresh(FakeDevice):
            calls, devices, wrong, lost, deaf = queue.SimpleQueue(), queue.SimpleQueue(), [], "", False

        self.kind = Fresh
        self.now = 100.0
        self.heard: queue.SimpleQueue[Edge | RawPoses] = queue.SimpleQueue()
        self.warned: list[str] = []
        self.sink = DeviceSink("fake", self.kind, self.heard.put, self.warned.append, lambda: self.now)

    def play(self, *robots: str, profile: Profile = SLOW, senses: Senses | None = None, first: int = 0) -> None:
        parts = {
            robot: Part(
                robot,
                (),
                profile,
                Pose(),
                f"/{robot}/cmd_vel",
                senses=senses or {},
                namespace=f"/{robot}",
                odom=f"/{robot}/odom",
                host=Host("fake", output=True),
                device=DeviceAddress(ADDRESS, node),
            )
            for node, robot in enumerate(robots, first)
        }
        self.sink.prepare(Score(Fraction(60), parts), restart=True)

    def next(self) -> Any:
        return self.kind.calls.get(timeout=LIMIT)

    def connected(self) -> FakeDevice:
        """Wait until its robot is driven."""
        device = self.kind.devices.get(timeout=LIMIT)
        assert [self.next(), self.next()] == ["connect", STILL]
        until(lambda: not self.sink.missing())
        return device


@pytest.fixture
def stand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Stand]:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr(module, "AGAIN", 0.02)
    approve(ADDRESS)
    made = Stand()
    yield made
    made.sink.close()


def test_a_robot_gets_velocities_calibrated_and_within_its_limits(stand: Stand) -> None:
    stand.play("ada")
    assert stand.sink.missing() in ({"ada": ""}, {})
    stand.connected()
    stand.sink.send("ada", Twist(0.2), 0.0)
    assert stand.next() == Twist(0.4)
    stand.sink.send("ada", Twist(0.3), 1.0)
    assert stand.next() == Twist(0.5)
    with pytest.raises(ValueError, match="finite"):
        stand.sink.send("ada", Twist(float("nan")), 2.0)


def test_nothing_is_opened_that_nobody_has_allowed(
    stand: Stand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "empty"))
    stand.play("ada")
    until(lambda: bool(stand.sink.missing().get("ada")))
    assert stand.sink.missing() == {
        "ada": f"ada: nobody has allowed Improv to use it: if you trust it, run `improv hosts allow {ADDRESS}`"
    }
    assert stand.kind.devices.empty()
    approve(ADDRESS)
    stand.connected()


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (OSError("it is switched off"), "ada: it is switched off"),
        (KeyError("x"), "ada: the output failed: KeyError: 'x'"),
    ],
)
def test_a_robot_that_cannot_be_reached_is_named_and_tried_again(stand: Stand, error: Exception, line: str) -> None:
    stand.kind.wrong = [error]
    stand.play("ada")
    lines = list[str | None]()

    def back() -> bool:
        lines.append(stand.sink.missing().get("ada"))
        return lines[-1] is None

    until(back)
    assert line in lines
    assert [stand.next(), stand.next(), stand.next()] == ["close", "connect", STILL]


def test_a_robot_that_is_lost_and_back_first_stands_and_forgets_its_velocity(stand: Stand) -> None:
    stand.play("ada")
    stand.connected()
    stand.sink.send("ada", Twist(0.2), 0.0)
    assert stand.next() == Twist(0.4)
    stand.kind.lost = "it is gone"
    assert [stand.next(), stand.next(), stand.next()] == ["close", "connect", STILL]
    until(lambda: not stand.sink.missing())
    assert stand.kind.calls.empty()
    stand.sink.send("ada", Twist(0.1), 1.0)
    assert stand.next() == Twist(0.2)


def test_a_velocity_that_comes_too_late_is_dropped(stand: Stand) -> None:
    stand.play("ada")
    device = stand.connected()
    drive, busy, goes_on = device.drive, queue.SimpleQueue[None](), queue.SimpleQueue[None]()

    def hang(twist: Twist) -> None:
        busy.put(None)
        goes_on.get(timeout=LIMIT)
        drive(twist)

    device.drive = hang  # type: ignore[method-assign]
    stand.sink.send("ada", Twist(0.1), 0.0)
    busy.get(timeout=LIMIT)
    stand.sink.send("ada", Twist(0.2), 0.1)
    stand.now += 1.0
    device.drive = drive  # type: ignore[method-assign]
    goes_on.put(None)
    assert stand.next() == Twist(0.2)
    stand.sink.send("ada", Twist(0.05), 0.2)
    assert stand.next() == Twist(0.1)


def test_a_zero_is_sent_until_the_robot_confirms_it(stand: Stand) -> None:
    stand.play("ada")
    stand.connected()
    stand.sink.retry(stand.now)
    stand.kind.deaf = True
    stand.sink.send("ada", Twist(0.2), 0.0)
    stand.next()
    stand.sink.send("ada", STILL, 1.0)
    assert stand.next() == STILL
    for _ in range(7):
        stand.now += PERIOD
        assert stand.sink.due <= stand.now
        stand.sink.retry(stand.now)
        assert stand.next() == STILL
    assert stand.warned == ["ada may still be moving: it has not confirmed the stop; look at the robot"]
    stand.kind.deaf = False
    stand.now += PERIOD

    def confirmed() -> bool:
        stand.sink.retry(stand.now)
        return stand.sink.due == float("inf")

    until(confirmed)


def test_a_robot_that_never_stops_by_itself_stands_unless_somebody_accepts_that(stand: Stand) -> None:
    stand.kind.stops_after = 0.0
    stand.play("ada")
    stand.kind.devices.get(timeout=LIMIT)
    assert [stand.next(), stand.next()] == ["connect", STILL]
    line = "ada never stops by itself: set `accept_no_stop = true` in its profile to move it"
    until(lambda: stand.sink.missing() == {"ada": line})
    stand.sink.send("ada", Twist(0.1), 0.0)
    assert stand.next() == STILL
    stand.play("ada", profile=Profile("free", 1.0, accept_no_stop=True))
    assert stand.sink.missing() == {}
    stand.sink.send("ada", Twist(0.1), 0.0)
    assert stand.next() == Twist(0.1)


def test_one_that_hangs_or_fails_delays_no_other(stand: Stand) -> None:
    stand.kind.wrong = [OSError("off")] * 1000
    stand.play("ada")
    until(lambda: bool(stand.sink.missing().get("ada")))
    stand.kind.wrong = []
    stand.play("ada", "bob")
    until(lambda: not stand.sink.missing())
    seen = [stand.next() for _ in range(stand.kind.calls.qsize())]
    stand.sink.send("bob", Twist(0.1), 0.0)
    assert "connect" in seen
    until(lambda: not stand.kind.calls.empty())
    assert stand.next() == Twist(0.2)


def test_a_robot_at_another_address_is_connected_once_its_device_before_has_closed(stand: Stand) -> None:
    stand.play("ada")
    device = stand.connected()
    close = device.close

    def slowly() -> None:
        with pytest.raises(queue.Empty):
            stand.kind.devices.get(timeout=0.3)
        close()

    device.close = slowly  # type: ignore[method-assign]
    stand.play("ada", first=7)
    assert [stand.next() for _ in range(4)] == [STILL, "close", "connect", STILL]


def test_the_last_zero_comes_before_the_end(stand: Stand) -> None:
    stand.play("ada")
    stand.connected()
    stand.sink.send("ada", Twist(0.1), 0.0)
    assert stand.next() == Twist(0.2)
    stand.sink.send("ada", STILL, 1.0)
    stand.sink.close()
    assert [stand.next(), stand.next()] == [STILL, "close"]


def test_readings_decide_the_senses_that_a_part_reads(stand: Stand) -> None:
    dark = Topic("/ada/ground", "std_msgs/Float32", below=200.0)
    stand.play("ada", senses={"near": BUILT_IN["near"], "dark": dark})
    device = stand.connected()
    device.readings.sense("near", False)
    device.readings.sense("ground", 900.0)
    device.readings.sense("near", False)
    device.readings.sense("ground", 100.0)
    device.readings.sense("other", True)
    expected = [("near", False), ("dark", False), ("dark", True)]
    found = [stand.heard.get(timeout=LIMIT) for _ in expected]
    assert found == [Edge(RobotSense("ada", name), value, stand.now) for name, value in expected]
    stand.kind.lost = "it is gone"
    silent = [stand.heard.get(timeout=LIMIT) for _ in range(2)]
    assert silent == [Edge(RobotSense("ada", name), None, stand.now) for name in ("near", "dark")]


def test_a_sense_that_the_robot_lacks_is_named(stand: Stand) -> None:
    stand.play("ada", senses={"dark": Topic("/ada/grund", "std_msgs/Float32", below=200.0)})
    stand.connected()
    assert stand.sink.warnings() == {}
    stand.now += 10
    assert stand.sink.warnings() == {"ada": "ada has no `grund`"}


def test_poses_are_those_of_wheels(stand: Stand) -> None:
    stand.play("ada")
    stand.connected().readings.pose(Pose(1.0))
    pose = RawPose("ada", "nav_msgs/Odometry", Pose(1.0), stand.now, topic="/ada/odom")
    assert stand.heard.get(timeout=LIMIT) == RawPoses([pose])


def test_robots_have_the_colors_of_the_page() -> None:
    style = (Path(module.__file__).parents[2] / "page" / "static" / "page.css").read_text(encoding="utf-8")
    listed = re.search(r"--robots:([^;]*);", style)
    assert listed
    colors = listed[1].split()[: len(COLORS)]
    assert [f"#{''.join(f'{round(255 * share):02x}' for share in color)}" for color in COLORS] == colors


def test_an_output_is_found_by_its_entry_point() -> None:
    assert device_class("thymio").__module__ == "improv_core.outputs.thymio.thymio"
    with pytest.raises(ImportError, match="no output thimyo is installed"):
        device_class("thimyo")

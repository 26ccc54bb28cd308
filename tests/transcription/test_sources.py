"""Tables, drawings, and recordings → places of robots, or one line that says what is wrong."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Sequence
from pathlib import Path

import pytest

from improv_core.outputs.cdr import pose_message
from improv_core.score.motion import Pose
from improv_core.transcription.reading import read_source
from improv_core.transcription.sources import Recording, SourceError
from improv_core.transcription.track import TimedPlace


def read(folder: Path, name: str, text: str, seconds: float = 10.0, scale: float | None = None) -> Recording:
    path = folder / name
    path.write_text(text)
    return read_source(path, seconds, scale)


def test_columns_are_known_by_their_names_and_units(tmp_path: Path) -> None:
    found = read(tmp_path, "ada.csv", "Time [msec],x [cm],y_mm,yaw_deg\n0,0,0,90\n500,100,2000,180\n")
    (places,) = found.places.values()
    assert list(found.places) == ["ada"]
    assert places[1] == pytest.approx((0.5, 1.0, 2.0, 0.0, math.pi))
    assert found.guesses == []


def test_each_robot_of_a_table_gets_its_rows(tmp_path: Path) -> None:
    found = read(tmp_path, "all.csv", "robot;t;x;y\nada;0;0;0\nbo 2;0;1;1\nada;1;0,5;0\nbo 2;1;1;2\n")
    assert {name: len(places) for name, places in found.places.items()} == {"ada": 2, "bo_2": 2}
    assert found.places["ada"][1].x == 0.5
    assert "`bo 2` is called bo_2" in found.guesses


def test_units_are_guessed_and_told(tmp_path: Path) -> None:
    found = read(tmp_path, "a.csv", "idx,t,px,py,yaw\n0,0,0,0,0\n1,50,0,0,90\n2,100,1,0,350\n")
    assert found.places["a"][2].time == 0.1
    assert found.guesses == [
        "column t is in milliseconds",
        "column px is in meters",
        "column py is in meters",
        "column yaw is in degrees",
    ]


def test_a_row_that_only_repeats_the_one_before_is_left_out(tmp_path: Path) -> None:
    table = tmp_path / "a.csv"
    table.write_text("t,x,y,led\n0,0,0,1\n1,1,0,1\n1,1,0,2\n2,1,0,2\n")
    assert [place.time for place in read_source(table, 20, None).places["a"]] == [0, 1, 2]


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("a.csv", "t,x,y\n0,0,0\n1,one,0\n", "row 3, column x: `one` is no number"),
        ("a.csv", "t,x,y\n0,0,0\n1,0\n", "row 3, column y: `` is no number"),
        ("a.csv", "t,x,y\n1,0,0\n1,1,0\n", "row 3: its time is not after that of the row before"),
        ("a.csv", "t,x\n0,0\n", "no column is named y: its columns are t, x"),
        ("a.csv", "t,x [furlong],y\n0,0,0\n", "column x [furlong]: the unit furlong is not known"),
        ("a.csv", "t,x,y\n0,0,0\n", "it has fewer than two places"),
        ("a.csv", "", "it is empty"),
        ("a.svg", "<svg><rect/></svg>", "a.svg: it has no paths or shapes: draw some"),
        ("a.svg", "<svg><use/><g><text>x</text></g></svg>", "it has no paths or shapes, only text, use: draw some"),
        ("a.svg", '<svg><circle r="1e999"/></svg>', "a.svg, circle: its path or transform is not understood"),
        ("a.svg", '<svg><circle r="5mm"/></svg>', "a.svg, circle: its path or transform is not understood"),
        ("a.svg", "<svg>", "it is no SVG"),
        ("a.svg", '<svg><path id="b" d="M0 0 L 1"/></svg>', "a.svg, b: its path or transform is not understood"),
        ("a.svg", '<svg><g transform="skewX(9)"/></svg>', "a.svg, g: its path or transform is not understood"),
        ("a.svg", '<svg><line x2="1e999"/></svg>', "a.svg, line: a number is too large"),
        ("a.mcap", "no recording", "it is no MCAP recording"),
        ("a.db3", "no recording", "it is no recording of rosbag2"),
        ("a.png", "", "name a .csv, .svg, .mcap, or .db3 file"),
    ],
)
def test_a_mistake_in_a_file_is_one_line(tmp_path: Path, name: str, text: str, line: str) -> None:
    with pytest.raises(SourceError) as problem:
        read(tmp_path, name, text)
    assert line in str(problem.value)
    assert "\n" not in str(problem.value)


def test_a_drawing_is_driven_in_its_time_and_turns_at_corners(tmp_path: Path) -> None:
    places = read(tmp_path, "a.svg", '<svg><path id="ada" d="M0 0 h1 v1"/></svg>', 6.0, 1.0).places["ada"]
    assert places[-1] == pytest.approx((6.0, 1.0, -1.0, 0.0, -math.pi / 2))
    assert all(abs(place.y) < 1e-9 or place.heading == pytest.approx(-math.pi / 2) for place in places)


def test_a_robot_waits_at_a_dot(tmp_path: Path) -> None:
    drawing = '<svg><path id="ada" d="M0 0h4"/><path id="bo" d="M2 1h.0001"/></svg>'
    assert {place[1:3] for place in read(tmp_path, "a.svg", drawing, 1.0).places["bo"]} == {(2.0, -1.0)}


@pytest.mark.parametrize(
    "path",
    ["M 0 0 A 1 1 0 0 1 2 0", "m0,0 a1,1,0,0,1,2,0", "M0 0a1 1 0 012 0", "M0 0c0-.5523.4477-1 1-1s1 .4477 1 1"],
)
def test_half_a_circle_can_be_drawn_as_an_arc_or_as_curves(tmp_path: Path, path: str) -> None:
    places = read(tmp_path, "a.svg", f'<svg><g transform="scale(2)"><path d="{path}"/></g></svg>', 6.0, 0.5).places["a"]
    assert all(math.dist((place.x, place.y), (1, 0)) == pytest.approx(1, abs=0.01) for place in places)


@pytest.mark.parametrize(
    ("shape", "path"),
    [
        ('<rect x="1" y="2" width="3" height="4"/>', "M1 2h3v4h-3z"),
        (
            '<rect width="4" height="6" ry="1"/>',
            "M1 0h2a1 1 0 0 1 1 1v4a1 1 0 0 1 -1 1h-2a1 1 0 0 1 -1 -1v-4a1 1 0 0 1 1 -1",
        ),
        (
            '<rect width="4" height="6" rx="2" ry="9"/>',
            "M2 0a2 3 0 0 1 2 3a2 3 0 0 1 -2 3a2 3 0 0 1 -2 -3a2 3 0 0 1 2 -3",
        ),
        ('<circle cx="1" cy="2" r="3"/>', "M4 2a3 3 0 0 1 -6 0a3 3 0 0 1 6 0"),
        ('<ellipse cx="1" cy="2" rx="3" ry="4"/>', "M4 2a3 4 0 0 1 -6 0a3 4 0 0 1 6 0"),
        ('<rect width="100%" height="100%"/><line x1="1" x2="2" y2="1e1"/>', "M1 0 2 10"),
    ],
)
def test_shapes_are_driven_as_paths_are(tmp_path: Path, shape: str, path: str) -> None:
    def driven(inside: str) -> Sequence[TimedPlace]:
        text = f'<svg xmlns="http://www.w3.org/2000/svg"><g transform="translate(2, 3) scale(2, 1)">{inside}</g></svg>'
        return read(tmp_path, "a.svg", text, 6.0, 0.5).places["a"]

    for place, other in zip(driven(shape), driven(f'<path d="{path}"/>'), strict=True):
        assert place == pytest.approx(other)


def test_a_drawing_names_what_is_not_read(tmp_path: Path) -> None:
    drawing = (
        '<svg xmlns="http://www.w3.org/2000/svg"><circle r="2"/><g><use/></g><text>round</text><text>it</text></svg>'
    )
    found = read(tmp_path, "a.svg", drawing, 6.0, 1.0)
    assert list(found.places) == ["a"]
    assert found.guesses == ["left out: text, use; convert what you need to paths"]


def test_poses_of_a_ros_recording_begin_when_something_moves(tmp_path: Path) -> None:
    path = tmp_path / "evening.db3"
    with sqlite3.connect(path) as base:
        base.execute("CREATE TABLE topics (id INTEGER, name TEXT, type TEXT)")
        base.execute("CREATE TABLE messages (topic_id INTEGER, timestamp INTEGER, data BLOB)")
        base.execute("INSERT INTO topics VALUES (1, '/tb1/odom', 'geometry_msgs/msg/PoseStamped')")
        for number in range(40):
            pose = Pose(max(0, number - 20) * 0.1, 0.0, 0.0, 0.0)
            row = (1, 10**18 + number * 50_000_000, pose_message(pose, 0, "odom"))
            base.execute("INSERT INTO messages VALUES (?, ?, ?)", row)
        for data in (b"", b"\0", None, "text"):  # they hold no pose
            base.execute("INSERT INTO messages VALUES (1, ?, ?)", (10**18, data))
    found = read_source(path, 10.0, None)
    assert found.guesses == ["tb1 is read from /tb1/odom"]
    assert found.places["tb1"][0] == (0.0, 0.0, 0.0, 0.0, 0.0)
    assert found.places["tb1"][1].x == pytest.approx(0.1)

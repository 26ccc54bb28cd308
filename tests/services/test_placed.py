"""Robots that were moved on the page of `improv edit` start there, and no file has it."""

from __future__ import annotations

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.services.placed import PlacedRobots, starts_of
from improv_core.stage.commands import Form, PlaceRobots
from improv_core.stage.fields import StartPoseJson

CIRCLE: Form = {"type": "form", "shape": "circle", "distance": 2.0, "facing": "in"}
PROGRAM = "ada bo $ forward\n"


def place(robot: str, x: float, y: float = 0.0, heading: float = 0.0) -> PlaceRobots:
    return {"type": "place", "start_poses": {robot: {"x": x, "y": y, "heading": heading}}}


def starts(*asked: PlaceRobots | Form, file: str = "", program: str = PROGRAM) -> dict[str, StartPoseJson]:
    placed = PlacedRobots()
    for each in asked:
        placed = placed.after(each)
    return starts_of(score_of(analyze(program, placed.robots(read_robots(file)))))


def pose(x: float, y: float, heading: float) -> object:
    return pytest.approx({"x": x, "y": y, "heading": heading})


def test_a_robot_that_was_moved_starts_there_and_the_others_where_they_did() -> None:
    assert starts() == {"ada": pose(0, 0, 0), "bo": pose(0, -3, 0)}
    assert starts(place("ada", 3, heading=90)) == {"ada": pose(3, 0, 90), "bo": pose(0, -3, 0)}
    assert starts(place("ada", 3), place("bo", 1), place("ada", 2)) == {"ada": pose(2, 0, 0), "bo": pose(1, 0, 0)}


def test_a_formation_takes_all_robots_that_the_file_does_not_place() -> None:
    circle = {"ada": pose(0, 1, -90), "bo": pose(0, -1, 90)}
    assert starts(CIRCLE) == starts(place("ada", 3), CIRCLE) == circle
    listed = "[robots.ada]\nstart = { x = 9 }\n[robots.bo]\n"
    assert starts(CIRCLE, file=listed) == {"ada": pose(9, 0, 0), "bo": pose(0, 0, 0)}


def test_a_robot_that_joins_the_program_later_is_no_stranger() -> None:
    assert starts(place("ada", 3), program="ada bo cleo $ left\n")["cleo"] == pose(0, -6, 0)


def test_a_formation_that_does_not_fit_is_an_error_of_the_robots() -> None:
    robots = PlacedRobots().after(CIRCLE).robots(read_robots("[world]\nsize = [1, 1]\n[robots.ada]\n[robots.bo]\n"))
    assert not robots.ok

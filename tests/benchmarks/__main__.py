"""Run one benchmark, or list them: `python -m tests.benchmarks [NAME] [--quick]`."""

from __future__ import annotations

import os
from argparse import ArgumentParser
from importlib import import_module

BENCHMARKS = {
    "begin_times": "how far from the time asked with `--at` the first velocity is sent",
    "bodies": "a key in a long program with words for body parts, and without",
    "calibration": "how far off bases that drift end, calibrated or following or not",
    "class": "from the stop of a teacher to zeros while a class sends dances, and what that costs",
    "clock": "how far changes of real robots are from the beats of a MIDI clock that they follow",
    "continuity": "what a save does to robots it does not change, and what it costs",
    "edit": "from `improv edit` to the first key, and from Ctrl+Enter to motion",
    "faults": "from a fault to the first zero that a robot hears",
    "first_beat": "how much of their first movement robots miss that were just started",
    "heavy": "keys and requests in and beside programs that take seconds to understand",
    "hosts": "when robots on bad links change their velocities, with a stage on each, and with one for all",
    "joints": "how soon joints rest when something fails, and how punctual they are, beside plain rclpy",
    "keep_apart": "from the pose that shows two robots too near to their zeros",
    "keystroke": "from a keystroke to its diagnostics, beside ruff and bare pygls",
    "link": "how well the clock of another machine is known, through ssh over a bad Wi-Fi",
    "meetings": "how long it takes to find who meets whom",
    "odometry": "how late commands are beside the odometry of twenty robots, and what it costs",
    "osc": "how punctual robots and beats are, and how soon a stop counts, while OSC messages pour in",
    "placing": "how near to their places `improv place` drives robots that slip",
    "publishing": "what it costs commands and processors to publish what plays for others in ROS 2",
    "requests": "from a request to its answer, and typing while a dance plays",
    "senses": "from a scan to its edge in the stage, and how late commands are beside scanners",
    "show": "what is said of twelve robots in MuJoCo when something goes wrong, and where they end",
    "simulator": "how much faster than real time, beside bare pymunk, and what the page costs",
    "song": "how far the song that a page plays is from the beat",
    "stage": "from a save to what robots hear, and how punctual that is, beside plain rclpy",
    "website": "how soon one can write and play on the website, over a slow network and without one",
    "worst": "how long the worst programs take",
}


def main() -> None:
    parser = ArgumentParser(prog="python -m tests.benchmarks", description="Benchmarks: each prints its table.")
    names = parser.add_subparsers(dest="name", metavar="NAME")
    for name, about in BENCHMARKS.items():
        names.add_parser(name, help=about).add_argument("--quick", action="store_true", help="fewer rounds")
    chosen = parser.parse_args()
    if chosen.name:
        os.environ["IMPROV_HISTORY"] = "off"  # what is measured is no work of the person's
        module = "class_room" if chosen.name == "class" else chosen.name
        import_module(f"tests.benchmarks.{module}").run(chosen.quick)
    else:
        parser.print_help()


if __name__ == "__main__":
    main()

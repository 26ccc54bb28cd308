"""Run one benchmark, or list them: `python -m tests.benchmarks [NAME] [--quick]`."""

from __future__ import annotations

import os
from argparse import ArgumentParser

from tests.benchmarks import (
    begin_times,
    bodies,
    calibration,
    class_room,
    clock,
    continuity,
    edit,
    faults,
    first_beat,
    heavy,
    hosts,
    joints,
    keep_apart,
    keystroke,
    link,
    meetings,
    odometry,
    osc,
    placing,
    publishing,
    requests,
    senses,
    show,
    simulator,
    song,
    stage,
    website,
    worst,
)

BENCHMARKS = {
    "begin_times": (begin_times.run, "how far from the time asked with `--at` the first velocity is sent"),
    "bodies": (bodies.run, "a key in a long program with words for body parts, and without"),
    "calibration": (
        calibration.run,
        "how far off bases that drift end, calibrated or following or not",
    ),
    "class": (class_room.run, "from the stop of a teacher to zeros while a class sends dances, and what that costs"),
    "clock": (clock.run, "how far changes of real robots are from the beats of a MIDI clock that they follow"),
    "continuity": (continuity.run, "what a save does to robots it does not change, and what it costs"),
    "edit": (edit.run, "from `improv edit` to the first key, and from Ctrl+Enter to motion"),
    "faults": (faults.run, "from a fault to the first zero that a robot hears"),
    "first_beat": (first_beat.run, "how much of their first movement robots miss that were just started"),
    "heavy": (heavy.run, "keys and requests in and beside programs that take seconds to understand"),
    "hosts": (
        hosts.run,
        "when robots on bad links change their velocities, with a stage on each, and with one for all",
    ),
    "joints": (joints.run, "how soon joints rest when something fails, and how punctual they are, beside plain rclpy"),
    "keep_apart": (
        keep_apart.run,
        "from the pose that shows two robots too near to their zeros",
    ),
    "keystroke": (keystroke.run, "from a keystroke to its diagnostics, beside ruff and bare pygls"),
    "link": (link.run, "how well the clock of another machine is known, through ssh over a bad Wi-Fi"),
    "meetings": (meetings.run, "how long it takes to find who meets whom"),
    "odometry": (odometry.run, "how late commands are beside the odometry of twenty robots, and what it costs"),
    "osc": (osc.run, "how punctual robots and beats are, and how soon a stop counts, while OSC messages pour in"),
    "placing": (placing.run, "how near to their places `improv place` drives robots that slip"),
    "publishing": (publishing.run, "what it costs commands and processors to publish what plays for others in ROS 2"),
    "requests": (requests.run, "from a request to its answer, and typing while a dance plays"),
    "senses": (senses.run, "from a scan to its edge in the stage, and how late commands are beside scanners"),
    "show": (show.run, "what is said of twelve robots in MuJoCo when something goes wrong, and where they end"),
    "simulator": (simulator.run, "how much faster than real time, beside bare pymunk, and what the page costs"),
    "song": (song.run, "how far the song that a page plays is from the beat"),
    "stage": (stage.run, "from a save to what robots hear, and how punctual that is, beside plain rclpy"),
    "website": (website.run, "how soon one can write and play on the website, over a slow network and without one"),
    "worst": (worst.run, "how long the worst programs take"),
}


def main() -> None:
    parser = ArgumentParser(prog="python -m tests.benchmarks", description="Benchmarks: each prints its table.")
    names = parser.add_subparsers(dest="name", metavar="NAME")
    for name, (_, about) in BENCHMARKS.items():
        names.add_parser(name, help=about).add_argument("--quick", action="store_true", help="fewer rounds")
    chosen = parser.parse_args()
    if chosen.name:
        os.environ["IMPROV_HISTORY"] = "off"  # what is measured is no work of the person's
        run, _ = BENCHMARKS[chosen.name]
        run(chosen.quick)
    else:
        parser.print_help()


if __name__ == "__main__":
    main()

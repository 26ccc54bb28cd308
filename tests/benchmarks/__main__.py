"""Run one benchmark, or list them: `python -m tests.benchmarks [NAME] [--quick]`."""

from __future__ import annotations

import os
from argparse import ArgumentParser
from importlib import import_module

BENCHMARKS = {
    "begin_times": "how far from the time asked with `--at` the first velocity is sent",
    "calibration": "how far off bases that drift end, calibrated or following or not",
    "class": "from the stop of a teacher to zeros while a class sends the worst text, and what that costs",
    "faults": "from a fault to the first zero that a robot hears",
    "first_save": "from the first save of a session to the first Twist, and whether first movements are whole",
    "heavy": "keys and requests in and beside programs that take seconds to understand",
    "hosts": "when robots on bad links change their velocities, with a stage on each, and with one for all",
    "joints": "how soon joints rest when something fails",
    "keep_apart": "how far apart two robots come to rest that drive toward each other",
    "keystroke": "from a keystroke to its diagnostics, start, and memory",
    "placing": "how near to their places `improv place` drives robots that slip",
    "show": "what is said of twelve robots in MuJoCo when something goes wrong, and where they end",
    "song": "how far the song that a page plays is from the beat",
    "stage": "from a save to what robots hear, and how punctual that is, beside plain rclpy",
    "thymio": "a Thymio among twelve in their simulator: from a save to its motors, from a kill to zeros, its squares",
    "transcription": "how well programs come back from their own paths, clean and noisy",
    "typing_page": "from a key on the page to its letter, color, and path, and what a page at rest costs",
}


def main() -> None:
    parser = ArgumentParser(prog="python -m tests.benchmarks", description="Benchmarks: each prints its table.")
    names = parser.add_subparsers(dest="name", metavar="NAME")
    for name, about in BENCHMARKS.items():
        names.add_parser(name, help=about).add_argument("--quick", action="store_true", help="fewer rounds")
    chosen = parser.parse_args()
    if chosen.name:
        os.environ["IMPROV_HISTORY"] = "off"  # the measured work is not the person's own
        module = "class_room" if chosen.name == "class" else chosen.name
        import_module(f"tests.benchmarks.{module}").run(chosen.quick)
    else:
        parser.print_help()


if __name__ == "__main__":
    main()

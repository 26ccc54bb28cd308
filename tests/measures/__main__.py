"""Print one measure of this repository, or of another checkout: `python -m tests.measures NAME [FOLDER]`."""

from __future__ import annotations

from argparse import ArgumentParser
from pathlib import Path

from tests.measures import messages, walk, weigh

HERE = Path(__file__).parent.parent.parent


def main() -> None:
    parser = ArgumentParser(prog="python -m tests.measures", description="The weight of Improv.")
    names = parser.add_subparsers(dest="name", required=True, metavar="NAME")
    weight = names.add_parser("weigh", help="lines of each package, of the page, and of tests; words of docs")
    names.add_parser("messages", help="message types between stages, session, and pages")
    way = names.add_parser("walk", help="modules from a save to the first Twist, and from a stop to the zero")
    for each in (weight, way):
        each.add_argument("folder", nargs="?", type=Path, default=HERE, help="a checkout; by default, this one")
    way.add_argument("--ros", metavar="PYTHON", help="a Python with rclpy: also follow both to the ROS stage")
    way.add_argument("--list", action="store_true", help="name the modules, too")
    chosen = parser.parse_args()
    if chosen.name == "weigh":
        print("\n".join(weigh.table(chosen.folder)))
    elif chosen.name == "messages":
        print("\n".join(messages.table()))
    else:
        walk.run(chosen.folder.resolve(), chosen.ros, chosen.list)


if __name__ == "__main__":
    main()

"""The `improv` command, also as `python -m improv_core`."""

import sys


def main() -> None:
    """Run the command. Importing it takes a moment, in which somebody may already press Ctrl-C."""
    try:
        from improv_core.commands.main import main as run
    except KeyboardInterrupt:
        sys.exit(130)
    run()


if __name__ == "__main__":
    main()

"""`python -m improv_core` is the `improv` command."""

from improv_core.commands.main import main

if __name__ == "__main__":
    main()

"""The `improv-ls` command: serve one editor over standard input and output."""

from __future__ import annotations

import gc


def main() -> None:
    """Start at once, and leave what is made while starting out of every later collection of garbage."""
    # Collections while lsprotocol makes its thousand classes, and again over them at every key, cost more than all
    # else that an edit of a long document needs.
    gc.disable()
    from improv_ls.server import serve

    gc.freeze()
    gc.enable()
    gc.set_threshold(50_000, 20, 50)
    serve()


if __name__ == "__main__":
    main()

"""The `improv-ls` command: serve one editor over standard input and output."""

from __future__ import annotations

import gc
import sys
from importlib import import_module
from importlib.util import find_spec
from typing import Any

HELP = """Usage: improv-ls [--stdio]

The language server of Improv. It speaks LSP over standard input and output: editors start it.

  --stdio    accepted, since many editors pass it
  --version  show the version and exit
  --help     show this message and exit
"""


def main() -> None:
    """Start at once, and exempt objects made while starting from all later garbage collections."""
    for argument in sys.argv[1:]:
        if argument != "--stdio":
            sys.exit(_answer(argument))
    # Garbage collections while starting, and again over all that at every key, would cost more than everything else
    # that an edit of a long document needs.
    gc.disable()
    _import_without_openssl()
    from improv_ls import lazy_types

    lazy_types.load()
    from improv_core.slices import keep_collections_short
    from improv_ls.server import serve

    keep_collections_short()
    gc.enable()
    sys.exit(serve())


def _import_without_openssl() -> None:
    """Import the modules that would load OpenSSL: it takes 5 MB, and this process neither speaks TLS nor needs it for
    hashes. Other packages still find it."""
    if not find_spec("_md5"):  # some distributions build Python without its own hashes
        return
    absent: dict[str, Any] = dict.fromkeys(("ssl", "_hashlib"))
    sys.modules.update(absent)
    for name in ("asyncio", "hmac"):
        import_module(name)
    for name in absent:
        del sys.modules[name]


def _answer(argument: str) -> int:
    from improv_core import __version__

    if argument == "--version":
        print(f"improv-ls, version {__version__}")
    elif argument in ("--help", "-h"):
        print(HELP, end="")
    else:
        print(f"improv-ls: unknown argument {argument!r}; see improv-ls --help", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    main()

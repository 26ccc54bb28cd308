"""`improv site`: a website with which people write programs without installing anything."""

from __future__ import annotations

from pathlib import Path

import click

from improv_core.commands.echo import echo
from improv_core.website.build import build


@click.command("site")
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
@click.option(
    "--pyodide",
    metavar="FOLDER",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("node_modules", "pyodide"),
    show_default=True,
    help="The folder of the npm package pyodide.",
)
def command(folder: Path, pyodide: Path) -> None:
    """Build a website in FOLDER, on which people write programs and play them in the simulator.

    All of Improv runs in their browsers: nothing is installed, and nothing they write leaves it. Any web server can
    serve the folder.
    """
    files = build(folder, pyodide)
    echo(f"{folder}: {len(files)} files, {sum(files.values()) / 1e6:.1f} MB; serve it with any web server, such as")
    echo(f"  python3 -m http.server --bind 127.0.0.1 --directory {folder}")

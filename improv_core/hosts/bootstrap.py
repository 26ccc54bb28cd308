"""Runs on another machine before anything of ours is there: it gets the far end of a link, and becomes it.

Its source travels as the first line (`bundle.boot_line`), so it imports nothing of ours, and Python 3.6 must be able to
read it, to report that it is too old.
"""

import hashlib
import io
import json
import os
import shutil
import sys
import zipfile
from pathlib import Path
from typing import Any, List  # noqa: UP035

MIN_PYTHON = (3, 10)
KEPT = 2


def begin(digest: str, size: int, arguments: List[str]) -> None:  # noqa: UP006
    """Become the far end whose bundle has this hash and size. Requests the bundle unless it is in the cache here."""
    os.chdir(os.path.abspath(os.sep))  # noqa: PTH100
    paths = [path for path in os.environ.pop("PYTHONPATH", "").split(os.pathsep) if Path(path).is_absolute()]
    if paths:
        os.environ["PYTHONPATH"] = os.pathsep.join(paths)
    python = list(sys.version_info[:3])
    if tuple(python) < MIN_PYTHON:
        say(python=python, problem="old")
        return
    stages = cache_folder() / "improv" / "stages"
    folder = stages / digest
    wanted = not folder.is_dir()
    say(python=python, wants=wanted)
    try:
        if wanted:
            data = read(size)
            if hashlib.sha256(data).hexdigest() != digest:
                say(problem="torn")
                return
            unpack(data, folder)
        os.utime(str(folder))
        tidy(stages, digest)
    except OSError as error:
        say(problem="disk", why=error.strerror or "it can't be used", where=str(stages))
        return
    say(begins=True)
    os.execv(sys.executable, [sys.executable, str(folder / "improv_core" / "hosts"), "far", *arguments])


def say(**fields: Any) -> None:
    """Send a line to the near end, which knows ours by their first word, whatever a shell has printed before."""
    os.write(1, b"\nimprov " + json.dumps(fields).encode() + b"\n")


def cache_folder() -> Path:
    """Return the folder for data that can be fetched again."""
    named = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return named if named.is_absolute() else Path.home() / ".cache"


def read(size: int) -> bytes:
    """Read this many bytes of standard input and no more; fewer if it ends."""
    read = []
    while size:
        data = os.read(0, min(size, 65536))
        if not data:
            break
        read.append(data)
        size -= len(data)
    return b"".join(read)


def unpack(data: bytes, folder: Path) -> None:
    """Write a bundle into a folder that appears only once it is complete, even if the power fails."""
    new = folder.with_name("{}.{}".format(folder.name, os.getpid()))  # noqa: UP032
    new.mkdir(mode=0o700, parents=True)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as bundle:
            bundle.extractall(str(new))
        os.sync()
        try:
            new.rename(folder)
        except OSError:
            if not folder.is_dir():  # otherwise, another link has brought it meanwhile
                raise
    finally:
        shutil.rmtree(str(new), ignore_errors=True)


def tidy(stages: Path, digest: str) -> None:
    """Remove incomplete folders, and all but the latest of the other versions."""
    others = []
    for path in stages.iterdir():
        version, _, maker = path.name.partition(".")
        if len(version) == len(digest) and path.name != digest:
            if not maker:
                others.append(path)
            elif not Path("/proc", maker).is_dir():
                shutil.rmtree(str(path), ignore_errors=True)
    for path in sorted(others, key=lambda path: path.stat().st_mtime)[:-KEPT]:
        shutil.rmtree(str(path), ignore_errors=True)

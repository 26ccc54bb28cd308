"""Builds the website: the page, Pyodide, and all Python files that run in the browser. No file of it names a host."""

from __future__ import annotations

import gzip
import io
import json
import shutil
import zipfile
from collections.abc import Iterator, Mapping
from hashlib import sha256
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from improv_core import LineError
from improv_core.page.files import FOLDER, page_files
from improv_core.page.gallery import examples, guide_files, songs

MARK = "improv-site.json"
"""The file that marks a folder as a website that we have built, so that it may be built again."""
PYODIDE = ("pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip", "pyodide-lock.json")
"""Files of the npm package `pyodide` that a browser needs: the `LIBRARY` is Python's own."""
PACKAGES = {
    "improv_core": (
        "__main__.py",
        "classroom/",
        "commands/",
        "hosts/",
        "ide/robots_file/",
        "outputs/ros/",
        "page/docs/",
        "page/examples/",
        "page/gallery.py",
        "page/guide.py",
        "website/build.py",
    ),
    "lark": ("tools/", "__pyinstaller/"),
    "segno": ("cli.py",),
}
"""Python packages that run in the browser, and the beginnings of the paths in each that don't."""
LIBRARY = "python_stdlib.zip"
NOT_IMPORTED = (
    *("_pyrepl/", "doctest.py", "ftplib.py", "imaplib.py", "mailbox.py", "multiprocessing/", "pdb.py", "poplib.py"),
    *("pydoc.py", "pydoc_data/", "smtplib.py", "unittest/", "wsgiref/", "xmlrpc/"),
)
"""Parts of Python's own library that nothing here imports: terminals, tests, mail, and servers."""
CODE = (".py", ".lark", ".json")
POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; "
    "connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'"
)
"""Content security policy: the website gets nothing from anywhere else."""
HEAD = '<meta charset="utf-8">'
SAME_TIME = (2020, 1, 1, 0, 0, 0)
"""The date of all files in an archive, so that equal files make equal archives."""


class SiteError(LineError):
    """The website can't be built. The message is one line that says what to do."""


def build(folder: Path, pyodide: Path) -> Mapping[str, int]:
    """Build the website in a folder that is new, empty, or of an earlier build. Returns the bytes of each file.

    `pyodide` is the folder of the npm package of that name. Raises SiteError and OSError.
    """
    if lacking := [name for name in PYODIDE if not (pyodide / name).is_file()]:
        raise SiteError(
            f"{pyodide} has no {lacking[0]}: run `npm install pyodide` here, or name the folder with --pyodide"
        )
    if folder.exists() and any(folder.iterdir()) and not (folder / MARK).is_file():
        raise SiteError(f"{folder} has other files in it: name a new folder")
    files = dict(_files(pyodide))
    hashes = [name.encode() + sha256(data).digest() for name, data in sorted(files.items())]
    version = sha256(b"".join(hashes)).hexdigest()[:16]
    site = json.dumps({"version": version, "files": ["./", *sorted(files)]})
    files["service-worker.js"] = f"self.SITE = {site}\n".encode() + _own("service-worker.js")
    files[MARK] = json.dumps({"version": version}).encode()
    if folder.exists():
        shutil.rmtree(folder)
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return {name: len(data) for name, data in files.items()}


def _files(pyodide: Path) -> Iterator[tuple[str, bytes]]:
    for name, path in page_files().items():
        yield name, path.read_bytes()
    yield "examples.json", examples()
    yield from songs().items()
    yield from guide_files().items()
    loaded = {"improv.zip": _archive(), **dict(_packed(pyodide / name) for name in PYODIDE)}
    yield from loaded.items()
    yield "worker.js", _own("worker.js")
    yield "index.html", _index(loaded).encode()


def _packed(path: Path) -> tuple[str, bytes]:
    """Return the name and content of a file of Pyodide. WebAssembly is compressed here, because most web servers don't
    do it. Raises SiteError."""
    data = path.read_bytes()
    if path.suffix == ".wasm":
        return f"pyodide/{path.name}.packed", gzip.compress(data, mtime=0)
    return f"pyodide/{path.name}", _library(path) if path.name == LIBRARY else data


def _library(path: Path) -> bytes:
    """Return Python's standard library with only the parts that are imported."""
    archive = io.BytesIO()
    try:
        with zipfile.ZipFile(path) as whole, zipfile.ZipFile(archive, "w") as file:
            for info in whole.infolist():
                if not info.filename.startswith(NOT_IMPORTED):
                    _add(file, info.filename, whole.read(info))
    except zipfile.BadZipFile:
        raise SiteError(f"{path} is broken: run `npm install pyodide` again") from None
    return archive.getvalue()


def _add(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    info = zipfile.ZipInfo(name, SAME_TIME)
    archive.writestr(info, data, zipfile.ZIP_DEFLATED, compresslevel=9)


def _index(loaded: Mapping[str, bytes]) -> str:
    """Return the page, which tells its worker the bytes of what it loads, those of `improv.zip`, and a hash of all."""
    code = sha256(b"".join(sha256(data).digest() for data in loaded.values())).hexdigest()[:16]
    fetched = sum(len(data) for name, data in loaded.items() if not name.endswith(".mjs"))  # a script imports those
    asked = f"worker.js?bytes={fetched}&amp;source={len(loaded['improv.zip'])}&amp;code={code}"
    page = (FOLDER / "index.html").read_text(encoding="utf-8")
    assert page.count(HEAD) == 1
    policy = f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
    names = " ".join(sorted(name.removeprefix("songs/") for name in songs()))
    metas = f'<meta name="improv-worker" content="{asked}">\n    <meta name="improv-songs" content="{names}">'
    return page.replace(HEAD, f"{HEAD}\n    {policy}\n    {metas}")


def _own(name: str) -> bytes:
    return (resources.files("improv_core.website") / name).read_bytes()


def _archive() -> bytes:
    """Return our package and lark's, as a zip archive."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        for package, left_out in PACKAGES.items():
            for name, data in _code(resources.files(package), ""):
                if not name.startswith(left_out):
                    _add(file, f"{package}/{name}", data)
    return archive.getvalue()


def _code(folder: Traversable, inside: str) -> Iterator[tuple[str, bytes]]:
    for each in sorted(folder.iterdir(), key=lambda each: each.name):
        if each.is_dir():
            yield from _code(each, f"{inside}{each.name}/")
        elif each.name.endswith(CODE):
            yield f"{inside}{each.name}", each.read_bytes()

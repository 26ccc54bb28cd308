"""The invariants of docs/architecture.md, read from the imports."""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from collections.abc import Sequence
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Literal, NamedTuple

ROOT = Path(__file__).parent.parent
CORE = sorted((ROOT / "improv_core").rglob("*.py"))
MODULES = [*CORE, *sorted((ROOT / "improv_ls").rglob("*.py"))]

BELOW_PROGRAM = ["slices", "values", "plain", "text", "diagnostics", "score", "syntax", "robots"]
PLAYING = ["protocol", "safety", "score"]
ROWS: dict[str, Sequence[str]] = {
    "improv_core": [],
    "plain": [],
    "slices": [],
    "values": [],
    "text": [],
    "diagnostics": ["plain", "text", "values"],
    "score": ["slices", "text", "values"],
    "syntax": ["slices", "values", "score", "diagnostics", "text"],
    "robots": ["slices", "syntax.vocabulary", "score", "diagnostics", "text"],
    "program": BELOW_PROGRAM,
    "ide": ["program", *BELOW_PROGRAM],
    "protocol": ["score", "plain"],
    "safety": ["protocol", "score"],
    "ipc": PLAYING,
    "player": PLAYING,
    "preview": ["protocol", "score"],
    "outputs": [],
    "outputs.cdr": ["score"],
    "outputs.recording": ["outputs.cdr", "protocol", "score"],
    "outputs.simulator": ["protocol", "score"],
    "outputs.devices": ["ipc", *PLAYING, "plain"],
    "outputs.thymio": ["outputs.devices", "score"],
    "outputs.ros": ["outputs.cdr", "ipc", "preview", *PLAYING, "plain"],
    "transcription": ["outputs.cdr", "robots", "score"],
    "stage": ["outputs", "ipc", "player", *PLAYING, "plain", "slices"],
    "page": [
        "stage",
        "outputs.simulator",
        "transcription.gestures",
        "ipc",
        "safety",
        "preview",
        "protocol",
        "ide",
        "program",
        *BELOW_PROGRAM,
    ],
    "music": ["ipc", "preview", *PLAYING, "plain"],
    "hosts": ["outputs.ros.setup", "outputs.ros.discovery", "ipc", *PLAYING, "plain"],
    "session": ["music", "ipc", *PLAYING],
    "storage": ["protocol", "safety.stops", "program", *BELOW_PROGRAM],
    "routines": ["protocol", "robots", "score", "slices"],
    "website": [
        "page",
        "storage.program_file",
        "session",
        "stage",
        "outputs.simulator",
        "ipc",
        *PLAYING,
        "program",
        *BELOW_PROGRAM,
    ],
    "classroom": [
        "website.build",
        "page",
        "session",
        "storage",
        "ipc",
        "protocol",
        "ide.merging",
        "program",
        *BELOW_PROGRAM,
    ],
}
ALL = list(ROWS)
ROWS |= {"commands": ALL, "improv_ls": ALL, "__main__": ["commands"]}
"""Packages that each folder or module may import besides itself and `improv_core/__init__.py`; of our packages,
everything in them."""

BARE = (
    "score",
    "protocol",
    "safety",
    "ipc",
    "player",
    "preview",
    "outputs",
    "page",
    "stage",
    "music",
    "hosts",
    "session",
)
"""Modules that run in ROS's Python: the standard library and Python 3.10, except for the libraries of outputs."""
LIBRARIES = {
    "pymunk": ["outputs/simulator/collisions.py"],
    "rclpy": [
        f"outputs/ros/{name}.py"
        for name in (
            "buttons",
            "clock",
            "graph",
            "joints/goals",
            "nodes",
            "output",
            "publisher/topics",
            "requests",
            "sensors/subscriptions",
            "topic",
        )
    ],
    "aiohttp": [
        *("classroom/student_server.py", "classroom/teacher_server.py"),
        *("page/routes.py", "page/song_file.py", "page/web_server.py"),
    ],
    "aalink": ["music/link.py"],
    "anyascii": ["ide/merging.py"],
    "mido": ["music/midi.py"],
    "defusedxml": ["robots/urdf.py", "transcription/svg_source.py"],
    "mcap": ["outputs/recording/recorder.py", "transcription/ros_source.py"],
    "pythonosc": ["music/osc_wire.py"],
    "resvg_py": ["commands/plot.py"],
    "serial": ["outputs/thymio/bus.py"],
    "svg": ["transcription/svg_source.py"],
}
SERVERS = {
    "improv_core.classroom.student_server",
    "improv_core.classroom.teacher_server",
    "improv_core.page.routes",
    "improv_core.page.web_server",
}
"""Modules that import aiohttp at once. All others import these only when they serve something."""
MESSAGES_OF_ROS = {
    "control_msgs",
    "trajectory_msgs",
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "nav_msgs",
    "rcl_interfaces",
    "rosgraph_msgs",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
    "visualization_msgs",
}


def name(path: Path) -> str:
    """Return `improv_core.player.player`; a package has the name of its folder."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def row(module: str) -> str:
    """Return the row of a module in the table: the longest that it is in."""
    inner = module.removeprefix("improv_core.")
    while inner not in ROWS:
        inner, _, last = inner.rpartition(".")
        if not last:
            return module
    return inner


OURS = {name(path) for path in MODULES}


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes(path: Path) -> Sequence[ast.AST]:
    return [*ast.walk(tree(path))]


class Import(NamedTuple):
    name: str  # `a.b.c` for `from a.b import c`
    when: Literal["for types", "at once", "later"]

    @property
    def package(self) -> str:
        return self.name.partition(".")[0]


@cache
def imports(path: Path) -> list[Import]:
    """Return all imports of a module: at once when it is imported, later inside functions, or for types alone."""
    found = []
    for top in tree(path).body:
        inside = isinstance(top, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        for_types = isinstance(top, ast.If) and ast.unparse(top.test) == "TYPE_CHECKING"
        when: Literal["for types", "at once", "later"] = "for types" if for_types else "later" if inside else "at once"
        for each in ast.walk(top):
            if isinstance(each, ast.Import):
                found += [Import(alias.name, when) for alias in each.names]
            elif isinstance(each, ast.ImportFrom):
                found += [Import(f"{each.module}.{alias.name}", when) for alias in each.names]
    return found


def ours(path: Path) -> set[str]:
    """Return our modules that a module imports, also for types alone."""
    return {each.name if each.name in OURS else each.name.rpartition(".")[0] for each in imports(path)} & OURS


def ours_at_once(path: Path) -> set[str]:
    """Return our modules that a module imports at once."""
    at_once = [each.name for each in imports(path) if each.when == "at once"]
    return {each if each in OURS else each.rpartition(".")[0] for each in at_once} & OURS


def packages(path: Path, *when: str) -> set[str]:
    """Return the packages that a module imports when it runs: at once or later, unless `when` selects one of these."""
    return {each.package for each in imports(path) if each.when in (when or ("at once", "later"))}


def within(module: str, allowed: str) -> bool:
    full = allowed if allowed == "improv_core" else f"improv_core.{allowed}"
    return module == full or (allowed != "improv_core" and module.startswith(f"{full}."))


def not_in_its_row(path: Path) -> set[str]:
    """Return the imports of a module that its row doesn't allow."""
    own = row(name(path))
    foreign = {module for module in ours(path) if row(module) not in (own, "improv_core")}
    return {module for module in foreign if not any(within(module, allowed) for allowed in ROWS[own])}


def test_modules_import_only_what_their_row_allows() -> None:
    assert {name(path): wrong for path in MODULES if (wrong := not_in_its_row(path))} == {}


def test_no_row_allows_a_later_one() -> None:
    rows = list(ROWS)
    later = {
        (own, allowed)
        for own, names in ROWS.items()
        for allowed in names
        if rows.index(row(f"improv_core.{allowed}")) >= rows.index(own)
    }
    assert later == set()


def test_no_module_imports_itself_in_a_circle() -> None:
    """Imports for types count too: a module depends on another one's types."""
    TopologicalSorter({name(path): ours(path) - {name(path)} for path in MODULES}).prepare()


def test_the_core_knows_nothing_of_lsp() -> None:
    assert [name(path) for path in CORE if packages(path) & {"pygls", "lsprotocol", "improv_ls"}] == []


def test_libraries_are_imported_in_their_place_and_lazily() -> None:
    importers = {library: [path for path in CORE if library in packages(path)] for library in LIBRARIES}
    within_core = {
        library: [path.relative_to(ROOT / "improv_core").as_posix() for path in paths]
        for library, paths in importers.items()
    }
    assert within_core == LIBRARIES
    at_once = {
        name(path) for library, paths in importers.items() for path in paths if library in packages(path, "at once")
    }
    assert at_once == SERVERS
    others = [path for path in MODULES if name(path) not in SERVERS]
    assert [name(path) for path in others if ours_at_once(path) & SERVERS] == []


def test_modules_that_ros_runs_use_only_the_standard_library() -> None:
    bare = [path for path in CORE if row(name(path)).partition(".")[0] in BARE]
    allowed = set(sys.stdlib_module_names) | {"improv_core"} | LIBRARIES.keys() | MESSAGES_OF_ROS
    assert {name(path): foreign for path in bare if (foreign := packages(path) - allowed)} == {}
    for path in bare:
        ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 10))


def test_the_process_that_reads_the_graph_sends_nothing() -> None:
    assert "publish(" not in (ROOT / "improv_core" / "outputs" / "ros" / "graph.py").read_text(encoding="utf-8")


def private_parts_of_pygls(path: Path) -> set[str]:
    return set(re.findall(r"\.protocol\.(?:_|fm\b)", path.read_text(encoding="utf-8")))


def test_the_private_parts_of_pygls_are_used_in_one_place() -> None:
    server = [path for path in MODULES if row(name(path)) == "improv_ls"]
    assert {path.name for path in server if private_parts_of_pygls(path)} <= {"framing.py"}


def test_columns_are_converted_in_one_place() -> None:
    converting = [path for path in MODULES if "utf-16" in path.read_text(encoding="utf-8").lower()]
    assert [path.name for path in converting] == ["positions.py"]


TO_PEOPLE = {
    "click.echo": ["commands/echo.py", "commands/format.py", "commands/screen.py"],
    "print": ["improv_ls/__main__.py", "framing.py", "page/answers.py", "page/meetings.py", "page/open_pages.py"],
    "window_show_message": ["improv_ls/editor.py"],
}
"""Functions that show text to people, and the modules that may call them: all others go through these, which escape
it."""


def test_text_reaches_people_in_few_places() -> None:
    found: dict[str, set[str]] = {function: set() for function in TO_PEOPLE}
    for path in MODULES:
        if not any(function.rpartition(".")[2] in path.read_text(encoding="utf-8") for function in TO_PEOPLE):
            continue
        called = {f".{ast.unparse(node.func)}" for node in nodes(path) if isinstance(node, ast.Call)}
        for function in TO_PEOPLE:
            if any(each.endswith(f".{function}") for each in called):
                found[function].add(path.as_posix())
    wrong = {
        path for function in TO_PEOPLE for path in found[function] if not path.endswith(tuple(TO_PEOPLE[function]))
    }
    assert wrong == set()


SHARED = {
    "Argument": 2,  # of a phrase; of a word
    "Condition": 2,  # of a movement; of a tree
    "Key": 2,  # of `improv.toml`; of a keyboard
    "Parallel": 2,  # a movement; a tree
    "Pause": 2,  # a movement; a message
    "Series": 2,  # a movement; a tree
}
"""Names that so many public classes share. Only remove rows: a new class gets its own name."""


def test_a_class_has_its_name_to_itself() -> None:
    counts = Counter(node.name for path in MODULES for node in nodes(path) if isinstance(node, ast.ClassDef))
    assert {name: count for name, count in counts.items() if count > 1 and not name.startswith("_")} == SHARED


IN_PIECES = {
    *("analysis", "cursor", "document_symbol", "formatter", "lexer"),  # of a text
    *("decoding", "dynamics", "strokes"),  # of a line of JSON, a motion, and a path
    *("algebra", "limits", "movement", "path", "ramps", "smoothing", "walk"),  # of a movement
}
"""Modules whose code uses *piece* for a part of something. A performance has a *score*. Only remove names."""


def identifiers(path: Path) -> set[str]:
    """Return the names that a module defines, and the variables and attributes that it uses."""
    found = nodes(path)
    defined = {node.name for node in found if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)}
    used = {node.id for node in found if isinstance(node, ast.Name)}
    return defined | used | {node.attr for node in found if isinstance(node, ast.Attribute)}


def test_performances_have_scores_and_not_pieces() -> None:
    assert {path.stem for path in MODULES if any("piece" in name.lower() for name in identifiers(path))} == IN_PIECES


def test_each_package_says_where_to_begin_reading() -> None:
    """Each in at most ten lines, and the modules that it names exist."""
    wrong = {}
    for path in MODULES:
        if path.name != "__init__.py" or path.parent == ROOT / "improv_core":
            continue
        doc = ast.get_docstring(tree(path)) or ""
        begin = " ".join(doc.split()).partition("Begin with ")[2]
        named = re.findall(r"`(\w+)`", re.split(r"[.;:,]", begin)[0])
        lacks = [each for each in named if name(path.parent / each) not in OURS]
        if not named or lacks or len(doc.splitlines()) > 10:
            wrong[name(path)] = doc
    assert wrong == {}


def test_the_top_level_is_what_was_agreed() -> None:
    agreed = {"pyproject.toml", "README.md", "improv_core", "improv_ls", "editors", "tests"}
    agreed |= {"docs", "examples", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md"}
    assert {path.name for path in ROOT.iterdir() if not path.name.startswith(".")} <= agreed

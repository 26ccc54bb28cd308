"""The invariants of docs/architecture.md, read from the imports."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
CORE = sorted((ROOT / "improv_core").rglob("*.py"))
MODULES = [*CORE, *sorted((ROOT / "improv_ls").rglob("*.py"))]

BELOW_PROGRAM = ["plain", "text", "diagnostics", "score", "syntax", "robots"]
ROWS: Mapping[str, Sequence[str]] = {
    "improv_core": [],
    "plain": [],
    "text": [],
    "diagnostics": ["plain", "text"],
    "score": ["text"],
    "syntax": ["score", "diagnostics", "text"],
    "robots": ["syntax.vocabulary", "score", "diagnostics", "text"],
    "program": BELOW_PROGRAM,
    "ide": ["program", *BELOW_PROGRAM],
    "stage": ["score", "plain", "text"],
    "playback": ["stage.protocol", "stage.discovery", "stage.urgent_queue", "stage.tickets", "score"],
    "services": ["playback", "stage.protocol", "ide", "program", *BELOW_PROGRAM],
    "commands": ["improv_core", "services", "playback", "stage", "ide", "program", *BELOW_PROGRAM],
    "__main__": ["commands"],
    "improv_ls": ["improv_core", "services", "playback", "stage", "ide", "program", *BELOW_PROGRAM],
}
"""What each folder or module may import besides itself; of a package of ours, everything in it."""

BARE = ("score", "stage", "playback")
"""Folders that run in ROS's Python: the standard library and Python 3.10, the libraries of sinks aside."""
LIBRARIES = {
    "pymunk": ["stage/sinks/collisions.py"],
    "rclpy": [
        "stage/graph.py",
        *(
            f"stage/sinks/{name}.py"
            for name in (
                "ros",
                "ros_listening",
                "ros_nodes",
                "ros_poses",
                "ros_publications",
                "ros_requests",
                "ros_subscriptions",
            )
        ),
    ],
    "aiohttp": ["stage/viewer/application.py"],
    "mcap": ["stage/sinks/recorder.py"],
    "resvg_py": ["commands/plot.py"],
    "tree_sitter": ["robots/toml_positions.py"],
    "tree_sitter_toml": ["robots/toml_positions.py"],
}
MESSAGES_OF_ROS = {
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "nav_msgs",
    "rcl_interfaces",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
    "visualization_msgs",
}


def name(path: Path) -> str:
    """`improv_core.stage.player`; a package goes by its folder."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def row(module: str) -> str:
    """The row of the table in which a module stands: its folder's, or its own where it stands at the top."""
    package, _, rest = module.partition(".")
    return rest.partition(".")[0] if package == "improv_core" and rest else package


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(node: ast.AST) -> Iterator[str]:
    """Every name that is imported, also for types alone: `a.b.c` for `from a.b import c`."""
    for each in ast.walk(node):
        if isinstance(each, ast.Import):
            yield from (alias.name for alias in each.names)
        elif isinstance(each, ast.ImportFrom):
            yield from (f"{each.module}.{alias.name}" for alias in each.names)


def ours(path: Path) -> set[str]:
    """The modules of ours that a module imports."""
    known = {name(each) for each in MODULES}
    found = {each if each in known else each.rpartition(".")[0] for each in imports(tree(path))}
    return found & known


def packages(path: Path) -> set[str]:
    """The packages that a module imports when it runs, at once or later."""
    return {module.partition(".")[0] for node in tree(path).body if not is_for_types(node) for module in imports(node)}


def is_for_types(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def at_import(path: Path) -> set[str]:
    """The packages imported as soon as the module is, not later inside functions, and not for types alone."""
    body = [
        node
        for node in tree(path).body
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not is_for_types(node)
    ]
    return {module.partition(".")[0] for module in imports(ast.Module(body, []))}


def within(module: str, allowed: str) -> bool:
    full = allowed if allowed == "improv_core" else f"improv_core.{allowed}"
    return module == full or (allowed != "improv_core" and module.startswith(f"{full}."))


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_a_module_imports_only_what_its_row_allows(path: Path) -> None:
    own = row(name(path))
    foreign = {module for module in ours(path) if row(module) != own}
    assert {module for module in foreign if not any(within(module, allowed) for allowed in ROWS[own])} == set()


def test_no_circle() -> None:
    """Counting imports for types too: who needs another's types depends on it."""
    TopologicalSorter({name(path): ours(path) - {name(path)} for path in MODULES}).prepare()


@pytest.mark.parametrize("path", CORE, ids=name)
def test_the_core_knows_nothing_of_lsp(path: Path) -> None:
    assert packages(path).isdisjoint({"pygls", "lsprotocol", "improv_ls"})


@pytest.mark.parametrize("library", LIBRARIES)
def test_a_library_is_imported_in_its_place_and_lazily(library: str) -> None:
    importers = [path for path in CORE if library in packages(path)]
    assert [path.relative_to(ROOT / "improv_core").as_posix() for path in importers] == LIBRARIES[library]
    assert all(library not in at_import(path) for path in importers)


@pytest.mark.parametrize("path", [path for path in CORE if row(name(path)) in BARE], ids=name)
def test_what_ros_runs_is_bare(path: Path) -> None:
    libraries = packages(path) - set(sys.stdlib_module_names) - {"improv_core"}
    assert libraries <= LIBRARIES.keys() | MESSAGES_OF_ROS
    ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 10))


def test_who_looks_at_the_graph_sends_nothing() -> None:
    assert "publish(" not in (ROOT / "improv_core" / "stage" / "graph.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", [path for path in MODULES if row(name(path)) == "improv_ls"], ids=name)
def test_the_private_parts_of_pygls_are_used_in_one_place(path: Path) -> None:
    used = {ast.unparse(node) for node in ast.walk(tree(path)) if isinstance(node, ast.Attribute)}
    if path.name != "framing.py":
        assert not {each for each in used if re.search(r"\.protocol\.(_|fm\b)", each)}


@pytest.mark.parametrize("path", MODULES, ids=name)
def test_columns_are_converted_in_one_place(path: Path) -> None:
    if path.name != "positions.py":
        assert "utf-16" not in path.read_text(encoding="utf-8").lower()


TO_PEOPLE = {
    "click.echo": ["commands/echo.py", "commands/format.py", "commands/terminal.py"],
    "print": ["improv_ls/__main__.py", "framing.py", "stage/graph.py", "viewer/answers.py", "viewer/pages.py"],
    "window_show_message": ["improv_ls/editor.py"],
}
"""What shows text to people, and the modules that may call it: all others go through these, which escape it."""


@pytest.mark.parametrize("function", TO_PEOPLE)
def test_text_reaches_people_in_few_places(function: str) -> None:
    def is_call(node: ast.AST) -> bool:
        return isinstance(node, ast.Call) and f".{ast.unparse(node.func)}".endswith(f".{function}")

    callers = {path.as_posix() for path in MODULES if any(is_call(node) for node in ast.walk(tree(path)))}
    assert {path for path in callers if not path.endswith(tuple(TO_PEOPLE[function]))} == set()


def test_the_top_level_is_what_was_agreed() -> None:
    agreed = {"pyproject.toml", "README.md", "improv_core", "improv_ls", "editors", "tests"}
    agreed |= {"docs", "examples", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md"}
    assert {path.name for path in ROOT.iterdir() if not path.name.startswith(".")} <= agreed

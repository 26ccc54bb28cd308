"""The invariants of docs/architecture.md, read from the imports."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
CORE = sorted((ROOT / "improv_core").rglob("*.py"))
STAGE = [path for path in CORE if "stage" in path.parts]
BARE = [
    ROOT / "improv_core" / f"{name}.py"
    for name in ("__init__", "drawing", "motion", "movement", "path", "profiles", "score", "world")
]
BARE += [ROOT / "improv_core" / "text.py", *STAGE]
LIBRARIES = {
    "pymunk": ["stage/sinks/collisions.py"],
    "rclpy": ["stage/graph.py", "stage/sinks/ros.py"],
    "aiohttp": ["stage/viewer/server.py"],
    "mcap": ["stage/sinks/recorder.py"],
    "resvg_py": ["plotting.py"],
}


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def imports(tree: ast.AST) -> Iterator[str]:
    """The top-level packages that are imported when this is run, those for types alone left out."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
        else:
            yield from imports(node)


def packages(path: Path) -> set[str]:
    return {module.split(".")[0] for module in imports(ast.parse(path.read_text(encoding="utf-8")))}


def at_import(path: Path) -> set[str]:
    """The packages imported as soon as the module is, not later inside functions."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    tree.body = [node for node in tree.body if not isinstance(node, ast.FunctionDef | ast.ClassDef)]
    return {module.split(".")[0] for module in imports(tree)}


@pytest.mark.parametrize("path", CORE, ids=name)
def test_the_core_knows_nothing_of_lsp(path: Path) -> None:
    assert packages(path).isdisjoint({"pygls", "lsprotocol", "improv_ls"})


@pytest.mark.parametrize("library", LIBRARIES)
def test_a_stages_library_is_imported_in_its_place_and_lazily(library: str) -> None:
    importers = [path for path in CORE if library in packages(path)]
    assert [name(path) for path in importers] == [f"improv_core/{place}" for place in LIBRARIES[library]]
    assert all(library not in at_import(path) for path in importers)


def test_who_looks_at_the_graph_sends_nothing() -> None:
    assert "publish(" not in (ROOT / "improv_core" / "stage" / "graph.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", BARE, ids=name)
def test_the_stage_needs_only_the_standard_library(path: Path) -> None:
    libraries = packages(path) - set(sys.stdlib_module_names) - {"improv_core"}
    assert libraries <= {"pymunk", "aiohttp", "rclpy", "geometry_msgs", "std_srvs", "mcap"}


@pytest.mark.parametrize("path", BARE, ids=name)
def test_the_stage_uses_our_package_only_as_far_as_it_is_bare(path: Path) -> None:
    bare = {name(each).removesuffix(".py").removesuffix("/__init__").replace("/", ".") for each in BARE}
    used = {module for module in imports(ast.parse(path.read_text())) if module.startswith("improv_core")}
    assert {module for module in used if module != "improv_core"} <= bare


@pytest.mark.parametrize("path", BARE, ids=name)
def test_the_stage_is_python_3_10(path: Path) -> None:
    ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 10))


@pytest.mark.parametrize("path", [*CORE, *(ROOT / "improv_ls").rglob("*.py")], ids=name)
def test_columns_are_converted_in_one_place(path: Path) -> None:
    if path.name != "positions.py":
        assert "utf-16" not in path.read_text(encoding="utf-8").lower()


def test_the_top_level_is_what_was_agreed() -> None:
    agreed = {"pyproject.toml", "README.md", "improv_core", "improv_ls", "editors", "tests"}
    agreed |= {"docs", "examples", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md"}
    assert {path.name for path in ROOT.iterdir() if not path.name.startswith(".")} <= agreed

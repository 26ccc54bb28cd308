"""The habits of docs/style.md that a program can check: `python -m tests.style [--subject FILE | --subjects]`.

Without an option, it checks how docstrings begin; with `--subject`, the message of one commit; with `--subjects`, those
of all commits since the rule.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
RULED_SINCE = "2a85a154"
"""The last commit before the rule for subjects."""
LONGEST_SUBJECT = 72
NO_BEGINNING = re.compile(r"(What|Whether|Who|Whom|Whose|Which|Where|How)\b")
"""Words with which no docstring begins: it begins with a verb or a noun."""
NO_IMPERATIVE = re.compile(
    r"[^A-Z]|(?i:(an?|the|no|it|that|this|what|whom?|which|of|one|two|all|tests?|[a-z]+(ing|ed)|[a-z]*[^s\W]s)\b)"
)
"""Beginnings of subjects that are no imperatives: no capital letter, an article, another form of a verb."""
IMPERATIVES = ("Bring", "Embed", "Feed", "Focus", "Need", "Ring", "Seed", "Speed", "String", "Test ")
"""Imperatives that the pattern above would refuse."""


def main() -> int:
    parser = ArgumentParser(prog="python -m tests.style", description="Check habits of docs/style.md.")
    parser.add_argument("--subject", type=Path, metavar="FILE", help="check the message of one commit")
    parser.add_argument("--subjects", action="store_true", help="check those of all commits since the rule")
    chosen = parser.parse_args()
    if chosen.subject:
        wrong = wrong_subjects(chosen.subject.read_text(encoding="utf-8").splitlines()[:1])
    elif chosen.subjects:
        wrong = wrong_subjects(_subjects())
    else:
        wrong = wrong_docstrings()
    found = [*wrong]
    print(*found, sep="\n", end="\n" if found else "")
    return 1 if found else 0


def wrong_docstrings() -> Iterator[str]:
    """A line for each docstring, also of a value, that begins with a word of a question."""
    for folder in ("improv_core", "improv_ls", "tests", "editors"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            if "node_modules" not in path.parts:
                for line, text in docstrings(path.read_text(encoding="utf-8")):
                    if NO_BEGINNING.match(text):
                        yield f"{path.relative_to(ROOT)}:{line}: begin with a verb or a noun: {text.splitlines()[0]}"


def docstrings(source: str) -> Iterator[tuple[int, str]]:
    """The strings that stand alone as statements, with their lines."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno, node.value.value


def wrong_subjects(subjects: list[str]) -> Iterator[str]:
    """A line for each subject that is long, or no imperative."""
    for subject in subjects:
        if len(subject) > LONGEST_SUBJECT:
            yield f"longer than {LONGEST_SUBJECT} characters: {subject}"
        elif NO_IMPERATIVE.match(subject) and not subject.startswith((*IMPERATIVES, "Merge ", "Revert ")):
            yield f"begin with an imperative, such as Confirm: {subject}"


def _subjects() -> list[str]:
    """The subjects of all commits since the rule; of the latest one alone if the history is not here."""
    for commits in (f"{RULED_SINCE}..HEAD", "-1"):
        git = ["git", "-C", str(ROOT), "log", "--no-merges", "--format=%s", commits]
        found = subprocess.run(git, capture_output=True, text=True, check=False)
        if found.returncode == 0:
            return found.stdout.splitlines()
    return []


if __name__ == "__main__":
    sys.exit(main())

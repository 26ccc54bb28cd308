"""The lines of an improv.toml that fold into the first one."""

from __future__ import annotations

from improv_core.ide.robots_file.structure import folds
from improv_core.text import LineIndex


def check(text: str, *expected: str) -> None:
    assert [f"{fold.first}-{fold.last} {fold.kind}" for fold in folds(LineIndex(text))] == list(expected)


def test_sections_values_comments_and_regions_fold() -> None:
    check("[robots.a]\nprofile = 'husky'\n\n# about b\n[robots.b]\n\n[world]\nsize = [6, 4]", "0-1 code", "6-7 code")
    check("[world]\nwalls = [\n  [0, 0, 1, 1],\n]\nsize = [6,\n  4]\n", "0-5 code", "1-2 code", "4-5 code")
    check("# one\n# two\n# region a\n[ros]\n# endregion\n", "0-1 comment", "2-4 region")
    check("[ros]\nnode = '''\n# one\n# two\n'''\n", "0-4 code", "1-4 code")

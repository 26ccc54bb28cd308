"""The history: the kept programs, their order, and files that can't be read."""

from __future__ import annotations

import stat
import subprocess
import sys
from datetime import datetime, timedelta, timezone
from pathlib import Path

import pytest

from improv_core.storage import history
from improv_core.storage.history import MAX_VERSIONS, HistoryError, keep, read

NOON = datetime(2026, 11, 22, 12, tzinfo=timezone.utc)


def check(played: str, kept: str) -> None:
    """Play programs one second after another, each written `FILE:TEXT`; compare the kept ones, the latest first."""
    for second, each in enumerate(played.split()):
        file, _, text = each.partition(":")
        keep(f"/dances/{file}", text, NOON + timedelta(seconds=second))
    found = read()
    assert [f"{Path(each.file).name}:{each.text}" for each in found.programs] == kept.split()
    assert found.complaint is None


@pytest.mark.parametrize(
    ("played", "kept"),
    [
        ("", ""),
        ("a:1 a:2", "a:2 a:1"),
        ("a:1 a:1 a:2 a:2 a:1", "a:1 a:2 a:1"),
        ("a:1 b:1 a:1 b:1", "b:1 a:1"),  # two servers that play in turns
    ],
)
def test_every_program_is_kept_and_the_same_twice_in_a_row_once(state: Path, played: str, kept: str) -> None:
    check(played, kept)


@pytest.mark.parametrize(
    "text", ["", "\n", "a\r\nb", "# played x\n", "r $ forward 😀\n\n", "\ufeffr $ left\u2028", "\x00"]
)
def test_a_program_is_kept_word_for_word(state: Path, text: str) -> None:
    file = '/a "folder"\n with 😀.improv'
    keep(file, text, NOON)
    (program,) = read().programs
    assert (program.file, program.text, program.at) == (file, text, NOON)


def test_only_the_last_ones_are_kept_and_only_their_user_can_read_them(state: Path) -> None:
    kept = [f"a:{n}" for n in range(MAX_VERSIONS + 2)]
    check(" ".join(kept), " ".join(reversed(kept[2:])))
    assert len(list(state.iterdir())) == MAX_VERSIONS
    assert {stat.S_IMODE(path.stat().st_mode) for path in state.iterdir()} == {0o600}
    assert stat.S_IMODE(state.stat().st_mode) == 0o700


def test_damaged_files_are_counted_and_stay_and_the_rest_is_read(state: Path) -> None:
    check("a:1 a:2 a:3", "a:3 a:2 a:1")
    newest, middle, _ = sorted(state.iterdir(), reverse=True)
    for path, damage in ((newest, b"\xff\xff"), (middle, b'# played never at "a"\n'), (state / "5.improv", b"")):
        path.write_bytes(damage)
    assert [each.text for each in read().programs] == ["1"]
    assert read().complaint == (
        f"3 files of the history can't be read and were left out: look at them in {history.folder()}"
    )
    keep("/dances/a", "4", NOON + timedelta(minutes=1))
    assert [each.text for each in read().programs] == ["4", "1"]
    assert newest.read_bytes() == b"\xff\xff"


def test_an_unwritable_history_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "improv").write_text("a file where the folder should be")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with pytest.raises(HistoryError, match=r"^this program was not kept in the history: .*: not a directory$"):
        keep("/dances/a", "1", NOON)
    assert read().programs == []


def test_a_full_disk_leaves_nothing_half_written(state: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check("a:1", "a:1")

    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(HistoryError, match=r"no space left on device$"):
        keep("/dances/a", "2", NOON + timedelta(minutes=1))
    assert [each.text for each in read().programs] == ["1"]
    assert len(list(state.iterdir())) == 1


def test_several_processes_lose_nothing(state: Path) -> None:
    script = (
        "import sys; from datetime import datetime, timezone; from improv_core.storage.history import keep\n"
        "for n in range(20): keep(sys.argv[1], str(n), datetime.now(timezone.utc))"
    )
    writers = [subprocess.Popen([sys.executable, "-c", script, f"/dances/{name}"]) for name in "ab"]
    assert [writer.wait(60) for writer in writers] == [0, 0]
    for name in "ab":
        assert [each.text for each in read().of(f"/dances/{name}")] == [str(n) for n in reversed(range(20))]


def test_it_can_be_turned_off_and_is_never_in_the_workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert history.folder() == tmp_path / ".local" / "state" / "improv" / "history"
    monkeypatch.setenv("IMPROV_HISTORY", "off")
    keep("/dances/a", "1", NOON)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("before", "after", "news"),
    [
        ("beat 60\nr $ left", "beat 60\nr $ right", "r $ right"),
        ("beat 60\n# a dance\nr $ left", "beat 60\nr $ left", "r $ left"),
        ("", "\n\n  # a dance\nr $ left", "# a dance"),
        ("", "", ""),
    ],
)
def test_the_line_that_is_new_tells_versions_apart(state: Path, before: str, after: str, news: str) -> None:
    keep("/dances/a", before, NOON)
    keep("/dances/b", after, NOON + timedelta(seconds=1))
    keep("/dances/a", after, NOON + timedelta(seconds=2))
    found = read()
    assert found.news(found.programs[0]) == news

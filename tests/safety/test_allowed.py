"""The hosts that may be used, and names that are no host at all."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from improv_core.safety.allowed import HostError, approve, approved, approved_file, checked, is_approved, withdraw


@pytest.fixture(autouse=True)
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    return tmp_path / "config"


@pytest.mark.parametrize("host", ["anna", "anna.local", "pi@anna.local", "pi@10.0.0.7:2222", "a_b-c@x-1"])
def test_a_plain_name_is_a_host(host: str) -> None:
    assert checked(host) == host


@pytest.mark.parametrize(
    "host",
    [
        "",
        "-oProxyCommand=touch /tmp/x",
        "pi@-oProxyCommand=x",
        "anna;reboot",
        "$(reboot)",
        "`reboot`",
        "anna local",
        "anna\nlocal",
        "anna\n",
        "pi@anna@local",
        "ssh://anna",
        "anna:0",
        "anna:65536",
        "anna:-1",
        "../anna",
        "a/b",
        "pi@-x",
        "änna",
        "a" * 256,
        "%h",
    ],
)
def test_anything_else_is_refused(host: str) -> None:
    with pytest.raises(HostError, match="is not a host"):
        checked(host)
    with pytest.raises(HostError):
        approve(host)
    assert approved() == []


def test_a_host_is_approved_once_it_was_allowed_and_until_it_is_removed() -> None:
    assert not is_approved("pi@anna")
    approve("pi@anna")
    approve("pi@bob")
    approve("pi@anna")
    assert approved() == ["pi@anna", "pi@bob"]
    assert is_approved("pi@anna")
    assert not is_approved("anna")
    assert stat.S_IMODE(approved_file().stat().st_mode) == 0o600
    assert [withdraw("pi@anna"), withdraw("pi@anna")] == [True, False]
    assert approved() == ["pi@bob"]
    assert [*approved_file().parent.iterdir()] == [approved_file()]


def test_a_folder_that_is_not_absolute_is_not_used(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A project could hold it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", "config")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert approved_file() == tmp_path / "home" / ".config" / "improv" / "hosts"


def test_a_file_that_cannot_be_read_allows_nothing() -> None:
    approved_file().mkdir(parents=True)
    with pytest.raises(HostError, match=r"can't be read"):
        is_approved("anna")

"""VS Code offers the server's settings, with the same defaults, and takes none from an untrusted workspace."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path

from improv_ls.server import COMMANDS
from improv_ls.settings import Settings, read_settings

# VS Code shows pictures in a hover; elsewhere their code would be shown. Without a value, onSave is restart as well.
DEFAULTS = Settings(on_save="restart", hover_pictures=True, inlay_hints_playing=False)
MANIFEST = json.loads((Path(__file__).parents[2] / "editors/vscode/package.json").read_text(encoding="utf-8"))
OFFERED = MANIFEST["contributes"]["configuration"]["properties"]


def test_an_untrusted_workspace_sets_nothing() -> None:
    assert MANIFEST["capabilities"]["untrustedWorkspaces"]["restrictedConfigurations"] == list(OFFERED)


def test_an_untrusted_workspace_can_stop_robots() -> None:
    client = (Path(__file__).parents[2] / "editors/vscode/src/client.ts").read_text(encoding="utf-8")
    (harmless,) = re.findall(r"const HARMLESS = (\[.*?\]);", client)
    assert {name for name, command in COMMANDS.items() if command == COMMANDS["improv.stop"]} <= set(
        json.loads(harmless)
    )


def test_no_workspace_names_a_program_or_a_file_to_write_or_opens_a_port_to_the_network() -> None:
    machines = {name.removeprefix("improv.") for name, about in OFFERED.items() if about.get("scope") == "machine"}
    assert machines == {"ros.python", "osc.network", "server.path"}


def test_settings_are_the_servers() -> None:
    settings = {name.removeprefix("improv."): about for name, about in OFFERED.items()}
    for its_own in ("server.path", "highlight.playing"):
        del settings[its_own]
    assert len(settings) == len(fields(Settings))
    for name, about in settings.items():
        unknown_to_the_server = read_settings({name: ["neither"]}, Settings()) == (Settings(), [])
        assert not unknown_to_the_server, name
        assert read_settings({name: about["default"]}, DEFAULTS) == (DEFAULTS, []), name
        for value in about.get("enum", []):
            assert read_settings({name: value}, Settings())[1] == [], name

"""A real Emacs with the package: its screen, the robot's movement, and no process left after the end."""

from __future__ import annotations

import asyncio
import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.editors import colors, robot
from tests.editors.editors import LIMIT, ROOT, find, nothing_left, slow_server
from tests.editors.terminal import Terminal
from tests.waiting import until

pytestmark = pytest.mark.slow("drives Emacs")

PACKAGE = ROOT / "editors" / "emacs"
SCRIPTS = Path(__file__).parent / "emacs"
PROGRAM = "beat 120\n\nturtle1 $ repeat (forward lft)\n"
INDENTED = """\
beat 60
star = ( # five
  [
    forward || slow 2 (
      left right
    )
  ]
  repeat 2 (left
    right) rest
) || halfleft
left_open = (forward
  [left
r1 r2 $ (star
  || [up
    up # a = (
  ]
)
answer n (m) = (
  m reflect sagittal
)
---
r1 $ if near left
  else (
    right
  )
# after it
--- finale
room 6 4
ada at circle 2 # (
bo is puppet
left_open (m) = (m
  bar 3
r2 $ left
"""
LINT = """
(setq native-comp-enable-subr-trampolines nil byte-compile-warnings t
      byte-compile-dest-file-function (lambda (file) (expand-file-name (concat (file-name-base file) ".elc"))))
(require 'checkdoc)
(dolist (file command-line-args-left)
  (unless (byte-compile-file file) (kill-emacs 1))
  (checkdoc-file file))
(kill-emacs 0)
"""

VERSION = re.compile(r'^(?:;; Version: |\(define-package "improv-mode" ")([\d.]+)', re.MULTILINE)


@pytest.fixture
def emacs() -> str:
    return find("EMACS", "emacs/usr/bin/emacs")


@pytest.mark.timeout(LIMIT + 60)
def test_session(emacs: str, tmp_path: Path) -> None:
    with nothing_left() as env:
        run(command(emacs, "session.el", "robots.el"), tmp_path, surroundings(env, tmp_path, PROGRAM))


@pytest.mark.timeout(LIMIT + 60)
def test_a_server_that_is_late_or_killed_and_a_killed_emacs(emacs: str, tmp_path: Path) -> None:
    """The robots stop with an Emacs that is killed while they dance."""
    server, gate = slow_server(tmp_path)
    with nothing_left() as env:
        late = {"IMPROV_SLOW": str(server), "IMPROV_GATE": str(gate)}
        environment = surroundings({**env, **late}, tmp_path, PROGRAM.replace("lft", "left"))
        line = command(emacs, "server.el")
        pipe, both = subprocess.PIPE, subprocess.STDOUT
        with subprocess.Popen(line, cwd=tmp_path, env=environment, stdout=pipe, stderr=both, text=True) as editor:
            assert editor.stdout
            lines: list[str] = []
            try:
                for said in editor.stdout:
                    lines.append(said)
                    if said.startswith("page: "):
                        break
                assert lines[-1].startswith("page: "), "".join(lines)
                asyncio.run(robot.moves(lines[-1].split()[1]))
            finally:
                editor.kill()


@pytest.mark.timeout(LIMIT)
def test_keys_and_the_screen(emacs: str, tmp_path: Path) -> None:
    program = PROGRAM.replace("120", "30").replace("lft", "left")
    with nothing_left() as env:
        environment = surroundings(env, tmp_path, program)
        init = tmp_path / ".emacs.d" / "early-init.el"  # so that it doesn't compile its files for the terminal
        init.parent.mkdir()
        init.write_text("(setq native-comp-jit-compilation nil)")
        options = ["--no-site-file", "--no-splash", "-nw"]
        line = [emacs, *options, "-l", str(SCRIPTS / "init.el"), environment["IMPROV_PROGRAM"]]
        with Terminal(tmp_path / "tmux", line, environment) as terminal:
            terminal.see("[eglot:")  # in the mode line, once the server runs
            plain = terminal.background("left")

            def wait_until_lit(word: str) -> None:
                until(lambda: terminal.background(word) != plain, terminal.screen)

            terminal.type("C-c", "C-c")
            terminal.see("▶ turtle1 ∞, endless at beat 30, simulator")
            terminal.see("(Improv ▶ beat ")
            terminal.see("/∞, 30 beats/min, simulator")
            for word in ("forward", "left"):
                wait_until_lit(word)
            terminal.type("C-c", "C-k")
            terminal.see("(Improv ■ stopped")
            assert terminal.background("forward") == terminal.background("left") == plain
            terminal.type("M-<", "C-o", "C-c", "C-b")  # an edit, so that words are where they were not
            wait_until_lit("forward")
            terminal.type("C-c", "C-p")
            terminal.see("(Improv ‖")
            terminal.type("C-x", "C-c")
            terminal.see("Save file")
            terminal.type("n")
            terminal.see("exit anyway?")
            terminal.type("yes", "Enter")


def test_lines_in_brackets_are_indented(emacs: str, tmp_path: Path) -> None:
    flat = "".join(line.lstrip() + "\n" for line in INDENTED.splitlines())
    done = run(command(emacs, "indent.el"), tmp_path, surroundings(os.environ, tmp_path, PROGRAM), flat)
    assert done.stdout == INDENTED, done.stderr


def test_colors_before_the_server_answers(emacs: str, tmp_path: Path) -> None:
    done = run(command(emacs, "colors.el"), tmp_path, surroundings(os.environ, tmp_path, colors.PROGRAM))
    faces = {
        "beat": "preprocessor",
        "opening": "preprocessor",
        "choice": "constant",
        "profile": "constant",
        "title": "variable-name",
        "scene": "preprocessor",
        "primitive": "function-call",
        "transformer": "keyword",
        "conditional": "keyword",
        "plane": "constant",
        "name": "variable-name",
        "parameter": "variable-use",
        "robot": "type",
        "number": "number",
        "operator": "operator",
        "comment": "comment",
    }
    expected = colors.expected({kind: f"font-lock-{face}-face" for kind, face in faces.items()}, plain="nil")
    found = json.loads(done.stdout.replace("comment-delimiter", "comment"))
    assert found == expected


def test_is_installed_as_its_page_says(emacs: str, tmp_path: Path) -> None:
    environment = surroundings(os.environ, tmp_path, PROGRAM)
    install = f'(package-install-file "{PACKAGE}/")'
    batch = [emacs, "--batch", "--eval", "(setq native-comp-enable-subr-trampolines nil)"]
    done = run([*batch, "-f", "package-initialize", "--eval", install], tmp_path, environment)
    assert "Warning" not in done.stdout + done.stderr
    tell = "(princ (list major-mode (fboundp 'improv-stop)))"
    done = run(
        [*batch, "-f", "package-initialize", environment["IMPROV_PROGRAM"], "--eval", tell], tmp_path, environment
    )
    assert done.stdout == "(improv-mode t)"


def test_compiles_without_warnings_and_reads_as_emacs_packages_do(emacs: str, tmp_path: Path) -> None:
    about, code = (PACKAGE / name for name in ("improv-mode-pkg.el", "improv-mode.el"))
    assert VERSION.findall(about.read_text()) == VERSION.findall(code.read_text())
    files = sorted(str(path) for path in PACKAGE.glob("*.el") if path != about)
    script = tmp_path / "lint.el"
    script.write_text(LINT)
    done = run([emacs, "-Q", "--batch", "-L", str(PACKAGE), "-l", str(script), *files], tmp_path, os.environ)
    assert done.stderr == ""
    assert len(list(tmp_path.glob("*.elc"))) == len(files)


def command(emacs: str, *scripts: str) -> list[str]:
    loads = [word for script in ("init.el", *scripts) for word in ("-l", str(SCRIPTS / script))]
    return [emacs, "-Q", "--batch", *loads]


def run(line: list[str], folder: Path, env: Mapping[str, str], text: str = "") -> subprocess.CompletedProcess[str]:
    """Run an Emacs in batch mode, which must succeed."""
    done = subprocess.run(line, cwd=folder, env=env, input=text, capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stdout + done.stderr
    return done


def surroundings(env: Mapping[str, str], folder: Path, program: str) -> dict[str, str]:
    """Return the environment of an Emacs that opens a program in its own folder."""
    path = folder / "dance.improv"
    path.write_text(program)
    return {
        **env,
        "HOME": str(folder),
        "IMPROV_ROOT": str(ROOT),
        "IMPROV_PACKAGE": str(PACKAGE),
        "IMPROV_PROGRAM": str(path),
        "IMPROV_PYTHON": sys.executable,
        "LANG": "C.UTF-8",
    }

"""Record the `initialize` of an editor: `python -m tests.ls.clients.record NAME`, where NAME.json is the record.

This is a language server that notes the first message and ends. Set up the editor as docs/editors.md describes, but
with a script in place of `improv-ls` that goes to this repository and runs the command. Then open a program in a folder
of your home.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

HOME = "/home/person"
"""The name in a record of your home."""


def main(name: str) -> None:
    stream = sys.stdin.buffer
    length = 0
    while line := stream.readline().strip():
        if found := re.match(rb"(?i)content-length: *(\d+)", line):
            length = int(found[1])
    record = {"source": "recorded", "initialize": {**json.loads(stream.read(length))["params"], "processId": None}}
    text = json.dumps(record, indent=1, ensure_ascii=False, sort_keys=True).replace(str(Path.home()), HOME)
    Path(__file__).with_name(f"{name}.json").write_text(f"{text}\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])

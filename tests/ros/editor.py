"""An editor in its own process, for a test to kill: it owns a server, and saves the program in its argument.

It prints the server's process id. A line of input makes it deaf: it makes the server write more than a pipe holds, and
halts itself. When continued, it prints the server's complaints, and saves the program in that line's JSON.
"""

from __future__ import annotations

import json
import os
import signal
import sys

from tests.ros.dance import Server

WRONG = "turtle1 $ forwrd\n" * 1000
"""A program whose diagnostics take more than 64 KiB."""

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # as SIGTERM and SIGKILL do, it ends us without a message
    with Server(os.environ) as server:
        server.save(sys.argv[1])
        print(server.pid, flush=True)
        for line in sys.stdin:
            server.type(WRONG)
            os.kill(os.getpid(), signal.SIGSTOP)
            server.wait_for_line("all robots were stopped")
            print(json.dumps(server.complaints()), flush=True)
            server.save_until_it_plays(json.loads(line))

"""An editor in a process of its own, to be killed: it owns a server, and saves the program that is its argument.

Prints the process id of the server. A line of input makes it deaf: it has the server say more than a pipe holds, and
stops itself. If it is continued, it prints what the server complained of, and saves the program in that line's JSON.
"""

from __future__ import annotations

import json
import os
import signal
import sys

from tests.ros.dance import Server

WRONG = "turtle1 $ forwrd\n" * 1000
"""Its diagnostics take more than 64 KiB."""

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # as SIGTERM and SIGKILL do, it ends us without a word
    with Server(os.environ) as server:
        server.save(sys.argv[1])
        print(server.pid, flush=True)
        for line in sys.stdin:
            server.type(WRONG)
            os.kill(os.getpid(), signal.SIGSTOP)
            server.wait_for_line("all robots were stopped")
            print(json.dumps(server.complaints()), flush=True)
            server.save(json.loads(line))

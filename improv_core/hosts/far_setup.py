"""The far end of a link that sets up ROS 2 on its machine. If its link ends, it ends and leaves nothing incomplete."""

from __future__ import annotations

import json
import os
import signal
import threading
from collections.abc import Callable

from improv_core.outputs.ros.setup.environment import SetupError
from improv_core.outputs.ros.setup.proof import Proof
from improv_core.outputs.ros.setup.setup import set_up


def set_up_here(proof: str, put: Callable[[bytes], None]) -> None:
    """Set up ROS 2 on the main thread, and `put` frames with the progress. `proof` is JSON."""
    topic, score = json.loads(proof)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a program that ssh starts may ignore it
    threading.Thread(target=_wait_for_end, daemon=True).start()
    try:
        set_up(lambda line: put(b"t%b\n" % line.encode()), Proof(topic, score))
    except SetupError as error:
        put(b"esetup %b\n" % str(error).replace("\n", " ").encode())
    except KeyboardInterrupt:
        pass
    else:
        put(b"idone\n")


def _wait_for_end() -> None:
    """Interrupt the main thread once standard input has ended: it then closes and removes unfinished work."""
    while os.read(0, 4_096):
        pass
    main = threading.main_thread().ident
    assert main
    signal.pthread_kill(main, signal.SIGINT)  # it may be waiting for an installer that prints nothing

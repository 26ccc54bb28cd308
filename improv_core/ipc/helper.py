"""A helper process that threads feed and read, so nobody waits for it. Standard library only.

Processes that stop robots are no such helpers: the stage itself feeds and reads its standby.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from improv_core.ipc.child import Child, Policy
from improv_core.protocol.decoding import ProtocolError, dumps, read_as

MAX_WAITING = 10_000
"""The most messages that may wait for the process. With more, it counts as hung and is killed."""

Make = Callable[[], Mapping[str, Any]]
"""Makes a message, on the thread that writes it, because that takes long."""


class Helper:
    """Starts a process that gets messages as lines of JSON.

    `hear` gets its messages, which are of the types in a union, and `ended` gets the reason why it has ended, or an
    empty line if none is known: both on a thread, and even after `close`.
    """

    def __init__(
        self,
        command: Sequence[str],
        policy: Policy,
        union: Any,
        hear: Callable[[Any], None],
        ended: Callable[[str], None],
    ) -> None:
        self._command = command
        self._policy = policy
        self._union = union
        self._hear = hear
        self._ended = ended
        self._queue: queue.SimpleQueue[Mapping[str, Any] | Make | None] = queue.SimpleQueue()
        self._child: Child | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def is_alive(self) -> bool:
        return self._thread.is_alive()

    def put(self, message: Mapping[str, Any] | Make) -> None:
        """Send it a message, after those before."""
        if self._queue.qsize() < MAX_WAITING:
            self._queue.put(message)
        else:
            self.kill()

    def close(self) -> None:
        """End it, without waiting."""
        self._queue.put(None)
        # The thread that writes can't end a process that hangs: it may wait until the process reads.
        patience = threading.Timer(self._policy.end, self.kill)
        patience.daemon = True
        patience.start()

    def wait(self, limit: float) -> None:
        """Wait until it has ended, and kill it after `limit` seconds."""
        self._thread.join(limit)
        self.kill()

    def kill(self) -> None:
        if self._child:
            self._child.kill()

    def _run(self) -> None:
        """Start the process and read from it, on a thread, because both may take long."""
        try:
            child = self._child = Child(self._command, self._policy)
        except OSError as error:
            self._ended(f"can't start: {error}")
            return
        threading.Thread(target=self._write, args=(child,), daemon=True).start()
        with suppress(EOFError):
            while True:
                for line in child.read():
                    with suppress(ProtocolError):
                        self._hear(read_as(line, self._union))
        self._queue.put(None)
        child.wait()
        self._ended(child.last_error)

    def _write(self, child: Child) -> None:
        with suppress(OSError):  # it has ended
            while (message := self._queue.get()) is not None:
                child.write(dumps(message() if callable(message) else message) + b"\n")
        child.close_input()

"""A way to an ssh server that delays all bytes, as a busy Wi-Fi does: ssh starts it as its ProxyCommand.

slow_link.py HOST PORT [--delay 0.002] [--jitter 0.098] [--loss 0.02] [--rate BYTES_PER_SECOND] [--seed 1]

Each piece of up to a packet waits the delay, and a random time of mean jitter/3, cut at the jitter. A lost piece comes
0.2 s later, as if it were sent again. Order is kept. It ends when either side does.
"""

from __future__ import annotations

import argparse
import heapq
import os
import random
import select
import socket
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

PACKET = 1_400
AGAIN = 0.2


@dataclass
class Way:
    """One direction: the pieces that wait, their times, and the time at which the last one arrives."""

    waiting: list[tuple[float, int, bytes]] = field(default_factory=list)
    free: float = 0.0
    count: int = 0

    def put(self, data: bytes, at: float, options: argparse.Namespace, dice: random.Random) -> None:
        for begin in range(0, len(data), PACKET):
            packet = data[begin : begin + PACKET]
            takes = options.delay + len(packet) / options.rate
            if options.jitter:
                takes += min(dice.expovariate(3 / options.jitter), options.jitter)
            if dice.random() < options.loss:
                takes += AGAIN
            self.free = max(self.free + len(packet) / options.rate, at + takes)
            self.count += 1
            heapq.heappush(self.waiting, (self.free, self.count, packet))

    def due(self, now: float) -> bytes:
        ready = b""
        while self.waiting and self.waiting[0][0] <= now:
            ready += heapq.heappop(self.waiting)[2]
        return ready


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("host")
    parser.add_argument("port", type=int)
    for name, usual in (("delay", 0.002), ("jitter", 0.098), ("loss", 0.02), ("rate", 1e9), ("seed", 1)):
        parser.add_argument(f"--{name}", type=float, default=usual)
    options = parser.parse_args(arguments)
    dice = random.Random(options.seed)
    server = socket.create_connection((options.host, options.port))
    server.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    down, up = Way(), Way()
    inputs = [0, server.fileno()]
    while inputs or up.waiting:
        now = time.monotonic()
        if data := down.due(now):
            server.sendall(data)
        for_us = up.due(now)
        while for_us:
            for_us = for_us[os.write(1, for_us) :]
        at = min((way.waiting[0][0] for way in (down, up) if way.waiting), default=now + 1)
        # As on a real way, only so much is on it: the rest waits in the sender.
        open_ = [each for each in inputs if sum(len(data) for *_, data in (down if each == 0 else up).waiting) < 65_536]
        readable, _, _ = select.select(open_, [], [], max(at - now, 0))
        for each in readable:
            data = os.read(each, 65_536)
            if not data:
                return
            (down if each == 0 else up).put(data, time.monotonic(), options, dice)


if __name__ == "__main__":
    main()

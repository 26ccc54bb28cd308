"""A way to an ssh server that a test can halt, as a Wi-Fi that falls silent: ssh starts it as its ProxyCommand.

relay.py HOST PORT passes on all bytes, and ends when either side does.
"""

from __future__ import annotations

import os
import select
import socket
import sys

MAX_BYTES = 65_536
"""Bytes that are read at once."""

server = socket.create_connection((sys.argv[1], int(sys.argv[2])))
while True:
    for each in select.select([0, server.fileno()], [], [])[0]:
        if not (data := os.read(each, MAX_BYTES)):
            sys.exit()
        if each == 0:
            server.sendall(data)
        while each != 0 and data:
            data = data[os.write(1, data) :]

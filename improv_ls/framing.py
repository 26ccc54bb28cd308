"""Messages out of a stream of bytes: LSP's base protocol, a header with the length before each message."""

from __future__ import annotations

import re
from collections.abc import Iterator

_LENGTH = re.compile(rb"^content-length:[ \t]*(\d+)[ \t]*\r?$", re.IGNORECASE | re.MULTILINE)
_HEADER_END = b"\r\n\r\n"
LONGEST_HEADER = 65_536


class Frames:
    """Keeps what has come of a message until the rest of it comes."""

    def __init__(self) -> None:
        self._kept = bytearray()
        self._length: int | None = None

    def fed(self, data: bytes) -> Iterator[bytes]:
        """The bodies that these bytes complete. A header that tells no length is passed over."""
        self._kept += data
        while True:
            if self._length is None:
                end = self._kept.find(_HEADER_END)
                if end < 0:
                    del self._kept[:-LONGEST_HEADER]  # no header is as long: whatever this is, it must not pile up
                    return
                length = _LENGTH.search(self._kept, 0, end + 2)
                self._length = int(length[1]) if length else None
                del self._kept[: end + len(_HEADER_END)]
                continue
            if len(self._kept) < self._length:
                return
            body = bytes(self._kept[: self._length])
            del self._kept[: self._length]
            self._length = None
            yield body

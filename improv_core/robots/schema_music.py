"""The keys of the section `[music]` of an `improv.toml`."""

from __future__ import annotations

from improv_core.robots.schema_key import Key
from improv_core.robots.schema_key import number as _number
from improv_core.robots.schema_key import table as _table

MUSIC = _table(
    "the song that the page plays",
    {
        "file": Key(
            "the song, in the folder of this file or deeper: WAV, MP3, Ogg, FLAC, or M4A",
            default="none: drop one onto the page",
            example='"song.mp3"',
        ),
        "first_beat": _number("where in the song beat 0 of the dance is", "seconds", -3600, 3600, "0"),
        "count_in": Key(
            "count one bar before each dance begins, with or without a song", "boolean", default="false", example="true"
        ),
        "volume": _number("how loud it is, from silent to as loud as it was recorded", "shares", 0, 1, "1"),
    },
)

"""The keys of the section `[osc]` of an `improv.toml`."""

from __future__ import annotations

from improv_core.robots.schema_key import Key

OSC = {
    "listen": Key(
        "the UDP port on which Improv hears OSC messages",
        "integer",
        default="none: it hears no messages",
        least=1,
        most=65535,
        example="7000",
    ),
    "host": Key(
        "the IPv4 address of this machine on which it hears them; other machines reach it only with"
        " `--osc-network` or the setting `osc.network`",
        default='`"127.0.0.1"`: only programs on this machine are heard',
    ),
    "send": Key(
        'where what plays is sent: each `"HOST:PORT"`; other machines get it only with `--osc-network` or the setting'
        " `osc.network`",
        "array",
        default="nowhere",
        items=Key("a program that hears OSC: its host and its UDP port", example='"127.0.0.1:9000"'),
        example='["127.0.0.1:9000"]',
    ),
    "time_tags": Key(
        "send bundles with the time at which each thing was due; false for programs that read no bundles, such as Sonic"
        " Pi",
        "boolean",
        default="true",
        example="false",
    ),
}

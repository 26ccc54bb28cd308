"""Songs for tests, whose samples show the place in the song; and a listener for a page's sound."""

from __future__ import annotations

import math
import struct
from array import array
from pathlib import Path
from typing import Any

RATE = 44_100

EAR = """
const made = window.AudioContext
const connect = AudioNode.prototype.connect
const processor = `registerProcessor("ear", class extends AudioWorkletProcessor {
  process([[left]]) {
    this.port.postMessage([currentTime, left ? left[0] : 0])
    return true
  }
})`
Object.assign(window, { contexts: [], heard: [], hearings: [], changes: [] })
window.AudioContext = class extends made {
  constructor(options) {
    super(options)
    window.contexts.push(this)
  }
}
const Socket = window.WebSocket
window.WebSocket = class extends Socket {
  constructor(address) {
    super(address)
    this.addEventListener("message", ({ data }) => {
      const { type, wall, beat, tempo, state } = JSON.parse(data)
      if (type === "transport") window.changes.push([wall, beat, tempo, state === "playing"])
    })
  }
}
AudioNode.prototype.connect = function (to, ...more) {
  if (to === this.context.destination) (this.context.last ??= []).push(this)
  return connect.call(this, to, ...more)
}
window.hear = async () => {
  const [context] = window.contexts
  await context.audioWorklet.addModule(URL.createObjectURL(new Blob([processor], { type: "text/javascript" })))
  const ear = new AudioWorkletNode(context, "ear")
  for (const node of context.last) connect.call(node, ear)
  ear.port.onmessage = ({ data }) => window.heard.push(data)
  setInterval(() => {
    const { contextTime, performanceTime } = context.getOutputTimestamp()
    window.hearings.push([performance.now() / 1000, contextTime, performanceTime / 1000, Date.now() / 1000])
  }, 20)
}
"""
"""Has a page note the samples that its audio context renders, their times, and the messages of its stage."""


def ramp(seconds: float) -> bytes:
    """Make a WAV file whose sound rises evenly from -1/2 at its beginning to 1/2 at its end, so that one sample shows
    the place in it. The numbers have a fraction, so that this is exact to less than a millisecond."""
    count = round(seconds * RATE)
    samples = array("f", (place / count - 0.5 for place in range(count)))
    return wav(samples.tobytes(), kind=3, width=4)


def clicks(seconds: float, tempo: float) -> bytes:
    """Make a WAV file with a short tone at each beat, the first one at its beginning."""
    rate = 8_000
    samples = array("h", bytes(2 * round(seconds * rate)))
    tone = array("h", (round(20_000 * math.sin(place) * math.exp(-place / 80)) for place in range(rate // 25)))
    beat = 0.0
    while beat < seconds - 0.05:
        start = round(beat * rate)
        samples[start : start + len(tone)] = tone
        beat += 60 / tempo
    return wav(samples.tobytes(), kind=1, width=2, rate=rate)


def wav(data: bytes, kind: int, width: int, rate: int = RATE) -> bytes:
    """Make a WAV file with one channel; `kind` 1 has whole numbers, and 3 numbers with a fraction."""
    form = struct.pack("<HHIIHH", kind, 1, rate, rate * width, width, 8 * width)
    body = b"WAVE" + b"fmt " + struct.pack("<I", len(form)) + form + b"data" + struct.pack("<I", len(data)) + data
    return b"RIFF" + struct.pack("<I", len(body)) + body


def improv_toml(folder: Path, song: bytes, **keys: Any) -> str:
    """Return an improv.toml with this song, which is put into the folder."""
    (folder / "song.wav").write_bytes(song)
    lines = "".join(f"{key} = {value}\n" for key, value in keys.items())
    return f'[music]\nfile = "song.wav"\n{lines}'

// The shape of a song under the timeline: what is at which pixel, and what a drag does.

import assert from "node:assert/strict"
import test from "node:test"

import { firstBeatAfter, loudness, rounded, shapeOf } from "../../../improv_core/page/static/sound/wave.js"

/** A song of two channels, whose samples are 0 except at these times, in seconds. */
function song(seconds, times) {
  const samples = new Float32Array(seconds * 8000)
  for (const time of times) samples[Math.round(time * 8000)] = -0.5
  return { sampleRate: 8000, length: samples.length, numberOfChannels: 2, getChannelData: (channel) => (channel ? samples : new Float32Array(samples.length)) }
}

/** The pixels at which a song is loud. */
const loudAt = (shape, fit, stretch) => [...loudness(shape, fit, stretch)].flatMap((height, x) => (height > 0.4 ? [x] : []))

test("what is at a beat is at its line, whatever the first beat and the tempo", () => {
  const shape = shapeOf(song(10, [0.5, 1, 1.5, 2]))
  assert.deepEqual(loudAt(shape, { firstBeat: 0.5, tempo: 120 }, { left: 0, scale: 20, width: 100 }), [0, 20, 40, 60])
  assert.deepEqual(loudAt(shape, { firstBeat: 0.5, tempo: 120 }, { left: 1, scale: 40, width: 100 }), [0, 40, 80])
  assert.deepEqual(loudAt(shape, { firstBeat: 0, tempo: 60 }, { left: 0, scale: 40, width: 100 }), [20, 40, 60, 80])
})

test("before and after the song, there is nothing", () => {
  const shape = shapeOf(song(1, [0.5]))
  const found = [...loudness(shape, { firstBeat: -1, tempo: 60 }, { left: 0, scale: 10, width: 30 })]
  assert.deepEqual(found.map((height) => height >= 0), Array.from({ length: 30 }, (_, x) => x >= 10 && x < 20))
})

test("no loud moment is lost where a pixel is a long time", () => {
  const shape = shapeOf(song(100, [33.3337, 66.667]))
  assert.deepEqual(loudAt(shape, { firstBeat: 0, tempo: 60 }, { left: 0, scale: 0.1, width: 10 }), [3, 6])
})

test("dragging the song to the right makes its beat 0 earlier in it, to the millisecond", () => {
  assert.equal(firstBeatAfter({ firstBeat: 0.5, tempo: 120 }, 40, 8), 0.4)
  assert.equal(firstBeatAfter({ firstBeat: 0.5, tempo: 120 }, 40, -8), 0.6)
  assert.equal(firstBeatAfter({ firstBeat: 0.5, tempo: 90 }, 37, 1), 0.482)
  assert.ok(Object.is(firstBeatAfter({ firstBeat: 0.1, tempo: 60 }, 10, 1), 0))
  assert.deepEqual([rounded(5000), rounded(-5000)], [3600, -3600])
})

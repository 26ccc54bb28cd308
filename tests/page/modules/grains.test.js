// Where a grain of a song joins the one before: where the sound continues as if nothing had been left out.

import assert from "node:assert/strict"
import test from "node:test"

import { align } from "../../../improv_core/page/static/sound/grains.js"

const RATE = 44_100
const tone = (hertz) => Float32Array.from({ length: RATE }, (_, n) => Math.sin((2 * Math.PI * hertz * n) / RATE))

/** How far apart the phases of a tone are in two places, in cycles. */
function apart(hertz, one, two) {
  const cycles = Math.abs(one - two) * hertz
  return Math.abs(cycles - Math.round(cycles))
}

for (const hertz of [110, 440, 1000]) {
  test(`a tone of ${hertz} Hz continues in phase, within 5 ms of where it should be`, () => {
    const samples = tone(hertz)
    for (const [from, wanted] of [[0.2, 0.203], [0.3, 0.2811], [0.5, 0.5071]]) {
      const found = align(samples, RATE, from, wanted)
      assert.ok(Math.abs(found - wanted) <= 0.0052)
      assert.ok(apart(hertz, found, from) < 0.03, `${hertz} ${found}`)
    }
  })
}

test("silence, and the ends of a song, change nothing", () => {
  assert.equal(align(new Float32Array(RATE), RATE, 0.2, 0.25), 0.25)
  assert.equal(align(tone(440), RATE, 0.995, 0.5), 0.5)
  assert.ok(align(tone(440), RATE, 0.5, 0.999) <= 1)
  assert.ok(align(tone(440), RATE, 0.5, 0) >= 0)
})

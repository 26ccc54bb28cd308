// A tempo from taps.

import assert from "node:assert/strict"
import test from "node:test"

import { tapped, tempoOf } from "../../../improv_core/page/static/sound/tapping.js"

const taps = (count, tempo, off = () => 0) => Array.from({ length: count }, (_, n) => 3 + (n * 60) / tempo + off(n))

test("eight taps are a tempo, seven aren't", () => {
  assert.equal(tempoOf(taps(7, 96)), null)
  for (const tempo of [40, 96, 128, 180]) assert.equal(tempoOf(taps(8, tempo)), tempo)
})

test("a tap that is late or early by 40 ms changes it by 2 at most", () => {
  for (let late = 0; late < 8; late++) {
    for (const by of [-0.04, 0.04]) assert.ok(Math.abs(tempoOf(taps(8, 100, (n) => (n === late ? by : 0))) - 100) <= 2)
  }
})

test("more taps make it more exact, and only the latest 32 count", () => {
  const found = taps(80, 120, (n) => (n % 2 ? 0.02 : -0.02)).reduce(tapped, [])
  assert.equal(found.length, 32)
  assert.equal(tempoOf(found), 120)
})

test("after a pause, taps begin anew", () => {
  assert.deepEqual(tapped([1, 2, 3], 5.6), [5.6])
  assert.deepEqual(tapped([1, 2, 3], 5.4), [1, 2, 3, 5.4])
})

test("nobody taps so fast or slow that no program could say it", () => {
  assert.equal(tempoOf(taps(8, 3000)), 400)
})

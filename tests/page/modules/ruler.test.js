// The timeline's ruler: beats or bars, and the names of scenes.

import assert from "node:assert/strict"
import test from "node:test"

import { formatPosition } from "../../../improv_core/page/static/score/clock.js"
import { paintRuler } from "../../../improv_core/page/static/timeline/ruler.js"

const COLORS = { grid: "thin", "grid-strong": "thick", quiet: "quiet", panel: "panel", ink: "ink" }

/** The texts on a ruler with letters of 6 pixels, and the beats that have a line, thin or thick. */
function ruler({ last = 12, bar = null, scale = 40, scenes = [{ beat: 0, number: 1, name: "" }] }) {
  const shown = { texts: [], thin: [], thick: [] }
  const pen = {
    fillStyle: "",
    measureText: (text) => ({ width: 6 * text.length }),
    fillText: (text) => shown.texts.push(text),
    fillRect: (x) => shown[pen.fillStyle]?.push(Math.round(x / scale)),
  }
  paintRuler(pen, { left: 0, last, bar, scenes, scale, letter: 10, head: 20, height: 100, colors: COLORS })
  return { ...shown, thick: shown.thick.filter((beat) => beat >= 0) }
}

test("without bars, all beats are numbered, as far as there is room", () => {
  assert.deepEqual(ruler({ last: 4 }).texts, ["1", "2", "3", "4"])
  assert.deepEqual(ruler({ last: 8, scale: 12 }).texts, ["1", "3", "5", "7"])
})

test("bars are numbered, and their beats have thinner lines", () => {
  const { texts, thin, thick } = ruler({ last: 6, bar: 3 })
  assert.deepEqual(texts, ["bar 1", "bar 2"])
  assert.deepEqual(thick, [0, 3, 6])
  assert.deepEqual(thin, [0, 1, 2, 3, 4, 5, 6])
})

test("where there is little room, only some bars are shown, without their beats", () => {
  const { texts, thin } = ruler({ last: 24, bar: 3, scale: 5 })
  assert.deepEqual(texts, ["bar 1", "bar 5"])
  assert.deepEqual(thin, [])
})

test("scenes have their names, or their numbers", () => {
  const scenes = [{ beat: 0, number: 1, name: "bows" }, { beat: 6, number: 2, name: "" }]
  assert.deepEqual(ruler({ scenes }).texts.filter((text) => text.includes("·")), ["1 · bows", "7 · scene 2"])
  assert.deepEqual(ruler({ bar: 3, scenes }).texts, ["bar 1, beat 1 · bows", "bar 3, beat 1 · scene 2"])
})

test("the name of a scene covers no number, and is left out where it has no room", () => {
  const scenes = [{ beat: 0, number: 1, name: "a_long_name" }, { beat: 1, number: 2, name: "b" }]
  assert.deepEqual(ruler({ last: 4, scenes }).texts, ["1", "3", "4", "2 · b"])
})

test("a position is said in bars and beats, which count from 1", () => {
  assert.deepEqual([0, 2, 3, 7].map((beat) => formatPosition(beat, 3)), ["bar 1, beat 1", "bar 1, beat 3", "bar 2, beat 1", "bar 3, beat 2"])
  assert.equal(formatPosition(7, null), "beat 8")
})

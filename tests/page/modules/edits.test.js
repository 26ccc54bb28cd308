// One edit between two texts.

import assert from "node:assert/strict"
import test from "node:test"

import { difference, marksAfter } from "../../../improv_core/page/static/editor/edits.js"

test("the difference of two texts is where they differ, and repeated letters are counted once", () => {
  /** @type {[string, string, [number, number, string]][]} */
  const scenes = [
    ["r $ left", "r $ left", [8, 8, ""]],
    ["r $ left", "r $ leftt", [8, 8, "t"]],
    ["aaa", "aa", [2, 3, ""]],
    ["", "r", [0, 0, "r"]],
    ["r $ up\ns $ up", "r $ up left\ns $ up", [6, 6, " left"]],
    ["🐢 up", "🐙 up", [1, 2, "\uDC19"]],
  ]
  for (const [before, after, [start, end, text]] of scenes) assert.deepEqual(difference(before, after), { start, end, text })
})

test("marks move along with an edit, grow with letters inside and behind, and are gone where it cuts them", () => {
  const marks = [{ start: 0, end: 4 }, { start: 5, end: 9 }]
  /** @type {[[number, number, string], [number, number][]][]} */
  const scenes = [
    [[4, 4, "s"], [[0, 5], [6, 10]]],
    [[4, 4, " "], [[0, 4], [6, 10]]],
    [[2, 2, "-"], [[0, 5], [6, 10]]],
    [[5, 5, "s"], [[0, 4], [6, 10]]],
    [[3, 6, ""], []],
    [[4, 5, "s"], [[0, 4], [5, 9]]],
  ]
  for (const [[start, end, text], after] of scenes) {
    assert.deepEqual(marksAfter(marks, { start, end, text }).map(({ start, end }) => [start, end]), after)
  }
  assert.deepEqual(marksAfter([{ start: 4, end: 4 }], { start: 4, end: 4, text: "s" }), [{ start: 4, end: 4 }]) // a missing word
})

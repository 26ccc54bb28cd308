// One edit between two texts.

import assert from "node:assert/strict"
import test from "node:test"

import { difference } from "../../../improv_core/page/static/editor/edits.js"

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

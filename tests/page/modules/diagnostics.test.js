// Fixes that may be made together.

import assert from "node:assert/strict"
import test from "node:test"

import { groupFixes } from "../../../improv_core/page/static/editor/diagnostics.js"

function diagnostic(start, title, kind, file = "") {
  return { start, end: start + 2, file, line: 1, severity: "error", message: "", fixes: [{ title, kind, edits: [{ start, end: start + 2, text: "x" }] }] }
}

test("what can be fixed more than once can be fixed at once", () => {
  const found = groupFixes([diagnostic(9, "Change to x", "k"), diagnostic(3, "Change to x", "k"), diagnostic(6, "Change to y", "l")])
  assert.deepEqual(found.map(({ title, times, edits }) => [title, times, edits.map(({ start }) => start)]), [["Change to x", 2, [3, 9]]])
})

test("a fix that is made alone is not among them, nor one of another file", () => {
  assert.deepEqual(groupFixes([diagnostic(1, "Define it", ""), diagnostic(5, "Define it", "")]), [])
  assert.deepEqual(groupFixes([diagnostic(1, "Change", "k", "improv.toml"), diagnostic(5, "Change", "k")]), [])
})

test("edits that overlap are made once", () => {
  assert.deepEqual(groupFixes([diagnostic(1, "Change", "k"), diagnostic(2, "Change", "k")]), [])
})

test("the most frequent kind comes first", () => {
  const found = groupFixes([1, 4].map((at) => diagnostic(at, "seldom", "s")).concat([10, 14, 18].map((at) => diagnostic(at, "often", "o"))))
  assert.deepEqual(found.map(({ title, times }) => `${title} ${times}`), ["often 3", "seldom 2"])
})

// The colors of a text, which come as a change of those before.

import assert from "node:assert/strict"
import test from "node:test"

import { changed } from "../../../improv_core/page/static/editor/analysis.js"

test("the first and last colors stay, and the new ones are between them", () => {
  assert.deepEqual(changed([1, 2, 3, 4], { first: 1, last: 2, new: [7, 8] }), [1, 7, 8, 3, 4])
  assert.deepEqual(changed([1, 2, 3], { first: 3, last: 0, new: [] }), [1, 2, 3])
  assert.deepEqual(changed([1, 2, 3], { first: 0, last: 0, new: [9] }), [9])
})

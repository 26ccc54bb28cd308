// The rows of the timeline.

import assert from "node:assert/strict"
import test from "node:test"

import { rowsOf } from "../../../improv_core/page/static/timeline/timerows.js"

const part = (name, moves) => ({ name, joints: [], moves })
const SCORE = { robots: { ada: { body: [part("head", true), part("left_arm", false), part("right_arm", true)] }, bo: { body: [] } } }
const CAST = [{ name: "ada" }, { name: "bo" }]
const HEIGHTS = { head: 20, row: 50, top: 0 }

test("a robot has a row, and a lower one for each body part that it moves", () => {
  const sheet = rowsOf(SCORE, CAST)
  assert.deepEqual(sheet.rows.map(({ name, part }) => [name, part]), [["ada", null], ["ada", "head"], ["ada", "right_arm"], ["bo", null]])
  assert.deepEqual([0, 1, 2, 3].map((index) => Math.round(sheet.y(HEIGHTS, index))), [20, 70, 101, 132])
  assert.deepEqual([0, 1, 3].map((index) => Math.round(sheet.inRow(HEIGHTS, index).row)), [50, 31, 50])
})

test("only rows that are not scrolled out of view are drawn", () => {
  const seen = (top, height) => [...rowsOf(SCORE, CAST).visible({ ...HEIGHTS, top }, height)].map(([index]) => index)
  assert.deepEqual(seen(0, 300), [0, 1, 2, 3])
  assert.deepEqual(seen(0, 95), [0, 1])
  assert.deepEqual(seen(60, 300), [1, 2, 3])
})

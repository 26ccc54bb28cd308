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
  const places = [...sheet.visible(HEIGHTS, 300)].map(({ y, row }) => [Math.round(y), Math.round(row)])
  assert.deepEqual(places, [[20, 50], [70, 31], [101, 31], [132, 50]])
})

test("only rows that are not scrolled out of view are drawn", () => {
  const seen = (top, height) => [...rowsOf(SCORE, CAST).visible({ ...HEIGHTS, top }, height)].map(({ robot: { name, part } }) => part ?? name)
  assert.deepEqual(seen(0, 300), ["ada", "head", "right_arm", "bo"])
  assert.deepEqual(seen(0, 95), ["ada", "head"])
  assert.deepEqual(seen(60, 300), ["head", "right_arm", "bo"])
})

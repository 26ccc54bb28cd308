// What a gauge shows of a joint.

import assert from "node:assert/strict"
import test from "node:test"

import { gauge, words } from "../../../improv_core/page/static/bodies/gauge.js"

const DEGREE = Math.PI / 180
const joint = (min, max, more = {}) => ({ name: "j", axis: "z", sign: 1, slides: false, min, max, start: 0, ...more })
const ELBOW = joint(0, 140 * DEGREE)

test("a joint is shown between its limits, with its start", () => {
  const { at, start, ends, words } = gauge(joint(-60 * DEGREE, 180 * DEGREE), 60 * DEGREE, 0)
  assert.deepEqual([at, start, ends, words].map((each) => (typeof each === "number" ? Number(each.toFixed(6)) : each)), [0.5, 0.25, [true, true], "60°"])
})

test("a limit holds a joint that is asked to move beyond it, and no other", () => {
  const held = (position, velocity) => gauge(ELBOW, position * DEGREE, velocity).held
  assert.equal(held(140, 1), 1)
  assert.equal(held(140, -1), 0)
  assert.equal(held(140, 0), 0)
  assert.equal(held(139, 1), 0)
  assert.equal(held(0, -1), -1)
  assert.equal(held(0, 0), 0) // where it starts
})

test("a joint without limits turns and turns", () => {
  const round = joint(null, null)
  assert.deepEqual(gauge(round, 0, 0).ends, [false, false])
  assert.ok(Math.abs(gauge(round, 450 * DEGREE, 9).at - 0.75) < 1e-9)
  assert.deepEqual([gauge(round, 450 * DEGREE, 9).words, gauge(round, 450 * DEGREE, 9).held], ["450°", 0])
})

test("a real joint is shown beside where it ideally is", () => {
  const { at, real, words } = gauge(ELBOW, 70 * DEGREE, 0, 35 * DEGREE)
  assert.deepEqual([at, real, words].map((each) => (typeof each === "number" ? Number(each.toFixed(6)) : each)), [0.5, 0.25, "70°, really 35°"])
  assert.equal(gauge(ELBOW, 70 * DEGREE, 0).real, null)
})

test("a joint that slides is shown in meters, a meter around its start where it has no limit", () => {
  const mast = joint(0.5, null, { slides: true, start: 0.5 })
  assert.deepEqual([gauge(mast, 1, 0).at, gauge(mast, 1, 0).words, gauge(mast, 9, 0).at], [0.5, "1.00 m", 1])
})

test("a joint that can't move is in the middle of its gauge", () => {
  assert.equal(gauge(joint(1, 1, { start: 1 }), 1, 0).at, 0.5)
})

test("nothing is minus zero", () => {
  assert.deepEqual([words(-0.001, false), words(-0.001, true), words(-0.5, true), words(-1, false)], ["0°", "0.00 m", "−0.50 m", "−57°"])
})

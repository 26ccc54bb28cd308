// Which joints turn the head and the arms of a figure, and where these are then.

import assert from "node:assert/strict"
import test from "node:test"

import { figureOf, HEAD, onHead, places } from "../../../improv_core/page/static/bodies/body.js"
import { view } from "../../../improv_core/page/static/bodies/puppet.js"

const joint = (name, axis, more = {}) => ({ name, axis, sign: 1, slides: false, min: null, max: null, start: 0, ...more })
const part = (name, ...joints) => ({ name, joints, moves: true })
const BODY = [
  part("head", joint("pan", "yaw"), joint("tilt", "z", { sign: -1 })),
  part("left_arm", joint("l1", "z"), joint("l2", "yaw"), joint("l3", "x")),
  part("right_arm", joint("r1", "z"), joint("r2", "yaw"), joint("r3", "x", { start: 1 })),
]
const QUARTER = Math.PI / 2
const arm = (raise, out = 0, bend = 0) => places({ side: 1, raise, out, bend })

/** Which way a hand is from its shoulder: forward, left, and up, in lengths of an arm. */
function way({ shoulder, hand }) {
  const reach = hand.map((each, axis) => each - shoulder[axis])
  return reach.map((each) => Math.round((each / 0.39) * 100) / 100 + 0)
}

test("parts called head, left arm, and right arm are drawn, at their joints' starts if nothing is known", () => {
  assert.deepEqual(figureOf(BODY), {
    head: { yaw: 0, pitch: -0 },
    arms: [{ side: 1, raise: 0, out: 0, bend: 0 }, { side: -1, raise: 0, out: 0, bend: 1 }],
  })
})

test("a joint that goes against its direction turns the figure the way of the direction", () => {
  assert.deepEqual(figureOf(BODY, { pan: 0.5, tilt: 0.25 }).head, { yaw: 0.5, pitch: -0.25 })
})

test("a body without a head or arms has no figure, only gauges", () => {
  assert.equal(figureOf([part("gripper", joint("finger", "x")), part("lift", joint("mast", "z", { slides: true }))]), null)
  assert.equal(figureOf([]), null)
})

test("a joint that slides turns nothing", () => {
  assert.deepEqual(figureOf([part("head", joint("mast", "z", { slides: true }))], { mast: 0.4 }).head, { yaw: 0, pitch: 0 })
})

test("an arm hangs down, is raised forward and up, taken to the left, and bent", () => {
  assert.deepEqual(way(arm(0)), [0, 0, -1])
  assert.deepEqual(way(arm(QUARTER)), [1, 0, 0])
  assert.deepEqual(way(arm(2 * QUARTER)), [0, 0, 1])
  assert.deepEqual(way(arm(0, QUARTER)), [0, 1, 0])
  assert.deepEqual(way(arm(QUARTER, QUARTER)), [0, 1, 0])
  const { elbow, hand } = arm(0, 0, QUARTER)
  assert.ok(hand[0] > elbow[0] + 0.1 && Math.abs(hand[2] - elbow[2]) < 1e-9)
})

test("a head that turns left looks to the left, and one that looks up looks up", () => {
  const nose = (head) => onHead(head, [1, 0, 0]).map((each, axis) => Math.round(((each - [0, 0, HEAD.height][axis]) / HEAD.radius) * 100) / 100 + 0)
  assert.deepEqual(nose({ yaw: 0, pitch: 0 }), [1, 0, 0])
  assert.deepEqual(nose({ yaw: QUARTER, pitch: 0 }), [0, 1, 0])
  assert.deepEqual(nose({ yaw: 0, pitch: QUARTER }), [0, 0, 1])
})

test("from the front the left arm is on our right, and from the right side it is behind", () => {
  const figure = figureOf(BODY, { l2: QUARTER, r2: -QUARTER })
  const [left, right] = view(figure, "front").arms
  assert.ok(left.hand[0] > 0.5 && right.hand[0] < -0.3)
  assert.deepEqual(view(figure, "side").arms.map(({ behind }) => behind), [true, false])
})

test("eyes that look away are not seen", () => {
  const seen = (yaw, name) => view({ head: { yaw, pitch: 0 }, arms: [] }, name).head.eyes.filter(Boolean).length
  assert.deepEqual([0, QUARTER, -QUARTER, 2 * QUARTER].map((yaw) => seen(yaw, "front")), [2, 1, 1, 0])
  assert.deepEqual([0, QUARTER, -QUARTER].map((yaw) => seen(yaw, "side")), [1, 0, 2])
})

test("each hand and the head hang on strings", () => {
  assert.equal(view(figureOf(BODY), "front").strings.match(/M/g).length, 3)
})

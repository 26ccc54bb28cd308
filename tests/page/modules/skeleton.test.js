// Where joints are by a robot's skeleton, and how it is seen from somewhere.

import assert from "node:assert/strict"
import test from "node:test"

import { framesOf } from "../../../improv_core/page/static/bodies/skeleton.js"
import { dragged, FROM_RIGHT, StickFigure } from "../../../improv_core/page/static/bodies/stick-figure.js"

const QUARTER = Math.PI / 2
const bone = (joint, carrier, more = {}) => ({
  joint, carrier, place: [0, 0, 0], turn: [0, 0, 0], axis: [0, 0, 1], way: "turns", rest: 0, follows: null, ratio: 1, shift: 0, ...more,
})
const ARM = [
  bone("waist", -1, { place: [0, 0, 1] }),
  bone("shoulder", 0, { place: [0.5, 0, 0], axis: [0, 1, 0] }),
  bone("hand", 1, { place: [1, 0, 0], way: "stays" }),
]
const rounded = (place) => place.map((each) => Math.round(each * 1e6) / 1e6 + 0)
const ends = (skeleton, positions) => framesOf(skeleton, positions).map(({ at }) => rounded(at))
const FRONT = { turn: 0, tilt: 0 }
const numbers = (path) => path.match(/-?\d+\.\d+/g).map(Number)

test("each joint is where those that carry it have it", () => {
  assert.deepEqual(ends(ARM, {}), [[0, 0, 1], [0.5, 0, 1], [1.5, 0, 1]])
  assert.deepEqual(ends(ARM, { waist: QUARTER }), [[0, 0, 1], [0, 0.5, 1], [0, 1.5, 1]])
  assert.deepEqual(ends(ARM, { shoulder: -QUARTER }), [[0, 0, 1], [0.5, 0, 1], [0.5, 0, 2]])
  assert.deepEqual(ends(ARM, { waist: QUARTER, shoulder: -QUARTER }), [[0, 0, 1], [0, 0.5, 1], [0, 0.5, 2]])
})

test("roll, pitch, and yaw are about fixed axes, in that order", () => {
  const turned = [bone("fixed", -1, { turn: [QUARTER, 0, QUARTER], way: "stays" }), bone("tip", 0, { place: [1, 2, 3], way: "stays" })]
  assert.deepEqual(ends(turned, {})[1], [3, 1, 2]) // roll: (1, -3, 2), then yaw
})

test("a joint slides along its axis, in the frame that it is turned to", () => {
  const lift = [bone("lift", -1, { way: "slides", turn: [0, 0, QUARTER], axis: [1, 0, 0] }), bone("tip", 0, { place: [0, 0, 1] })]
  assert.deepEqual(ends(lift, { lift: 0.5 }), [[0, 0.5, 0], [0, 0.5, 1]])
})

test("a joint about which nothing is known rests, and one that follows another does what that does", () => {
  const fingers = [
    bone("one", -1, { rest: QUARTER }), bone("tip", 0, { place: [1, 0, 0], way: "stays" }),
    bone("other", -1, { follows: "one", ratio: -1, shift: 0.5 }), bone("end", 2, { place: [1, 0, 0], way: "stays" }),
  ]
  assert.deepEqual(ends(fingers, {}), [[0, 0, 0], [0, 1, 0], [0, 0, 0], [1, 0, 0]])
  assert.deepEqual(ends(fingers, { one: 0.5 + QUARTER })[3], [0, -1, 0])
})

test("from the front, a robot's left is on our right, and its front looks at us", () => {
  const figure = new StickFigure([bone("neck", -1, { place: [0, 1, 1], way: "stays" })])
  const [x, y, left, up] = numbers(figure.seen({}, FRONT).still)
  assert.ok(left > x && up < y)
  const [middle, , ahead] = numbers(new StickFigure([bone("nose", -1, { place: [1, 0, 0], way: "stays" })]).seen({}, FRONT).still)
  assert.equal(middle, ahead)
})

test("what no joint moves is drawn apart, and a last joint has a hand that shows how it turns", () => {
  const { still, moving, joints } = new StickFigure(ARM).seen({}, FROM_RIGHT)
  assert.deepEqual([still, moving, joints].map((path) => path.split("M").length - 1), [0, 3, 2])
  const wrist = new StickFigure([bone("pole", -1, { place: [0, 0, 1], way: "stays" }), bone("wrist", 0, { place: [0, 0, 0.2] })])
  const before = wrist.seen({}, FROM_RIGHT)
  assert.deepEqual([before.still, before.moving].map((path) => path.split("M").length - 1), [1, 2])
  assert.notEqual(wrist.seen({ wrist: 1 }, FROM_RIGHT).moving, before.moving)
})

test("all of a figure fits from everywhere, wherever its joints are", () => {
  const figure = new StickFigure([...ARM, bone("rail", 2, { way: "slides", axis: [1, 0, 0] })])
  for (const positions of [{}, { shoulder: -QUARTER }, { waist: 2, rail: 9 }]) {
    for (const turn of [0, 1, 3, 5]) {
      for (const tilt of [-0.3, 0.5, QUARTER]) {
        const { moving } = figure.seen(positions, { turn, tilt })
        assert.ok(numbers(moving).every((each) => Math.abs(each) <= 1))
      }
    }
  }
})

test("dragging to the right turns what is in front to the right, and a figure is never seen from far below", () => {
  assert.ok(dragged(FROM_RIGHT, 10, 0).turn < FROM_RIGHT.turn)
  assert.equal(dragged(FROM_RIGHT, 0, 10_000).tilt, QUARTER)
  assert.equal(dragged(FROM_RIGHT, 0, -10_000).tilt, -0.3)
})

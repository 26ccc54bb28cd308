// The rings where robots start: their size, and which one is under a hand.

import assert from "node:assert/strict"
import test from "node:test"

import { nearestRing, placeRings } from "../../../improv_core/page/static/floor/rings.js"

const CAMERA = { toScreen: ({ x, y }) => ({ x: 100 * x, y: -100 * y }) }

/** Rings on the screen, of robots at these meters, which face east. */
function rings(...places) {
  return placeRings(places.map(([x, y], index) => ({ name: `r${index}`, x, y, heading: 0, color: "", chosen: false })), CAMERA)
}

test("rings that are close to each other are smaller", () => {
  assert.deepEqual(rings([0, 0], [5, 0]).map(({ size }) => size), [16, 16])
  assert.deepEqual(rings([0, 0], [0.4, 0], [5, 0]).map(({ size }) => Number(size.toFixed(3))), [11.6, 11.6, 16])
  assert.deepEqual(rings([0, 0], [0, 0]).map(({ size }) => size), [5, 5])
})

test("no ring or arrow reaches another ring", () => {
  const all = rings(...[0, 1, 2, 3, 4, 5].flatMap((x) => [0, 1, 2, 3, 4].map((y) => [x * 0.3, y * 0.3])))
  for (const one of all) {
    for (const other of all.filter((each) => each !== one)) {
      const apart = ({ x, y }) => Math.hypot(x - other.place.x, y - other.place.y)
      assert.ok(apart(one.place) > one.size + other.size)
      assert.ok(apart(one.tip) >= other.size - 1e-9)
    }
  }
})

test("the nearest ring or arrow is under a hand, if one is near", () => {
  const all = rings([0, 0], [0.4, 0])
  const at = (x, y) => (({ name, part }) => `${name} ${part}`)(nearestRing({ x, y }, all))
  assert.equal(at(3, 2), "r0 place")
  assert.equal(at(27, 0), "r0 tip")
  assert.equal(at(36, 0), "r1 place")
  assert.equal(nearestRing({ x: 0, y: 60 }, all), null)
})

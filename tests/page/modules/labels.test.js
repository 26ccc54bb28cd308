// Names stand beside their robots, where they cover no robot and no other name.

import assert from "node:assert/strict"
import test from "node:test"

import { LabelPlaces } from "../../../improv_core/page/static/floor/labels.js"

const FLOOR = { left: 0, top: 0, right: 400, bottom: 400 }

/** A robot with a radius of 10 pixels, and a name of 40 by 12. */
function robot(name, x, y) {
  return { name, place: { x, y }, size: 10, wide: 40, high: 12 }
}

/** On which side of its robot each name stands, which have room. */
function sides(robots, { pointed = null, labels = new LabelPlaces(), floor = FLOOR } = {}) {
  const boxes = labels.place(robots, pointed, floor)
  return Object.fromEntries(
    [...boxes].map(([name, { left, top, right, bottom }]) => {
      const { place } = robots.find((each) => each.name === name)
      const [x, y] = [(left + right) / 2 - place.x, (top + bottom) / 2 - place.y]
      return [name, Math.abs(y) > Math.abs(x) ? (y > 0 ? "below" : "above") : x > 0 ? "right" : "left"]
    }),
  )
}

test("a name stands below its robot", () => {
  assert.deepEqual(sides([robot("ada", 200, 200)]), { ada: "below" })
})

test("a name gives way to another robot, and to another name", () => {
  assert.deepEqual(sides([robot("ada", 200, 200), robot("bo", 200, 225)]), { ada: "above", bo: "below" })
  assert.deepEqual(sides([robot("ada", 200, 200), robot("bo", 225, 200)]), { ada: "below", bo: "above" })
})

test("a name without room is left out, unless somebody points at its robot", () => {
  const crowd = [-24, 0, 24].flatMap((x) => [-24, 0, 24].map((y) => robot(`${x},${y}`, 200 + x, 200 + y)))
  assert.ok(!("0,0" in sides(crowd)))
  assert.ok("0,0" in sides(crowd, { pointed: "0,0" }))
})

test("a name stays on its side as long as there is room", () => {
  const labels = new LabelPlaces()
  assert.equal(sides([robot("ada", 200, 200), robot("bo", 200, 225)], { labels }).ada, "above")
  assert.equal(sides([robot("ada", 200, 200), robot("bo", 300, 300)], { labels }).ada, "above")
  assert.equal(sides([robot("ada", 200, 200), robot("bo", 200, 175)], { labels }).ada, "below")
})

test("a name stays on the floor", () => {
  assert.deepEqual(sides([robot("ada", 200, 390)]), { ada: "above" })
  const { left } = new LabelPlaces().place([robot("ada", 5, 200)], null, FLOOR).get("ada")
  assert.equal(left, 0)
})

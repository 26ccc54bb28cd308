// Bumps: when they are shown, counted, and announced.

import assert from "node:assert/strict"
import test from "node:test"

import { Bumps } from "../../../improv_core/page/static/floor/bumps.js"

const label = (robot) => (robot === "ada" ? "Ada: r" : robot)
const bump = (at, ...robots) => ({ at, x: 1, y: 2, robots, thing: robots[1] ? "" : "the edge of the floor" })

test("a bump is shown for a moment once the stage shows its time, and counted at once", () => {
  const counter = {}
  const bumps = new Bumps(counter)
  bumps.clear()
  assert.equal(counter.hidden, true)
  bumps.take({ past: false, bumps: [bump(3, "ada", "bo")] })
  assert.deepEqual(counter, { hidden: false, textContent: "1 bump" })
  assert.deepEqual(bumps.show(2.9, 100), [])
  assert.deepEqual(bumps.show(3, 100.1), [{ x: 1, y: 2, age: 0 }])
  assert.equal(bumps.show(3, 100.9).length, 1)
  assert.deepEqual(bumps.show(3, 101.1), []) // although nothing moves any more
})

test("bumps of before the page was opened are counted, but no news", () => {
  const counter = {}
  const bumps = new Bumps(counter)
  bumps.take({ past: true, bumps: [bump(1, "ada"), bump(2, "ada")] })
  assert.equal(counter.textContent, "2 bumps")
  assert.deepEqual(bumps.show(3, 100), [])
  assert.equal(bumps.news(100, label), "")
})

test("many bumps are announced together, so that everything else can be heard too", () => {
  const bumps = new Bumps({})
  const heard = [[1, "ada", "bo"], [2, "ada"], [3, "bo"]].map(([at, ...robots]) => {
    bumps.take({ past: false, bumps: [bump(at, ...robots)] })
    bumps.show(at, 100 + at)
    return bumps.news(100 + at, label)
  })
  assert.deepEqual(heard, ["Ada: r and bo bumped into each other", "", ""])
  assert.equal(bumps.news(104, label), "2 bumps, most recently bo bumped into the edge of the floor")
})

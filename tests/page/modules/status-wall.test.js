// The wall of robots: who is in trouble, in which order, and what one line says about all.

import assert from "node:assert/strict"
import test, { beforeEach } from "node:test"

import { measured } from "../../../improv_core/page/static/floor/measured.js"
import { clock } from "../../../improv_core/page/static/score/clock.js"
import { StatusWall } from "../../../improv_core/page/static/controls/status-wall.js"

/** A performance of 12 seconds so far, and what is measured of ada: the time of its latest pose, and how far off it is. */
function perform({ state = "playing", muted = [] } = {}, latest = null, off = 0, turned = 0, follows = 0) {
  clock.takeTime({ type: "time", wall: 102 })
  clock.take({ type: "transport", generation: 1, restarted: 1, state, beat: 0, beats: null, tempo: 60, wall: 100, performed: 10, muted, soloed: [] })
  measured.restart()
  const place = [latest, 0, 0, 0, 0, 0, 0, 0, off, turned, 0, 0, follows]
  if (latest !== null) measured.take({ robots: { ada: { from: 0, places: [place] } } })
}
const well = { odom: true, posed: 11.5, battery: 0.8 }
const fault = (robot, kind, over = false) => ({ robot, fault: kind, over, message: `${robot} ${kind}` })

beforeEach(() => perform())

function wall(robots, ...faults) {
  const made = new StatusWall()
  made.takeVitals({ robots })
  for (const each of faults) made.takeFault(each)
  return made
}

test("without real robots there is no line, and one line says that all is well", () => {
  assert.equal(wall({}).summary, "")
  assert.equal(wall({ ada: well }).summary, "1 robot, all well")
  assert.equal(wall({ ada: well, bo: well }).summary, "2 robots, all well")
})

test("robots in trouble come first, the worst trouble first, then all by their names", () => {
  const robots = Object.fromEntries(["r1", "r2", "r10", "r3", "r4"].map((name) => [name, well]))
  const made = wall({ ...robots, r4: { ...well, battery: 0.1 } }, fault("r10", "late"), fault("r3", "gone"))
  assert.deepEqual(made.tiles.map(({ name }) => name), ["r3", "r10", "r4", "r1", "r2"])
  assert.equal(made.summary, "3 of 5 robots in trouble: r3 gone; r10 late; r4 battery low")
})

test("a line names three robots, and counts the others", () => {
  const names = ["a", "b", "c", "d", "e"]
  const made = wall(Object.fromEntries(names.map((name) => [name, well])), ...names.map((name) => fault(name, "silent")))
  assert.equal(made.summary, "5 of 5 robots in trouble: a silent; b silent; c silent, and 2 more")
})

test("a robot has several faults until each is over, and none after a restart", () => {
  const made = wall({ ada: well }, fault("ada", "stuck"), fault("ada", "gone"))
  assert.equal(made.tiles[0].state, "gone, stuck")
  made.takeFault(fault("ada", "gone", true))
  assert.equal(made.tiles[0].state, "stuck")
  made.restart()
  assert.equal(made.summary, "1 robot, all well")
})

test("how old a pose is; one is told of once a second, so those of a moment ago are as good as new", (context) => {
  context.mock.method(clock, "now", () => 102) // a busy machine lets time pass
  const ages = { 11.5: "now", 10.1: "now", 9.4: "2.6 s", "-20": "32 s" }
  for (const [posed, age] of Object.entries(ages)) {
    assert.equal(wall({ ada: { ...well, posed: Number(posed) } }).tiles[0].age, age)
  }
  assert.equal(wall({ ada: { ...well, posed: null } }).tiles[0].age, "none yet")
  assert.equal(wall({ ada: { odom: false, posed: null, battery: null } }).tiles[0].age, "not measured")
})

test("a pose that the page was sent counts before it is told of again", () => {
  perform({}, 11.9, 0.1, 0.05, 1)
  const made = wall({ ada: { ...well, posed: 3 } })
  assert.deepEqual([made.tiles[0].age, made.tiles[0].off], ["now", "0.10 m, 3° off, following"])
})

test("how far off a robot was when it was last seen is no news, and nobody knows whether it follows its path", () => {
  perform({}, 3, 0.1, 0.05, 1)
  const made = wall({ ada: { ...well, posed: 3 } })
  assert.deepEqual([made.tiles[0].age, made.tiles[0].off], ["9.0 s", "0.10 m, 3° off then"])
})

test("nobody looks for poses after the end", () => {
  perform({ state: "ended" })
  assert.equal(wall({ ada: well }).tiles[0].age, "–")
})

for (const [kind, posed, lost] of [
  ["silent", 9, "silent, last pose 3 s ago"],
  ["gone", 9, "gone, last pose 3 s ago"],
  ["gone", null, "gone"],
  ["gone", 11.5, ""], // a camera still sees it
  ["stuck", 9, ""],
]) {
  test(`what is known of a robot that is ${kind}, with its latest pose at ${posed}`, () => {
    const made = wall({ ada: { ...well, posed }, bo: well }, fault("ada", kind))
    assert.deepEqual([made.lost("ada"), made.lost("bo"), made.lost("nobody")], [lost, "", ""])
  })
}

test("a robot that is muted stands, and that is no trouble", () => {
  perform({ muted: ["ada"] }, 11.9, 0.1, 0.05)
  const made = wall({ ada: well })
  const [{ state, kind, off, battery }] = made.tiles
  assert.deepEqual({ state, kind, off, battery }, { state: "muted", kind: "still", off: "0.10 m, 3° off", battery: "80%" })
  assert.equal(made.summary, "1 robot, all well")
})

test("a host says how exactly its robots dance with the others, and when nothing more is heard from it", () => {
  const made = wall({ ada: well })
  assert.deepEqual(made.links(0), [])
  made.takeLink({ host: "pi", offset: 100, error: 0.0004, round_trip: 0.004, lag: 0.052 }, 1000)
  assert.deepEqual(made.links(3000), ["pi: together within 0.4 ms, reached within 52 ms"])
  assert.deepEqual(made.links(6000), ["pi: no word for 5 s"])
})

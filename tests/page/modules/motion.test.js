// Where robots are between two messages, and the arcs that join their poses.

import assert from "node:assert/strict"
import test from "node:test"

import { Motion } from "../../../improv_core/page/static/floor/motion.js"
import { poseAfter, velocityBetween } from "../../../improv_core/page/static/base/path.js"

const poses = (i) => ({ ada: [i, 0, 2 * i, -i] })

function near(found, expected) {
  assert.ok(Math.abs(found - expected) < 1e-9, `${found} is not ${expected}`)
}

test("poses are drawn between two messages, and never ahead of the latest", () => {
  const motion = new Motion()
  for (let i = 0; i <= 4; i++) motion.take({ at: i / 4, placed: 0, poses: poses(i), joints: {} }, 100 + i / 4)
  const { robots, moving } = motion.present(100.925)
  for (const [axis, value] of Object.entries({ x: 3.5, y: 0, z: 7, heading: -3.5 })) near(robots.ada[axis], value)
  assert.ok(moving)
  const later = motion.present(102)
  assert.deepEqual([later.robots.ada.x, later.moving], [4, false])
})

test("a performance that begins again shows its own poses at once", () => {
  const motion = new Motion()
  motion.take({ at: 1, placed: 0, poses: poses(4), joints: {} }, 101)
  assert.ok(motion.take({ at: 0, placed: 1, poses: poses(7), joints: {} }, 103))
  assert.equal(motion.present(103).robots.ada.x, 7)
})

test("what is shown is smooth and never goes back, however unevenly messages arrive", () => {
  const motion = new Motion()
  const late = [0, 0.03, 0.001, 0.12, 0.05, 0, 0.09, 0.02]
  const messages = Array.from({ length: 120 }, (_, i) => ({ at: i / 60, arrives: 100 + i / 60 + late[i % late.length] }))
  const seen = []
  for (let now = 100; now < 102; now += 1 / 60) {
    while (messages.length && messages[0].arrives <= now) {
      const { at } = messages.shift()
      motion.take({ at, placed: 0, poses: { ada: [at, 0, 0, 0] }, joints: {} }, now)
    }
    const { ada } = motion.present(now).robots
    if (ada) seen.push(ada.x)
  }
  assert.deepEqual(seen, seen.toSorted((one, other) => one - other))
  assert.ok(new Set(seen).size > 60)
})

test("a robot that is put elsewhere is there all at once", () => {
  const motion = new Motion()
  motion.take({ at: 0, placed: 0, poses: poses(0), joints: {} }, 100)
  motion.take({ at: 0.1, placed: 1, poses: poses(9), joints: {} }, 100.1)
  const places = [0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.15].map((passed) => motion.present(100.05 + passed).robots.ada.x)
  assert.deepEqual([...new Set(places)], [0, 9])
})

test("the arc between two poses is the one that was driven", () => {
  const from = { x: 1, y: 2, z: 0, heading: 0.5 }
  for (const yaw of [-3, -0.5, -1e-6, 0, 1e-6, 0.5, 3]) {
    const to = poseAfter(from, { x: 1, y: 0.5, z: 0, yaw }, 1)
    const found = poseAfter(from, velocityBetween(from, to), 1)
    for (const axis of ["x", "y", "heading"]) near(found[axis], to[axis])
  }
})

test("joints are drawn between two messages, as poses are", () => {
  const motion = new Motion()
  for (let i = 0; i <= 4; i++) motion.take({ at: i / 4, placed: 0, poses: poses(i), joints: { ada: [i, -i] } }, 100 + i / 4)
  const [first, second] = motion.present(100.925).joints.ada
  near(first, 3.5)
  near(second, -3.5)
  motion.take({ at: 1.25, placed: 0, poses: poses(5), joints: { ada: [7, 8, 9] } }, 101.25)
  assert.deepEqual(motion.present(101.2).joints.ada, [7, 8, 9]) // another body
})

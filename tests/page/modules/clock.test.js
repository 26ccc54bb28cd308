// The beat that plays, from the latest transport message and the time since then.

import assert from "node:assert/strict"
import test from "node:test"

import { Clock, countIn } from "../../../improv_core/page/static/score/clock.js"

const playing = { generation: 1, restarted: 1, state: "playing", beat: 2, beats: 100, tempo: 60, performed: 2 }

test("a page counts on from the beat of the latest message, also if its clock is an hour off", (context) => {
  context.mock.timers.enable({ apis: ["Date"], now: 5_000_000 })
  for (const hour of [0, 3600, -3600]) {
    const clock = new Clock()
    clock.takeTime({ type: "time", wall: 5000 + hour })
    clock.take({ type: "transport", ...playing, wall: 4999 + hour })
    assert.equal(clock.beat(), 3)
  }
})

test("a page that heard late what time it is at the server asks, and is right then", (context) => {
  context.mock.timers.enable({ apis: ["Date"], now: 5_000_000 })
  for (const ahead of [0, 3600]) {
    const clock = new Clock()
    clock.takeTime({ type: "time", wall: 4999.6 + ahead })
    clock.take({ type: "transport", ...playing, wall: 4999 + ahead })
    clock.takeAnswer({ sent: 9.9, wall: 5000 + ahead, received: 10.1, own: 4990 })
    assert.ok(Math.abs(clock.beat() - 3) < 1e-9)
    assert.ok(Math.abs(clock.ahead - (4990 + ahead)) < 1e-9)
    clock.takeTime({ type: "time", wall: 4999 + ahead })
    assert.ok(Math.abs(clock.beat() - 3) < 1e-9, "an answer says more")
  }
})

test("the beats before beat 0 are counted from 1, and only these", () => {
  const clock = new Clock()
  clock.takeArmed({ type: "armed", generation: 1, armed: true, begins: 100, count: { beats: 4, period: 0.5 } })
  const counted = (now) => countIn(clock.count, now).number
  assert.deepEqual([97.9, 98, 98.25, 98.5, 99, 99.5, 99.9, 100.2].map(counted), [0, 1, 1, 2, 3, 4, 4, 4])
  assert.ok(Math.abs(countIn(clock.count, 98.375).passed - 0.75) < 1e-3)
  for (const change of [{ count: undefined }, { begins: null }, { armed: false }]) {
    const other = new Clock()
    other.takeArmed({ ...clock.armed, ...change })
    assert.equal(countIn(other.count, 99).number, 0)
  }
})

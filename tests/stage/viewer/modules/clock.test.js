// The beat that plays, from the latest transport message and the time since then.

import assert from "node:assert/strict"
import test from "node:test"

import { Clock } from "../../../../improv_core/stage/viewer/page/clock.js"

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

// By how much the server's clock is ahead of the page's, from answers that take more or less time.

import assert from "node:assert/strict"
import test from "node:test"

import { aheadBy, answered } from "../../../../improv_core/stage/viewer/page/ahead.js"

/** A question to a server whose clock is this far ahead; its way there and back, in seconds. */
const asked = (sent, ahead, there, back) => ({ sent, wall: sent + ahead + there, received: sent + there + back })
const after = (...answers) => answers.reduce((known, answer) => answered(known, answer), [])

test("without an answer, nothing is known", () => {
  assert.equal(aheadBy([]), null)
})

test("the fastest answer counts, so a late one does no harm", () => {
  const found = aheadBy(after(asked(1, 1000, 0.05, 0.05), asked(2, 1000, 0.001, 0.001), asked(3, 1000, 0.3, 0.001)))
  assert.ok(Math.abs(found - 1000) < 1e-9)
})

test("after the server's clock was set, only later answers count", () => {
  const found = aheadBy(after(asked(1, 1000, 0.001, 0.001), asked(2, 1060, 0.01, 0.01)))
  assert.ok(Math.abs(found - 1060) < 1e-9)
})

test("only the latest eight are kept: clocks drift", () => {
  const answers = after(asked(0, 1000, 0.001, 0.001), ...Array.from({ length: 9 }, (_, n) => asked(n + 1, 1000.002, 0.01, 0.01)))
  assert.equal(answers.length, 8)
  assert.ok(Math.abs(aheadBy(answers) - 1000.002) < 1e-9)
})

// By how much the server's clock is ahead of the page's, from answers that take more or less time.

import assert from "node:assert/strict"
import test from "node:test"

import { clockOffset, withAnswer } from "../../../improv_core/page/static/net/clock-offset.js"

/** A question to a server whose clock is this far ahead; its way there and back, and the page's own clock, in seconds. */
const asked = (sent, ahead, there, back, own = 0) => ({ sent, wall: sent + ahead + there, received: sent + there + back, own })
const after = (...answers) => answers.reduce((known, answer) => withAnswer(known, answer), [])
const check = (expected, ...answers) => assert.ok(Math.abs(clockOffset(after(...answers)) - expected) < 1e-9, String(clockOffset(after(...answers))))

test("without an answer, nothing is known", () => {
  assert.equal(clockOffset([]), null)
})

test("an answer is right if it took as long as its question", () => {
  check(1000, asked(1, 1000, 0.05, 0.05))
})

test("a question that was quick and an answer that was quick are enough, also if the rest of them was slow", () => {
  check(999.9995, asked(1, 1000, 0.001, 0.3), asked(2, 1000, 0.2, 0.002))
})

test("if the server's clock is that of the page's machine, answers may be as slow as they like", () => {
  check(1000, asked(1, 1000, 0.2, 0.01, 1000), asked(2, 1000, 0.3, 0.05, 1000))
})

test("a machine whose clock differs doesn't count", () => {
  check(1000, asked(1, 1000, 0.01, 0.01, 999.9), asked(2, 1000, 0.02, 0.02, 999.9))
})

test("after the server's clock was set, only later answers count", () => {
  check(1060, asked(1, 1000, 0.001, 0.001), asked(2, 1060, 0.01, 0.01))
})

test("only the latest twelve are kept: clocks drift", () => {
  const answers = after(asked(0, 1000, 0.001, 0.001), ...Array.from({ length: 13 }, (_, n) => asked(n + 1, 1000.001, 0.01, 0.01)))
  assert.equal(answers.length, 12)
  assert.ok(Math.abs(clockOffset(answers) - 1000.001) < 1e-9)
})

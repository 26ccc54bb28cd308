// A child's dance on its way to the teacher: what the child reads is what has happened.

import assert from "node:assert/strict"
import test from "node:test"

import { when } from "../../../improv_core/page/static/base/when.js"
import { answered, asked, describe, UNSENT } from "../../../improv_core/page/static/website/handing-in.js"

const AT = Date.UTC(2026, 1, 3, 10, 32)
const OFFLINE = { status: 0, problem: "the class doesn't answer" }
const sent = answered(asked(UNSENT, "a"), { status: 200 }, AT)

test("a dance is not sent, being sent, then sent, and changed once its text is another one", () => {
  assert.equal(describe(UNSENT, "a"), "Not sent yet.")
  assert.equal(describe(asked(UNSENT, "a"), "a"), "Sending…")
  assert.equal(describe(sent, "a"), `Sent at ${when(AT)}.`)
  assert.equal(describe(sent, "b"), `Changed since you sent it at ${when(AT)}.`)
  assert.equal(describe(sent, "a"), `Sent at ${when(AT)}.`) // back to the text that the class has
})

test("a time has its day, unless that is today", ({ mock }) => {
  mock.timers.enable({ apis: ["Date"], now: AT })
  assert.doesNotMatch(when(AT), /2026/)
  assert.match(when(AT - 7 * 24 * 3600 * 1000), /2026/)
})

test("a dance that the class has not received is never shown as sent, even if an earlier one was", () => {
  const lost = answered(asked(sent, "b"), OFFLINE, AT)
  assert.equal(describe(lost, "b"), "Not received: the class doesn't answer.")
  assert.equal(describe(answered(asked(lost, "b"), { status: 200 }, AT + 60_000), "b"), `Sent at ${when(AT + 60_000)}.`)
})

test("a tap while a dance is on its way sends another text after it, and the same one not again", () => {
  const sending = asked(UNSENT, "a")
  assert.equal(asked(sending, "a").again, false)
  const twice = asked(sending, "b")
  assert.deepEqual([twice.text, twice.again], ["a", true])
  assert.equal(answered(twice, { status: 200 }, AT).again, true)
  assert.equal(answered(twice, OFFLINE, AT).again, false) // nothing is sent again and again to a class that is gone
})

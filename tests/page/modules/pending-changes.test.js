// Robots that are moved one after the other are written one after the other, each into the text that the one before has left.

import assert from "node:assert/strict"
import test from "node:test"

import { sendBy } from "../../../improv_core/page/static/net/send.js"
import { PendingChanges } from "../../../improv_core/page/static/editor/pending-changes.js"

const ADA = { type: "place", start_poses: { ada: { x: 1, y: 2, heading: 0 } } }
const LINE = { type: "arrange", shape: "line", distance: 2, facing: "in" }
const EDITS = [{ start: 0, end: 0, text: "ada at 1 2\n" }]

/** Moves in a text with number 3 that the server knows, and what happens because of them. */
function moves() {
  const page = { number: 3, known: true, log: [] }
  const text = {
    known: () => (page.known ? page.number : null),
    edit: () => {
      page.log.push("edit")
      page.number++
      page.known = false
    },
    say: (problem) => problem && page.log.push(problem),
    save: () => page.log.push("save"),
  }
  sendBy(({ number, change }) => page.log.push(`${change.type} in ${number}`))
  page.pendingChanges = new PendingChanges(text)
  page.answer = (number, edits = EDITS, problem = "") => page.pendingChanges.take({ type: "change", number, edits, problem })
  page.learn = () => {
    page.known = true
    page.pendingChanges.ask()
  }
  return page
}

test("the next one waits until the server has the text after the one before", () => {
  const page = moves()
  page.pendingChanges.add(ADA)
  page.pendingChanges.add(LINE)
  page.answer(3)
  assert.deepEqual(page.log, ["place in 3", "edit"])
  page.learn()
  page.answer(4)
  assert.deepEqual(page.log, ["place in 3", "edit", "arrange in 4", "edit"])
  assert.ok(!page.pendingChanges.open)
})

test("an answer about a text that has been edited since is asked for again", () => {
  const page = moves()
  page.pendingChanges.add(ADA)
  page.number++
  page.answer(3)
  page.learn()
  assert.deepEqual(page.log, ["place in 3", "place in 4"])
})

test("the text is saved after all of them", () => {
  const page = moves()
  assert.ok(!page.pendingChanges.saveAfter())
  page.pendingChanges.add(ADA)
  assert.ok(page.pendingChanges.saveAfter())
  page.answer(3)
  assert.deepEqual(page.log, ["place in 3", "edit", "save"])
})

test("why nothing was written is said, and nothing is edited", () => {
  const page = moves()
  page.pendingChanges.add(ADA)
  page.answer(3, [], "fix it first")
  assert.deepEqual(page.log, ["place in 3", "fix it first"])
})

test("after the connection was lost, it is asked again", () => {
  const page = moves()
  page.pendingChanges.add(ADA)
  page.pendingChanges.forget()
  page.learn()
  assert.deepEqual(page.log, ["place in 3", "place in 3"])
})

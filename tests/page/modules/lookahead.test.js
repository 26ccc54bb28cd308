// What comes next, fetched piece by piece, and again when senses may have changed it.

import assert from "node:assert/strict"
import { test } from "node:test"
import { Lookahead, partsOf } from "../../../improv_core/page/static/score/lookahead.js"

const SCORE = { generation: 1, beats: null, tempo: 60, text: "a program", words: {}, offsets: { 0: 0 }, robots: { r: { ends: null, senses: { near: {} } } } }

/** A lookahead, what it asks for, and a function that answers with segments of one beat with these words. */
function looking() {
  const asked = []
  const lookahead = new Lookahead(SCORE, (from, to) => asked.push([from, to]))
  const answer = (word) => {
    const [from, to] = asked.at(-1)
    const moments = []
    for (let start = from; start < to; start++) moments.push([start, 1, 1, 0, 0, 0, [[0, word, word + 1]]])
    lookahead.take({ generation: 1, from, to, robots: { r: { pose: [0, 0, 0, 0], moments, body: {}, until: to } } })
  }
  const words = (...beats) => beats.map((beat) => lookahead.at("r", null, beat)?.words[0][0])
  return { lookahead, asked, answer, words }
}

test("what was known is shown until the server has told what senses have changed", (context) => {
  let now = 0
  context.mock.method(performance, "now", () => now)
  const { lookahead, asked, answer, words } = looking()
  lookahead.want(0)
  answer(1)
  assert.deepEqual(words(0, 20, 30), [1, 1, 1])
  lookahead.renew(20.5)
  lookahead.renew(20.6) // while nothing has been asked
  assert.deepEqual(words(20), [1])
  now += 1000
  lookahead.want(20.7)
  assert.deepEqual(asked.at(-1), [12, 60])
  assert.deepEqual(words(20), [1])
  lookahead.renew(20.8) // after it was asked, so its answer may be out of date
  answer(2)
  assert.deepEqual(words(12, 20), [2, 2])
  now += 1000
  lookahead.want(20.9)
  answer(3)
  assert.deepEqual(words(12, 20), [3, 3])
  assert.equal(asked.length, 3)
})

test("a change is asked for again if the connection was lost", (context) => {
  let now = 0
  context.mock.method(performance, "now", () => now)
  const { lookahead, asked, answer, words } = looking()
  lookahead.want(0)
  answer(1)
  lookahead.renew(10)
  now += 1000
  lookahead.want(10)
  lookahead.askAgain()
  lookahead.want(10)
  answer(2)
  assert.deepEqual(words(10), [2])
  assert.equal(asked.length, 3)
})

test("each body part that moves is known for itself", () => {
  const body = ["head", "arm"].map((name) => ({ name, joints: [], moves: name === "head" }))
  const score = { ...SCORE, beats: 2, robots: { r: { ends: 2, senses: {}, body } } }
  const lookahead = new Lookahead(score, () => {})
  assert.deepEqual(partsOf(score, "r"), [null, "head"])
  lookahead.want(0)
  const moment = (start, beats, word) => [start, beats, 0, 0, 0, 1, [[0, word, word + 1]]]
  const moves = { pose: [0, 0, 0, 0], moments: [moment(0, 2, 5)], body: { head: [moment(0, 1, 7), moment(1, 1, 8)] }, until: 2 }
  lookahead.take({ generation: 1, from: 0, to: 2, robots: { r: moves } })
  assert.deepEqual([0, 1].map((beat) => lookahead.at("r", "head", beat).words[0][0]), [7, 8])
  assert.deepEqual([0, 1].map((beat) => lookahead.at("r", null, beat).words[0][0]), [5, 5])
  assert.equal(lookahead.at("r", "arm", 0), undefined)
})

test("words are found in a text with emoji, though the server counts code points", () => {
  const text = "# 🤖🤖\nr $ left"
  const lookahead = new Lookahead({ ...SCORE, text, offsets: { 3: 5 } }, () => {})
  assert.deepEqual(lookahead.spans([3, 4, 8]).map((span) => lookahead.text.word(span)), ["left"])
  assert.deepEqual(lookahead.spans([7, 0, 1]), []) // of a statement that is no longer there
})

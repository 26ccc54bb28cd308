// When the server is asked what plays: editors/vscode/src/words.ts, with a clock that the test turns.

import assert from "node:assert/strict"
import { afterEach, beforeEach, mock, test } from "node:test"
import { PlayingWords } from "../../../editors/vscode/src/words.ts"
import { close, document, lit, open, type } from "./vscode.mjs"

const PATIENCE = 500 // ms, as src/words.ts has it
const TRANSPORT = { generation: 1, state: "playing", beat: 0, beats: null, tempo: 60, muted: [], soloed: [] }

mock.timers.enable({ apis: ["setTimeout", "Date"] })

let words, asked

beforeEach(() => {
  open()
  asked = []
  words = new PlayingWords((beat) => new Promise((answer) => asked.push({ beat, answer })))
})

afterEach(() => words.dispose())

/** The document's first word plays, for ever or as far as the server tells. */
function evaluated({ generation = 1, until = null, from = 0 } = {}) {
  const moments = [[0, until ?? 1e9, [0]]]
  const { uri, version } = document
  return { uri, version, generation, from, ranges: [[0, 0, 0, 1]], robots: { one: { moments, until } } }
}

function play(transport = {}) {
  words.setTransport({ ...TRANSPORT, wall: Date.now() / 1000, ...transport })
}

async function answer(its) {
  asked.at(-1).answer(its)
  await new Promise(setImmediate)
}

test("what the server tells is lit, and nothing is asked", () => {
  words.expect(evaluated())
  play()
  assert.deepEqual(lit, [[0, 0, 0, 1]])
  mock.timers.tick(10 * PATIENCE)
  assert.equal(asked.length, 0)
})

for (const state of ["playing", "paused"]) {
  test(`${state}: who types on is asked about again, until it is known where the words are`, async () => {
    const early = evaluated()
    type("# ")
    words.expect(early)
    play({ state })
    assert.deepEqual(lit, [])
    const late = evaluated()
    type("# ")
    await answer(late)
    assert.deepEqual(lit, [])
    assert.equal(asked.length, 1)
    mock.timers.tick(2 * PATIENCE)
    assert.equal(asked.length, 2)
    await answer(evaluated())
    assert.deepEqual(lit, [[0, 0, 0, 1]])
    mock.timers.tick(10 * PATIENCE)
    assert.equal(asked.length, 2)
  })
}

test("a save right after another is asked about, too", async () => {
  play()
  for (const generation of [1, 2]) {
    const early = evaluated({ generation })
    type("# ")
    words.expect(early)
    play({ generation })
    if (generation === 1) await answer(evaluated({ generation }))
  }
  assert.deepEqual(lit, [])
  mock.timers.tick(2 * PATIENCE)
  await answer(evaluated({ generation: 2 }))
  assert.deepEqual(lit, [[0, 0, 0, 1]])
})

test("an answer holds from the beat on that was asked for", async () => {
  words.expect(evaluated({ until: 8 }))
  play({ beat: 9 })
  assert.equal(asked.at(-1).beat, 9)
  await answer({ ...evaluated({ from: 9 }), robots: { one: { moments: [], until: null } } }) // nothing plays there
  assert.deepEqual(lit, [])
  mock.timers.tick(PATIENCE)
  play({ beat: 0 })
  assert.equal(asked.at(-1).beat, 0)
})

test("a document that was closed may be another when it is opened again", async () => {
  words.expect(evaluated())
  play()
  close()
  mock.timers.tick(10 * PATIENCE)
  assert.equal(asked.length, 0)
  open()
  assert.deepEqual(lit, [])
  await answer(evaluated())
  assert.deepEqual(lit, [[0, 0, 0, 1]])
})

test("a new server counts its generations anew", () => {
  words.expect(evaluated())
  play()
  words.setTransport(undefined)
  play()
  assert.deepEqual(lit, [])
})

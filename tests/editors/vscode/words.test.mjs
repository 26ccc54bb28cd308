// Which words are highlighted, by what the server says is lit: editors/vscode/src/words.ts.

import assert from "node:assert/strict"
import { afterEach, beforeEach, test } from "node:test"
import { LitWords } from "../../../editors/vscode/src/words.ts"
import { close, document, lit, open, type } from "./vscode.mjs"

let words

beforeEach(() => {
  open()
  words = new LitWords()
})

afterEach(() => words.dispose())

/** The server says that these words are lit in the document as it is now. */
function light(...ranges) {
  words.show({ uri: document.uri, version: document.version, ranges })
}

test("what the server says is lit, until it says otherwise", () => {
  light([0, 0, 0, 1], [0, 2, 0, 3])
  assert.deepEqual(lit, [[0, 0, 0, 1], [0, 2, 0, 3]])
  light([0, 2, 0, 3])
  assert.deepEqual(lit, [[0, 2, 0, 3]])
  light()
  assert.deepEqual(lit, [])
})

test("what was just played is lit for a moment", (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] })
  words.flash({ uri: document.uri, version: document.version - 1, range: [0, 0, 0, 9] })
  assert.deepEqual(lit, [])
  words.flash({ uri: document.uri, version: document.version, range: [0, 0, 0, 9] })
  assert.deepEqual(lit, [[0, 0, 0, 9]])
  context.mock.timers.tick(1000)
  assert.deepEqual(lit, [])
})

test("highlights move with the text until the server has the text, too", () => {
  light([0, 0, 0, 1])
  const { version } = document
  type()
  words.show({ uri: document.uri, version, ranges: [[0, 4, 0, 5]] })
  assert.deepEqual(lit, [[0, 0, 0, 1]]) // VS Code itself has moved it
  light([0, 2, 0, 3])
  assert.deepEqual(lit, [[0, 2, 0, 3]])
})

test("nothing is lit, whoever types, once nothing plays", () => {
  light([0, 0, 0, 1])
  const { version } = document
  type()
  words.show({ uri: document.uri, version, ranges: [] })
  assert.deepEqual(lit, [])
  light([0, 0, 0, 1])
  words.show(undefined) // the server is gone
  assert.deepEqual(lit, [])
})

test("other documents stay dark", () => {
  words.show({ uri: "file:///other.improv", version: document.version, ranges: [[0, 0, 0, 1]] })
  assert.deepEqual(lit, [])
})

test("a document that is shown again is lit again, unless it was closed", () => {
  light([0, 0, 0, 1])
  open()
  assert.deepEqual(lit, [[0, 0, 0, 1]])
  close()
  open()
  assert.deepEqual(lit, [])
})

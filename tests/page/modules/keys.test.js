// Keys by the letters that people see on them, whatever the keyboard.

import assert from "node:assert/strict"
import test from "node:test"

import { keyOf } from "../../../improv_core/page/static/base/keys.js"

const KEYS = {
  "a letter": [["s", "KeyS"], "s"],
  "a letter with Caps Lock": [["S", "KeyS"], "s"],
  "a letter at another place on a Latin keyboard": [["s", "Semicolon"], "s"],
  "a Cyrillic letter": [["\u044B", "KeyS"], "s"],
  "a Cyrillic letter with Caps Lock": [["\u042B", "KeyS"], "s"],
  "a Greek letter": [["\u03BA", "KeyK"], "k"],
  "a Cyrillic letter where others have a bracket": [["\u0445", "BracketLeft"], "["],
  "a sign": [["?", "Digit7"], "?"],
  "a key with a name": [["ArrowLeft", "ArrowLeft"], "ArrowLeft"],
  "a key without a place": [["K", ""], "k"],
}
for (const [what, [[key, code], expected]] of Object.entries(KEYS)) {
  test(`${what} is ${expected}`, () => assert.equal(keyOf({ key, code }), expected))
}

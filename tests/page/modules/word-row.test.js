// Words that are tapped instead of typed.

import assert from "node:assert/strict"
import { test } from "node:test"

import { spaced } from "../../../improv_core/page/static/editor/word-row.js"

test("words are set apart from what is there", () => {
  for (const [before, word, after] of [
    ["", "repeat", "repeat "],
    ["ada", "$", "ada $ "],
    ["ada $ ", "forward", "ada $ forward "],
    ["ada $ forward", "left", "ada $ forward left "],
    ["repeat 4", "(", "repeat 4 ("],
    ["repeat 4 (", "left", "repeat 4 (left "],
    ["repeat 4 (left", ")", "repeat 4 (left) "],
    ["one\n", "left", "one\nleft "],
  ]) {
    assert.equal(before + spaced(before, before.length, word), after)
  }
})

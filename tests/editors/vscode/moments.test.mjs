// Which words are lit, and where they are after an edit: editors/vscode/src/moments.ts.

import assert from "node:assert/strict"
import { test } from "node:test"
import { edited, playing, reaches } from "../../../editors/vscode/src/moments.ts"

/** In `before`, ‹…› is a word that plays, and what is between ^ and ^ is replaced; in `after` it is where it is then. */
function check(before, text, after) {
  const plain = before.replaceAll(/[‹›]/g, "")
  const [head, gone = "", tail = ""] = plain.split("^")
  const place = found(before.replaceAll("^", ""))
  const range = { start: position(head), end: position(head + gone) }
  const [now] = edited([place], { range, text })
  assert.equal(head + text + tail, after.replaceAll(/[‹›]/g, ""))
  assert.deepEqual(now, found(after))
}

function found(marked) {
  const [head, word] = marked.split(/[‹›]/)
  if (word === undefined) return null
  const [start, end] = [position(head), position(head + word)]
  return [start.line, start.character, end.line, end.character]
}

function position(text) {
  const lines = text.split(/\r\n|\r|\n/)
  return { line: lines.length - 1, character: lines.at(-1).length }
}

test("a word moves with what is before it, and stays where something is after it", () => {
  check("^one^ ‹left› two", "1", "1 ‹left› two")
  check("^^one ‹left› two", "# above\n", "# above\none ‹left› two")
  check("one^ ^‹left› two", "\r\n", "one\r\n‹left› two")
  check("one^\n^‹left› two", " ", "one ‹left› two")
  check("a\n^b\nc\n^d ‹left›", "", "a\nd ‹left›")
  check("a^\nb^ ‹left›", "\nx\nyy", "a\nx\nyy ‹left›")
  check("one ‹left› ^two^", "three", "one ‹left› three")
  check("one\n‹left›\n^^two", "x\n", "one\n‹left›\nx\ntwo")
  check("💃 ^^‹left›", "💃 ", "💃 💃 ‹left›")
})

test("a word that is touched is none any more", () => {
  check("one ‹^left^› two", "right", "one right two")
  check("one ‹le^^ft› two", " ", "one le ft two")
  check("one ‹left›^^ two", "y", "one lefty two")
  check("one ^^‹left› two", "half", "one halfleft two")
  check("^one ‹le^ft› two", "", "ft two")
})

test("brackets and blanks beside a word do not touch it", () => {
  check("one ‹left›^^", " two", "one ‹left› two")
  check("one ^^‹left›", "(", "one (‹left›")
  check("one ‹left›^^", ")", "one ‹left›)")
})

const EVALUATED = {
  from: 0,
  ranges: [[0, 0, 0, 1], [0, 2, 0, 3], null],
  robots: {
    one: { moments: [[0, 1, [0]], [1, 2.5, [1, 2]]], until: null },
    two: { moments: [[0, 1.5, [0]]], until: 1.5 },
  },
}

test("words are lit from their first beat to their last", () => {
  const at = (beat, silent = () => false) => {
    const { ranges, next } = playing(EVALUATED, beat, silent)
    return [ranges.map(([, column]) => column), next]
  }
  assert.deepEqual(at(0), [[0], 1])
  assert.deepEqual(at(0.99), [[0], 1])
  assert.deepEqual(at(1), [[2, 0], 1.5])
  assert.deepEqual(at(1.5), [[2], 2.5])
  assert.deepEqual(at(2.5), [[], Infinity])
  assert.deepEqual(at(1, (robot) => robot === "two"), [[2], 1.5])
})

test("more is to be asked for where what is known ends", () => {
  assert.deepEqual([0, 1.4, 1.5, 9].map((beat) => reaches(EVALUATED, beat)), [true, true, false, false])
  assert.deepEqual([0, 1, 1.4].map((beat) => reaches({ ...EVALUATED, from: 1 }, beat)), [false, true, true])
})

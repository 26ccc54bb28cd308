// @ts-check
// What the server says about a text that is written: its colors and its diagnostics, by offsets in UTF-16 units.

/** @import { CodePoints } from "../base/code-points.js" */
/** @import { Diagnostic } from "./diagnostics.js" */
/** @import { Color } from "./highlight.js" */

// In the order of improv_core/ide/semantic_tokens_legend.py.
const KINDS = [
  "comment", "keyword", "function", "variable", "class", "enumMember", "number", "operator", "modifier", "parameter", "property",
]

/**
 * The numbers of a text's colors, from those of the one before.
 * @param {number[]} before
 * @param {Messages["analyze"]["colors"]} change
 */
export const changed = (before, change) => [...before.slice(0, change.first), ...change.new, ...before.slice(before.length - change.last)]

/**
 * @param {number[]} numbers three for each color: the code points between the one before and it, its length, and its kind
 * @param {CodePoints} codePoints of the text
 */
export function readColors(numbers, codePoints) {
  /** @type {Color[]} */
  const found = []
  for (let i = 0, at = 0; i < numbers.length; i += 3) {
    const start = at + numbers[i]
    at = start + numbers[i + 1]
    found.push({ start: codePoints.toUnits(start), end: codePoints.toUnits(at), name: KINDS[numbers[i + 2]] })
  }
  return found
}

/** @param {Color[]} one @param {Color[]} other */
export const isSame = (one, other) =>
  one.length === other.length && one.every(({ start, end, name }, i) => start === other[i].start && end === other[i].end && name === other[i].name)

/** @param {Messages["check"]["problems"]} problems @param {CodePoints} codePoints of the text @returns {Diagnostic[]} */
export const readProblems = (problems, codePoints) =>
  problems.map((problem) => ({
    ...codePoints.inUnits(problem),
    fixes: problem.fixes.map((fix) => ({ ...fix, edits: fix.edits.map((edit) => codePoints.inUnits(edit)) })),
  }))

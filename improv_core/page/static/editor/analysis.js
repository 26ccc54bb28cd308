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
 * @param {Messages["analyze"]} message has a color as three numbers: the code points between the one before and it, its
 *   length, and its kind
 * @param {CodePoints} codePoints of the text
 * @returns {{ colors: Color[], diagnostics: Diagnostic[] }}
 */
export function readAnalysis({ colors, problems }, codePoints) {
  /** @type {Color[]} */
  const found = []
  for (let i = 0, at = 0; i < colors.length; i += 3) {
    const start = at + colors[i]
    at = start + colors[i + 1]
    found.push({ ...codePoints.inUnits({ start, end: at }), name: KINDS[colors[i + 2]] })
  }
  const diagnostics = problems.map((problem) => ({
    ...codePoints.inUnits(problem),
    fixes: problem.fixes.map((fix) => ({ ...fix, edits: fix.edits.map((edit) => codePoints.inUnits(edit)) })),
  }))
  return { colors: found, diagnostics }
}

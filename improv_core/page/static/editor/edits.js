// @ts-check
// Edits of a text, and what they do to marks on it. Offsets count UTF-16 units.

/** @typedef {{ start: number, end: number, text: string }} Edit replaces the text from start to end */
/** @typedef {{ start: number, end: number }} Span */

/**
 * One edit that turns a text into another.
 * @param {string} before
 * @param {string} after
 * @returns {Edit}
 */
export function difference(before, after) {
  const most = Math.min(before.length, after.length)
  let start = 0
  while (start < most && before.charCodeAt(start) === after.charCodeAt(start)) start++
  let same = 0
  while (same < most - start && before.charCodeAt(before.length - 1 - same) === after.charCodeAt(after.length - 1 - same)) same++
  return { start, end: before.length - same, text: after.slice(start, after.length - same) }
}

/**
 * The text after several edits, all of which count from before the first one.
 * @param {string} text
 * @param {Edit[]} edits in order
 */
export function applyEdits(text, edits) {
  return edits.reduceRight((now, { start, end, text: put }) => now.slice(0, start) + put + now.slice(end), text)
}

/**
 * Marks after an edit: they move along, and those that it touches in part are gone.
 * @template {Span} T
 * @param {T[]} marks
 * @param {Edit} edit
 * @returns {T[]}
 */
export function marksAfter(marks, { start, end, text }) {
  const by = text.length - (end - start)
  /** @type {T[]} */
  const found = []
  for (const mark of marks) {
    if (mark.end <= start) found.push(mark)
    else if (mark.start >= end) found.push({ ...mark, start: mark.start + by, end: mark.end + by })
    else if (mark.start <= start && mark.end >= end) found.push({ ...mark, end: mark.end + by })
  }
  return found
}

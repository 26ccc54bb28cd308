// @ts-check
// Edits of a text, and what they do to marks on it. Offsets count UTF-16 units.

/** @typedef {{ start: number, end: number, text: string }} Edit replaces the text from start to end */
/** @typedef {{ start: number, end: number }} Span */

/**
 * The number of items that two lists, or texts, share at their beginnings, and then at their ends.
 * @param {ArrayLike<string>} before
 * @param {ArrayLike<string>} after
 */
export function sharedEnds(before, after) {
  const most = Math.min(before.length, after.length)
  let first = 0
  while (first < most && before[first] === after[first]) first++
  let last = 0
  while (last < most - first && before[before.length - 1 - last] === after[after.length - 1 - last]) last++
  return [first, last]
}

/**
 * One edit that turns a text into another.
 * @param {string} before
 * @param {string} after
 * @returns {Edit}
 */
export function difference(before, after) {
  const [start, last] = sharedEnds(before, after)
  return { start, end: before.length - last, text: after.slice(start, after.length - last) }
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

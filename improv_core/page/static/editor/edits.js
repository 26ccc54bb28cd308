// @ts-check
// Edits of a text, and what they do to marks on it. Offsets count UTF-16 units.

import { partitionPoint } from "../base/search.js"

/** @typedef {{ start: number, end: number, text: string }} Edit replaces the text from start to end */
/** @typedef {{ start: number, end: number }} Span */

/**
 * One edit that turns a text into another.
 * @param {string} before
 * @param {string} after
 * @returns {Edit}
 */
export function difference(before, after) {
  // Parts of texts are compared eight times as fast as their characters in a loop.
  const most = Math.min(before.length, after.length)
  const start = partitionPoint(most, (i) => before.slice(0, i + 1) === after.slice(0, i + 1))
  const last = partitionPoint(most - start, (i) => before.slice(before.length - 1 - i) === after.slice(after.length - 1 - i))
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

const LETTERS = /^[\p{L}\p{M}\p{N}_]+$/u

/**
 * Marks after an edit: they move along, words continue with letters behind them, and marks that it touches in part are gone.
 * @template {Span} T
 * @param {T[]} marks
 * @param {Edit} edit
 * @returns {T[]}
 */
export function marksAfter(marks, { start, end, text }) {
  const by = text.length - (end - start)
  const written = start === end && LETTERS.test(text)
  /** @type {T[]} */
  const found = []
  for (const mark of marks) {
    if (mark.end < start || (mark.end === start && !(written && mark.start < start))) found.push(mark)
    else if (mark.start >= end) found.push({ ...mark, start: mark.start + by, end: mark.end + by })
    else if (mark.start <= start && mark.end >= end) found.push({ ...mark, end: mark.end + by })
  }
  return found
}

/**
 * What is at offsets of a text after an edit: it moves along, and what the edit touches is gone.
 * @template T
 * @param {Map<number, T>} all
 * @param {Edit} edit
 */
export function offsetsAfter(all, { start, end, text }) {
  /** @type {Map<number, T>} */
  const found = new Map()
  for (const [offset, each] of all) {
    if (offset < start) found.set(offset, each)
    else if (offset >= end) found.set(offset + text.length - (end - start), each)
  }
  return found
}

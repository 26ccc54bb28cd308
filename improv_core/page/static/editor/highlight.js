// @ts-check
// The program's text in colors: alone, or below the text control that it is written in, which breaks lines at the same
// places.

import { element } from "../base/elements.js"
import { partitionPoint } from "../base/search.js"

/** @import { Span } from "./edits.js" */
/** @typedef {Span & { name: string }} Color of a class of the style sheet */
/** @typedef {{ color: string, moves: boolean }} Light on a word that moves a robot, or that names something that does */
/** @typedef {Span & { severity: string }} Underline */
/** @typedef {{ start: number, name: string, text: string }} Piece of a line, of some classes or none */
/** @typedef {Piece & { node: Text }} Shown */
/** @typedef {{ key: string, number: number, element: HTMLElement, pieces: Shown[] }} Line */

export class Highlight {
  #parts = ["far", "", "far"].map((className) => element("section", { className })) // what is above, near, and below the view
  /** @type {Line[]} */
  #lines = []
  /** @type {number[]} */
  #starts = [] // of lines
  /** @type {[number, number]} */
  #near = [0, Infinity] // the first line that has colors, and the one after the last
  #looked = false // whether these may be others since lines were last put into their parts
  /** @type {Set<HTMLElement>} */
  lit = new Set() // words

  /** @param {HTMLElement} sheet */
  constructor(sheet) {
    sheet.append(...this.#parts)
  }

  /**
   * Shows a text, and the colors near what was visible at the latest look. Only lines that have changed are made again.
   * @param {string} text
   * @param {Color[]} colors in order
   * @param {Underline[]} underlines
   */
  show(text, colors, underlines) {
    const before = this.#lines
    const added = text.split("\n").length - before.length
    if (added) this.#near[1] = Math.max(this.#near[0], this.#near[1] + added) // what was in view stays in its part
    this.#looked ||= added !== 0
    const wanted = described(text, colors, underlines, this.#near)
    const [first, same] = sharedEnds(before.map(({ key }) => key), wanted.map(({ key }) => key))
    const old = before.slice(first, before.length - same)
    const now = wanted.slice(first, wanted.length - same)
    const made = now.map((line, i) => drawn(line, old.length === now.length ? old[i] : null))
    for (const [i, { element }] of old.entries()) if (element !== made[i]?.element) element.remove()
    this.#lines = [...before.slice(0, first), ...made, ...before.slice(before.length - same)]
    for (const [i, { number }] of wanted.entries()) renumber(this.#lines[i], number)
    const [from, to] = this.#looked ? [0, this.#lines.length] : [first, first + made.length]
    this.#looked = false
    for (let i = to - 1; i >= from; i--) {
      const { element } = this.#lines[i]
      const part = this.#parts[i < this.#near[0] ? 0 : i < this.#near[1] ? 1 : 2]
      const after = this.#lines[i + 1]?.element
      const next = after?.parentElement === part ? after : null
      if (element.parentElement !== part || element.nextSibling !== next) part.insertBefore(element, next)
    }
    this.#starts = wanted.map(({ start }) => start)
  }

  /**
   * Has only lines near what a scroller shows have colors: browsers paint much more than that, with every key. To look
   * has them lay the page out, if it has changed: not with every key.
   * @param {HTMLElement} scroller
   */
  look(scroller) {
    const { top, bottom, height } = scroller.getBoundingClientRect()
    this.#looked = true
    this.#near = [this.#lineAt(top - height / 4), this.#lineAt(bottom + height / 4) + 1]
  }

  get lines() {
    return this.#lines.length
  }

  /** Lights words, given by offset. @param {Map<number, Light>} lights */
  light(lights) {
    const lit = new Set()
    for (const [offset, { color, moves }] of lights) {
      const index = this.#line(offset)
      const word = this.#lines[index]?.pieces.find(({ start, name }) => name && start === offset - this.#starts[index])?.node.parentElement
      if (!word) continue
      lit.add(word)
      word.classList.add("lit")
      word.classList.toggle("moving", moves)
      word.style.setProperty("--robot", color)
    }
    for (const word of this.lit) if (!lit.has(word)) word.classList.remove("lit", "moving")
    this.lit = lit
  }

  /** The cursor's place on the screen at an offset. @param {number} offset */
  place(offset) {
    const index = this.#line(offset)
    const { element } = this.#lines[index]
    let rest = offset - this.#starts[index]
    const walker = document.createTreeWalker(element, NodeFilter.SHOW_TEXT)
    let node = walker.nextNode()
    while (node && rest > (node.nodeValue ?? "").length) {
      rest -= (node.nodeValue ?? "").length
      node = walker.nextNode()
    }
    const { left, top, bottom } = element.getBoundingClientRect()
    if (!node || !rest) return node && offset > this.#starts[index] ? edge(node, rest) : { left, top, bottom: Math.min(bottom, top + 30) }
    return edge(node, rest)
  }

  /**
   * The word at a point of the screen: where it starts and ends in the text.
   * @param {number} x
   * @param {number} y
   * @returns {Span | null}
   */
  wordAt(x, y) {
    const index = this.#lineAt(y)
    for (const { start, name, text, node } of this.#lines[index]?.pieces ?? []) {
      for (const { left, right, top, bottom } of (name && node.parentElement?.getClientRects()) || []) {
        if (left <= x && x < right && top <= y && y < bottom) {
          const from = this.#starts[index] + start
          return { start: from, end: from + text.length }
        }
      }
    }
    return null
  }

  /** The line at a height of the screen, or the first below it. @param {number} y */
  #lineAt(y) {
    return partitionPoint(this.#lines.length, (i) => this.#lines[i].element.getBoundingClientRect().bottom <= y)
  }

  /** @param {number} offset */
  #line(offset) {
    return partitionPoint(this.#starts.length, (i) => this.#starts[i] <= offset) - 1
  }
}

/**
 * The number of items that two lists share at their beginnings, and then at their ends.
 * @param {string[]} before
 * @param {string[]} after
 */
function sharedEnds(before, after) {
  const most = Math.min(before.length, after.length)
  let first = 0
  while (first < most && before[first] === after[first]) first++
  let last = 0
  while (last < most - first && before[before.length - 1 - last] === after[after.length - 1 - last]) last++
  return [first, last]
}

/** @param {Node} node a text @param {number} offset after its first character */
function edge(node, offset) {
  const range = document.createRange()
  range.setStart(node, Math.max(offset - 1, 0))
  range.setEnd(node, offset || 1)
  const rects = range.getClientRects()
  const { left, right, top, bottom } = rects[rects.length - 1]
  return { left: offset ? right : left, top, bottom }
}

/**
 * The lines of a text, those from `first` to `last` with their numbers and marks, which count from the start of the line.
 * @param {string} text
 * @param {Color[]} colors
 * @param {Underline[]} underlines
 * @param {[number, number]} near
 */
function described(text, colors, underlines, [first, last]) {
  const found = []
  let start = 0
  let next = 0
  for (const [index, line] of text.split("\n").entries()) {
    const end = start + line.length
    if (index < first || index >= last) {
      found.push({ start, line, number: 0, marks: [], key: `${line}\n` })
      start = end + 1
      continue
    }
    while (colors[next]?.start < start) next++
    /** @type {(Span & { name: string })[]} */
    const marks = []
    for (; next < colors.length && colors[next].start < end; next++) {
      marks.push({ start: colors[next].start - start, end: colors[next].end - start, name: colors[next].name })
    }
    for (const each of underlines) {
      // A missing word has no text: the character before it is underlined.
      const from = each.end > each.start ? each.start : Math.max(each.start - 1, 0)
      if (from < end && Math.max(each.end, from + 1) > start) {
        marks.push({ start: Math.max(from, start) - start, end: Math.min(Math.max(each.end, from + 1), end) - start, name: each.severity })
      }
    }
    const number = index + 1
    found.push({ start, line, number, marks, key: `${line}\n${marks.map(({ start, end, name }) => `${start} ${end} ${name}`).join()}` })
    start = end + 1
  }
  return found
}

/**
 * Makes a line, or writes into the one that is there if it has the same colors: a browser has less to do then.
 * @param {ReturnType<typeof described>[number]} line
 * @param {Line | null} before
 * @returns {Line}
 */
function drawn({ line, marks, key }, before) {
  if (before?.key === key) return before
  const cuts = [...new Set([0, line.length, ...marks.flatMap(({ start, end }) => [start, end])])].sort((a, b) => a - b)
  const pieces = cuts.slice(1).map((end, i) => {
    const names = marks.filter((mark) => mark.start < end && mark.end > cuts[i]).map(({ name }) => name)
    return { start: cuts[i], name: names.join(" "), text: line.slice(cuts[i], end) }
  })
  const there = before?.pieces ?? []
  if (before && line && pieces.length === there.length && pieces.every(({ name }, i) => name === there[i].name)) {
    pieces.forEach(({ text }, i) => text !== there[i].text && (there[i].node.data = text))
    return { ...before, key, pieces: pieces.map((piece, i) => ({ ...piece, node: there[i].node })) }
  }
  const shown = pieces.map((piece) => ({ ...piece, node: new Text(piece.text) }))
  const made = element("div", {}, ...shown.map(({ name, node }) => (name ? element("span", { className: name }, node) : node)))
  if (!line) made.append(element("br")) // keeps an empty line's height
  return { key, number: 0, element: made, pieces: shown }
}

/** Puts a number before a line: none if it is 0. @param {Line} line @param {number} number */
function renumber(line, number) {
  if (line.number === number) return
  line.number = number
  if (number) line.element.dataset.number = String(number)
  else delete line.element.dataset.number
}

// @ts-check
// The text of a program that plays, and the voices of its words. Offsets count UTF-16 units, as everywhere on the page.

import { CodePoints } from "../base/code-points.js"

/** @import { Segment } from "./lookahead.js" */
/** @import { Velocity } from "../base/path.js" */
/** @typedef {{ word: string, sign: string, rests: boolean, axis?: typeof AXES[number], at: number, names: { word: string, at: number }[] }} Voice */

export const AXES = /** @type {const} */ (["x", "y", "z", "yaw"])
// Signs for words: for each axis that of a positive and that of a negative velocity.
const SIGNS = { x: ["↑", "↓"], y: ["←", "→"], z: ["⤒", "⤓"], yaw: ["↰", "↱"] }
const HALF_TURNS = ["↖", "↗"]
const REST = "·"
const POSE = "⇢"
const CHANCE = "chance" // in the place of what dice have left out

const PIECE = /[*/×]|[\d.]+|[^\s\d.*/×]+/g // as words are colored

export class ProgramText {
  #text
  #words
  #codePoints
  /** @type {Map<number, number> | null} */
  #brackets = null
  /** @type {WeakMap<Pick<Segment, "words" | "velocity">, Voice[]>} */
  #voices = new WeakMap()

  /**
   * @param {string} text
   * @param {Record<string, number[]>} words those that move robots, each with its velocity along x, y, and z, and its turn
   */
  constructor(text, words) {
    this.#text = text
    this.#words = words
    this.#codePoints = new CodePoints(text)
  }

  /** The offset of a place that the server counts in code points. @param {number} points */
  toUnits(points) {
    return this.#codePoints.toUnits(points)
  }

  /** @param {number[]} span */
  word([start, end]) {
    return this.#text.slice(start, end)
  }

  /**
   * The starts of the words in a span: of both in a pose, such as `to high`, and of a measure, such as `forward 1.5m`.
   * @param {number[]} span
   */
  wordStarts(span) {
    return [...this.word(span).matchAll(PIECE)].map(({ index }) => span[0] + index)
  }

  /** Returns whether a span moves a robot, and is no name of something that does. @param {number[]} span */
  moves(span) {
    const word = this.word(span)
    return Object.hasOwn(this.#words, word) || /\s/.test(word)
  }

  /**
   * The voices of a segment: for each its word, and the names by which it is used. A segment lists for each voice first
   * the names, then the word.
   * @param {Pick<Segment, "words" | "velocity">} segment
   */
  voices(segment) {
    const known = this.#voices.get(segment)
    if (known) return known
    /** @type {Voice[]} */
    const voices = []
    /** @type {Voice["names"]} */
    let names = []
    for (const span of segment.words) {
      const [word, at] = [this.word(span), span[0]]
      if (word === CHANCE || this.moves(span)) {
        voices.push({ word, ...this.#drawn(word, segment.velocity), at, names })
        names = []
      } else names.push({ word, at })
    }
    this.#voices.set(segment, voices)
    return voices
  }

  /** The offset of the innermost `[` around an offset, or undefined. @param {number} at */
  bracket(at) {
    this.#brackets ??= brackets(this.#text)
    return this.#brackets.get(at)
  }

  /**
   * The drawing of a word where it makes the velocity `here`: that may be reflected or retraced.
   * @param {string} word
   * @param {Velocity} here
   */
  #drawn(word, here) {
    if (word === CHANCE) return { sign: REST, rests: true }
    const [head] = word.split(/\s/)
    if (!Object.hasOwn(this.#words, head)) return { sign: POSE, rests: false }
    const [x, y, z, yaw] = this.#words[head]
    const velocity = { x, y, z, yaw }
    const axis = AXES.find((each) => velocity[each] !== 0)
    if (!axis) return { sign: REST, rests: true }
    const signs = axis === "yaw" && Math.abs(yaw) < 1 ? HALF_TURNS : SIGNS[axis]
    const mirrored = here[axis] * velocity[axis] < 0
    return { sign: signs[velocity[axis] > 0 === mirrored ? 1 : 0], rests: false, axis }
  }
}

/** The offset of the innermost `[` for each offset within brackets. @param {string} text */
function brackets(text) {
  const found = new Map()
  /** @type {number[]} */
  const open = []
  for (let i = 0; i < text.length; i++) {
    const sign = text[i]
    if (sign === "#") while (i + 1 < text.length && text[i + 1] !== "\n") i++
    else if (sign === "[") open.push(i)
    else if (sign === "]") open.pop()
    else if (open.length && !/\s/.test(sign)) found.set(i, open[open.length - 1])
  }
  return found
}

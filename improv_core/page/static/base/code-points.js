// @ts-check
// Offsets in a text: the server counts code points, and JavaScript counts UTF-16 units, two for an emoji.

import { partitionPoint } from "./search.js"

const ASTRAL = /[\u{10000}-\u{10FFFF}]/gu

/** Turns offsets in a text into those of the other kind. */
export class CodePoints {
  /** @type {number[]} */
  #astral = [] // the units at which characters of two units begin

  /** @param {string} text */
  constructor(text) {
    for (const { index } of text.matchAll(ASTRAL)) this.#astral.push(index)
  }

  /** @param {number} units */
  toPoints(units) {
    return units - partitionPoint(this.#astral.length, (i) => this.#astral[i] < units)
  }

  /** @param {number} points */
  toUnits(points) {
    return points + partitionPoint(this.#astral.length, (i) => this.#astral[i] - i < points)
  }

  /**
   * A place that counts in code points, in units.
   * @template {{ start: number, end: number }} T
   * @param {T} place
   * @returns {T}
   */
  inUnits(place) {
    return { ...place, start: this.toUnits(place.start), end: this.toUnits(place.end) }
  }
}

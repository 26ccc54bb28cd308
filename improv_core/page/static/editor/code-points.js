// @ts-check
// Offsets in a text: the server counts code points, and JavaScript counts UTF-16 units, two for an emoji.

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
}

/**
 * The count of the first numbers that fit, if all that fit come first.
 * @param {number} length
 * @param {(index: number) => boolean} fits
 */
export function partitionPoint(length, fits) {
  let low = 0
  let high = length
  while (low < high) {
    const middle = (low + high) >> 1
    if (fits(middle)) low = middle + 1
    else high = middle
  }
  return low
}

// @ts-check
// The rows of the timeline: one for each robot, and below it a lower one for each body part that it moves.

import { partsOf } from "../score/lookahead.js"

/** @import { Robot } from "../score/robot-list.js" */
/** @import { Messages } from "../net/messages.js" */
/** @typedef {Robot & { part: string | null }} TimelineRow of a robot, or of one of its body parts */
/** @typedef {{ head: number, row: number, top: number }} Heights in pixels: above all rows, of a robot's row, and scrolled out of view */

const PART_HEIGHT = 0.62 // of the height of a robot's row, for a body part: as in panels.css

/**
 * The rows of robots in a score.
 * @param {Messages["score"]} score
 * @param {Robot[]} robots
 */
export function rowsOf(score, robots) {
  return new TimelineRows(robots.flatMap((robot) => partsOf(score, robot.name).map((part) => ({ ...robot, part }))))
}

export class TimelineRows {
  #tops = [0] // of each row, and the end of the last, in heights of a robot's row
  rows

  /** @param {TimelineRow[]} rows */
  constructor(rows) {
    this.rows = rows
    for (const { part } of rows) this.#tops.push(this.#tops[this.#tops.length - 1] + (part === null ? 1 : PART_HEIGHT))
  }

  /**
   * The rows that can be seen.
   * @param {Heights} heights
   * @param {number} height of the canvas, in pixels
   * @returns {Generator<[number, TimelineRow]>}
   */
  *visible({ head, row, top }, height) {
    for (const [index, each] of this.rows.entries()) {
      if (this.#tops[index + 1] * row > top && this.#tops[index] * row - top < height - head) yield [index, each]
    }
  }

  /**
   * The start of a row, in pixels.
   * @param {Heights} heights
   * @param {number} index
   */
  y({ head, row, top }, index) {
    return head + this.#tops[index] * row - top
  }

  /**
   * The view, with the height of one row.
   * @template {Heights} T
   * @param {T} view
   * @param {number} index
   */
  inRow(view, index) {
    return { ...view, row: view.row * (this.#tops[index + 1] - this.#tops[index]) }
  }
}

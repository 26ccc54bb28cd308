// @ts-check
// The rows of the timeline: one for each robot, and below it a lower one for each body part that it moves.

import { partsOf } from "../score/lookahead.js"

/** @import { Robot } from "../score/robot-list.js" */
/** @typedef {Robot & { part: string | null }} TimelineRow of a robot, or of one of its body parts */
/** @typedef {{ robot: TimelineRow, y: number, row: number }} RowPlace where a row begins, and how high it is, in pixels */
/** @typedef {{ head: number, row: number, top: number }} Heights in pixels: above all rows, of a robot's row, and scrolled out of view */

const PART_HEIGHT = 0.62 // of the height of a robot's row, for a body part: as in panels.css

/** The rows of robots in a score. @param {Messages["score"]} score @param {Robot[]} robots */
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
   * @returns {Generator<RowPlace>}
   */
  *visible({ head, row, top }, height) {
    for (const [index, robot] of this.rows.entries()) {
      const [begin, end] = [this.#tops[index] * row - top, this.#tops[index + 1] * row - top]
      if (end > 0 && begin < height - head) yield { robot, y: head + begin, row: end - begin }
    }
  }
}

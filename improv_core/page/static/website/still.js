// @ts-check
// A still picture of paths in few numbers, which a link holds: for each line, the place of its robot in the list, a
// point, and the steps from each point to the next one.

import { robotColor } from "../base/colors.js"
import { bounds } from "../floor/camera.js"

/** @import { Point } from "../floor/camera.js" */
/** @typedef {number[][]} Still */

const SIZE = 400 // units of the picture, to which points are rounded,
const MARGIN = 20 // and around it
const MAX_POINTS = 300

/**
 * The picture of paths; empty if there are none, or if they would make a link long.
 * @param {Point[][][]} robots the lines of each, in meters
 * @returns {Still}
 */
export function stillOf(robots) {
  if (robots.flat(2).length > MAX_POINTS) return []
  const [low, high] = bounds(robots.flat())
  const scale = SIZE / Math.max(high.x - low.x, high.y - low.y, 0.1)
  const place = (/** @type {number} */ from, /** @type {number} */ to) => Math.round(SIZE / 2 + (to - from) * scale)
  const x = (/** @type {Point} */ point) => place((low.x + high.x) / 2, point.x)
  const y = (/** @type {Point} */ point) => place(point.y, (low.y + high.y) / 2)
  return robots.flatMap((lines, robot) =>
    lines.map((points) => [robot, ...points.flatMap((point, i) => (i ? [x(point) - x(points[i - 1]), y(point) - y(points[i - 1])] : [x(point), y(point)]))]),
  )
}

/** Returns whether a link holds a picture, and nothing else in its place. @param {unknown} found @returns {found is Still} */
export function isStill(found) {
  return Array.isArray(found) && found.every((line) => Array.isArray(line) && line.length > 2 && line.every((each) => Number.isSafeInteger(each)))
}

/** The picture as SVG. @param {Still} still */
export function svgOf(still) {
  const lines = still.map(([robot, x, y, ...steps]) => {
    const color = robotColor(Math.abs(robot))
    return `<g stroke="${color}"><circle cx="${x}" cy="${y}" r="6"/><path d="M${x} ${y}l${steps.length ? steps.join(" ") : "0 0"}"/></g>`
  })
  const box = `viewBox="${-MARGIN} ${-MARGIN} ${SIZE + 2 * MARGIN} ${SIZE + 2 * MARGIN}" width="${SIZE}" height="${SIZE}"`
  return `<svg xmlns="http://www.w3.org/2000/svg" ${box} fill="none" stroke-width="3" stroke-linejoin="round">${lines.join("")}</svg>`
}

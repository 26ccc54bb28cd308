// @ts-check
// The head and the arms of a robot from above, on its disc.

import { places } from "../bodies/body.js"
import { DARK, disc } from "./robots.js"

/** @import { Figure } from "../bodies/body.js" */
/** @import { Pen } from "../base/pen.js" */

const REACH = 3.1 // radii of the disc for a length of 1 of the figure
const HEAD = 0.5 // of the disc's radius
const EYES = 0.62 // radians to each side

/**
 * Draws the limbs of a figure around the pen's origin, where the robot looks along x; the world's y is up.
 * @param {Pen} pen
 * @param {Figure} figure
 * @param {number} radius of the disc, in pixels
 * @param {string} color
 * @param {string} shade
 */
export function drawLimbs(pen, { head, arms }, radius, color, shade) {
  pen.save()
  pen.scale(radius, -radius)
  for (const arm of arms) {
    const { shoulder, elbow, hand } = places(arm)
    pen.beginPath()
    for (const [x, y] of [shoulder, elbow, hand]) pen.lineTo(x * REACH, y * REACH)
    pen.lineWidth = 0.22
    pen.strokeStyle = shade
    pen.stroke()
    disc(pen, hand[0] * REACH, hand[1] * REACH, 0.17, color)
  }
  if (head) {
    pen.rotate(head.yaw)
    disc(pen, HEAD * 1.05 * Math.cos(head.pitch), 0, 0.14, shade)
    disc(pen, 0, 0, HEAD, shade)
    for (const side of [-1, 1]) {
      const [x, y] = [0.34 * Math.cos(EYES * side), 0.34 * Math.sin(EYES * side)]
      disc(pen, x, y, 0.17, "#ffffff")
      disc(pen, x + 0.05, y, 0.09, DARK)
    }
  }
  pen.restore()
}

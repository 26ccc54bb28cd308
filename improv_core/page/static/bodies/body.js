// @ts-check
// The looks of a body: the joints that turn the head and the arms of a figure, and the places of these.

import { about, plus } from "./vectors.js"

/** @import { Place } from "./vectors.js" */
/** @typedef {Messages["score"]["robots"][string]["body"]} Body */
/** @typedef {Body[number]["joints"][number]} Joint */
/** @typedef {Record<string, number>} Positions of joints by name, in radians or meters */
/** @typedef {{ yaw: number, pitch: number }} Head turned to the left, and looking up, in radians */
/** @typedef {{ side: 1 | -1, raise: number, out: number, bend: number }} Arm on the left if `side` is 1; in radians */
/** @typedef {{ head: Head | null, arms: Arm[] }} Figure */

export const HEAD = { height: 0.8, radius: 0.14 } // a figure is about 1 high
/** @type {Place} */
const TO_THE_RIGHT = [0, -1, 0] // about this, an arm that hangs down rises forward, and a face that looks ahead looks up
/** @type {Place} */
const FORWARD = [1, 0, 0] // about this, an arm that hangs down moves to the left
/** @type {Place} */
const UP = [0, 0, 1]
const SHOULDER = { height: 0.6, aside: 0.17 }
const UPPER = 0.2 // an arm's length down to the elbow,
const LOWER = 0.19 // and from there to the hand

/**
 * The figure of a body whose joints are at these positions, or at their starts. A part called head is its head; parts
 * with left or right, and arm, in their names are its arms. Null if it has neither: it has gauges only.
 * @param {Body} body
 * @param {Positions} [positions]
 * @returns {Figure | null}
 */
export function figureOf(body, positions = {}) {
  const angles = (/** @type {Body[number]} */ part) => (/** @type {string[]} */ ...axes) => {
    const joint = part.joints.find(({ axis, slides }) => axes.includes(axis) && !slides)
    return joint ? joint.sign * (positions[joint.name] ?? joint.start) : 0
  }
  const heads = body.filter(({ name }) => /head/i.test(name)).map(angles)
  /** @type {Arm[]} */
  const arms = []
  for (const part of body) {
    const side = /left/i.test(part.name) ? 1 : /right/i.test(part.name) ? -1 : null
    if (side === null || !/arm/i.test(part.name) || arms.some((arm) => arm.side === side)) continue
    const angle = angles(part)
    arms.push({ side, raise: angle("z"), out: angle("yaw", "y"), bend: angle("x") })
  }
  if (!heads.length && !arms.length) return null
  return { head: heads.length ? { yaw: heads[0]("yaw"), pitch: heads[0]("z") } : null, arms }
}

/**
 * The places of an arm's shoulder, elbow, and hand. Its joints follow one another as in most robots: it is raised forward,
 * then taken to the left, then bent. An arm hangs down if all are 0.
 * @param {Arm} arm
 * @returns {{ shoulder: Place, elbow: Place, hand: Place }}
 */
export function places({ side, raise, out, bend }) {
  /** @type {Place} */
  const shoulder = [0, side * SHOULDER.aside, SHOULDER.height]
  const turned = (/** @type {Place} */ place) => about(TO_THE_RIGHT, raise, about(FORWARD, out, place))
  const elbow = plus(shoulder, turned([0, 0, -UPPER]))
  return { shoulder, elbow, hand: plus(elbow, turned(about(TO_THE_RIGHT, bend, [0, 0, -LOWER]))) }
}

/**
 * The position of a place of a head that looks ahead in `face`, in radii from its middle.
 * @param {Head} head
 * @param {Place} face
 * @returns {Place}
 */
export function onHead({ yaw, pitch }, face) {
  const turned = about(UP, yaw, about(TO_THE_RIGHT, pitch, face))
  return plus([0, 0, HEAD.height], /** @type {Place} */ (turned.map((each) => each * HEAD.radius)))
}

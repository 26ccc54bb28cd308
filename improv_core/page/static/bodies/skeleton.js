// @ts-check
// The places of a robot's joints, from its skeleton: meters, in the frame of its base: x forward, y to the left, z up.

import { about, along, plus } from "./vectors.js"

/** @import { Positions } from "./body.js" */
/** @import { Axes, Place } from "./vectors.js" */
/** @typedef {Messages["score"]["skeletons"][string]} Skeleton */
/** @typedef {Skeleton[number]} Bone */
/** @typedef {{ at: Place, axes: Axes }} Frame of what a joint carries */

/** @type {Frame} */
const BASE = { at: [0, 0, 0], axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }

/**
 * The frame of what each joint carries.
 * @param {Skeleton} skeleton
 * @param {Positions} positions where joints are, in radians or meters; others rest
 */
export function framesOf(skeleton, positions) {
  /** @type {Frame[]} */
  const frames = []
  for (const bone of skeleton) frames.push(carried(bone, frames[bone.carrier] ?? BASE, positionOf(bone, positions)))
  return frames
}

/** @param {Bone} bone @param {Positions} positions */
function positionOf({ joint, follows, ratio, shift, rest }, positions) {
  if (follows === null) return positions[joint] ?? rest
  return follows in positions ? ratio * positions[follows] + shift : rest
}

/** @param {Bone} bone @param {Frame} carrier @param {number} position @returns {Frame} */
function carried({ place, turn, axis, way }, { at, axes }, position) {
  const begin = plus(at, along(axes, place))
  const own = /** @type {Axes} */ (rotation(turn).map((each) => along(axes, each)))
  if (way === "slides") return { at: plus(begin, along(own, /** @type {Place} */ (axis.map((each) => each * position)))), axes: own }
  if (way === "stays" || !position) return { at: begin, axes: own }
  const turned = BASE.axes.map((each) => along(own, about(axis, position, each)))
  return { at: begin, axes: /** @type {Axes} */ (turned) }
}

/**
 * The x, y, and z axes after roll, pitch, and yaw about fixed axes, as in a URDF.
 * @param {number[]} turn
 * @returns {Axes}
 */
function rotation([roll, pitch, yaw]) {
  const turned = BASE.axes.map((each) => about([0, 0, 1], yaw, about([0, 1, 0], pitch, about([1, 0, 0], roll, each))))
  return /** @type {Axes} */ (turned)
}

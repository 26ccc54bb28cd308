// @ts-check
// The places of a robot's joints, from its skeleton: meters, in the frame of its base: x forward, y to the left, z up.

/** @import { Messages } from "../net/messages.js" */
/** @import { Place, Positions } from "./body.js" */
/** @typedef {Messages["score"]["skeletons"][string]} Skeleton */
/** @typedef {Skeleton[number]} Bone */
/** @typedef {[Place, Place, Place]} Turned the axes of a frame */
/** @typedef {{ at: Place, axes: Turned }} Frame of what a joint carries */

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

/**
 * @param {Bone} bone
 * @param {Positions} positions
 */
function positionOf({ joint, follows, ratio, shift, rest }, positions) {
  if (follows === null) return positions[joint] ?? rest
  return follows in positions ? ratio * positions[follows] + shift : rest
}

/**
 * @param {Bone} bone
 * @param {Frame} carrier
 * @param {number} position
 * @returns {Frame}
 */
function carried({ place, turn, axis, way }, { at, axes }, position) {
  const begin = plus(at, along(axes, place))
  const own = /** @type {Turned} */ (rotation(turn).map((each) => along(axes, each)))
  if (way === "slides") return { at: plus(begin, along(own, /** @type {Place} */ (axis.map((each) => each * position)))), axes: own }
  if (way === "stays" || !position) return { at: begin, axes: own }
  const turned = BASE.axes.map((each) => along(own, about(axis, position, each)))
  return { at: begin, axes: /** @type {Turned} */ (turned) }
}

/**
 * The x, y, and z axes after roll, pitch, and yaw about fixed axes, as in a URDF.
 * @param {number[]} turn
 * @returns {Turned}
 */
function rotation([roll, pitch, yaw]) {
  const turned = BASE.axes.map((each) => about([0, 0, 1], yaw, about([0, 1, 0], pitch, about([1, 0, 0], roll, each))))
  return /** @type {Turned} */ (turned)
}

/**
 * A vector turned about an axis of length 1 (Rodrigues' formula).
 * @param {number[]} axis
 * @param {number} angle
 * @param {Place} vector
 * @returns {Place}
 */
function about([x, y, z], angle, [a, b, c]) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)]
  const rest = (x * a + y * b + z * c) * (1 - cos)
  return [a * cos + (y * c - z * b) * sin + x * rest, b * cos + (z * a - x * c) * sin + y * rest, c * cos + (x * b - y * a) * sin + z * rest]
}

/**
 * A vector that is known in a frame.
 * @param {Turned} axes
 * @param {number[]} vector
 * @returns {Place}
 */
export function along([x, y, z], [a, b, c]) {
  return [x[0] * a + y[0] * b + z[0] * c, x[1] * a + y[1] * b + z[1] * c, x[2] * a + y[2] * b + z[2] * c]
}

/**
 * @param {Place} one
 * @param {Place} other
 * @returns {Place}
 */
export function plus(one, other) {
  return [one[0] + other[0], one[1] + other[1], one[2] + other[2]]
}

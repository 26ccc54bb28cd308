// @ts-check
// The path of a robot: exact arcs from its velocities.

/** @typedef {{ x: number, y: number, z: number, heading: number }} Pose in meters and radians */
/** @typedef {{ x: number, y: number, z: number, yaw: number }} Velocity in the robot's own frame, in m/s and rad/s */
/** @import { Pen } from "./pen.js" */

const STRAIGHT = 1e-4 // radians: below this, a curve counts as a straight line

/**
 * The pose after holding a velocity: the integral of the turning velocity (Lynch & Park, Modern Robotics, 3.3.3).
 * @param {Pose} pose
 * @param {Velocity} velocity
 * @param {number} seconds
 * @returns {Pose}
 */
export function poseAfter(pose, velocity, seconds) {
  const angle = velocity.yaw * seconds
  const small = Math.abs(angle) < STRAIGHT
  const along = small ? 1 - (angle * angle) / 6 : Math.sin(angle) / angle
  const across = small ? angle / 2 : (1 - Math.cos(angle)) / angle
  const forward = (velocity.x * along - velocity.y * across) * seconds
  const left = (velocity.x * across + velocity.y * along) * seconds
  return compose(pose, { x: forward, y: left, z: velocity.z * seconds, heading: angle })
}

/** A pose from the numbers in a message. @param {number[]} numbers @returns {Pose} */
export function poseOf([x, y, z, heading]) {
  return { x, y, z, heading }
}

/**
 * Composes two poses: `then` is given in the frame of `first`.
 * @param {Pose} first
 * @param {Pose} then
 * @returns {Pose}
 */
export function compose(first, then) {
  const cos = Math.cos(first.heading)
  const sin = Math.sin(first.heading)
  return {
    x: first.x + cos * then.x - sin * then.y,
    y: first.y + sin * then.x + cos * then.y,
    z: first.z + then.z,
    heading: first.heading + then.heading,
  }
}

/**
 * The transform from one pose to another: `compose(transformBetween(from, to), from)` is `to`.
 * @param {Pose} from
 * @param {Pose} to
 * @returns {Pose}
 */
export function transformBetween(from, to) {
  const turned = compose({ x: 0, y: 0, z: 0, heading: to.heading - from.heading }, from)
  return { x: to.x - turned.x, y: to.y - turned.y, z: to.z - turned.z, heading: to.heading - from.heading }
}

/**
 * The velocity that takes one pose to another in one second, along an arc. Between them there is less than half a turn.
 * @param {Pose} from
 * @param {Pose} to
 * @returns {Velocity}
 */
export function velocityBetween(from, to) {
  const yaw = to.heading - from.heading
  const longer = Math.abs(yaw) < STRAIGHT ? 1 : yaw / 2 / Math.sin(yaw / 2) // an arc than its chord
  const cos = Math.cos(from.heading + yaw / 2) * longer
  const sin = Math.sin(from.heading + yaw / 2) * longer
  const [x, y] = [to.x - from.x, to.y - from.y]
  return { x: cos * x + sin * y, y: cos * y - sin * x, z: to.z - from.z, yaw }
}

/**
 * Draws one segment from a pose, with a pen that has canvas's `lineTo(x, y)` and `arc(x, y, radius, from, to, clockwise)`.
 * The pen is at the pose already.
 * @param {Pick<Pen, "lineTo" | "arc">} pen
 * @param {Pose} pose
 * @param {Velocity} velocity
 * @param {number} seconds
 */
export function trace(pen, pose, velocity, seconds) {
  const speed = Math.hypot(velocity.x, velocity.y)
  const sweep = velocity.yaw * seconds
  if (speed * seconds < 1e-6) return
  if (Math.abs(sweep) < STRAIGHT) {
    const { x, y } = poseAfter(pose, velocity, seconds)
    pen.lineTo(x, y)
    return
  }
  const direction = pose.heading + Math.atan2(velocity.y, velocity.x)
  const reach = speed / velocity.yaw
  const x = pose.x - reach * Math.sin(direction)
  const y = pose.y + reach * Math.cos(direction)
  const first = direction - (Math.sign(reach) * Math.PI) / 2
  pen.arc(x, y, Math.abs(reach), first, first + sweep, sweep < 0)
}

/**
 * Points along a segment, its end among them, close enough to tell how much room it takes.
 * @param {Pose} pose
 * @param {Velocity} velocity
 * @param {number} seconds
 */
export function pointsAlong(pose, velocity, seconds) {
  const parts = Math.min(Math.max(Math.ceil(Math.abs(velocity.yaw * seconds) / 0.5), 1), 16)
  return Array.from({ length: parts }, (_, i) => poseAfter(pose, velocity, (seconds * (i + 1)) / parts))
}

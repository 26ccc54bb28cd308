// @ts-check
// The gauge of a joint: its position between its limits, and the limit that holds it back.

/** @import { Joint } from "./body.js" */

const NEAR = 1e-3 // radians or meters
const AROUND = 1 // meters that a sliding joint without a limit shows on that side

/**
 * Shares are from 0, the least position that the gauge shows, to 1. `held` is 1 at a greatest position beyond which the
 * joint should move, -1 at a least one, otherwise 0. `real` is the position of a real joint, null if it isn't known.
 * @param {Joint} joint
 * @param {number} position in radians or meters
 * @param {number} velocity at which it should move
 * @param {number} [real] where it really is
 */
export function gauge(joint, position, velocity, real) {
  const { min, max, start, slides } = joint
  const least = min ?? (slides ? Math.min(start - AROUND, max ?? Infinity) : -Math.PI)
  const most = max ?? (slides ? Math.max(start + AROUND, min ?? -Infinity) : Math.PI)
  const endless = !slides && min === null && max === null // it may turn and turn
  const around = (/** @type {number} */ at) => (endless ? Math.atan2(Math.sin(at), Math.cos(at)) : at)
  const share = (/** @type {number} */ at) => (most > least ? Math.min(Math.max((around(at) - least) / (most - least), 0), 1) : 0.5)
  const atMost = max !== null && position >= max - NEAR
  const atLeast = min !== null && position <= min + NEAR
  return {
    at: share(position),
    real: real === undefined ? null : share(real),
    start: share(start),
    held: atMost && velocity > 0 ? 1 : atLeast && velocity < 0 ? -1 : 0,
    ends: [min !== null, max !== null],
    words: words(position, slides) + (real === undefined ? "" : `, really ${words(real, slides)}`),
  }
}

/** A position as people read it. @param {number} position in radians or meters @param {boolean} slides */
export function words(position, slides) {
  const text = slides ? position.toFixed(2) : Math.round((position * 180) / Math.PI).toString()
  return `${text.replace(/^-(0\.?0*)$/, "$1").replace("-", "−")}${slides ? " m" : "°"}`
}

// @ts-check
// The latest poses of the robots in performance time.

/** @import { Pose } from "../base/path.js" */
/** @typedef {{ at: number, placed: number, poses: Record<string, number[]>, joints: Record<string, number[]> }} Frame */

const DELAY = 0.05 // seconds the page shows behind the newest poses, to have a pose on either side of its own time
const MAX_FRAMES = 30

export class Motion {
  /** @type {Frame[]} */
  #frames = []
  #offset = -Infinity // performance time minus the page's clock
  #shown = -Infinity // the latest performance time presented: a page that was held up never goes back

  clear() {
    this.#frames = []
    this.#offset = -Infinity
    this.#shown = -Infinity
  }

  /**
   * Takes poses that arrived at `now`, by the page's clock. Returns whether a new performance begins.
   * @param {Frame} frame
   * @param {number} now
   */
  take({ at, placed, poses, joints }, now) {
    const startsOver = at < (this.#frames.at(-1)?.at ?? -Infinity)
    if (startsOver) this.clear()
    const offset = at - now
    // Messages are late, never early, so the largest offset is the truest; it decreases slowly, as clocks drift, and
    // at once after a pause of the performance.
    this.#offset = this.#offset - offset > 0.25 ? offset : Math.max(this.#offset - 0.0002, offset)
    const last = this.#frames.at(-1)
    if (at === last?.at) this.#frames.pop() // the list of robots has changed, or a robot was put elsewhere
    this.#frames.push({ at, placed, poses, joints })
    if (this.#frames.length > MAX_FRAMES) this.#frames.shift()
    return startsOver
  }

  /** The latest poses, or undefined. */
  get newest() {
    return this.#frames.at(-1)
  }

  /**
   * Performance time, `placed`, poses, and positions of joints to show at `now`, and whether later ones will differ without a new message.
   * @param {number} now
   */
  present(now) {
    const frames = this.#frames
    if (!frames.length) return { at: 0, placed: 0, robots: {}, joints: {}, moving: false }
    const newest = frames[frames.length - 1]
    const at = Math.min(Math.max(now + this.#offset - DELAY, this.#shown), newest.at)
    this.#shown = at
    const next = frames.findIndex((frame) => frame.at >= at)
    const later = frames[next]
    const before = frames[Math.max(next - 1, 0)]
    const after = before.placed === later.placed || at === later.at ? later : before // put elsewhere all at once
    const part = after.at > before.at ? Math.max((at - before.at) / (after.at - before.at), 0) : 1
    /** @type {Record<string, Pose>} */
    const robots = {}
    for (const [name, [x, y, z, heading]] of Object.entries(between(before.poses, after.poses, part))) {
      robots[name] = { x, y, z, heading }
    }
    return { at, placed: after.placed, robots, joints: between(before.joints, after.joints, part), moving: at < newest.at }
  }
}

/**
 * The numbers of each robot, part of the way from one frame to the next.
 * @param {Record<string, number[]>} before
 * @param {Record<string, number[]>} after
 * @param {number} part
 */
function between(before, after, part) {
  return Object.fromEntries(
    Object.entries(after).map(([name, to]) => {
      const from = before[name]?.length === to.length ? before[name] : to
      return [name, to.map((value, index) => from[index] + (value - from[index]) * part)]
    }),
  )
}

// @ts-check
// The latest poses of the robots in performance time, and their trails.

import { bounds } from "./camera.js"

/** @import { Point } from "./camera.js" */
/** @import { Pose } from "./path.js" */
/** @typedef {{ at: number, placed: number, poses: Record<string, number[]> }} Frame */
/** @typedef {{ at: number, placed: number, x: number, y: number, first: boolean }} TrailPoint `first` where a stroke begins */

const DELAY = 0.05 // seconds the page shows behind the newest poses, to have a pose on either side of its own time
const ROUNDING = 0.0001 // seconds by which the time of poses may be rounded
const FRAMES_KEPT = 30
const TRAIL_POINTS = 4000
const TRAIL_STEP = 0.01 // meters between two samples of a trail
const TOLERANCE = 0.003 // meters that a trail may be off
const SAMPLES = 32 // between two points of a trail, at most

export class Motion {
  /** @type {Frame[]} */
  #frames = []
  #offset = -Infinity // performance time minus the page's clock
  #shown = -Infinity // the latest performance time presented: a page that was held up never goes back
  /** @type {Map<string, TrailPoint[]>} */
  #samples = new Map() // places since the last point of a trail, all close to a straight line
  /** @type {Map<string, TrailPoint[]>} */
  trails = new Map() // by robot
  /** @type {Point[]} */
  room = [] // corners around the trails

  clear() {
    this.#frames = []
    this.#offset = -Infinity
    this.#shown = -Infinity
    this.clearTrails()
  }

  clearTrails() {
    this.trails.clear()
    this.#samples.clear()
    this.room = []
  }

  /**
   * Forgets trails from before a performance time: those of an earlier program.
   * @param {number} since
   */
  forgetTrails(since) {
    for (const [name, trail] of [...this.trails]) {
      const kept = [...trail, ...(this.#samples.get(name) ?? [])].filter(({ at }) => at >= since - ROUNDING)
      this.#forget(name)
      if (kept.length) this.trails.set(name, [{ ...kept[0], first: true }, ...kept.slice(1)])
    }
    this.#measure()
  }

  /**
   * Forgets robots that are not in `names`.
   * @param {Set<string>} names
   */
  keep(names) {
    for (const name of [...this.trails.keys()]) if (!names.has(name)) this.#forget(name)
    this.#measure()
  }

  /**
   * Takes poses that arrived at `now`, by the page's clock. Whether a new performance begins.
   * @param {Frame} frame
   * @param {number} now
   */
  take({ at, placed, poses }, now) {
    const anew = at < (this.#frames.at(-1)?.at ?? -Infinity)
    if (anew) this.clear()
    const offset = at - now
    // Messages are late, never early, so the largest offset is the truest; it decreases slowly, as clocks drift, and
    // at once after a pause of the performance.
    this.#offset = this.#offset - offset > 0.25 ? offset : Math.max(this.#offset - 0.0002, offset)
    const last = this.#frames.at(-1)
    if (at === last?.at) this.#frames.pop() // the cast has changed, or a robot was put elsewhere
    this.#frames.push({ at, placed, poses })
    if (this.#frames.length > FRAMES_KEPT) this.#frames.shift()
    for (const [name, [x, y]] of Object.entries(poses)) this.#draw(name, { at, placed, x, y, first: placed !== last?.placed })
    return anew
  }

  #measure() {
    this.room = this.trails.size ? bounds(this.trails.values()) : []
  }

  /** @param {Point} place */
  #widen(place) {
    const [low, high] = this.room
    if (low && low.x <= place.x && low.y <= place.y && high.x >= place.x && high.y >= place.y) return
    this.room = bounds([this.room, [place]])
  }

  /** @param {string} name */
  #forget(name) {
    this.trails.delete(name)
    this.#samples.delete(name)
  }

  /**
   * @param {string} name
   * @param {TrailPoint} place
   */
  #draw(name, place) {
    const trail = this.trails.get(name)
    const samples = this.#samples.get(name) ?? []
    if (!trail || place.first) this.#widen(place)
    if (!trail) {
      this.trails.set(name, [{ ...place, first: true }])
      return
    }
    const corner = trail[trail.length - 1]
    const last = samples.at(-1) ?? corner
    if (place.first) {
      trail.push(...samples.slice(-1), place)
      this.#samples.set(name, [])
      return
    }
    if (Math.hypot(place.x - last.x, place.y - last.y) < TRAIL_STEP) return
    if (samples.length && (samples.length === SAMPLES || !straight(corner, place, samples))) {
      trail.push(last)
      this.#widen(last)
      if (trail.length > TRAIL_POINTS) trail.splice(0, 2, { ...trail[1], first: true })
      this.#samples.set(name, [place])
      return
    }
    samples.push(place)
    this.#samples.set(name, samples)
  }

  /** The latest poses, or undefined. */
  get newest() {
    return this.#frames.at(-1)
  }

  /**
   * Performance time, `placed` and poses to show at `now`, and whether later ones will differ without a new message.
   * @param {number} now
   */
  present(now) {
    const frames = this.#frames
    if (!frames.length) return { at: 0, placed: 0, robots: {}, moving: false }
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
    for (const [name, to] of Object.entries(after.poses)) {
      const from = before.poses[name] ?? to
      const [x, y, z, heading] = to.map((value, axis) => from[axis] + (value - from[axis]) * part)
      robots[name] = { x, y, z, heading }
    }
    return { at, placed: after.placed, robots, moving: at < newest.at }
  }
}

/**
 * Whether all places are close to the line between two others.
 * @param {Point} from
 * @param {Point} to
 * @param {Point[]} places
 */
function straight(from, to, places) {
  const x = to.x - from.x
  const y = to.y - from.y
  const length = Math.hypot(x, y)
  if (length < TRAIL_STEP) return false // there and back
  return places.every((place) => {
    const forward = ((place.x - from.x) * x + (place.y - from.y) * y) / length
    const aside = Math.abs((place.x - from.x) * y - (place.y - from.y) * x) / length
    return aside < TOLERANCE && forward >= 0 && forward <= length
  })
}

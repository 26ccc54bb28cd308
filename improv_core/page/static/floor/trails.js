// @ts-check
// Trails of robots: the places that the server sends, which arcs join, and before a seek the path of the score.

import { partitionPoint } from "../base/search.js"
import { pointsAlong, poseAfter, velocityBetween } from "../base/path.js"
import { bounds } from "./camera.js"

/** @import { Point } from "./camera.js" */
/** @import { Lookahead, Segment } from "../score/lookahead.js" */
/** @import { Pose, Velocity } from "../base/path.js" */
/** @typedef {{ x: number, y: number }} Spot */
/** @typedef {Pose & { at: number }} Place a pose at a time of the performance, in seconds */
/** @typedef {{ pose: Pose, velocity: Velocity, at: number, end: number }} TrailSegment an arc that takes one unit of time to draw */

const NEAR = 0.01 // meters
const SHARPEST = 1 // radians between two places: below half a turn, only one arc joins two poses

export class Trails {
  /** @type {Map<string, Place[]>} */
  #places = new Map()
  /** @type {Map<string, Place[]>} */
  #before = new Map() // the paths that lead to a seek
  /** @type {{ beat: number, poses: Record<string, Spot> } | null} */
  #sought = null // the latest seek: to which beat, and where that put robots
  #placed = 0 // the number of times that robots were put elsewhere before the latest places
  #shown = 0 // the same of the poses that are shown
  #known = -1 // the version of the lookahead that the paths before a seek are from
  #cleared = -Infinity // seconds of performance
  /** @type {Point[]} */
  room = [] // corners around all trails
  version = 0 // changes when trails become other ones, not when they only become longer

  /** @param {Messages["trails"]} message */
  take({ placed, robots }) {
    if (placed !== this.#placed) this.version++
    this.#placed = placed
    let isReplaced = false // a trail, by another performance's
    for (const [name, { from, places }] of Object.entries(robots)) {
      const trail = this.#places.get(name) ?? []
      if (from !== trail.length) {
        isReplaced ||= trail.length > 0
        trail.length = 0
        this.version++
        this.#known = -1
      }
      for (const [at, x, y, heading] of places) {
        const place = { at, x, y, z: 0, heading }
        const last = trail.at(-1)
        this.#widen(last ? pointsAlong(last, velocityBetween(last, place), 1) : [place])
        trail.push(place)
      }
      this.#places.set(name, trail)
    }
    if (isReplaced) this.#measure()
  }

  /** Another performance begins. */
  restart() {
    this.#sought = null
    this.#cleared = -Infinity
    this.#before.clear()
    this.#measure()
  }

  /**
   * Takes the number of times that robots were put elsewhere before the shown poses. Poses and trails arrive in any
   * order: if their numbers differ, no robot has driven from its place in one to its place in the other.
   * @param {number} placed
   */
  show(placed) {
    this.#shown = placed
  }

  /**
   * Robots were placed where the score has them at a beat.
   * @param {number} beat
   * @param {Record<string, Spot>} [poses]
   */
  seek(beat, poses = {}) {
    this.restart()
    this.#sought = { beat, poses }
    this.#known = -1
    this.version++
  }

  /** Takes from the score what leads to the latest seek. @param {Lookahead | null} lookahead */
  complete(lookahead) {
    if (!this.#sought || !lookahead || lookahead.version === this.#known) return
    this.#known = lookahead.version
    const { beat, poses } = this.#sought
    for (const [name, [first]] of this.#places) {
      const segments = lookahead.robots.get(name) ?? []
      const there = first && isNear(first, poses[name]) // otherwise the places are from before the seek
      this.#before.set(name, there ? [...leading(segments, beat, first.at)] : [])
    }
    this.version++
  }

  /** Forgets robots that are not in `names`. @param {Set<string>} names */
  keep(names) {
    for (const name of this.#places.keys()) if (!names.has(name)) this.#places.delete(name)
    this.#measure()
  }

  /** Shows nothing from before a time of the performance. @param {number} at */
  clear(at) {
    this.#cleared = at
    this.version++
  }

  /**
   * The arcs of a robot's trail from one time to another, at which it is at `pose`.
   * @param {string} name
   * @param {number} since
   * @param {number} until
   * @param {Pose} pose
   * @returns {Generator<TrailSegment>}
   */
  *segments(name, since, until, pose) {
    const from = Math.max(since, this.#cleared)
    const before = this.#before.get(name) ?? []
    const places = this.#places.get(name) ?? []
    const count = before.length + places.length
    const place = (/** @type {number} */ i) => (i < before.length ? before[i] : places[i - before.length])
    const first = partitionPoint(count, (i) => place(i).at <= from)
    for (let i = Math.max(first - 1, 0); i < count && place(i).at <= until; i++) {
      const one = place(i)
      const isLast = i + 1 >= count || place(i + 1).at > until
      if (isLast && this.#placed !== this.#shown) return
      const next = isLast ? { ...pose, at: until } : place(i + 1)
      const velocity = velocityBetween(one, next)
      const cut = one.at < from && next.at > one.at ? Math.min((from - one.at) / (next.at - one.at), 1) : 0
      const rest = 1 - cut
      yield {
        pose: cut ? poseAfter(one, velocity, cut) : one,
        velocity: { x: velocity.x * rest, y: velocity.y * rest, z: 0, yaw: velocity.yaw * rest },
        at: Math.max(one.at, from),
        end: next.at,
      }
    }
  }

  #measure() {
    this.room = this.#places.size ? bounds(this.#places.values()) : []
  }

  /** @param {Point[]} points */
  #widen(points) {
    const [low, high] = this.room
    const inside = (/** @type {Point} */ { x, y }) => low && low.x <= x && low.y <= y && high.x >= x && high.y >= y
    if (!points.every(inside)) this.room = bounds([this.room, points])
  }
}

/** @param {Spot} one @param {Spot | undefined} other where it should be, if that is known */
function isNear(one, other) {
  return !other || Math.hypot(one.x - other.x, one.y - other.y) < NEAR
}

/**
 * The places of a path up to a beat, which is reached at a time.
 * @param {Segment[]} segments
 * @param {number} beat
 * @param {number} reached
 * @returns {Generator<Place>}
 */
function* leading(segments, beat, reached) {
  for (const { start, end, seconds, pose, velocity } of segments) {
    if (!pose || start >= beat) return
    const perBeat = seconds / (end - start)
    const until = Math.min(end, beat)
    const parts = Math.max(Math.ceil(Math.abs(velocity.yaw * seconds) / SHARPEST), 1)
    for (let i = 0; i < parts; i++) {
      const here = start + ((until - start) * i) / parts
      yield { ...poseAfter(pose, velocity, (here - start) * perBeat), at: reached - (beat - here) * perBeat }
    }
  }
}

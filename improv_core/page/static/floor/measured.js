// @ts-check
// Measured places of robots, beside their ideal ones, as the server sends them.

import { bounds } from "./camera.js"

/** @import { Point } from "./camera.js" */
/** @import { Pen } from "../base/pen.js" */
/** @import { Pose } from "../base/path.js" */
/**
 * @typedef {object} Place
 * @property {number} at seconds of performance
 * @property {number} beat
 * @property {Pose} pose
 * @property {Pose} ideal
 * @property {number} off meters
 * @property {number} turned radians
 * @property {number} aligned how often the robot's frame was aligned: only what follows the latest time is drawn
 * @property {number} simulated 1 if the simulator, which shows the robot there anyway, is the source
 * @property {number} follows 1 if the robot is pulled back to its ideal path
 */

const MIN_DISTANCE = 0.005 // meters by which a simulated robot has to be off, so that this is shown
const MIN_TURN = 0.01 // radians
const LINE_TOLERANCE = 0.003 // meters that a line may leave out
const NEAR_BEAT = 0.5 // beats between a place and the beat that it is shown for
const EASING = 12 // how much of the way to its latest place a picture goes in a second

export class Measured {
  /** @type {Map<string, Place[]>} */
  #places = new Map()
  /** @type {Map<string, number>} */
  #begins = new Map() // the first place that is drawn, by robot
  /** @type {Map<string, Pose>} */
  #poses = new Map() // of their pictures
  /** @type {Set<string>} */
  #shown = new Set()
  #cleared = -Infinity // seconds of performance
  /** @type {Point[]} */
  room = [] // corners around all that is drawn
  version = 0 // changes when lines become other ones, not when they only become longer

  /** @param {Messages["measured"]} message */
  take({ robots }) {
    for (const [name, { from, places }] of Object.entries(robots)) {
      if (!from) this.#forget(name)
      const known = this.#places.get(name) ?? []
      for (const numbers of places) {
        const place = read(numbers)
        if (known.at(-1)?.aligned !== place.aligned) {
          this.#begins.set(name, known.length)
          this.version++
        }
        known.push(place)
        if (!this.#shown.has(name) && (!place.simulated || place.off > MIN_DISTANCE || place.turned > MIN_TURN)) {
          this.#shown.add(name)
          this.version++
        }
        this.room = bounds([this.room, [place.pose, place.ideal]])
      }
      this.#places.set(name, known)
    }
  }

  /** Another performance begins. */
  restart() {
    for (const name of [...this.#places.keys()]) this.#forget(name)
    this.#cleared = -Infinity
    this.room = []
  }

  /** Draws nothing from before a time of the performance. @param {number} at */
  clear(at) {
    this.#cleared = at
    this.version++
  }

  /**
   * Returns whether the page shows a robot's error: it is real, or it has been off its ideal path.
   * @param {string} name
   */
  has(name) {
    return this.#shown.has(name)
  }

  /** The number of a robot's places. @param {string} name */
  count(name) {
    return this.#places.get(name)?.length ?? 0
  }

  /**
   * The place of a real robot, for its picture; undefined for others. `seconds` have passed since the last time.
   * @param {string} name
   * @param {number} seconds
   * @returns {Pose | undefined}
   */
  pose(name, seconds) {
    const latest = this.#places.get(name)?.at(-1)
    if (!latest || latest.simulated) return undefined
    const before = this.#poses.get(name) ?? latest.pose
    const part = Math.min(seconds * EASING, 1)
    const mix = (/** @type {keyof Pose} */ axis) => before[axis] + (latest.pose[axis] - before[axis]) * part
    const pose = { x: mix("x"), y: mix("y"), z: mix("z"), heading: mix("heading") }
    this.#poses.set(name, pose)
    return pose
  }

  /**
   * When the latest pose of a real robot came, in seconds of performance; -Infinity if none is known.
   * @param {string} name
   */
  latest(name) {
    const latest = this.#places.get(name)?.at(-1)
    return latest && !latest.simulated ? latest.at : -Infinity
  }

  /**
   * A robot's error now, or at a beat, in words; empty if it is not known.
   * @param {string} name
   * @param {number | null} beat
   */
  off(name, beat = null) {
    const places = (this.has(name) && this.#places.get(name)) || []
    if (beat === null) return words(places.at(-1))
    return words(places.findLast((place) => place.beat <= beat && beat - place.beat < NEAR_BEAT))
  }

  /** A robot's largest error, in words. @param {string} name */
  most(name) {
    const places = this.#places.get(name) ?? []
    const most = (/** @type {"off" | "turned"} */ what) => places.reduce((found, place) => Math.max(found, place[what]), 0)
    return words({ off: most("off"), turned: most("turned"), follows: 0 })
  }

  /**
   * Paints in the world, from the place with number `from` on and at most this many seconds before `at`: where a robot was,
   * and over it the thin ideal line.
   * @param {Pen} pen
   * @param {string} name
   * @param {{ from: number, since: number, color: string, ink: string, width: number, thin: number }} how
   */
  paint(pen, name, { from, since, color, ink, width, thin }) {
    const places = this.#places.get(name) ?? []
    const first = Math.max(from - 1, this.#begins.get(name) ?? 0)
    const drawn = places.slice(first).filter(({ at }) => at >= Math.max(since, this.#cleared))
    /** @type {["pose" | "ideal", string, number][]} */
    const lines = [["pose", color, width], ["ideal", ink, thin]]
    for (const [which, stroke, wide] of lines) {
      pen.beginPath()
      /** @type {Pose | null} */
      let last = null
      for (const [index, place] of drawn.entries()) {
        const { x, y } = place[which]
        if (!last) pen.moveTo(x, y)
        else if (index < drawn.length - 1 && Math.hypot(x - last.x, y - last.y) < LINE_TOLERANCE) continue
        else pen.lineTo(x, y)
        last = place[which]
      }
      pen.strokeStyle = stroke
      pen.lineWidth = wide
      pen.stroke()
    }
  }

  /** The ideal place of a robot, if that is shown. @param {string} name @returns {Pose | undefined} */
  ideal(name) {
    return this.has(name) ? this.#places.get(name)?.at(-1)?.ideal : undefined
  }

  /** @param {string} name */
  #forget(name) {
    this.#places.delete(name)
    this.#begins.delete(name)
    this.#poses.delete(name)
    this.#shown.delete(name)
    this.version++
  }
}

export const measured = new Measured()

/** @param {number[]} numbers @returns {Place} */
function read([at, beat, x, y, heading, idealX, idealY, idealHeading, off, turned, aligned, simulated, follows]) {
  const pose = { x, y, z: 0, heading }
  const ideal = { x: idealX, y: idealY, z: 0, heading: idealHeading }
  return { at, beat, pose, ideal, off, turned, aligned, simulated, follows }
}

/** @param {{ off: number, turned: number, follows: number } | undefined} place */
function words(place) {
  if (!place) return ""
  const how = place.follows ? ", following" : ""
  return `${place.off.toFixed(2)} m, ${Math.round((place.turned * 180) / Math.PI)}° off${how}`
}

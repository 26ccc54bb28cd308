// @ts-check
// A stick figure of a skeleton as it is seen from somewhere: paths of an SVG in which what is seen is 1 in each direction.

import { framesOf } from "./skeleton.js"
import { along, line, plus } from "./vectors.js"

/** @import { Positions } from "./body.js" */
/** @import { Frame, Skeleton } from "./skeleton.js" */
/** @import { Place } from "./vectors.js" */
/** @typedef {{ turn: number, tilt: number }} Sight from how far to the left of its front, and from how far above, in radians */
/** @typedef {{ middle: Place, radius: number }} Room that is shown: all of it fits from everywhere */

/** @type {Place} */
const BASE = [0, 0, 0]
const PER_PIXEL = 0.012 // radians that a figure turns when it is dragged
/** @type {Readonly<Sight>} */
export const FROM_RIGHT = { turn: -0.95, tilt: 0.35 } // and a little from the front: many arms point forward
const LOWEST = -0.3 // tilts,
const HIGHEST = Math.PI / 2
const GROWING = 1.15 // a figure that needs more room gets some to spare, so that this is rare
const FLOOR = 0.4 // of what is shown
const CORNERS = 32 // of the floor, which is round
const HAND = 0.09 // the length of what shows that a last joint turns
const MIN_APART = 1e-4 // of what is shown: places that are nearer are the same

export class StickFigure {
  #skeleton
  #moving // which bones move when some joint does
  #last // which of those that turn carry nothing that is elsewhere, so that nobody would see that they turn
  #floor = 0

  /** @param {Skeleton} skeleton */
  constructor(skeleton) {
    this.#skeleton = skeleton
    /** @type {boolean[]} */
    const moving = []
    for (const { way, carrier } of skeleton) moving.push(way !== "stays" || (moving[carrier] ?? false))
    this.#moving = moving
    const places = framesOf(skeleton, {}).map(({ at }) => at)
    this.#floor = Math.min(0, ...places.map(([, , z]) => z))
    const high = Math.max(0, ...places.map(([, , z]) => z))
    /** @type {Room} */
    this.room = { middle: [0, 0, (this.#floor + high) / 2], radius: 1e-3 }
    this.#fit(places)
    const carries = skeleton.map(() => false)
    for (let index = skeleton.length - 1; index > 0; index--) {
      const { carrier } = skeleton[index]
      if (carrier >= 0 && (carries[index] || this.#apart(places[index], places[carrier]))) carries[carrier] = true
    }
    this.#last = skeleton.map(({ way }, index) => way === "turns" && !carries[index])
  }

  /** @param {Positions} positions @param {Sight} sight */
  seen(positions, sight) {
    const frames = framesOf(this.#skeleton, positions)
    this.#fit(frames.map(({ at }) => at))
    const flat = this.#flat(sight)
    const paths = { floor: this.#drawnFloor(flat), still: "", moving: "", joints: "" }
    frames.forEach(({ at }, index) => {
      const { carrier, way } = this.#skeleton[index]
      const from = carrier < 0 ? BASE : frames[carrier].at
      if (this.#apart(from, at)) paths[this.#moving[index] ? "moving" : "still"] += line([flat(from), flat(at)])
      if (way !== "stays") paths.joints += line([flat(at), flat(at)])
      if (this.#last[index]) paths.moving += line([flat(at), flat(this.#hand(frames[index], index))])
    })
    return paths
  }

  /**
   * The end of a hand that shows how a last joint turns: at a right angle to what it turns about.
   * @param {Frame} frame
   * @param {number} index
   */
  #hand({ at, axes }, index) {
    const { axis } = this.#skeleton[index]
    const least = axis.map(Math.abs).indexOf(Math.min(...axis.map(Math.abs)))
    const other = [0, 1, 2].map((each) => (each === least ? 1 : 0) - axis[least] * axis[each])
    const length = (HAND * this.room.radius) / Math.hypot(...other)
    return plus(at, along(axes, other.map((each) => each * length)))
  }

  /** @param {(place: Place) => [number, number]} flat */
  #drawnFloor(flat) {
    const radius = FLOOR * this.room.radius
    const round = (/** @type {number} */ angle, by = 1) => flat([by * radius * Math.cos(angle), by * radius * Math.sin(angle), this.#floor])
    const edge = Array.from({ length: CORNERS }, (_, corner) => round((corner * 2 * Math.PI) / CORNERS))
    return `${line(edge)}Z${line([round(0.12, 1.12), round(0, 1.35), round(-0.12, 1.12)])}` // its front
  }

  /** @param {Sight} sight */
  #flat({ turn, tilt }) {
    const { middle, radius } = this.room
    const [sin, cos, up, flat] = [Math.sin(turn), Math.cos(turn), Math.sin(tilt), Math.cos(tilt)]
    return (/** @type {Place} */ place) => {
      const [x, y, z] = place.map((each, axis) => (each - middle[axis]) / radius)
      return /** @type {[number, number]} */ ([y * cos - x * sin, up * (x * cos + y * sin) - flat * z])
    }
  }

  /** @param {Place[]} places */
  #fit(places) {
    const far = Math.max(0, ...places.map((place) => distance(place, this.room.middle)))
    if (far > this.room.radius) this.room.radius = far * GROWING
  }

  /** @param {Place} one @param {Place} other */
  #apart(one, other) {
    return distance(one, other) > MIN_APART * this.room.radius
  }
}

/** @param {Place} one @param {Place} other */
function distance(one, other) {
  return Math.hypot(one[0] - other[0], one[1] - other[1], one[2] - other[2])
}

/**
 * A sight after it was dragged by some pixels.
 * @param {Sight} sight
 * @param {number} right
 * @param {number} down
 * @returns {Sight}
 */
export function dragged({ turn, tilt }, right, down) {
  return { turn: turn - right * PER_PIXEL, tilt: Math.min(Math.max(tilt + down * PER_PIXEL, LOWEST), HIGHEST) }
}

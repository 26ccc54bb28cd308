// @ts-check
// The part of the world that the stage shows. World x is right, y is up, in meters; the screen's y is down, in pixels.

/** @typedef {{ x: number, y: number }} Point */
/** @typedef {{ x: number, y: number, scale: number }} Sight the world point in the middle, and pixels per meter */

const MARGIN = 2 // radii of the largest robot around everything,
const EDGE = 36 // and pixels, for names and noses,
const EDGE_SHARE = 0.06 // or, on a small stage, this part of its shorter side
const MIN_VIEW = 16 // radii: a single robot at rest still has a stage around it
const EASING_TIME = 0.25 // seconds
const SPARE_TIME = 8 // seconds for which unused room is kept, so that a dance played again does not zoom
const FRESH_TIME = 2 // seconds for which none is kept: until all that another dance uses has arrived
const MIN_SCALE = 0.5
const MAX_SCALE = 2000 // pixels per metre

export class Camera {
  /** @type {[Point, Point] | null} */
  #room = null // the corners of what should be in view
  #spare = 0 // seconds for which that has been more than is used
  #fresh = 0 // seconds for which it is what is used
  /** @type {Sight | null} */
  view = null
  size = { width: 0, height: 0 }
  insets = { top: 0, bottom: 0, left: 0 } // pixels that are covered
  held = false // whether it stays where it is: something is under a hand,
  stays = false // or somebody draws
  fits = true // whether it follows the robots and paths
  #isNear = false // whether it shows a point larger while somebody draws

  /** The shorter side of the stage, in pixels. */
  get shorter() {
    return Math.min(this.size.width, this.size.height)
  }

  /** True if all robots and paths are in view. */
  get showsAll() {
    return this.fits && !(this.stays && this.#isNear)
  }

  /** The view, once there is one. */
  get sight() {
    if (!this.view) throw new Error("nothing has been drawn yet")
    return this.view
  }

  /**
   * Moves toward a view that holds the corners `used`, or jumps if `seconds` is infinite. Returns whether it is still moving.
   * @param {[Point, Point]} used
   * @param {number} radius of the largest robot, in meters
   * @param {number} seconds
   */
  follow(used, radius, seconds) {
    this.#isNear &&= this.stays
    const room = bounds([this.#room ?? used, used])
    const isUsed = room.every(({ x, y }, corner) => x === used[corner].x && y === used[corner].y)
    const isFresh = this.#fresh > 0
    this.#fresh -= seconds
    this.#spare = isUsed ? 0 : this.#spare + seconds
    const [low, high] = (this.#room = this.#spare < SPARE_TIME && !isFresh ? room : used)
    if ((this.held || this.stays || !this.fits) && this.view) return false
    const width = high.x - low.x + 2 * MARGIN * radius
    const height = high.y - low.y + 2 * MARGIN * radius
    const least = MIN_VIEW * radius
    const edge = Math.min(EDGE, EDGE_SHARE * this.shorter)
    const free = Math.max(this.size.height - this.insets.top - this.insets.bottom - 2 * edge, 80)
    const across = Math.max(this.size.width - this.insets.left - 2 * edge, 80) / Math.max(width, least)
    const scale = Math.max(Math.min(across, free / Math.max(height, least * 0.75)), MIN_SCALE)
    const wanted = { x: (low.x + high.x) / 2, y: (low.y + high.y) / 2, scale }
    if (seconds === Infinity) {
      // Jumps are rarer with room to spare.
      if (!this.view || isFresh || !this.#shows(low, high) || this.view.scale < scale / 3) this.view = { ...wanted, scale: scale * 0.85 }
      return false
    }
    this.view ??= wanted
    const part = 1 - Math.exp(-seconds / EASING_TIME)
    let left = 0
    const view = { ...this.view }
    for (const key of /** @type {const} */ (["x", "y", "scale"])) {
      const distance = wanted[key] - view[key]
      view[key] += distance * part
      left += key === "scale" ? Math.abs(distance / scale) : Math.abs(distance * scale) / this.size.width
    }
    if (left < 3e-4) {
      if (left > 0) this.view = wanted
      return false
    }
    this.view = view
    return true
  }

  /** Fits what there is now, and nothing that was. */
  fit() {
    this.fits = true
    this.stays = false
    this.forget()
  }

  /** Forgets the room that was used: another dance begins. */
  forget() {
    this.#fresh = FRESH_TIME
  }

  /** Shows a point at least this large, if it stays there and nobody has moved the view. @param {Point} point @param {number} scale */
  look({ x, y }, scale) {
    if (!this.view || !this.stays || !this.fits || this.held) return
    const isFar = this.view.scale < scale || !this.#shows({ x, y }, { x, y })
    this.#isNear ||= isFar
    if (isFar) this.view = { x, y, scale: Math.max(this.view.scale, scale) }
  }

  /** Zooms around a point of the screen. @param {number} factor @param {Point} [at] the middle, if nothing is given */
  zoom(factor, at = { x: this.size.width / 2, y: this.size.height / 2 }) {
    const view = this.sight
    const before = this.toWorld(at)
    const scale = Math.min(Math.max(view.scale * factor, MIN_SCALE), MAX_SCALE)
    this.view = { ...view, scale }
    const after = this.toWorld(at)
    this.view = { x: view.x + before.x - after.x, y: view.y + before.y - after.y, scale }
    this.fits = false
  }

  /** @param {number} x @param {number} y */
  pan(x, y) {
    const view = this.sight
    this.view = { ...view, x: view.x - x / view.scale, y: view.y + y / view.scale }
    this.fits = false
  }

  /** @param {Point} point */
  toScreen({ x, y }) {
    const middle = this.#middle()
    const view = this.sight
    return { x: middle.x + (x - view.x) * view.scale, y: middle.y - (y - view.y) * view.scale }
  }

  /** @param {Point} point */
  toWorld({ x, y }) {
    const middle = this.#middle()
    const view = this.sight
    return { x: view.x + (x - middle.x) / view.scale, y: view.y - (y - middle.y) / view.scale }
  }

  #middle() {
    const { top, bottom, left } = this.insets
    return { x: left + (this.size.width - left) / 2, y: top + (this.size.height - top - bottom) / 2 }
  }

  /** @param {Point} low @param {Point} high */
  #shows(low, high) {
    const { x: left, y: bottom } = this.toScreen(low)
    const { x: right, y: top } = this.toScreen(high)
    const { width, height } = this.size
    return left > this.insets.left && right < width && top > this.insets.top && bottom < height - this.insets.bottom
  }
}

/**
 * The lower left and the upper right corner around lists of points, or around the origin where there are none.
 * @param {Iterable<Iterable<Point>>} lists
 * @returns {[Point, Point]}
 */
export function bounds(lists) {
  const low = { x: Infinity, y: Infinity }
  const high = { x: -Infinity, y: -Infinity }
  for (const points of lists) {
    for (const { x, y } of points) {
      low.x = Math.min(low.x, x)
      low.y = Math.min(low.y, y)
      high.x = Math.max(high.x, x)
      high.y = Math.max(high.y, y)
    }
  }
  return low.x <= high.x ? [low, high] : [{ x: 0, y: 0 }, { x: 0, y: 0 }]
}

/** The shortest of …0.5, 1, 2, 5, 10… meters that is no shorter than `least`. @param {number} least */
export function roundLength(least) {
  const power = 10 ** Math.floor(Math.log10(least))
  const factor = [1, 2, 5].find((factor) => factor * power >= least) ?? 10
  return Number((factor * power).toPrecision(1))
}

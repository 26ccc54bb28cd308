// Which part of the world the stage shows. World x is right, y is up, in metres; the screen's y is down, in pixels.

const MARGIN = 0.6 // metres around everything,
const EDGE = 36 // and pixels, for names and noses
const LEAST_VIEW = 5 // metres: a single robot at rest still has a stage around it
const EASING = 0.35 // seconds
const SHRINKING = 8 // seconds in which room that is no longer used is given up: a dance played again does not zoom
const LEAST_SCALE = 0.5
const MOST_SCALE = 2000 // pixels per metre

export class Camera {
  #room = null // the corners of what the view should hold
  view = null // {x, y, scale}: the world point in the middle, pixels per metre
  size = { width: 0, height: 0 }
  insets = { top: 0, bottom: 0, left: 0 } // pixels that are covered
  fits = true // whether it follows what there is to see

  /** Moves on to a view that holds the corners `used`; whether it is still on its way. Infinite seconds: it jumps. */
  follow(used, seconds) {
    const [low, high] = (this.#room = shrunk(this.#room ?? used, used, 1 - Math.exp(-seconds / SHRINKING)))
    if (!this.fits && this.view) return false
    const width = high.x - low.x + 2 * MARGIN
    const height = high.y - low.y + 2 * MARGIN
    const free = Math.max(this.size.height - this.insets.top - this.insets.bottom - 2 * EDGE, 80)
    const across = Math.max(this.size.width - this.insets.left - 2 * EDGE, 80) / Math.max(width, LEAST_VIEW)
    const scale = Math.max(Math.min(across, free / Math.max(height, LEAST_VIEW * 0.75)), LEAST_SCALE)
    const wanted = { x: (low.x + high.x) / 2, y: (low.y + high.y) / 2, scale }
    if (seconds === Infinity) {
      // Jumps are rarer with room to spare.
      if (!this.view || !this.#shows(low, high) || this.view.scale < scale / 3) this.view = { ...wanted, scale: scale * 0.85 }
      return false
    }
    this.view ??= wanted
    const part = 1 - Math.exp(-seconds / EASING)
    let left = 0
    const view = { ...this.view }
    for (const key of ["x", "y", "scale"]) {
      const way = wanted[key] - view[key]
      view[key] += way * part
      left += key === "scale" ? Math.abs(way / scale) : Math.abs(way * scale) / this.size.width
    }
    if (left < 3e-4) {
      if (left > 0) this.view = wanted
      return false
    }
    this.view = view
    return true
  }

  /** Forgets the room that was used: the next view is for what there is now. */
  fit() {
    this.fits = true
    this.#room = null
  }

  zoom(factor, at = { x: this.size.width / 2, y: this.size.height / 2 }) {
    const before = this.toWorld(at)
    const scale = Math.min(Math.max(this.view.scale * factor, LEAST_SCALE), MOST_SCALE)
    this.view = { ...this.view, scale }
    const after = this.toWorld(at)
    this.view = { x: this.view.x + before.x - after.x, y: this.view.y + before.y - after.y, scale }
    this.fits = false
  }

  pan(x, y) {
    this.view = { ...this.view, x: this.view.x - x / this.view.scale, y: this.view.y + y / this.view.scale }
    this.fits = false
  }

  toScreen({ x, y }) {
    const middle = this.#middle()
    return { x: middle.x + (x - this.view.x) * this.view.scale, y: middle.y - (y - this.view.y) * this.view.scale }
  }

  toWorld({ x, y }) {
    const middle = this.#middle()
    return { x: this.view.x + (x - middle.x) / this.view.scale, y: this.view.y - (y - middle.y) / this.view.scale }
  }

  #middle() {
    const { top, bottom, left } = this.insets
    return { x: left + (this.size.width - left) / 2, y: top + (this.size.height - top - bottom) / 2 }
  }

  #shows(low, high) {
    const { x: left, y: bottom } = this.toScreen(low)
    const { x: right, y: top } = this.toScreen(high)
    const { width, height } = this.size
    return left > this.insets.left && right < width && top > this.insets.top && bottom < height - this.insets.bottom
  }
}

/** The lower left and the upper right corner around lists of points, or around the origin where there are none. */
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

/** The corners of `room` after going `part` of the way to those `used`, which are always within. */
function shrunk([low, high], [usedLow, usedHigh], part) {
  const step = (from, to) => from + (to - from) * part
  return [
    { x: Math.min(step(low.x, usedLow.x), usedLow.x), y: Math.min(step(low.y, usedLow.y), usedLow.y) },
    { x: Math.max(step(high.x, usedHigh.x), usedHigh.x), y: Math.max(step(high.y, usedHigh.y), usedHigh.y) },
  ]
}

/** The shortest of …0.5, 1, 2, 5, 10… metres that is no shorter than `least`. */
export function roundLength(least) {
  const power = 10 ** Math.floor(Math.log10(least))
  const factor = [1, 2, 5, 10].find((factor) => factor * power >= least)
  return Number((factor * power).toPrecision(1))
}

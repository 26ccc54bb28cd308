// Draws the stage: a grid of metres, trails and robots, seen from above. World x is right, y is up.

const MARGIN = 0.9 // metres around everything, for names and noses
const LEGEND = 46 // pixels below everything, for the scale bar
const LEAST_VIEW = 6 // metres: a single robot at rest still has a stage around it
const EASING = 0.35 // seconds
const SHRINKING = 8 // seconds in which room that is no longer used is given up: a dance played again does not zoom
const SHADES = 24 // steps in which a trail fades
const FINEST = 2.5 // pixels between two points of a drawn trail
const FADED = 0.36
const LEAST_RADIUS = 9 // pixels

export class Stage {
  #canvas
  #pen
  #colors
  #size = { width: 0, height: 0 }
  #insets = { top: 0, bottom: 0 }
  #view = null // {x, y, scale}: the world point in the middle, pixels per metre
  #room = null // the corners of what the view should hold

  constructor(canvas) {
    this.#canvas = canvas
    this.#pen = canvas.getContext("2d", { alpha: false })
  }

  /** Reads the colors of the present theme. */
  readTheme() {
    const style = getComputedStyle(document.documentElement)
    const read = (name) => style.getPropertyValue(`--${name}`).trim()
    const names = ["ground", "grid", "grid-strong", "ink", "quiet", "shadow"]
    this.#colors = Object.fromEntries(names.map((name) => [name, read(name)]))
    this.#colors.robots = read("robots").split(/\s+/).map((color) => ({
      full: color,
      shades: Array.from({ length: SHADES }, (_, i) => mix(this.#colors.ground, color, FADED + ((1 - FADED) * i) / (SHADES - 1))),
    }))
  }

  /** Fits the canvas to the window; `insets` are the pixels that the header and a bottom button cover. */
  resize(insets) {
    const { clientWidth: width, clientHeight: height } = this.#canvas
    this.#size = { width, height }
    this.#insets = { top: insets.top, bottom: insets.bottom + LEGEND }
    this.#canvas.width = Math.round(width * devicePixelRatio)
    this.#canvas.height = Math.round(height * devicePixelRatio)
  }

  /**
   * Draws one frame. `seconds` is the time since the last one, for easing the view; Infinity for a view that jumps.
   * Returns whether the view is still on its way.
   */
  draw({ robots, radii, trails, at }, seconds) {
    const moving = this.#fit(robots, trails, seconds)
    const pen = this.#pen
    pen.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0)
    pen.fillStyle = this.#colors.ground
    pen.fillRect(0, 0, this.#size.width, this.#size.height)
    pen.lineJoin = pen.lineCap = "round"
    this.#drawGrid()
    const cast = Object.keys(radii)
    const seen = cast.filter((name) => robots[name]).map((name) => ({
      name,
      pose: robots[name],
      place: this.#toScreen(robots[name]),
      radius: Math.max(radii[name] * this.#view.scale, LEAST_RADIUS),
      color: this.#colors.robots[cast.indexOf(name) % this.#colors.robots.length],
    }))
    for (const robot of seen) this.#drawTrail(trails.get(robot.name) ?? [], robot, at)
    seen.sort((one, other) => one.pose.z - other.pose.z)
    for (const robot of seen) this.#drawRobot(robot)
    for (const robot of seen) this.#drawName(robot)
    this.#drawScale()
    return moving
  }

  #fit(robots, trails, seconds) {
    const used = bounds([Object.values(robots), ...trails.values()]) ?? [{ x: 0, y: 0 }, { x: 0, y: 0 }]
    const [low, high] = (this.#room = shrunk(this.#room ?? used, used, 1 - Math.exp(-seconds / SHRINKING)))
    const width = high.x - low.x + 2 * MARGIN
    const height = high.y - low.y + 2 * MARGIN
    const free = this.#size.height - this.#insets.top - this.#insets.bottom
    const scale = Math.max(Math.min(this.#size.width / Math.max(width, LEAST_VIEW), free / Math.max(height, LEAST_VIEW * 0.75)), 1)
    const wanted = { x: (low.x + high.x) / 2, y: (low.y + high.y) / 2, scale }
    if (seconds === Infinity) {
      // Jumps are rarer with room to spare.
      if (!this.#view || !this.#shows(low, high) || this.#view.scale < scale / 3) {
        this.#view = { ...wanted, scale: scale * 0.75 }
      }
      return false
    }
    this.#view ??= wanted
    const part = 1 - Math.exp(-seconds / EASING)
    let change = 0
    for (const key of ["x", "y", "scale"]) {
      const step = (wanted[key] - this.#view[key]) * part
      this.#view[key] += step
      change += Math.abs(key === "scale" ? step / scale : (step * scale) / this.#size.width)
    }
    return change > 1e-5
  }

  #shows(low, high) {
    const { x: left, y: bottom } = this.#toScreen(low)
    const { x: right, y: top } = this.#toScreen(high)
    const { width, height } = this.#size
    return left > 0 && right < width && top > this.#insets.top && bottom < height - this.#insets.bottom
  }

  #toScreen({ x, y }) {
    const { width, height } = this.#size
    const { top, bottom } = this.#insets
    return {
      x: width / 2 + (x - this.#view.x) * this.#view.scale,
      y: top + (height - top - bottom) / 2 - (y - this.#view.y) * this.#view.scale,
    }
  }

  #drawGrid() {
    const pen = this.#pen
    const { width, height } = this.#size
    const step = roundLength(44 / this.#view.scale)
    const origin = this.#toScreen({ x: 0, y: 0 })
    const spacing = step * this.#view.scale
    const lines = (from, to, put, color) => {
      pen.beginPath()
      for (let i = from; i <= to; i++) put(i)
      pen.strokeStyle = color
      pen.lineWidth = 1
      pen.stroke()
    }
    const upright = (i) => {
      const x = Math.round(origin.x + i * spacing) + 0.5
      pen.moveTo(x, 0)
      pen.lineTo(x, height)
    }
    const level = (i) => {
      const y = Math.round(origin.y + i * spacing) + 0.5
      pen.moveTo(0, y)
      pen.lineTo(width, y)
    }
    lines(Math.ceil(-origin.x / spacing), (width - origin.x) / spacing, upright, this.#colors.grid)
    lines(Math.ceil(-origin.y / spacing), (height - origin.y) / spacing, level, this.#colors.grid)
    lines(0, 0, upright, this.#colors["grid-strong"])
    lines(0, 0, level, this.#colors["grid-strong"])
  }

  #drawTrail(trail, { place, color }, at) {
    let shown = trail.length
    while (shown > 0 && trail[shown - 1].at > at) shown--
    if (shown === 0) return
    const pen = this.#pen
    const width = Math.min(Math.max(this.#view.scale * 0.06, 3), 9)
    const length = Math.ceil((shown + 1) / SHADES)
    const count = Math.ceil(shown / length)
    pen.lineWidth = width
    for (let part = 0; part < count; part++) {
      const last = Math.min((part + 1) * length, shown)
      let drawn = { x: Infinity, y: Infinity }
      pen.beginPath()
      for (let i = part * length; i <= last; i++) {
        const point = i < shown ? this.#toScreen(trail[i]) : place
        if (i < last && Math.hypot(point.x - drawn.x, point.y - drawn.y) < FINEST) continue
        pen.lineTo(point.x, point.y)
        drawn = point
      }
      pen.strokeStyle = color.shades[SHADES - count + part] // the newest is the brightest, however short the trail
      pen.stroke()
    }
    const start = this.#toScreen(trail[0])
    pen.fillStyle = this.#colors.ground
    pen.strokeStyle = color.shades[SHADES - count]
    pen.lineWidth = width * 0.75
    circle(pen, start.x, start.y, width * 1.1)
    pen.stroke()
  }

  #drawRobot({ pose, place, radius, color }) {
    const pen = this.#pen
    const lift = Math.min(Math.abs(pose.z) * this.#view.scale * 0.25, radius * 1.5)
    pen.save()
    pen.translate(place.x, place.y)
    pen.rotate(-pose.heading)
    // The tangents from the nose's tip touch the disc at this angle.
    const tip = 1.38 * radius
    const touch = Math.acos(radius / tip)
    const body = new Path2D()
    body.arc(0, 0, radius, touch, -touch)
    body.lineTo(tip, 0)
    body.closePath()
    const shadowScale = devicePixelRatio // shadows ignore the transform
    pen.shadowColor = `${this.#colors.shadow}59`
    pen.shadowBlur = (radius * 0.35 + lift * 0.5) * shadowScale
    pen.shadowOffsetX = lift * 0.7 * shadowScale
    pen.shadowOffsetY = (radius * 0.12 + lift) * shadowScale
    pen.fillStyle = pen.strokeStyle = color.full
    pen.fill(body)
    pen.shadowColor = "transparent"
    pen.lineWidth = radius * 0.16 // rounds the nose
    pen.stroke(body)
    for (const side of [-1, 1]) {
      pen.fillStyle = "#ffffff"
      circle(pen, radius * 0.42, side * radius * 0.4, radius * 0.27)
      pen.fillStyle = "#1c2330"
      circle(pen, radius * 0.5, side * radius * 0.4, radius * 0.15)
    }
    pen.restore()
  }

  #drawName({ name, pose, place, radius }) {
    const pen = this.#pen
    const size = Math.min(Math.max(14, Math.min(this.#size.width, this.#size.height) * 0.024), 30)
    const height = Math.abs(pose.z) >= 0.05 ? ` ${pose.z > 0 ? "↑" : "↓"} ${Math.abs(pose.z).toFixed(1)} m` : ""
    this.#write(name + height, place.x, place.y + radius * 1.4 + size * 0.75, size, "center")
  }

  #drawScale() {
    const pen = this.#pen
    const metres = roundLength(64 / this.#view.scale)
    const length = metres * this.#view.scale
    const size = Math.min(Math.max(13, this.#size.height * 0.018), 24)
    const x = 24
    const y = this.#size.height - this.#insets.bottom + LEGEND - 22
    pen.beginPath()
    pen.moveTo(x, y - 6)
    pen.lineTo(x, y)
    pen.lineTo(x + length, y)
    pen.lineTo(x + length, y - 6)
    pen.strokeStyle = this.#colors.quiet
    pen.lineWidth = 2
    pen.stroke()
    this.#write(`${metres} m`, x + length / 2, y - size * 0.8, size, "center", this.#colors.quiet)
  }

  #write(text, x, y, size, align, color = this.#colors.ink) {
    const pen = this.#pen
    pen.font = `600 ${size}px system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif`
    pen.textAlign = align
    pen.textBaseline = "middle"
    pen.lineWidth = size * 0.3
    pen.strokeStyle = this.#colors.ground // an edge that keeps it legible over trails
    pen.strokeText(text, x, y)
    pen.fillStyle = color
    pen.fillText(text, x, y)
  }
}

function circle(pen, x, y, radius) {
  pen.beginPath()
  pen.arc(x, y, radius, 0, 2 * Math.PI)
  pen.fill()
}

/** The lower left and the upper right corner around lists of points, or null where there are none. */
function bounds(lists) {
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
  return low.x <= high.x ? [low, high] : null
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
function roundLength(least) {
  const power = 10 ** Math.floor(Math.log10(least))
  const factor = [1, 2, 5, 10].find((factor) => factor * power >= least)
  return Number((factor * power).toPrecision(1))
}

/** The color `part` of the way from one #rrggbb to another. */
function mix(from, to, part) {
  const channel = (color, i) => parseInt(color.slice(1 + 2 * i, 3 + 2 * i), 16)
  const mixed = [0, 1, 2].map((i) => Math.round(channel(from, i) + (channel(to, i) - channel(from, i)) * part))
  return `rgb(${mixed.join(" ")})`
}

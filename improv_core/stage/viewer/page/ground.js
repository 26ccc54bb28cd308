// All that stands still on the stage for a while: the grid, the world, the paths ahead and the trails. It is painted a
// little in each frame, on a sheet of its own, so that no frame is late for it; a frame copies the last finished sheet.

import { roundLength } from "./camera.js"
import { mix } from "./colors.js"
import { after, trace } from "./path.js"
import { paintWorld } from "./world.js"

const SHADES = 12 // steps in which a trail fades
const FADED = 0.36
const AHEAD = 0.5 // how much of its color a path ahead has
const OLD = 0.4 // seconds after which a sheet has to be brought up to date while robots move
const TURNED = 0.1 // seconds after which it is, while the view changes
const FADING = 5 // seconds after which it is painted anew, as trails fade

export class Ground {
  #canvas = null // to paint on; what is finished is an image, which is copied faster
  #shown = null // {image, view, middle, ratio, painted, signs, begun, since}: painted from `begun` on, up to date as of `since`
  #making = null // the same, with the `steps` that are left

  /** Goes on painting for so many milliseconds. Whether there is more to paint. */
  paint(scene, milliseconds) {
    const signs = scene.signs.join()
    const { view } = scene.camera
    const outdated = (sheet) => sheet.view !== view || sheet.signs !== signs
    const now = performance.now()
    if (this.#making && outdated(this.#making) && (!this.#shown || now - this.#making.begun > 250)) {
      this.#making = null // what is half done would be wrong for long
    }
    if (!this.#making) {
      const fresh = this.#shown && !outdated(this.#shown)
      if (this.#shown?.signs === signs && !fresh && now - this.#shown.begun < TURNED * 1000) return true
      if (fresh && !(scene.moving && now - this.#shown.since > OLD * 1000)) return false
      if (fresh && scene.trail === Infinity && now - this.#shown.begun < FADING * 1000) {
        this.#lengthen(scene)
        return false
      }
      this.#making = this.#begin(scene, signs)
    }
    const end = now + milliseconds
    while (!this.#making.steps.next().done) if (performance.now() > end && this.#shown) return true
    this.#show(this.#making)
    this.#making = null
    return outdated(this.#shown)
  }

  /** Copies the last finished sheet, moved to where the camera looks now. What of each trail is on it. */
  draw(pen, camera, colors) {
    const { image, view, middle, ratio, painted } = this.#shown
    pen.setTransform(1, 0, 0, 1, 0, 0)
    if (camera.view !== view) {
      const { x, y } = camera.toScreen(view)
      const factor = camera.view.scale / view.scale
      pen.fillStyle = colors.ground
      pen.fillRect(0, 0, image.width, image.height)
      pen.setTransform(factor, 0, 0, factor, (x - middle.x * factor) * ratio, (y - middle.y * factor) * ratio)
    }
    pen.drawImage(image, 0, 0)
    return painted
  }

  /** Throws all away: the size has changed, or the theme. */
  reset() {
    this.#canvas = this.#shown = this.#making = null
  }

  #show(sheet) {
    this.#shown?.image.close()
    this.#shown = { ...sheet, image: this.#canvas.transferToImageBitmap() }
  }

  /** Adds to the sheet what has been gone since it was painted. */
  #lengthen(scene) {
    const { image, ratio, painted } = this.#shown
    const pen = this.#pen()
    pen.setTransform(1, 0, 0, 1, 0, 0)
    pen.drawImage(image, 0, 0)
    pen.setTransform(ratio, 0, 0, ratio, 0, 0)
    for (const robot of scene.cast) paintTail(pen, scene, robot, painted.get(robot.name))
    const now = new Map(scene.cast.map(({ name, pose }) => [name, reached(scene, pose)]))
    this.#show({ ...this.#shown, painted: now, since: performance.now() })
  }

  #begin(scene, signs) {
    const { camera, ratio } = scene
    const { view } = camera
    const [width, height] = [camera.size.width, camera.size.height].map((length) => Math.round(length * ratio))
    this.#canvas ??= new OffscreenCanvas(width, height)
    const middle = camera.toScreen(view)
    const painted = new Map()
    const now = performance.now()
    const steps = paintAll(this.#pen(), { ...scene, view, middle, size: { ...camera.size } }, painted)
    return { view, middle, ratio, painted, signs, steps, begun: now, since: now }
  }

  #pen() {
    const pen = this.#canvas.getContext("2d", { alpha: false })
    pen.lineJoin = pen.lineCap = "round"
    return pen
  }
}

/** Where a world point is on a sheet, in CSS pixels. */
function onSheet({ view, middle }, { x, y }) {
  return { x: middle.x + (x - view.x) * view.scale, y: middle.y - (y - view.y) * view.scale }
}

function* paintAll(pen, scene, painted) {
  const { colors, cast, ratio, size } = scene
  const flat = () => pen.setTransform(ratio, 0, 0, ratio, 0, 0)
  flat()
  pen.fillStyle = colors.ground
  pen.fillRect(0, 0, size.width, size.height)
  paintGrid(pen, scene)
  yield
  if (scene.world) {
    inWorld(pen, scene)
    paintWorld(pen, scene.world, scene.view.scale, scene.colors.wall)
    flat()
    yield
  }
  for (const robot of scene.ahead ? cast : []) {
    if (!robot.way) continue
    inWorld(pen, scene)
    paintAhead(pen, scene, robot)
    flat()
    yield
  }
  for (const robot of cast) {
    painted.set(robot.name, paintTrail(pen, scene, robot))
    yield
  }
}

function inWorld(pen, { view, middle, ratio }) {
  const scale = view.scale * ratio
  pen.setTransform(scale, 0, 0, -scale, middle.x * ratio - view.x * scale, middle.y * ratio + view.y * scale)
}

function paintGrid(pen, scene) {
  const { view, size, colors } = scene
  const spacing = roundLength(44 / view.scale) * view.scale
  const origin = onSheet(scene, { x: 0, y: 0 })
  const lines = (color, put) => {
    pen.beginPath()
    put()
    pen.strokeStyle = color
    pen.lineWidth = 1
    pen.stroke()
  }
  const upright = (i) => {
    const x = Math.round(origin.x + i * spacing) + 0.5
    pen.moveTo(x, 0)
    pen.lineTo(x, size.height)
  }
  const level = (i) => {
    const y = Math.round(origin.y + i * spacing) + 0.5
    pen.moveTo(0, y)
    pen.lineTo(size.width, y)
  }
  lines(colors.grid, () => {
    for (let i = Math.ceil(-origin.x / spacing); i <= (size.width - origin.x) / spacing; i++) upright(i)
    for (let i = Math.ceil(-origin.y / spacing); i <= (size.height - origin.y) / spacing; i++) level(i)
  })
  lines(colors["grid-strong"], () => {
    upright(0)
    level(0)
  })
}

function paintAhead(pen, { view, colors, beat, until }, { way, moved, color }) {
  const first = way.findIndex(({ end }) => end > beat)
  if (first < 0) return
  if (moved) {
    const cos = Math.cos(moved.heading)
    const sin = Math.sin(moved.heading)
    pen.transform(cos, sin, -sin, cos, moved.x, moved.y)
  }
  pen.beginPath()
  for (let i = first; i < way.length && way[i].start < until; i++) {
    const { start, end, pose, velocity, seconds } = way[i]
    const done = Math.max((beat - start) / (end - start), 0)
    const from = done > 0 ? after(pose, velocity, seconds * done) : pose
    if (i === first) pen.moveTo(from.x, from.y)
    trace(pen, from, velocity, seconds * (1 - done))
  }
  pen.strokeStyle = mix(colors.ground, color, AHEAD)
  pen.lineWidth = Math.min(Math.max(view.scale * 0.03, 2), 4) / view.scale
  pen.stroke()
}

/** Paints the trail of a robot up to where it is now, brighter the newer it is. What has been painted. */
function paintTrail(pen, scene, { name, color, pose }) {
  const { at, colors, view } = scene
  const points = visible(scene.trails.get(name) ?? [], scene)
  const width = trailWidth(view)
  const place = onSheet(scene, pose)
  if (!points.length) return reached(scene, pose)
  const oldest = points[0].at
  const shade = (time) => Math.min(Math.floor(((time - oldest) / (at - oldest || 1)) * SHADES), SHADES - 1)
  pen.lineWidth = width
  let now = -1
  let last = null
  const finish = () => {
    if (now < 0) return
    pen.strokeStyle = mix(colors.ground, color, FADED + ((1 - FADED) * now) / (SHADES - 1))
    pen.stroke()
  }
  for (const point of [...points, { ...pose, at }]) {
    const { x, y } = onSheet(scene, point)
    if (point.first || shade(point.at) !== now) {
      if (!point.first && last) pen.lineTo(x, y)
      finish()
      now = shade(point.at)
      pen.beginPath()
      pen.moveTo(x, y)
    } else {
      pen.lineTo(x, y)
    }
    last = point
  }
  pen.lineTo(place.x, place.y)
  finish()
  if (scene.trail === Infinity) paintStart(pen, onSheet(scene, points[0]), width, colors.ground, mix(colors.ground, color, 0.7))
  return reached(scene, pose)
}

/** How far a trail is painted. */
function reached({ at, placed }, place) {
  return { at, placed, place }
}

/** Paints the part of a trail that is too new to be on the sheet: what was gone since `from`. */
export function paintTail(pen, scene, { name, place, color }, from) {
  const { camera } = scene
  const trail = scene.trails.get(name) ?? []
  if (!from || isLater(from, scene) || !trail.length) return
  const start = camera.toScreen(from.place)
  let index = trail.length
  while (index > 0 && isLater(trail[index - 1], from)) index--
  pen.beginPath()
  pen.moveTo(start.x, start.y)
  for (; index < trail.length && !isLater(trail[index], scene); index++) {
    const point = camera.toScreen(trail[index])
    if (trail[index].first) pen.moveTo(point.x, point.y)
    else pen.lineTo(point.x, point.y)
  }
  pen.lineTo(place.x, place.y)
  pen.strokeStyle = color
  pen.lineWidth = trailWidth(camera.view)
  pen.stroke()
}

function paintStart(pen, { x, y }, width, ground, color) {
  pen.beginPath()
  pen.arc(x, y, width * 1.1, 0, 2 * Math.PI)
  pen.fillStyle = ground
  pen.fill()
  pen.strokeStyle = color
  pen.lineWidth = width * 0.75
  pen.stroke()
}

/** While nothing plays no time passes, however often robots are put elsewhere. */
function isLater(one, other) {
  return one.placed > other.placed || one.at > other.at
}

/** The points of a trail that are to be seen in a scene; the first lies on the way, as old as may be. */
function visible(trail, scene) {
  const points = trail.filter((point) => !isLater(point, scene))
  if (scene.trail === Infinity) return points
  const since = scene.at - scene.trail
  const first = points.findIndex((point) => point.at > since)
  if (first < 0 || scene.trail === 0) return []
  const [before, next] = [points[first - 1], points[first]]
  if (!before || next.first) return points.slice(first)
  const part = (since - before.at) / (next.at - before.at)
  const cut = { ...before, at: since, x: before.x + (next.x - before.x) * part, y: before.y + (next.y - before.y) * part, first: true }
  return [cut, ...points.slice(first)]
}

/** In pixels. */
function trailWidth(view) {
  return Math.min(Math.max(view.scale * 0.06, 3), 9)
}

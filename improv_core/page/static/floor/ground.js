// @ts-check
// Everything that rarely changes on the stage: the grid, the world, the paths ahead, and the trails. Each frame paints a
// little of it on a separate sheet, so that no frame is late, and copies the last finished sheet.

import { roundLength } from "./camera.js"
import { colors, mix } from "../base/colors.js"
import { due, isWriting } from "../base/frames.js"
import { poseAfter, trace } from "../base/path.js"
import { penOn } from "../base/pen.js"
import { measured } from "./measured.js"
import { paintWorld } from "./world.js"

/** @import { Point, Sight } from "./camera.js" */
/** @import { Drawn, GroundScene } from "./floor.js" */
/** @import { Pen } from "../base/pen.js" */
/** @typedef {{ at: number, version: number, count: number }} Reached how far a trail is painted, and which version of it */
/** @typedef {GroundScene & { view: Sight, middle: Point, size: { width: number, height: number } }} SheetScene */
/**
 * @typedef {object} Sheet
 * @property {Sight} view
 * @property {Point} middle of the view, in pixels
 * @property {number} ratio device pixels per CSS pixel
 * @property {Map<string, Reached>} painted by robot
 * @property {string} key of the scene
 * @property {Generator<void>} steps that are left
 * @property {number} begun when painting began, in milliseconds
 * @property {number} since when trails were last added
 */

const SHADES = 12 // steps in which a trail fades
const FADED = 0.36
const AHEAD_OPACITY = 0.5 // how much of its color a path ahead has
const MOVING_PERIOD = 0.4 // seconds after which a sheet is updated while robots move,
const WRITING_PERIOD = 2 // and while somebody writes, too
const TURNING_PERIOD = 0.1 // seconds after which it is updated while the view changes
const REPAINT_PERIOD = 5 // seconds after which it is repainted, as trails fade
const TIME = 3 // milliseconds of a frame for painting,
const PATHS_TIME = 16 // and for paths of the text, for which somebody waits

export class Ground {
  /** @type {OffscreenCanvas | null} */
  #canvas = null // to paint on, while the other one is shown
  /** @type {(Sheet & { canvas: OffscreenCanvas }) | null} */
  #shown = null
  /** @type {Sheet | null} */
  #making = null

  /**
   * Continues painting for some milliseconds. Returns whether there is more to paint.
   * @param {GroundScene} scene
   * @param {number} milliseconds
   * @returns {boolean}
   */
  paint(scene, milliseconds = due.paths ? PATHS_TIME : TIME) {
    const { key } = scene
    const { sight: view } = scene.camera
    const outdated = (/** @type {Sheet} */ sheet) => sheet.view !== view || sheet.key !== key
    const now = performance.now()
    if (!this.#making) {
      const fresh = this.#shown && !outdated(this.#shown)
      if (this.#shown?.key === key && !fresh && now - this.#shown.begun < TURNING_PERIOD * 1000) return true
      const period = isWriting() ? WRITING_PERIOD : MOVING_PERIOD
      if (this.#shown && fresh && !(scene.moving && now - this.#shown.since > period * 1000)) return false
      if (this.#shown && fresh && scene.trail === Infinity && now - this.#shown.begun < REPAINT_PERIOD * 1000) {
        this.#lengthen(this.#shown, scene)
        return false
      }
      this.#making = this.#begin(scene)
    }
    const end = now + milliseconds
    const sheet = this.#making
    while (!sheet.steps.next().done) if (performance.now() > end && this.#shown) return true
    this.#show(sheet)
    this.#making = null
    return outdated(sheet) && (performance.now() > end || this.paint(scene, end - performance.now()))
  }

  /**
   * Copies the last finished sheet, moved to where the camera looks now. Returns how far trails are painted on it.
   * @param {Pen} pen
   * @param {GroundScene["camera"]} camera
   */
  draw(pen, camera) {
    if (!this.#shown) throw new Error("nothing has been painted yet")
    const { canvas, view, middle, ratio, painted } = this.#shown
    pen.setTransform(1, 0, 0, 1, 0, 0)
    if (camera.view !== view) {
      const { x, y } = camera.toScreen(view)
      const factor = camera.sight.scale / view.scale
      pen.fillStyle = colors().ground
      pen.fillRect(0, 0, canvas.width, canvas.height)
      pen.setTransform(factor, 0, 0, factor, (x - middle.x * factor) * ratio, (y - middle.y * factor) * ratio)
    }
    pen.drawImage(canvas, 0, 0)
    return painted
  }

  /** Discards everything: the size has changed. */
  reset() {
    this.#canvas = this.#shown = this.#making = null
  }

  /** @param {Sheet} sheet */
  #show(sheet) {
    const canvas = this.#shown?.canvas ?? null
    if (this.#canvas) this.#shown = { ...sheet, canvas: this.#canvas }
    this.#canvas = canvas
  }

  /**
   * Adds to the sheet the trails since it was painted.
   * @param {Sheet & { canvas: OffscreenCanvas }} shown
   * @param {GroundScene} scene
   */
  #lengthen(shown, scene) {
    const pen = penFor(shown.canvas)
    for (const robot of scene.robots) paintTail(pen, scene, robot, shown.painted.get(robot.name))
    shown.painted = new Map(scene.robots.map(({ name }) => [name, reached(scene, name)]))
    shown.since = performance.now()
  }

  /** @param {GroundScene} scene @returns {Sheet} */
  #begin(scene) {
    const { camera, ratio } = scene
    const view = camera.sight
    const middle = camera.toScreen(view)
    /** @type {Sheet["painted"]} */
    const painted = new Map()
    const now = performance.now()
    const size = { ...camera.size }
    this.#canvas ??= new OffscreenCanvas(Math.round(size.width * ratio), Math.round(size.height * ratio))
    const steps = paintAll(penFor(this.#canvas), { ...scene, view, middle, size }, painted)
    return { view, middle, ratio, painted, key: scene.key, steps, begun: now, since: now }
  }
}

/** @param {OffscreenCanvas} canvas */
function penFor(canvas) {
  const pen = penOn(canvas, { alpha: false })
  pen.lineJoin = pen.lineCap = "round"
  return pen
}

/** @param {Pen} pen @param {SheetScene} scene @param {Sheet["painted"]} painted */
function* paintAll(pen, scene, painted) {
  const { robots, ratio, size, preview } = scene
  const { version } = preview
  pen.setTransform(ratio, 0, 0, ratio, 0, 0)
  pen.fillStyle = colors().ground
  pen.fillRect(0, 0, size.width, size.height)
  paintGrid(pen, scene)
  inWorld(pen, scene)
  yield
  if (scene.world) paintWorld(pen, scene.world, scene.view.scale, colors().wall)
  yield
  for (const robot of scene.ahead ? robots : []) {
    paintAhead(pen, scene, robot)
    yield
  }
  yield* preview.paint(pen, scene.view.scale)
  for (const robot of robots) {
    painted.set(robot.name, paintTrail(pen, scene, robot))
    yield
  }
  preview.appeared(version)
}

/** Has a pen draw in meters. @param {Pen} pen @param {Pick<SheetScene, "view" | "middle" | "ratio">} scene */
function inWorld(pen, { view, middle, ratio }) {
  const scale = view.scale * ratio
  pen.setTransform(scale, 0, 0, -scale, middle.x * ratio - view.x * scale, middle.y * ratio + view.y * scale)
}

/** @param {Pen} pen @param {SheetScene} scene */
function paintGrid(pen, scene) {
  const { view, middle, size } = scene
  const spacing = roundLength(44 / view.scale) * view.scale
  const origin = { x: middle.x - view.x * view.scale, y: middle.y + view.y * view.scale } // in CSS pixels
  const lines = (/** @type {string} */ color, /** @type {() => void} */ put) => {
    pen.beginPath()
    put()
    pen.strokeStyle = color
    pen.lineWidth = 1
    pen.stroke()
  }
  const upright = (/** @type {number} */ i) => {
    const x = Math.round(origin.x + i * spacing) + 0.5
    pen.moveTo(x, 0)
    pen.lineTo(x, size.height)
  }
  const level = (/** @type {number} */ i) => {
    const y = Math.round(origin.y + i * spacing) + 0.5
    pen.moveTo(0, y)
    pen.lineTo(size.width, y)
  }
  lines(colors().grid, () => {
    for (let i = Math.ceil(-origin.x / spacing); i <= (size.width - origin.x) / spacing; i++) upright(i)
    for (let i = Math.ceil(-origin.y / spacing); i <= (size.height - origin.y) / spacing; i++) level(i)
  })
  lines(colors()["grid-strong"], () => {
    upright(0)
    level(0)
  })
}

/** @param {Pen} pen @param {SheetScene} scene @param {Drawn} robot */
function paintAhead(pen, { view, size, beat, until }, { path, moved, color }) {
  if (!path) return
  const first = path.findIndex(({ end }) => end > beat)
  if (first < 0) return
  pen.save()
  if (moved) {
    pen.translate(moved.x, moved.y)
    pen.rotate(moved.heading)
  }
  pen.beginPath()
  for (let i = first; i < path.length && path[i].start < until; i++) {
    const { start, end, pose, velocity, seconds } = path[i]
    if (!pose) break
    const done = Math.max((beat - start) / (end - start), 0)
    const from = done > 0 ? poseAfter(pose, velocity, seconds * done) : pose
    if (i === first) pen.moveTo(from.x, from.y)
    trace(pen, from, velocity, seconds * (1 - done))
  }
  pen.strokeStyle = mix(colors().ground, color, AHEAD_OPACITY)
  pen.lineWidth = (trailWidth(view, size) * 0.5) / view.scale
  pen.stroke()
  pen.restore()
}

/**
 * Paints the trail of a robot up to where it is now, brighter where it is newer. Returns how far.
 * @param {Pen} pen
 * @param {SheetScene} scene
 * @param {Drawn} robot
 * @returns {Reached}
 */
function paintTrail(pen, scene, { name, color, pose, seen }) {
  const { view, size, trail, trails } = scene
  const at = Math.min(scene.at, seen)
  if (measured.has(name)) {
    if (trail > 0) measured.paint(pen, name, { from: 0, since: at - trail, ...strokes(size, view, color) })
    return reached(scene, name)
  }
  const segments = trail > 0 ? [...trails.segments(name, at - trail, at, pose)] : []
  if (!segments.length) return reached(scene, name)
  const oldest = segments[0].at
  const shade = (at - oldest) / SHADES || 1 // seconds
  let now = -1
  const finish = () => {
    if (now < 0) return
    pen.strokeStyle = mix(colors().ground, color, FADED + ((1 - FADED) * now) / (SHADES - 1))
    pen.stroke()
  }
  pen.lineWidth = trailWidth(view, size) / view.scale
  for (const { pose: from, velocity, at: start, end } of segments) {
    const long = Math.max(end - start, 1e-9)
    for (let time = start; time < end; ) {
      const step = Math.min(Math.floor((time - oldest) / shade + 1e-9), SHADES - 1)
      const until = step === SHADES - 1 ? end : Math.min(oldest + (step + 1) * shade, end)
      const here = poseAfter(from, velocity, (time - start) / long)
      if (step !== now) {
        finish()
        now = step
        pen.beginPath()
        pen.moveTo(here.x, here.y)
      }
      trace(pen, here, velocity, (until - time) / long)
      time = until
    }
  }
  finish()
  if (trail === Infinity) paintStart(pen, segments[0].pose, trailWidth(view, size) / view.scale, mix(colors().ground, color, 0.7))
  return reached(scene, name)
}

/**
 * The paint of a measured robot's lines: the thin one is its ideal path.
 * @param {{ width: number, height: number }} size of the picture
 * @param {Sight} view
 * @param {string} color
 */
function strokes(size, view, color) {
  return { color, ink: colors().ink, width: trailWidth(view, size) / view.scale, thin: 1.5 / view.scale }
}

/**
 * The painted length of trails.
 * @param {Pick<GroundScene, "at" | "trails">} scene
 * @param {string} name
 * @returns {Reached}
 */
function reached({ at, trails }, name) {
  const version = measured.has(name) ? measured.version : trails.version
  return { at, version, count: measured.count(name) }
}

/**
 * Paints the part of a trail that is too new to be on the sheet.
 * @param {Pen} pen
 * @param {Pick<GroundScene, "camera" | "ratio" | "trails" | "at">} scene
 * @param {Drawn} robot
 * @param {Reached | undefined} from
 */
export function paintTail(pen, { camera, ratio, trails, at: now }, { name, pose, color, seen }, from) {
  const real = measured.has(name)
  const at = Math.min(now, seen)
  if (!from || from.version !== (real ? measured : trails).version) return
  if (real ? from.count === measured.count(name) : from.at >= at) return
  inWorld(pen, { view: camera.sight, middle: camera.toScreen(camera.sight), ratio })
  if (real) measured.paint(pen, name, { from: from.count, since: -Infinity, ...strokes(camera.size, camera.sight, color) })
  else {
    pen.beginPath()
    for (const segment of trails.segments(name, from.at, at, pose)) {
      pen.moveTo(segment.pose.x, segment.pose.y)
      trace(pen, segment.pose, segment.velocity, 1)
    }
    pen.strokeStyle = color
    pen.lineWidth = trailWidth(camera.sight, camera.size) / camera.sight.scale
    pen.stroke()
  }
  pen.setTransform(ratio, 0, 0, ratio, 0, 0)
}

/** @param {Pen} pen @param {Point} place @param {number} width @param {string} color */
function paintStart(pen, { x, y }, width, color) {
  pen.beginPath()
  pen.arc(x, y, width * 1.1, 0, 2 * Math.PI)
  pen.fillStyle = colors().ground
  pen.fill()
  pen.strokeStyle = color
  pen.lineWidth = width * 0.75
  pen.stroke()
}

/**
 * Pixels: as wide as a pen would draw, but within limits that suit the size of the picture.
 * @param {Sight} view
 * @param {{ width: number, height: number }} size
 */
function trailWidth(view, { width, height }) {
  const shorter = Math.min(width, height)
  return Math.min(Math.max(view.scale * 0.06, shorter * 0.006, 3), Math.max(shorter * 0.012, 6))
}

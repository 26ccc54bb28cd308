// @ts-check
// Draws the stage in each frame: the ground as it was last painted, and on it everything that moves.

import { bounds, Camera, roundLength } from "./camera.js"
import { RADIUS } from "../score/robot-list.js"
import { mix, readColors } from "../base/colors.js"
import { Ground, paintTail } from "./ground.js"
import { Labels } from "./labels.js"
import { drawLimbs } from "./figure-above.js"
import { drawMark } from "./meetings.js"
import { drawReturnPath } from "./out-of-place.js"
import { penOn } from "../base/pen.js"
import { drawLost, drawRing, placeRings } from "./rings.js"
import { picture, REACH } from "./robots.js"

/** @import { Colors } from "../base/colors.js" */
/** @import { Pen } from "../base/pen.js" */
/** @import { Point } from "./camera.js" */
/** @import { Pose } from "../base/path.js" */
/** @import { Mark } from "./meetings.js" */
/** @import { Placed } from "./rings.js" */
/** @import { Scene } from "./view.js" */
/** @typedef {Scene["robots"][number] & { pose: Pose, place: Point, size: number }} Drawn a robot, with its place in pixels */
/** @typedef {Omit<Scene, "robots"> & { robots: Drawn[], camera: Camera, ratio: number, colors: Colors }} GroundScene */

const LEAST_PIXELS = 12 // pixels: a robot's radius,
const LEAST_SHARE = 0.034 // of the stage's shorter side,
const CROWD_SIZE = 8 // as long as there are no more robots; more of them are smaller
const LEAST_STRIP = 48 // pixels for the scale
const MOST_NAMES = 200 // in view: more robots are named only if somebody points at them
const LINE_HEIGHT = 1.15 // of a name's size, to the next line
const PAINT_BUDGET = 3 // milliseconds of each frame
const FONT = `system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif`

export class Floor {
  #canvas
  #pen
  #ground = new Ground()
  /** @type {Map<string, ImageBitmap>} */
  #labels = new Map()
  /** @type {ImageBitmap | null} */
  #shadow = null
  #ratio = 1
  #strip = { foot: 0, width: 0 } // at the bottom, for the scale, in pixels
  #names = new Labels()
  /** @type {Drawn[]} */
  #robots = [] // of the latest frame
  /** @type {string[]} */
  names = [] // that are shown
  /** @type {string | null} */
  pointed = null // the robot whose name is shown in any case
  camera = new Camera()
  colors = readColors()

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.#canvas = canvas
    this.#pen = penOn(canvas, { alpha: false })
  }

  readTheme() {
    this.colors = readColors()
    this.#labels.clear()
    this.#ground.reset()
    this.#shadow = null
  }

  /**
   * Fits the canvas to its room; `insets` are the covered pixels on each side, and `strip` is left for the scale.
   * @param {Camera["insets"]} insets
   * @param {{ foot: number, width: number }} strip
   */
  resize(insets, strip) {
    this.#strip = strip
    const { clientWidth: width, clientHeight: height } = this.#canvas
    this.#ratio = Math.min(devicePixelRatio, 2)
    this.camera.size = { width, height }
    this.camera.insets = insets
    if (this.camera.view) this.camera.view = { ...this.camera.view }
    this.#canvas.width = Math.round(width * this.#ratio)
    this.#canvas.height = Math.round(height * this.#ratio)
    this.#ground.reset()
  }

  /**
   * The color of the robot with this index in the list of robots.
   * @param {number} index
   */
  color(index) {
    return this.colors.robots[index % this.colors.robots.length]
  }

  /**
   * Draws one frame of a scene. `seconds` is the time since the last frame, for easing the view, or Infinity to jump.
   * Returns whether there is more to draw.
   * @param {Scene} scene
   * @param {number} seconds
   */
  draw(scene, seconds) {
    const { camera } = this
    if (!camera.size.width || !camera.size.height) return false
    const seen = scene.robots.flatMap((robot) => (robot.pose ? [{ ...robot, pose: robot.pose }] : []))
    const radius = seen.length ? Math.max(...seen.map(({ radius }) => radius)) : RADIUS
    const turning = camera.follow(bounds([seen.map(({ pose }) => pose), scene.room]), radius, seconds)
    const { scale } = camera.sight
    const crowd = Math.sqrt(Math.max(seen.length / CROWD_SIZE, 1))
    const least = Math.max(LEAST_PIXELS / Math.sqrt(crowd), (LEAST_SHARE * camera.shorter) / crowd)
    const robots = seen.map((robot) => ({
      ...robot,
      place: camera.toScreen(robot.pose),
      size: Math.max(robot.radius * scale, least),
    }))
    const painting = this.#ground.paint({ ...scene, robots, camera, ratio: this.#ratio, colors: this.colors }, PAINT_BUDGET)
    const pen = this.#pen
    const painted = this.#ground.draw(pen, camera, this.colors)
    pen.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0)
    pen.lineJoin = pen.lineCap = "round"
    if (scene.trail > 0) for (const robot of robots) paintTail(pen, { ...scene, camera, ratio: this.#ratio, colors: this.colors }, robot, painted.get(robot.name))
    const named = [...robots]
    this.#robots = robots.sort((one, other) => one.pose.z - other.pose.z)
    for (const robot of robots) this.#drawFields(robot)
    const text = Math.round(Math.min(Math.max(14, (camera.shorter * 0.032) / crowd), 44))
    for (const robot of robots) this.#drawIdeal(robot)
    for (const robot of robots) this.#drawRobot(robot)
    const rings = placeRings(scene.rings, camera)
    for (const ring of rings) drawRing(pen, ring, this.colors)
    const colors = new Map(robots.map(({ name, color }) => [name, color]))
    for (const path of scene.returnPaths) drawReturnPath(pen, path, camera, colors.get(path.name) ?? this.colors.ink, this.colors)
    this.#drawNames(named, rings, text)
    for (const mark of scene.meetings?.marks(camera) ?? []) this.#drawMeeting(mark, robots)
    this.#drawBumps(scene)
    if (robots.length) this.#drawScale()
    return turning || painting
  }

  /** The drawn places of robots. */
  get poses() { return Object.fromEntries(this.#robots.map(({ name, pose }) => [name, pose])) }

  /**
   * The robot that is drawn at a point of the canvas.
   * @param {Point} point
   */
  robotAt({ x, y }) {
    const at = this.#robots.findLast(({ place, size }) => Math.hypot(x - place.x, y - place.y) < size)
    return at?.name ?? null
  }

  /**
   * Draws where a robot looks, lit if something is there.
   * @param {Drawn} robot
   */
  #drawFields({ fields, pose, place, color }) {
    const pen = this.#pen
    const { scale } = this.camera.sight
    for (const { field, on } of fields) {
      const reach = field.reach * scale
      pen.save()
      pen.translate(place.x, place.y)
      pen.rotate(-pose.heading)
      pen.beginPath()
      if ("radius" in field) {
        const wide = field.radius * scale
        pen.roundRect(-wide, -wide, reach + 2 * wide, 2 * wide, wide)
      } else {
        pen.moveTo(0, 0)
        pen.arc(0, 0, reach, -field.end, -field.start)
        pen.closePath()
      }
      pen.fillStyle = pen.strokeStyle = color
      pen.globalAlpha = on ? 0.45 : 0.1
      pen.fill()
      pen.globalAlpha = on ? 1 : 0.4
      pen.lineWidth = on ? 3 : 1.5
      pen.stroke()
      pen.restore()
    }
  }

  /**
   * Draws where a measured robot ideally is.
   * @param {Drawn} robot
   */
  #drawIdeal({ ideal, size, pose }) {
    if (!ideal || Math.hypot(ideal.x - pose.x, ideal.y - pose.y) * this.camera.sight.scale < 1) return
    const pen = this.#pen
    const { x, y } = this.camera.toScreen(ideal)
    pen.beginPath()
    pen.arc(x, y, size, 0, 2 * Math.PI)
    pen.moveTo(x + size * Math.cos(ideal.heading), y - size * Math.sin(ideal.heading))
    pen.lineTo(x + size * 1.38 * Math.cos(ideal.heading), y - size * 1.38 * Math.sin(ideal.heading))
    pen.strokeStyle = this.colors.ink
    pen.lineWidth = 1.5
    pen.stroke()
  }

  /** @param {Drawn} robot */
  #drawRobot({ kind, figure, pose, place, size, color, silent, lost }) {
    const pen = this.#pen
    const shade = mix(color, this.colors.shadow, 0.28)
    const made = picture(kind, color, shade, Math.round(size), this.#ratio)
    const height = Math.min(Math.max(pose.z, -2), 4)
    const lift = Math.max(height, 0) * size * 0.8
    const scale = 1 + height * 0.12
    const reach = size * 1.35 * Math.max(scale, 1)
    pen.globalAlpha = silent || lost ? 0.2 : 0.6 / (1 + Math.max(height, 0) * 0.15)
    this.#shadow ??= shadow(this.colors.below) // in the dark theme a light, as no shadow would be visible
    pen.drawImage(this.#shadow, place.x - reach + lift * 0.7, place.y - reach + lift + size * 0.1, 2 * reach, 2 * reach)
    pen.globalAlpha = silent || lost ? 0.4 : 1
    pen.save()
    pen.translate(place.x, place.y)
    pen.rotate(-pose.heading)
    const half = size * REACH * scale
    pen.drawImage(made, -half, -half, 2 * half, 2 * half)
    if (figure) drawLimbs(pen, figure, size * scale, color, shade)
    pen.restore()
    pen.globalAlpha = 1
    if (lost) drawLost(pen, place, size, this.colors)
  }

  /**
   * Draws the names that have room: of the rings, if there are any, or of the robots.
   * @param {Drawn[]} robots
   * @param {Placed[]} rings
   * @param {number} text pixels
   */
  #drawNames(robots, rings, text) {
    const { size, insets } = this.camera
    const floor = { left: insets.left, top: insets.top, right: size.width, bottom: size.height - insets.bottom + text }
    const named = [
      ...rings.map(({ name, place, size }) => ({ name, place, size, words: [name], off: "" })),
      ...(rings.length ? [] : robots).map((robot) => ({ ...robot, words: about(robot) })),
    ]
    const seen = named.filter(({ place: { x, y } }) => x > floor.left && x < floor.right && y > floor.top && y < floor.bottom)
    const shown = seen.length > MOST_NAMES ? seen.filter(({ name }) => name === this.pointed) : seen
    const labeled = shown.map((each) => ({ ...each, lines: this.#lines(each.words, text, each.off) })).map((each) => ({
      ...each,
      wide: Math.max(...each.lines.map(({ label, size }) => label.width / this.#ratio - size / 2)),
      high: text * LINE_HEIGHT * each.lines.length,
    }))
    const boxes = this.#names.place(labeled, this.pointed, floor)
    this.names = [...boxes.keys()]
    for (const { name, lines } of labeled.sort((one, other) => Number(one.name === this.pointed) - Number(other.name === this.pointed))) {
      const box = boxes.get(name)
      if (box) lines.forEach(({ label }, index) => this.#drawLabel(label, (box.left + box.right) / 2, box.top + text * LINE_HEIGHT * (index + 0.5)))
    }
  }

  /**
   * The pictures beside a robot: a line for each.
   * @param {string[]} words
   * @param {number} text pixels
   * @param {string} [off] how far off the robot is, less prominent
   */
  #lines(words, text, off) {
    const lines = words.map((words) => ({ words, size: text, color: this.colors.ink }))
    if (off) lines.splice(1, 0, { words: off, size: Math.round(text * 0.85), color: this.colors.quiet })
    return lines.map(({ words, size, color }) => ({ size, label: this.#label(words, size, color) }))
  }

  /**
   * Draws where robots meet, with their discs there.
   * @param {Mark} mark
   * @param {Drawn[]} drawn
   */
  #drawMeeting({ meeting: { robots, poses }, place, shows }, drawn) {
    const pen = this.#pen
    for (const [index, pose] of shows ? poses.entries() : []) {
      const robot = drawn.find(({ name }) => name === robots[index])
      if (!robot) continue
      const { x, y } = this.camera.toScreen(pose)
      pen.beginPath()
      pen.arc(x, y, robot.radius * this.camera.sight.scale, 0, 2 * Math.PI)
      pen.fillStyle = pen.strokeStyle = robot.color
      pen.globalAlpha = 0.25
      pen.fill()
      pen.globalAlpha = 1
      pen.lineWidth = 2
      pen.stroke()
    }
    drawMark(pen, place, this.colors)
  }

  /** @param {Scene} scene */
  #drawBumps({ bumps, still }) {
    const pen = this.#pen
    const unit = Math.max(1, this.camera.shorter / 600)
    pen.lineWidth = 4 * unit
    for (const { x, y, age } of bumps) {
      const place = this.camera.toScreen({ x, y })
      const reach = (still ? 26 : 16 + 20 * Math.sqrt(age)) * unit
      pen.globalAlpha = still ? 1 : 1 - age ** 2
      pen.strokeStyle = this.colors.bump
      pen.beginPath()
      for (let i = 0; i < 8; i++) {
        const [cos, sin] = [Math.cos((i * Math.PI) / 4), Math.sin((i * Math.PI) / 4)]
        pen.moveTo(place.x + cos * reach * 0.55, place.y + sin * reach * 0.55)
        pen.lineTo(place.x + cos * reach, place.y + sin * reach)
      }
      pen.stroke()
    }
    pen.globalAlpha = 1
  }

  #drawScale() {
    if (this.#strip.width < LEAST_STRIP) return
    const pen = this.#pen
    const { size, sight: view, insets } = this.camera
    const meters = roundLength(Math.min(64, this.#strip.width / 2.5) / view.scale)
    const length = meters * view.scale
    const text = Math.min(Math.max(14, size.height * 0.022), 26)
    const x = 20 + insets.left
    const y = size.height - 18 - (insets.bottom - this.#strip.foot)
    pen.beginPath()
    pen.moveTo(x, y - 7)
    pen.lineTo(x, y)
    pen.lineTo(x + length, y)
    pen.lineTo(x + length, y - 7)
    pen.strokeStyle = this.colors.quiet
    pen.lineWidth = 2.5
    pen.stroke()
    this.#drawLabel(this.#label(`${meters} m`, Math.round(text), this.colors.quiet), x + length / 2, y - text * 0.85)
  }

  /**
   * Draws a text around a point, as a picture: text with an edge is slow to draw.
   * @param {ImageBitmap} label
   * @param {number} x
   * @param {number} y
   */
  #drawLabel(label, x, y) {
    const [width, height] = [label.width / this.#ratio, label.height / this.#ratio]
    this.#pen.drawImage(label, Math.round(x - width / 2), Math.round(y - height / 2), width, height)
  }

  /**
   * @param {string} name
   * @param {number} size
   * @param {string} color
   */
  #label(name, size, color) {
    const key = `${name} ${size} ${color}`
    let label = this.#labels.get(key)
    if (!label) {
      if (this.#labels.size > 300) this.#labels.clear()
      const pen = this.#pen
      pen.font = `600 ${size}px ${FONT}`
      const width = Math.ceil(pen.measureText(name).width + size)
      const canvas = new OffscreenCanvas(width * this.#ratio, size * 1.8 * this.#ratio)
      const own = penOn(canvas)
      own.scale(this.#ratio, this.#ratio)
      this.#write(name, width / 2, size * 0.9, size, color, own)
      label = canvas.transferToImageBitmap()
      this.#labels.set(key, label)
    }
    return label
  }

  /**
   * @param {string} text
   * @param {number} x
   * @param {number} y
   * @param {number} size
   * @param {string} color
   * @param {Pen} pen
   */
  #write(text, x, y, size, color, pen) {
    pen.font = `600 ${size}px ${FONT}`
    pen.textAlign = "center"
    pen.textBaseline = "middle"
    pen.lineJoin = "round"
    pen.lineWidth = size * 0.3
    pen.strokeStyle = this.colors.ground // an edge that keeps it legible over trails
    pen.strokeText(text, x, y)
    pen.fillStyle = color
    pen.fillText(text, x, y)
  }
}

/**
 * A robot's name, and how high it is.
 * @param {Drawn} robot
 */
function about({ name, pose, silent }) {
  const high = Math.abs(pose.z) < 0.05 ? [] : [`${pose.z > 0 ? "↑" : "↓"} ${Math.abs(pose.z).toFixed(1)} m`]
  return [silent ? `${name} · muted` : name, ...high]
}

/**
 * A soft round shadow, as a picture.
 * @param {string} color
 */
function shadow(color) {
  const canvas = new OffscreenCanvas(96, 96)
  const pen = penOn(canvas)
  const fade = pen.createRadialGradient(48, 48, 24, 48, 48, 48)
  fade.addColorStop(0, `${color}c0`)
  fade.addColorStop(1, `${color}00`)
  pen.fillStyle = fade
  pen.fillRect(0, 0, 96, 96)
  return canvas.transferToImageBitmap()
}

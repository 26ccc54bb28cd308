// @ts-check
// Draws the stage in each frame: the ground as it was last painted, and on it everything that moves.

import { bounds, Camera, roundLength } from "./camera.js"
import { redraw } from "../base/frames.js"
import { RADIUS } from "../score/robot-list.js"
import { colors, mix } from "../base/colors.js"
import { Ground, paintTail } from "./ground.js"
import { LabelPlaces } from "./labels.js"
import { drawLimbs } from "./figure-above.js"
import { drawMark } from "./meetings.js"
import { drawReturnPath } from "./out-of-place.js"
import { penOn, picture } from "../base/pen.js"
import { drawFacing, drawLost, drawRing, placeRings } from "./rings.js"
import { REACH, robotPicture } from "./robots.js"
import { drawText, textPicture } from "./texts.js"

/** @import { Point } from "./camera.js" */
/** @import { Pose } from "../base/path.js" */
/** @import { Mark } from "./meetings.js" */
/** @import { Placed } from "./rings.js" */
/** @import { Scene } from "./view.js" */
/** @typedef {Scene["robots"][number] & { pose: Pose, place: Point, size: number }} Drawn a robot, with its place in pixels */
/** @typedef {Omit<Scene, "robots"> & { robots: Drawn[], camera: Camera, ratio: number }} GroundScene */

const MIN_PIXELS = 12 // pixels: a robot's radius,
const MIN_SHARE = 0.034 // of the stage's shorter side,
const CROWD_SIZE = 8 // as long as there are no more robots; more of them are smaller
const MIN_STRIP = 48 // pixels for the scale
const MAX_NAMES = 200 // in view: more robots are named only if somebody points at them
const LINE_HEIGHT = 1.15 // of a name's size, to the next line

export class Floor {
  #canvas
  #pen
  #ground = new Ground()
  #ratio = 1
  #strip = { foot: 0, width: 0 } // at the bottom, for the scale, in pixels
  #names = new LabelPlaces()
  /** @type {Drawn[]} */
  #robots = [] // of the latest frame
  /** @type {string | null} */
  pointed = null // the robot whose name is shown in any case
  camera = new Camera()

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.#canvas = canvas
    this.#pen = penOn(canvas, { alpha: false })
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
    const least = Math.max(MIN_PIXELS / Math.sqrt(crowd), (MIN_SHARE * camera.shorter) / crowd)
    const robots = seen.map((robot) => ({
      ...robot,
      place: camera.toScreen(robot.pose),
      size: Math.max(robot.radius * scale, least),
    }))
    const painting = this.#ground.paint({ ...scene, robots, camera, ratio: this.#ratio })
    const pen = this.#pen
    const painted = this.#ground.draw(pen, camera)
    pen.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0)
    pen.lineJoin = pen.lineCap = "round"
    if (scene.trail > 0) for (const robot of robots) paintTail(pen, { ...scene, camera, ratio: this.#ratio }, robot, painted.get(robot.name))
    const named = [...robots]
    this.#robots = robots.sort((one, other) => one.pose.z - other.pose.z)
    for (const robot of robots) this.#drawFields(robot)
    const text = Math.round(Math.min(Math.max(14, (camera.shorter * 0.032) / crowd), 44))
    for (const robot of robots) this.#drawIdeal(robot)
    for (const robot of robots) this.#drawRobot(robot)
    const rings = placeRings(scene.rings, camera)
    for (const ring of rings) drawRing(pen, ring)
    scene.gesturing.draw(pen)
    for (const path of scene.returnPaths) {
      drawReturnPath(pen, path, camera, robots.find(({ name }) => name === path.name)?.color ?? colors().ink)
    }
    this.#drawNames(named, rings, text)
    scene.handle.draw(pen, camera)
    for (const mark of scene.meetings?.marks(camera) ?? []) this.#drawMeeting(mark, robots)
    this.#drawBumps(scene)
    this.#drawScale()
    return turning || painting
  }

  /** Shows the name of the robot that somebody points at in any case. @param {string | null} name */
  point(name) {
    if (name !== this.pointed) redraw()
    this.pointed = name
  }

  /** The drawn places of robots. */
  get poses() { return Object.fromEntries(this.#robots.map(({ name, pose }) => [name, pose])) }

  /** The robot that is drawn at a point of the canvas. @param {Point} point */
  robotAt({ x, y }) {
    const at = this.#robots.findLast(({ place, size }) => Math.hypot(x - place.x, y - place.y) < size)
    return at?.name ?? null
  }

  /** Draws where a robot looks, lit if something is there. @param {Drawn} robot */
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

  /** Draws where a measured robot ideally is. @param {Drawn} robot */
  #drawIdeal({ ideal, size, pose }) {
    if (!ideal || Math.hypot(ideal.x - pose.x, ideal.y - pose.y) * this.camera.sight.scale < 1) return
    this.#pen.strokeStyle = colors().ink
    this.#pen.lineWidth = 1.5
    drawFacing(this.#pen, this.camera.toScreen(ideal), ideal.heading, size, size, size * 1.38)
  }

  /** @param {Drawn} robot */
  #drawRobot({ kind, figure, pose, place, size, color, faint, lost }) {
    const pen = this.#pen
    const shade = mix(color, colors().shadow, 0.28)
    const made = robotPicture(kind, color, shade, Math.round(size), this.#ratio)
    const height = Math.min(Math.max(pose.z, -2), 4)
    const lift = Math.max(height, 0) * size * 0.8
    const scale = 1 + height * 0.12
    const reach = size * 1.35 * Math.max(scale, 1)
    pen.globalAlpha = faint ? 0.2 : 0.6 / (1 + Math.max(height, 0) * 0.15)
    const { below } = colors() // in the dark theme a light, as no shadow would be visible
    pen.drawImage(picture(`shadow ${below}`, () => shadow(below)), place.x - reach + lift * 0.7, place.y - reach + lift + size * 0.1, 2 * reach, 2 * reach)
    pen.globalAlpha = faint ? 0.4 : 1
    pen.save()
    pen.translate(place.x, place.y)
    pen.rotate(-pose.heading)
    const half = size * REACH * scale
    pen.drawImage(made, -half, -half, 2 * half, 2 * half)
    if (figure) drawLimbs(pen, figure, size * scale, color, shade)
    pen.restore()
    pen.globalAlpha = 1
    if (lost) drawLost(pen, place, size)
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
    const shown = seen.length > MAX_NAMES ? seen.filter(({ name }) => name === this.pointed) : seen
    const labeled = shown.map((each) => ({ ...each, lines: this.#lines(each.words, text, each.off) })).map((each) => ({
      ...each,
      wide: Math.max(...each.lines.map(({ picture, size }) => picture.width - size / 2)),
      high: text * LINE_HEIGHT * each.lines.length,
    }))
    const boxes = this.#names.place(labeled, this.pointed, floor)
    for (const { name, lines } of labeled.sort((one, other) => Number(one.name === this.pointed) - Number(other.name === this.pointed))) {
      const box = boxes.get(name)
      if (box) lines.forEach(({ picture }, index) => drawText(this.#pen, picture, (box.left + box.right) / 2, box.top + text * LINE_HEIGHT * (index + 0.5)))
    }
  }

  /**
   * The pictures beside a robot: a line for each.
   * @param {string[]} words
   * @param {number} text pixels
   * @param {string} [off] how far off the robot is, less prominent
   */
  #lines(words, text, off) {
    const lines = words.map((words) => ({ words, size: text, color: colors().ink }))
    if (off) lines.splice(1, 0, { words: off, size: Math.round(text * 0.85), color: colors().quiet })
    return lines.map(({ words, size, color }) => ({ size, picture: textPicture(words, size, color, this.#ratio) }))
  }

  /** Draws where robots meet, with their discs there. @param {Mark} mark @param {Drawn[]} drawn */
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
    drawMark(pen, place)
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
      pen.strokeStyle = colors().bump
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
    if (this.#strip.width < MIN_STRIP) return
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
    pen.strokeStyle = colors().quiet
    pen.lineWidth = 2.5
    pen.stroke()
    drawText(pen, textPicture(`${meters} m`, Math.round(text), colors().quiet, this.#ratio), x + length / 2, y - text * 0.85)
  }
}

/** A robot's name, and how high it is. @param {Drawn} robot */
function about({ label, pose, silent }) {
  const high = Math.abs(pose.z) < 0.05 ? [] : [`${pose.z > 0 ? "↑" : "↓"} ${Math.abs(pose.z).toFixed(1)} m`]
  return [silent ? `${label} · muted` : label, ...high]
}

/** A soft round shadow, as a picture. @param {string} color */
function shadow(color) {
  const canvas = new OffscreenCanvas(96, 96)
  const pen = penOn(canvas)
  const fade = pen.createRadialGradient(48, 48, 24, 48, 48, 48)
  fade.addColorStop(0, `${color}c0`)
  fade.addColorStop(1, `${color}00`)
  pen.fillStyle = fade
  pen.fillRect(0, 0, 96, 96)
  return canvas
}

// @ts-check
// Movements by hand: a path that somebody draws on the floor, or a robot that somebody moves with the arrow keys or a
// finger. Their words are written into the program. Only the picture of a robot moves: nothing is sent to robots.

import { find, findA, span } from "../base/elements.js"
import { redraw } from "../base/frames.js"
import { isOpen } from "../base/keys.js"
import { announce } from "../base/notices.js"
import { poseAfter } from "../base/path.js"
import { strokeWithEdge } from "../base/pen.js"
import { settings } from "../base/storage.js"
import { startPoses } from "../floor/start-poses.js"
import { changes } from "../score/changes.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"
import { robotList } from "../score/robot-list.js"

/** @import { Point } from "../floor/camera.js" */
/** @import { Hold } from "../floor/gestures.js" */
/** @import { Editor } from "../editor/editor.js" */
/** @import { Floor } from "../floor/floor.js" */
/** @import { Pose } from "../base/path.js" */
/** @import { Pen } from "../base/pen.js" */
/** @import { Transport } from "../score/clock.js" */
/** @typedef {"draw" | "perform"} Mode */

const PEN_STEP = 0.1 // meters that an arrow key moves the pen
const MIN_STEP = 0.01 // meters between two points that are kept
const LONGEST_FRAME = 0.1 // seconds by which the robot moves at once
const REACH = 0.02 // meters from a finger at which a robot stands
const GRAB_RADIUS = 40 // pixels around a robot
const FINE = 80 // pixels per meter, at least, to draw: 60 cm are as wide as a fingertip
const MAX_POINTS = 4_900 // points or keys of a gesture
const WIDTH = 3 // pixels
/** The direction ahead, and the turn, that each arrow key means. @type {Record<string, [ahead: number, turn: number]>} */
const ARROWS = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] }
const LINES = {
  draw: ["Draw anywhere: the words replace the robot's line.", "", "By keyboard: arrow keys, Enter, Esc to end."],
  "draw on": ["The path continues at the dot: its words go to the cursor.", "", "By keyboard: arrow keys, Enter, Esc to end."],
  perform: ["Drag a robot; real ones stay.", "Press Perform again: the words replace the robot's line.", "By keyboard: arrow keys, Enter, Esc to discard."],
}

export class Gesturing {
  #bar = find("gesture")
  #robot = findA("gesture-robot", HTMLSelectElement)
  #parts = findA("gesture-parts", HTMLSelectElement)
  #editor
  #floor
  #click
  #moveView
  /** @type {Mode | null} */
  #mode = null
  #begun = 0 // the time of its beat 0, in milliseconds
  #tempo = 60 // in beats per minute, from the first movement on: a dance that stops then changes no beat of it
  #seen = 0 // the time of the latest frame, in seconds
  /** @type {Pose | null} */
  #pose = null // of the robot that performs, or of the pen
  /** @type {[beat: number, x: number, y: number][]} */
  #points = []
  /** @type {[beat: number, ahead: number, turn: number][]} */
  #keys = []
  /** @type {Set<string>} */
  #held = new Set() // arrow keys
  /** @type {Point | null} */
  #finger = null // where it is, in meters
  #drags = false // whether a finger has moved the robot
  #isChosen = false // whether somebody has chosen the robot
  #from = 0 // the beat of the dance from which on the robot performs
  /** @type {Record<string, number[]>} */
  #pens = {} // the places of robots as they come to the cursor

  /**
   * @param {Editor} editor
   * @param {Floor} floor
   * @param {(transport: Transport | null) => void} click clicks on each beat while somebody performs
   * @param {() => void} moveView called when the view has changed
   */
  constructor(editor, floor, click, moveView) {
    this.#editor = editor
    this.#floor = floor
    this.#click = click
    this.#moveView = moveView
    for (const mode of /** @type {Mode[]} */ (["draw", "perform"])) {
      find(mode).addEventListener("click", () => (this.#mode === mode ? this.finish() : this.#begin(mode)))
    }
    this.#parts.value = String(settings.get("gesture parts", 0))
    this.#parts.addEventListener("change", () => settings.set("gesture parts", Number(this.#parts.value)))
    this.#robot.addEventListener("change", () => this.#mode && this.#begin(this.#mode, false))
    addEventListener("keydown", (event) => this.#press(event), true)
    addEventListener("keyup", (event) => this.#hold(event.key, false), true)
    addEventListener("blur", () => Object.keys(ARROWS).forEach((key) => this.#hold(key, false)))
    addEventListener("click", ({ detail }) => {
      const pressed = document.activeElement instanceof HTMLButtonElement
      if (this.#mode && detail && pressed) find("stage").focus() // or Enter would press that button again
    })
  }

  /** True while a robot is moved by hand. */
  get performs() {
    return this.#mode === "perform"
  }

  /** The pose to which somebody has moved a robot, if it performs. @param {string} name */
  poseOf(name) {
    return this.performs && name === this.#robot.value ? this.#pose : null
  }

  /** Shows the buttons, if words can be written. */
  showButtons() {
    for (const mode of ["draw", "perform"]) find(mode).hidden = !changes.write || (mode === "perform" && !robotList.playing.length)
  }

  /** Moves the robot that performs. Returns whether frames are needed. @param {number} now in seconds */
  advance(now) {
    const beats = (Math.min(now - this.#seen, LONGEST_FRAME) * this.#tempo) / 60
    this.#seen = now
    if (!this.performs || !this.#pose) return false
    const [far, turn] = program.current?.score.robots[this.#robot.value]?.speeds ?? [0, 0]
    const [ahead, around] = this.#directions
    const way = this.#finger ? this.#toFinger(this.#finger, far * beats, turn * beats) : [ahead * far * beats, around * turn * beats]
    this.#pose = poseAfter(this.#pose, { x: way[0], y: 0, z: 0, yaw: way[1] }, 1)
    if (way.some(Boolean)) this.#note(this.#pose)
    redraw()
    return true
  }

  /**
   * Grabs a robot that performs from then on, or puts the pen down. Returns a hold of it, or null.
   * @param {Point} point
   * @returns {Hold | null}
   */
  grab(point) {
    if (!this.#mode) return null
    const { camera, poses } = this.#floor
    const far = (/** @type {Point} */ place) => {
      const { x, y } = camera.toScreen(place)
      return Math.hypot(point.x - x, point.y - y)
    }
    if (this.#mode === "draw") {
      const isNear = this.#pose && far(this.#pose) < GRAB_RADIUS
      this.#bar.classList.add("held") // and stays as large: else the floor would move under the hand
      const at = camera.toWorld(point)
      this.#restart(this.#pen ?? { ...at, z: 0, heading: 0 })
      const [x, y] = this.#pen && isNear ? [this.#pen.x - at.x, this.#pen.y - at.y] : [0, 0]
      const move = (/** @type {Point} */ to) => {
        if (!isNear && this.#points.length === 1) this.#note(at) // a line leads there
        const here = camera.toWorld(to)
        this.#note({ x: here.x + x, y: here.y + y })
      }
      return { move, release: (zooms) => this.#release(zooms) }
    }
    const names = [...this.#robot.options].map(({ value }) => value).filter((name) => poses[name])
    const [name] = names.sort((one, other) => far(poses[one]) - far(poses[other]))
    if (!name || far(poses[name]) > GRAB_RADIUS) return null
    if (name !== this.#robot.value) {
      this.#write()
      this.#robot.value = name
      this.#begin("perform", false)
    }
    this.#bar.classList.add("held")
    this.#drags = true
    this.#startClock()
    return { move: (to) => (this.#finger = camera.toWorld(to)), release: (zooms) => this.#release(zooms) }
  }

  /** Ends, and has the words for what was drawn or performed written. */
  finish() {
    const mode = this.#mode
    this.#write()
    this.#end()
    if (mode) announce(mode === "draw" ? "Drawing is off" : "Performing is off")
  }

  /** @param {Pen} pen */
  draw(pen) {
    if (!this.#mode) return
    const { camera } = this.#floor
    const color = robotList.colorOf(this.#robot.value)
    pen.beginPath()
    for (const [, x, y] of this.#points) {
      const place = camera.toScreen({ x, y })
      pen.lineTo(place.x, place.y)
    }
    strokeWithEdge(pen, color, WIDTH)
    if (this.#mode === "perform" || !this.#pose) return
    const { x, y } = camera.toScreen(this.#pose)
    pen.beginPath()
    pen.arc(x, y, WIDTH, 0, 2 * Math.PI)
    strokeWithEdge(pen, color, 2 * WIDTH) // a full disc
  }

  /** Takes the places of robots as they come to the cursor. @param {Record<string, number[]>} pens */
  takePens(pens) {
    if (this.#mode !== "draw" || this.#points.length > 1) return
    this.#pens = pens
    const [first] = Object.keys(pens)
    if (first && !this.#isChosen && !(this.#robot.value in pens)) this.#robot.value = first
    this.#put()
  }

  /** @param {Mode} mode @param {boolean} [isNew] false if somebody has chosen the robot */
  #begin(mode, isNew = true) {
    const written = mode === "draw" ? startPoses.written : {} // only a robot of the score has a picture that performs
    const names = Object.keys(written).length ? Object.keys(written) : robotList.playing.map(({ name }) => name)
    const before = this.#robot.value
    this.#robot.replaceChildren(...(names.length ? names : ["turtle1"]).map((name) => new Option(name)))
    if (names.includes(before)) this.#robot.value = before
    find("gesture-whose").hidden = names.length < 2
    this.#end()
    this.#mode = mode
    this.#isChosen = !isNew
    const [whole] = this.#parts.options
    whole.hidden = whole.disabled = mode === "perform"
    if (mode === "perform" && this.#parts.value === "0") this.#parts.value = "2"
    const parts = Number(this.#parts.value)
    this.#from = mode === "perform" && !clock.atStart ? Math.round(clock.beat() * parts) / parts : 0
    this.#floor.camera.stays = mode === "draw"
    this.#put()
    this.#show()
    find("stage").focus()
  }

  /** Puts the robot or the pen where it begins. */
  #put() {
    const name = this.#robot.value
    const [x, y, z, heading] = program.current?.score.robots[name]?.start_pose ?? [0, 0, 0, 0]
    const start = Object.assign({ x, y, z, heading }, this.performs ? {} : startPoses.written[name])
    const left = this.#from ? program.current?.poseAt(name, this.#from) : null
    const pose = this.#pen ?? left ?? start
    this.#restart(pose)
    this.#floor.camera.look(pose, FINE)
    this.#moveView()
    const [before, line, keys] = LINES[this.#pen ? "draw on" : (this.#mode ?? "draw")]
    find("gesture-line").replaceChildren(span("before", `${before} `), line, span("by-key", ` ${keys}`))
  }

  /** The place where the robot comes to the cursor, if it does. @returns {Pose | null} */
  get #pen() {
    const [x, y] = this.#pens[this.#robot.value] ?? []
    return x === undefined ? null : { x, y, z: 0, heading: 0 }
  }

  #end() {
    this.#mode = null
    this.#bar.className = ""
    this.#floor.camera.stays = false
    this.#moveView()
    this.#click(null)
    this.#restart(null)
    this.#held.clear()
    this.#finger = null
    this.#pens = {}
    this.#show()
  }

  #show() {
    this.#editor.handle.gesture = this.#mode
    for (const mode of ["draw", "perform"]) find(mode).setAttribute("aria-pressed", String(this.#mode === mode))
    this.#bar.hidden = !this.#mode
    redraw()
  }

  /** Begins a new gesture at a pose, or ends it. @param {Pose | null} pose */
  #restart(pose) {
    this.#pose = pose
    this.#begun = 0
    this.#keys = []
    this.#points = []
    this.#drags = false
    if (pose && this.#mode === "draw") this.#note(pose)
  }

  /** Beats count from the first movement or, if the dance plays, from where the robot left it. */
  #startClock() {
    if (this.#begun) return
    const along = this.performs && clock.playing
    this.#tempo = along ? clock.transport.tempo : (program.current?.score.tempo ?? 60)
    const gone = along ? Math.max(clock.beat() - this.#from, 0) : 0
    this.#begun = performance.now() - (gone / this.#tempo) * 60_000
    if (!this.performs) return
    if (this.#pose) this.#points = [[this.#beat(), this.#pose.x, this.#pose.y]]
    if (!along) this.#click({ ...clock.transport, state: "playing", beat: 0, beats: null, tempo: this.#tempo, wall: clock.now(), behind: 0 })
  }

  /** @returns {number} */
  #beat() {
    return this.#begun ? ((performance.now() - this.#begun) / 60_000) * this.#tempo : 0
  }

  /** Keeps a place, unless it is close to the latest one. @param {Point} place */
  #note({ x, y }) {
    const [, lastX, lastY] = this.#points.at(-1) ?? [0, Infinity, Infinity]
    if (this.#points.length >= MAX_POINTS || Math.hypot(x - lastX, y - lastY) < MIN_STEP) return
    if (this.#mode === "draw") this.#startClock()
    this.#points.push([this.#beat(), x, y])
    if (this.#mode === "draw" && this.#pose) this.#pose = { ...this.#pose, x, y }
    redraw()
  }

  /** A hand lets go; one that zooms has drawn nothing. @param {boolean} zooms */
  #release(zooms) {
    if (this.#mode === "draw") zooms ? this.#put() : this.#write()
    if (this.#bar.className) this.#bar.className = "used"
    this.#finger = null
  }

  #write() {
    const draws = this.#mode === "draw"
    const about = { robot: this.#robot.value, parts: Number(this.#parts.value), begin: this.#from || undefined } // JSON has no undefined ones
    if ((draws || this.#drags) && this.#points.length > 1) {
      changes.write?.({ type: "draw", points: this.#points, offset: draws ? this.#editor.writtenAt : undefined, ...about })
      if (!draws || !this.#pose) return
      if (this.#pen) this.#pens[about.robot] = [this.#pose.x, this.#pose.y]
      this.#restart(this.#pose)
    } else if (this.#keys.length) changes.write?.({ type: "perform", keys: this.#keys, end: this.#beat(), ...about })
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    if (!this.#mode || event.ctrlKey || event.altKey || event.metaKey || event.isComposing) return
    if (event.target instanceof Element && event.target.closest("input, select, textarea")) return
    if (event.key === "Escape" && isOpen()) return
    if (event.key === "Escape") this.#end()
    else if (event.code === "Space") return this.finish() // and robots stop
    else if (event.key === "Enter" && !(event.target instanceof HTMLButtonElement)) {
      if (this.performs) this.finish()
      else this.#write()
    } else if (ARROWS[event.key]) {
      if (this.performs) this.#hold(event.key, true)
      else this.#movePen(ARROWS[event.key])
    } else return
    event.preventDefault()
    event.stopPropagation()
  }

  /** @param {[ahead: number, turn: number]} arrow */
  #movePen([ahead, turn]) {
    if (!this.#pose) return
    const to = { x: this.#pose.x - turn * PEN_STEP, y: this.#pose.y + ahead * PEN_STEP }
    this.#note(to)
    announce(`${to.x.toFixed(1)}, ${to.y.toFixed(1)}`)
  }

  /** @param {string} key @param {boolean} held */
  #hold(key, held) {
    if (!this.performs || !ARROWS[key] || this.#held.has(key) === held) return
    if (held) this.#held.add(key)
    else this.#held.delete(key)
    this.#startClock()
    if (this.#keys.length < MAX_POINTS) this.#keys.push([this.#beat(), ...this.#directions])
    redraw()
  }

  /** The directions that the held keys mean together. @returns {[ahead: number, turn: number]} */
  get #directions() {
    const sums = [0, 1].map((axis) => [...this.#held].reduce((sum, key) => sum + ARROWS[key][axis], 0))
    return [sums[0], sums[1]]
  }

  /**
   * The way to a finger, at most so far, with at most that turn.
   * @param {Point} finger
   * @param {number} far
   * @param {number} turn
   * @returns {[far: number, turn: number]}
   */
  #toFinger(finger, far, turn) {
    const pose = /** @type {Pose} */ (this.#pose)
    const distance = Math.hypot(finger.x - pose.x, finger.y - pose.y)
    if (distance < REACH) return [0, 0]
    const off = Math.atan2(finger.y - pose.y, finger.x - pose.x) - pose.heading
    const around = Math.atan2(Math.sin(off), Math.cos(off))
    return [Math.min(distance, far) * Math.max(Math.cos(around), 0), Math.min(Math.max(around, -turn), turn)]
  }
}

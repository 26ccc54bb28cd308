// @ts-check
// The paths of the text on this page, or in an editor, as it stands, before somebody saves it: thin and dashed.

import { colors, mix } from "../base/colors.js"
import { find } from "../base/elements.js"
import { due, redraw, redrawPaths } from "../base/frames.js"
import { whenReleased } from "../base/pressing.js"
import { pointsAlong, trace, velocityBetween } from "../base/path.js"
import { setting } from "../base/setting.js"
import { program } from "../score/program.js"
import { robotList } from "../score/robot-list.js"
import { figureOf } from "../bodies/body.js"
import { bounds } from "./camera.js"
import { kindOf } from "./robots.js"

/** @import { Point } from "./camera.js" */
/** @import { Pose } from "../base/path.js" */
/** @import { Pen } from "../base/pen.js" */
/** @typedef {NonNullable<Messages["preview"]["robots"][string]>} Sent */
/** @typedef {{ start: Pose, strokes: [from: Pose, to: Pose][], certain: number, sent: Sent }} PreviewedPath */

const CALM = 400 // milliseconds without a key after which an error counts: half a word is one
const WIDTH = 2 // pixels
const DASHES = [8, 4] // pixels
const DOUBTFUL = [4, 4] // pixels, where senses may decide otherwise
const RING = 5 // pixels: the radius of the ring at a start
const STRENGTH = 0.85 // of a robot's color

export class Preview {
  #isOn
  #calm = 0 // the timer that shows an error
  #text = "" // whose paths are known
  #now = "" // the text as it stands
  /** @type {Map<string, Sent>} */
  #sent = new Map() // the latest paths that came
  /** @type {number | undefined} */
  known // the number of their text
  /** @type {Map<string, PreviewedPath>} */
  #paths = new Map()
  /** @type {Point[]} */
  #room = [] // corners around all of them
  #problem = ""
  version = 0 // changes with the paths
  #painted = 0 // the latest version that was painted
  #texts = 0 // whose paths were taken
  #seen = 0 // of these, until all were painted

  /** @param {() => void} ask has the server asked for the paths */
  constructor(ask) {
    this.#isOn = setting("preview", (on) => {
      if (on) ask()
      redraw()
    })
  }

  get isOn() {
    return this.#isOn()
  }

  /** The number of texts whose paths have been on the stage. */
  get painted() {
    if (this.#painted === this.version) this.#seen = this.#texts
    return this.#seen
  }

  /** True if the paths are drawn: those of a text that plays, or was played last, are on the stage already. */
  get isShown() {
    return this.isOn && this.#text !== program.text
  }

  /** The lines of a text's paths, for each robot, if they are known. @param {string} text @returns {Point[][][]} */
  linesOf(text) {
    if (!this.isOn || this.#text !== text || this.#problem) return []
    return [...this.#paths.values()].map(({ start, strokes }) => {
      /** @type {Point[][]} */
      const lines = [[start]]
      for (const [from, to] of strokes) {
        const last = lines.at(-1)?.at(-1)
        if (last?.x !== from.x || last.y !== from.y) lines.push([from])
        lines.at(-1)?.push(...pointsAlong(from, velocityBetween(from, to), 1))
      }
      return lines
    })
  }

  /** The robots that are not on the stage yet, at their starts, as the floor draws robots. */
  get waiting() {
    const there = robotList.names
    return [...(this.isShown ? this.#paths : [])].flatMap(([name, { start, sent }]) => {
      if (there.includes(name)) return []
      const { profile, radius, motions, body } = sent.look
      const look = { kind: kindOf(profile, motions, body), figure: body.length ? figureOf(body) : null, color: robotList.colorOf(name), radius, body }
      const unknown = { seen: Infinity, moved: undefined, ideal: undefined, off: "", fields: [], silent: false, lost: false, path: null }
      return [{ name, label: name, pose: start, faint: program.current !== null, ...look, ...unknown }]
    })
  }

  /** The corners around the paths that are drawn. */
  get room() {
    return this.isShown ? this.#room : []
  }

  /**
   * Takes the paths of a text. While somebody types, those of the latest text without an error stay.
   * @param {Messages["draft"]["paths"]} message
   * @param {string | null} text null if there is another one by now
   */
  take({ number, robots, problem, waits_for }, text) {
    const sent = new Map(Object.entries(robots).flatMap(([name, path]) => {
      const known = path ?? this.#sent.get(name)
      return known ? [[name, known]] : []
    }))
    this.#sent = sent
    this.known = number
    if (text === null) return
    clearTimeout(this.#calm)
    if (problem) this.#calm = window.setTimeout(() => this.#show(sent, problem, waits_for, text), CALM)
    else this.#show(sent, problem, waits_for, text)
  }

  /** @param {Map<string, Sent>} sent @param {string} problem @param {string[]} waitsFor robots @param {string} text */
  #show(sent, problem, waitsFor, text) {
    const wasShown = this.isShown
    this.#text = text
    this.#problem = problem
    this.#texts++
    const before = waitsFor.flatMap((name) => /** @type {[string, PreviewedPath][]} */ (this.#paths.has(name) ? [[name, this.#paths.get(name)]] : []))
    const now = [...sent].map(([name, path]) => {
      const known = this.#paths.get(name)
      return /** @type {[string, PreviewedPath]} */ ([name, known && isSame(known.sent, path) ? known : made(path)])
    })
    const paths = new Map([...before, ...now])
    // A key in a comment or in a word that nobody plays draws nothing.
    if (wasShown === this.isShown && isSameMap(paths, this.#paths)) return this.showButton()
    this.#paths = paths
    robotList.previewed = [...paths.keys()]
    const points = [...this.#paths.values()].map(({ start, strokes, certain }) => [
      start,
      ...strokes.slice(0, certain).flatMap(([from, to]) => pointsAlong(from, velocityBetween(from, to), 1)),
    ])
    this.#room = points.length ? bounds(points) : []
    this.version++
    if (this.isShown) redrawPaths()
    else redraw()
  }

  /** The paths of a version are on the stage, with all that is painted over them. @param {number} version */
  appeared(version) {
    this.#painted = version
    due.paths = version !== this.version
  }

  /** The text is another one now. @param {string} text */
  edit(text) {
    this.#now = text
    this.showButton()
  }

  /** Shows the button, and on it what is missing, unless the text plays or was played last. */
  showButton() {
    whenReleased(() => {
      const words = ["Preview", ...(this.isShown && this.#problem ? [this.#problem] : [])].join(": ")
      const button = find("preview")
      const hidden = !this.#now || this.#now === program.text
      if (button.textContent !== words || button.hidden !== hidden) Object.assign(button, { textContent: words, hidden })
    })
  }

  /**
   * Paints the paths, one after another, with a pen that draws in meters.
   * @param {Pen} pen
   * @param {number} scale pixels per meter
   */
  *paint(pen, scale) {
    if (!this.isShown) return
    for (const [name, { start, strokes, certain }] of this.#paths) {
      pen.strokeStyle = mix(colors().ground, robotList.colorOf(name), STRENGTH)
      pen.lineWidth = WIDTH / scale
      pen.setLineDash([])
      pen.beginPath()
      pen.arc(start.x, start.y, RING / scale, 0, 2 * Math.PI)
      pen.stroke()
      draw(pen, strokes.slice(0, certain), DASHES, scale)
      draw(pen, strokes.slice(certain), DOUBTFUL, scale)
      pen.setLineDash([])
      yield
    }
  }
}

/**
 * @param {Pen} pen
 * @param {[from: Pose, to: Pose][]} strokes
 * @param {number[]} dashes pixels
 * @param {number} scale pixels per meter
 */
function draw(pen, strokes, dashes, scale) {
  pen.setLineDash(dashes.map((dash) => dash / scale))
  pen.lineCap = "butt" // round dashes take browsers longer
  pen.beginPath()
  /** @type {Pose | null} */
  let last = null
  for (const [from, to] of strokes) {
    if (last?.x !== from.x || last.y !== from.y) pen.moveTo(from.x, from.y)
    trace(pen, from, velocityBetween(from, to), 1)
    last = to
  }
  pen.stroke()
  pen.lineCap = "round"
}

/** @param {Sent} sent @returns {PreviewedPath} */
function made(sent) {
  const strokes = sent.strokes.map((stroke) => /** @type {[Pose, Pose]} */ ([pose(stroke), pose(stroke.slice(3))]))
  return { start: pose(sent.start), strokes, certain: sent.certain, sent }
}

/** @param {Sent} one @param {Sent} other */
function isSame(one, other) {
  const numbers = (/** @type {Sent} */ { start, strokes, certain }) => [certain, ...start, ...strokes.flat()].join()
  return one === other || one.strokes.length === other.strokes.length && numbers(one) === numbers(other)
}

/** @template T @param {Map<string, T>} one @param {Map<string, T>} other */
function isSameMap(one, other) {
  const there = [...other]
  return one.size === other.size && [...one].every(([name, each], i) => name === there[i][0] && each === there[i][1])
}

/** @param {number[]} numbers @returns {Pose} */
function pose([x, y, heading]) {
  return { x, y, z: 0, heading }
}

// @ts-check
// Starts of robots: dragged on the stage or typed, then written into the program or, if nobody can, offered as lines for
// improv.toml.

import { element, find, findA, robotElement } from "../base/elements.js"
import { redraw } from "../base/frames.js"
import { tomlLines } from "../editor/toml-lines.js"
import { changes } from "../score/changes.js"
import { robotList } from "../score/robot-list.js"
import { nearestRing, placeRings } from "./rings.js"

/** @import { Camera, Point } from "./camera.js" */
/** @import { Hold } from "./gestures.js" */
/** @import { Robot } from "../score/robot-list.js" */

/** @typedef {Messages["analyze"]["starts"][string]} StartPose in meters and degrees */

const LONG_NAME = 9 // letters: a longer name takes two smaller lines
const PRECISION = 0.001 // meters and degrees, as they are written
const MAX_DISTANCE = 1000 // meters along x and y
const WRITE_DELAY = 600 // milliseconds without a key after which a number that was typed is written
const KEYS = /** @type {const} */ (["x", "y", "heading"])
const FIELDS = { x: { most: MAX_DISTANCE, step: 0.1 }, y: { most: MAX_DISTANCE, step: 0.1 }, heading: { most: 360, step: 15 } }

export class StartPoses {
  #card = findA("start-poses", HTMLDialogElement)
  #showToml = tomlLines("start-poses-toml")
  #telling = 0 // the timer that has what was typed written
  /** @type {Set<string>} */
  #moved = new Set() // robots that were moved, which is not written yet
  #held = false
  /** @type {Map<string, StartPose>} */
  #poses = new Map()
  /** The robots of the text on this page, if it can be written. @type {Record<string, StartPose>} */
  written = {}
  /** @type {string | null} */
  #chosen = null

  constructor() {
    find("start-poses-list").addEventListener("change", () => this.tell())
    this.#card.addEventListener("close", () => {
      for (const name of this.#poses.keys()) this.#showFields(name)
      this.tell()
    })
  }

  /**
   * Shows the start poses of a score. Moved ones stay until they are written, or for good if nobody can.
   * @param {Messages["score"]} score
   */
  show(score) {
    const before = this.#poses
    const kept = (/** @type {string} */ name) => (this.#moved.has(name) ? before.get(name) : this.written[name])
    this.#poses = new Map(Object.entries(score.robots).map(([name, { start_pose }]) => [name, { ...(kept(name) ?? degrees(start_pose)) }]))
    find("start-poses-rows").replaceChildren(...robotList.playing.map((robot) => this.#fields(robot)))
    this.showLines()
  }

  /** Takes where robots start according to the text on this page. @param {Record<string, StartPose>} starts */
  place(starts) {
    this.written = starts
    for (const [name, pose] of Object.entries(starts)) {
      const shown = this.#poses.get(name)
      const now = rounded(pose)
      if (!shown || this.#moved.has(name) || KEYS.every((key) => now[key] === shown[key])) continue
      this.#poses.set(name, now)
      this.#showFields(name)
      redraw()
    }
  }

  /** The rings, which have to be in view. */
  get room() {
    return this.rings.map(({ x, y }) => ({ x, y }))
  }

  /** The rings to draw on the stage: none unless the card is open. */
  get rings() {
    if (!this.#card.open) return []
    return robotList.playing.map(({ name, color }) => {
      const { x, y, heading } = this.#pose(name)
      return { name, x, y, heading: (heading * Math.PI) / 180, color, chosen: name === this.#chosen }
    })
  }

  /** The robot whose ring or arrow is at a point of the canvas. @param {Point} point @param {Camera} camera */
  ringAt(point, camera) {
    return nearestRing(point, placeRings(this.rings, camera))?.name ?? null
  }

  /**
   * Grabs the ring or arrow near a point of the canvas. Returns a hold of it, or null.
   * @param {Point} point
   * @param {Camera} camera
   * @returns {Hold | null}
   */
  grab(point, camera) {
    const best = nearestRing(point, placeRings(this.rings, camera))
    if (!best) return null
    const { name, part } = best
    this.#chosen = name
    this.#held = true
    this.#rowOf(name)?.scrollIntoView({ block: "nearest" })
    const move = (/** @type {Point} */ to) => {
      const pose = this.#pose(name)
      const world = camera.toWorld(to)
      if (part === "place") Object.assign(pose, { x: neat(within(world.x, MAX_DISTANCE), 0.05), y: neat(within(world.y, MAX_DISTANCE), 0.05) })
      else pose.heading = neat((Math.atan2(world.y - pose.y, world.x - pose.x) * 180) / Math.PI, 5)
      this.#showFields(name)
      this.#move(name)
    }
    return { move, release: () => void ((this.#held = false), this.tell()) }
  }

  /** @param {string} name */
  #pose(name) {
    const pose = this.#poses.get(name)
    if (!pose) throw new Error(`no robot is called ${name}`)
    return pose
  }

  /** Somebody has moved a robot. @param {string} name */
  #move(name) {
    this.#moved.add(name)
    this.showLines()
    clearTimeout(this.#telling)
    if (!this.#held) this.#telling = window.setTimeout(() => this.tell(), WRITE_DELAY)
  }

  /** Has what was moved written now, all at once. */
  tell() {
    clearTimeout(this.#telling)
    if (!changes.write || !this.#moved.size || find("start-poses-list").querySelector(":invalid")) return
    const start_poses = Object.fromEntries([...this.#moved].map((name) => [name, this.#pose(name)]))
    this.#moved.clear()
    changes.write({ type: "place", start_poses })
  }

  /** Shows the lines to copy, if nobody can write them. */
  showLines() {
    find("start-poses-writes").hidden = changes.write === null
    const lines = [...this.#moved].map((name) => {
      const { x, y, heading } = this.#pose(name)
      return `[robots.${name}]\nstart = { x = ${x}, y = ${y}, heading = ${heading} }\n`
    })
    this.#showToml(changes.write || find("start-poses-list").querySelector(":invalid") ? "" : lines.join("\n"))
    redraw()
  }

  /** @param {Robot} robot */
  #fields(robot) {
    const { name } = robot
    const className = name.length > LONG_NAME ? "long" : ""
    const set = robotElement("fieldset", robot, element("legend", { className, textContent: name, title: name }))
    for (const key of KEYS) {
      const { most, step } = FIELDS[key]
      const input = element("input", { type: "number", required: true, min: String(-most), max: String(most), step: "any" })
      input.value = String(this.#pose(name)[key])
      input.dataset.key = key
      let before = 0 // while somebody types
      input.addEventListener("focus", () => {
        before = this.#pose(name)[key]
        this.#chosen = name
        redraw()
      })
      input.addEventListener("input", () => {
        this.#pose(name)[key] = input.validity.valid ? neat(Number(input.value), PRECISION) : before // also if it begins with a valid one
        this.#move(name)
      })
      input.addEventListener("change", () => input.reportValidity())
      input.addEventListener("keydown", (event) => {
        if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return
        event.preventDefault()
        const next = Number(input.value) + (event.key === "ArrowUp" ? step : -step)
        input.value = String(neat(within(next, most), step))
        input.dispatchEvent(new Event("input"))
      })
      const word = element("span", { className: "unseen", textContent: key }) // the head of the list says it for all
      set.append(element("label", {}, word, input))
    }
    return set
  }

  /** @param {string} name */
  #rowOf(name) {
    return find("start-poses-list").querySelector(`[data-robot="${CSS.escape(name)}"]`)
  }

  /** @param {string} name */
  #showFields(name) {
    const pose = this.#pose(name)
    const row = this.#rowOf(name)
    for (const key of KEYS) {
      const input = row?.querySelector(`[data-key=${key}]`)
      if (!(input instanceof HTMLInputElement) || (input.validity.valid && Number(input.value) === pose[key])) continue
      if (input === document.activeElement && !input.validity.valid) continue // somebody is typing there
      input.value = String(pose[key])
    }
  }
}

export const startPoses = new StartPoses()

/** @param {number[]} pose */
function degrees([x, y, , heading]) {
  return rounded({ x, y, heading: (heading * 180) / Math.PI })
}

/** @param {StartPose} pose */
function rounded({ x, y, heading }) {
  return { x: neat(x, PRECISION), y: neat(y, PRECISION), heading: neat(heading, PRECISION) }
}

/** @param {number} value @param {number} most */
function within(value, most) {
  return Math.min(Math.max(value, -most), most)
}

/** The nearest multiple of a step, rounded as people would write it. @param {number} value @param {number} step */
function neat(value, step) {
  return Number((Math.round(value / step) * step).toFixed(4)) || 0
}

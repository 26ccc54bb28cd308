// @ts-check
// The senses of robots: a chip for each sense, which can be forced in the simulator; the cue; and keys that are senses.

import { button, element, find, robotElement } from "../base/elements.js"
import { redraw } from "../base/frames.js"
import { keyOf } from "../base/keys.js"
import { send } from "../net/send.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"
import { robotList } from "../score/robot-list.js"

/** @import { Robot } from "../score/robot-list.js" */
/** @typedef {{ reach: number, start: number, end: number } | { reach: number, radius: number }} Field a sector, or what is straight ahead */

const CUE = "cue"
const SEND_PERIOD = 100 // milliseconds between two messages that a key is held
const CUE_TIME = 300 // milliseconds for which a cue that was given is shown

export class Senses {
  /** @type {Map<string, boolean | null>} */
  #values = new Map() // by robot and sense
  /** @type {Map<string, HTMLButtonElement>} */
  #chips = new Map()
  /** @type {Set<string>} */
  #forced = new Set()
  /** @type {Map<string, ReturnType<typeof setInterval>>} */
  #held = new Map() // keys

  constructor() {
    find("cue").addEventListener("click", () => {
      send({ type: "cue" })
      find("cue").dataset.given = "true"
      setTimeout(() => (find("cue").dataset.given = "false"), CUE_TIME)
    })
    // Before other keys: in a program that listens to a key, the key does nothing else.
    addEventListener("keydown", (event) => this.#press(event), { capture: true })
    addEventListener("keyup", (event) => this.#release(keyOf(event)))
    addEventListener("blur", () => this.#releaseAll())
    document.addEventListener("visibilitychange", () => document.hidden && this.#releaseAll())
  }

  /** Shows the senses that the score reads. */
  show() {
    this.#chips.clear()
    const read = robotList.playing.map((robot) => ({ robot, names: Object.keys(this.#robots[robot.name].senses) }))
    find("cue").hidden = !read.some(({ names }) => names.includes(CUE))
    const rows = read.flatMap(({ robot, names }) => {
      const chips = names.filter((name) => name !== CUE).map((name) => this.#chip(robot.name, name))
      return chips.length ? [row(robot, chips)] : []
    })
    find("senses").hidden = !rows.length
    find("senses").replaceChildren(...rows)
    for (const key of this.#held.keys()) if (!this.#keys().has(key)) this.#release(key)
  }

  get #robots() {
    return program.current?.score.robots ?? {}
  }

  /** @param {Messages["sensed"]} message */
  take({ generation, robot, sense, value, beat }) {
    this.#values.set(idOf(robot, sense), value)
    this.#showChip(idOf(robot, sense))
    if (generation === program.current?.score.generation) program.current.renew(beat)
  }

  /** Another performance begins: nothing is known yet. */
  restart() {
    this.#values.clear()
    for (const id of this.#chips.keys()) this.#showChip(id)
  }

  /**
   * The area where a robot looks, and whether something is there.
   * @param {string} robot
   * @returns {{ field: Field, on: boolean }[]}
   */
  fields(robot) {
    const { senses = {}, near = 0, radius = 0 } = this.#robots[robot] ?? {}
    return Object.entries(senses).flatMap(([name, source]) => {
      const field = fieldOf(source, near, radius)
      return field ? [{ field, on: this.#values.get(idOf(robot, name)) === true }] : []
    })
  }

  /** @param {string} robot @param {string} sense */
  #chip(robot, sense) {
    const chip = button({ className: "chip", textContent: sense }, ({ shiftKey }) => shiftKey && this.#force(robot, sense))
    this.#chips.set(idOf(robot, sense), chip)
    this.#showChip(idOf(robot, sense))
    return chip
  }

  /** @param {string} id */
  #showChip(id) {
    const chip = this.#chips.get(id)
    if (!chip) return
    const value = this.#values.get(id)
    const [word, shown] = value ? ["true", "on"] : value === false ? ["false", "off"] : ["not known", "silent"]
    const [robot, sense] = /** @type {string[]} */ (JSON.parse(id))
    const forced = this.#forced.has(id)
    chip.dataset.value = shown
    chip.dataset.forced = String(forced)
    chip.setAttribute("aria-pressed", String(value === true))
    chip.setAttribute("aria-label", `${robot} ${sense}: ${word}${forced ? ", forced" : ""}`)
    chip.title = `${sense} is ${word}. ${forced ? "Shift+click: sense what is there again" : "Shift+click: force it (only in the simulator)"}`
    redraw()
  }

  /** @param {string} robot @param {string} sense */
  #force(robot, sense) {
    if (!clock.transport.generation) return
    const id = idOf(robot, sense)
    const value = this.#forced.delete(id) ? null : !this.#values.get(id)
    if (value !== null) this.#forced.add(id)
    send({ type: "force", robot, sense, value })
    this.#showChip(id)
  }

  /** The keys that are senses. */
  #keys() {
    const sources = Object.values(this.#robots).flatMap(({ senses }) => Object.values(senses))
    return new Set(sources.flatMap(({ key }) => (typeof key === "string" ? [key] : [])))
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    const { target } = event
    const key = keyOf(event)
    if (event.ctrlKey || event.altKey || event.metaKey || (target instanceof Element && target.closest("input, select, textarea"))) return
    if (key === " " || key === "Escape" || !this.#keys().has(key)) return
    event.preventDefault()
    event.stopImmediatePropagation()
    if (this.#held.has(key)) return
    send({ type: "key", key, held: true })
    this.#held.set(key, setInterval(() => send({ type: "key", key, held: true }), SEND_PERIOD))
  }

  /** @param {string} key */
  #release(key) {
    if (!this.#held.has(key)) return
    clearInterval(this.#held.get(key))
    this.#held.delete(key)
    send({ type: "key", key, held: false })
  }

  #releaseAll() {
    for (const key of [...this.#held.keys()]) this.#release(key)
  }
}

/** @param {string} robot @param {string} sense */
function idOf(robot, sense) {
  return JSON.stringify([robot, sense])
}

/** @param {Robot} robot @param {HTMLElement[]} chips */
function row(robot, chips) {
  return robotElement("li", robot, element("span", { className: "name", textContent: robot.name, title: robot.name }), ...chips)
}

/**
 * The part of the ground that a sense looks at, if there is one. The built-in `near` looks where its robot is about to drive.
 * @param {Record<string, unknown>} source
 * @param {number} near meters
 * @param {number} radius meters
 * @returns {Field | null}
 */
function fieldOf({ built_in, below, start, end }, near, radius) {
  if (built_in === "near") return { reach: near, radius }
  if (typeof below !== "number" || typeof start !== "number" || typeof end !== "number") return null
  return { reach: below, start, end }
}

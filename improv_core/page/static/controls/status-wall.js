// @ts-check
// The wall of real robots: how each of them is, those in trouble first, and in one line whether all is well.

import { element, find, syncChildren, write } from "../base/elements.js"
import { refit } from "../base/frames.js"
import { announce } from "../base/notices.js"
import { measured } from "../floor/measured.js"
import { clock } from "../score/clock.js"

/** @type {Record<string, string>} */
const WORDS = { gone: "gone", silent: "silent", stuck: "stuck", joints: "joints don't follow", off_path: "off its path", jumped: "jumped", late: "late" }
const COLUMNS = ["state", "off", "age", "battery"] // after the name
/** The faults, the worst first. */
const ORDER = Object.keys(WORDS)
const LOW_BATTERY = 0.2 // of a battery: less is trouble
const MAX_NAMED = 3 // robots in trouble that the line names
const HOST_TIMEOUT = 3 // seconds without a message from a host until a line reports it; usually one comes each second
const FRESH_AGE = 2 // seconds: while poses come, with a message each second, the latest one is not older
const SHOW_PERIOD = 250 // milliseconds between two looks: numbers that change faster can't be read

export class StatusWall {
  /** @type {Map<string, Map<string, string>>} */
  #faults = new Map() // the line of each fault that is not over, by robot and kind
  /** @type {Messages["vitals"]["robots"]} */
  #vitals = {}
  /** @type {Map<string, Messages["link"] & { at: number }>} */
  #links = new Map() // the latest message about each host, and its time
  #looked = -Infinity
  #hadLost = false

  /** @param {Messages["fault"]} message */
  takeFault({ robot, fault, over, message, line }) {
    const open = this.#faults.get(robot) ?? new Map()
    if (over) open.delete(fault)
    else open.set(fault, message)
    this.#faults.set(robot, open)
    this.#looked = -Infinity
    if (line) announce(line)
  }

  /** @param {Messages["vitals"]} message */
  takeVitals({ robots }) {
    this.#vitals = robots
  }

  /** @param {Messages["link"]} message @param {number} now milliseconds */
  takeLink(message, now) {
    this.#links.set(message.host, { ...message, at: now })
  }

  /** The state of each host's connection, in a line each. @param {number} now milliseconds */
  links(now) {
    return [...this.#links.values()].map(({ host, error, lag, at }) => {
      const silent = Math.round((now - at) / 1000)
      if (silent > HOST_TIMEOUT) return `${host}: no word for ${silent} s`
      return `${host}: together within ${milliseconds(error)}, reached within ${milliseconds(lag)}`
    })
  }

  /** Another performance begins. */
  restart() {
    this.#faults.clear()
    this.#looked = -Infinity
  }

  /** The line about a robot that nobody can see or reach now; empty for others. @param {string} name */
  lost(name) {
    const fault = ["silent", "gone"].find((fault) => this.#faults.get(name)?.has(fault))
    if (!fault || !Object.hasOwn(this.#vitals, name)) return ""
    const seconds = this.#seconds(name)
    if (fault === "gone" && seconds < FRESH_AGE) return "" // it is still seen
    return `${WORDS[fault]}${seconds < Infinity ? `, last pose ${Math.round(seconds)} s ago` : ""}`
  }

  /** All robots that are real, those in trouble first. */
  get tiles() {
    const found = Object.entries(this.#vitals).map(([name, { odom, battery, instead }]) => {
      const faults = ORDER.filter((fault) => this.#faults.get(name)?.has(fault))
      const low = battery !== null && battery < LOW_BATTERY
      const wrong = [...faults.map((fault) => WORDS[fault]), ...(low ? ["battery low"] : [])]
      const silent = clock.isSilent(name)
      const { state } = clock.transport
      const does = silent ? "muted" : instead && clock.playing ? instead : state
      /** @type {"fault" | "still" | "well"} */
      const kind = wrong.length ? "fault" : silent || instead || !clock.playing ? "still" : "well"
      const age = this.#age(name)
      const off = measured.off(name)
      const tile = {
        name,
        state: wrong.length ? `${wrong.join(", ")}${silent ? " (muted)" : ""}` : does,
        kind,
        off: age === "now" || !off ? off : `${off.replace(", following", "")} then`,
        age: odom ? age || "none yet" : "not measured",
        battery: battery === null ? "" : `${Math.round(battery * 100)}%`,
      }
      return { tile, worst: faults.length ? ORDER.indexOf(faults[0]) : low ? ORDER.length : ORDER.length + 1 }
    })
    return found.sort((a, b) => a.worst - b.worst || a.tile.name.localeCompare(b.tile.name, "en", { numeric: true })).map(({ tile }) => tile)
  }

  /** The state of all robots, in a line; empty without real robots. */
  get summary() {
    const { tiles } = this
    if (!tiles.length) return ""
    const robots = tiles.length === 1 ? "1 robot" : `${tiles.length} robots`
    const wrong = tiles.filter(({ kind }) => kind === "fault")
    if (!wrong.length) return `${robots}, all well`
    const named = wrong.slice(0, MAX_NAMED).map(({ name, state }) => `${name} ${state}`)
    const more = wrong.length > MAX_NAMED ? `, and ${wrong.length - MAX_NAMED} more` : ""
    return `${wrong.length} of ${robots} in trouble: ${named.join("; ")}${more}`
  }

  /**
   * Shows it, if that is due. Returns whether robots are lost, or were just now, so that their lines have to be shown
   * again.
   * @param {number} now milliseconds
   */
  show(now) {
    if (now < this.#looked + SHOW_PERIOD) return false
    this.#looked = now
    const { tiles, summary } = this
    const button = find("show-wall")
    if (button.hidden === Boolean(summary)) button.hidden = !summary // the same again would cost a frame
    write(button, summary)
    const trouble = tiles[0]?.kind === "fault"
    if (button.classList.contains("trouble") !== trouble) {
      button.classList.toggle("trouble", trouble)
      refit() // it must not cover robots
    }
    const isLost = tiles.some(({ name }) => this.lost(name))
    const lost = isLost || this.#hadLost
    this.#hadLost = isLost
    if (!find("wall").hasAttribute("open")) return lost
    write(find("wall-summary"), summary)
    write(find("wall-links"), this.links(now).join("\n"))
    const rows = find("wall-rows")
    syncChildren(rows, tiles.map(({ name }) => name), tableRow)
    for (const [index, row] of [...rows.children].entries()) {
      if (!(row instanceof HTMLTableRowElement)) continue
      const { name, state, kind, off, age, battery } = tiles[index]
      row.dataset.kind = kind
      ;[name, state, off, age, battery].forEach((text, column) => write(row.cells[column], text))
      row.title = [...(this.#faults.get(name)?.values() ?? [])].join("\n")
    }
    return lost
  }

  /** The age of a robot's latest pose, in words; empty if none has come. @param {string} name */
  #age(name) {
    const seconds = this.#seconds(name)
    if (seconds === Infinity) return ""
    if (!["playing", "paused"].includes(clock.transport.state)) return "–" // nobody looks
    return seconds < FRESH_AGE ? "now" : `${seconds < 10 ? seconds.toFixed(1) : Math.round(seconds)} s`
  }

  /** The age of a robot's latest pose; Infinity if none has come. @param {string} name */
  #seconds(name) {
    const told = this.#vitals[name].posed ?? -Infinity
    return clock.performed() - Math.max(told, measured.latest(name))
  }
}

export const wall = new StatusWall()

/** A row without texts. */
function tableRow() {
  return element("tr", {}, element("th", { scope: "row" }), ...COLUMNS.map((className) => element("td", { className })))
}

/** @param {number} seconds */
function milliseconds(seconds) {
  const value = seconds * 1000
  return `${value < 10 ? value.toFixed(1) : Math.round(value)} ms`
}

// @ts-check
// The timeline: one row per robot, one item per word, as wide as its duration, and the playhead. Drag to scrub.

import { TimelineSheet } from "./timesheet.js"

import { formatPosition } from "../score/clock.js"
import { find, findA } from "../base/elements.js"
import { Silence } from "../score/silence.js"
import { rowsOf } from "./timerows.js"

/** @import { Robot } from "../score/robot-list.js" */
/** @import { Clock } from "../score/clock.js" */
/** @import { Colors } from "../base/colors.js" */
/** @import { Measured } from "../floor/measured.js" */
/** @import { Meeting } from "../floor/meetings.js" */
/** @import { Lookahead } from "../score/lookahead.js" */
/** @import { Messages } from "../net/messages.js" */


const LONG_NAME = 12 // letters: a longer name takes two or three smaller lines
const LEAST_BEAT_WIDTH = 30 // pixels per beat, at 16 pixels per letter: a longer score scrolls
const PLAYHEAD_AT = 0.25 // where in the view the playhead stays
const CROWD_SIZE = 8 // robots; with more, rows are lower, to leave room for the stage
const SNAP_DISTANCE = 7 // pixels from a mark to a pointer
const SEEK_PERIOD = 60 // milliseconds between two seeks while scrubbing

export class Timeline {
  #tracks
  #line
  #list
  #sheet
  #seek
  #silence
  #left = 0 // the beat at the left edge
  /** @type {number | null} */
  #scrubbed = null // the beat under the pointer
  #sent = 0
  #drawn = ""
  #scale = 1 // pixels per beat
  #shown = { left: 0, scale: 1, beat: 0, width: 0 }
  #sizes = { width: 0, height: 0, letter: 16, head: 0, row: 0 }
  /** @type {Messages["score"] | null} */
  #score = null
  /** @type {Meeting[]} */
  #meetings = []
  #clock
  #silenced = new Silence()
  #measured
  #lost
  /** @type {number | null} */
  #pointed = null // the beat under a pointer that presses nothing

  /**
   * `seek` and `silence` ask the server, and `lost` says what is known of a robot that nobody can see or reach now.
   * @param {Clock} clock
   * @param {Measured} measured
   * @param {(name: string) => string} lost
   * @param {(beat: number) => void} seek
   * @param {(muted: string[], soloed: string[]) => void} silence
   */
  constructor(clock, measured, lost, seek, silence) {
    this.#clock = clock
    this.#measured = measured
    this.#lost = lost
    this.#seek = seek
    this.#silence = silence
    this.#tracks = find("tracks")
    this.#line = find("playline")
    this.#list = find("robots-list")
    this.#sheet = new TimelineSheet(findA("rows", HTMLCanvasElement))
    this.#line.addEventListener("pointerdown", (event) => this.#press(event))
    this.#line.addEventListener("pointermove", (event) => this.#drag(event))
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) this.#line.addEventListener(end, () => this.#release())
    this.#line.addEventListener("pointerleave", () => this.#point(null))
    this.#tracks.addEventListener("scroll", () => this.touch())
  }

  /** Has the next frame redraw everything. */
  touch() {
    this.#drawn = ""
    this.#sheet.forget()
  }

  /**
   * Marks in a robot's row what its senses have decided.
   * @param {Messages["decided"]} decision
   */
  mark(decision) {
    this.#sheet.mark(decision)
    this.touch()
  }

  /**
   * Marks where robots will meet. A pointer near such a mark goes to its beat.
   * @param {Meeting[]} meetings
   */
  showMeetings(meetings) {
    this.#meetings = meetings
    this.#sheet.meetings = meetings
    this.touch()
  }

  forgetMarks() {
    this.#sheet.forgetMarks()
    this.touch()
  }

  /** @param {Colors} colors */
  set colors(colors) {
    this.#sheet.colors = colors
  }

  resize() {
    this.#sizes = {
      width: this.#line.clientWidth,
      height: this.#tracks.clientHeight,
      letter: parseFloat(getComputedStyle(this.#tracks).fontSize),
      head: find("robots-head").offsetHeight,
      row: this.#list.firstElementChild?.getBoundingClientRect().height ?? 0,
    }
    this.#sheet.resize(this.#sizes.width, this.#sizes.height)
    this.touch()
  }

  /**
   * Shows another score; `robots` are robots with their names and colors.
   * @param {Messages["score"]} score
   * @param {Robot[]} robots
   */
  show(score, robots) {
    this.#score = score
    this.#left = 0
    const sheet = rowsOf(score, robots)
    this.#tracks.classList.toggle("crowd", sheet.rows.length > CROWD_SIZE)
    this.#sheet.show(score, sheet)
    this.#list.replaceChildren(...sheet.rows.map((row) => (row.part === null ? this.#row(row) : partRow(row, row.part))))
    this.showSilence()
    this.showMeasured()
    this.showPosition()
    this.resize()
  }

  /** Shows which robots are muted or soloed, as the latest message says. */
  showSilence() {
    const { muted, soloed } = this.#clock.transport
    this.#silenced.take({ muted, soloed })
    for (const row of this.#ownRows()) {
      const { robot = "" } = row.dataset
      row.dataset.silent = String(this.#clock.isSilent(robot))
      row.querySelector(".mute")?.setAttribute("aria-pressed", String(muted.includes(robot)))
      row.querySelector(".solo")?.setAttribute("aria-pressed", String(soloed.includes(robot)))
    }
    this.touch()
  }

  /** Shows how far off robots are, or were at the beat under the pointer. */
  showMeasured() {
    const rows = this.#ownRows()
    const known = rows.filter(({ dataset: { robot = "" } }) => this.#measured.has(robot))
    const beat = known.length ? this.#pointed : null
    const count = rows.length > CROWD_SIZE ? `${rows.length} robots` : "" // most have to be scrolled to
    find("robots-head").textContent = beat === null ? count : formatPosition(Math.floor(beat), this.#clock.bar)
    for (const row of rows) {
      const off = row.querySelector(".off")
      const { robot = "" } = row.dataset
      const text = (beat === null && this.#lost(robot)) || this.#measured.off(robot, beat)
      if (off && off.textContent !== text) off.textContent = text
    }
  }

  /** The rows of robots, without those of their body parts. */
  #ownRows() {
    return [...this.#list.querySelectorAll("li")].filter(({ dataset }) => dataset.robot)
  }

  /** Tells screen readers the position. */
  showPosition() {
    const { beats } = this.#clock.transport
    const beat = this.#scrubbed ?? this.#clock.beat()
    const values = {
      "aria-valuenow": Number(beat.toFixed(2)),
      "aria-valuemax": beats ?? Math.ceil(beat) + 1,
      "aria-valuetext": `${this.#clock.words}${beats === null ? ", endless" : ` of ${formatPosition(this.#clock.lastBeat - 1, this.#clock.bar).replace(/^beat /, "")}`}`,
    }
    for (const [name, value] of Object.entries(values)) this.#line.setAttribute(name, String(value))
  }

  /**
   * Draws if something has changed; `still` turns pages instead of scrolling.
   * @param {Lookahead | null} lookahead
   * @param {boolean} still
   */
  draw(lookahead, still) {
    const { width, height } = this.#sizes
    if (!this.#score || !width || height < 2) return
    const { letter } = this.#sizes
    const least = (LEAST_BEAT_WIDTH * letter) / 16
    const beat = this.#scrubbed ?? this.#clock.beat()
    const beats = this.#score.beats ?? Infinity
    const fits = beats * least <= width
    const scale = fits ? (width - 2) / Math.max(beats, 1) : least * 1.5
    const shown = width / scale
    if (fits) this.#left = 0
    else if (this.#scrubbed === null) this.#left = this.#follow(beat, shown, still)
    // In whole pixels: copying between pixels is slow and shows nothing new.
    const pixels = scale * Math.min(devicePixelRatio, 2)
    const left = Math.round(this.#left * pixels) / pixels
    const playhead = Math.round((beat - left) * pixels)
    const look = [playhead, left, scale, lookahead?.version, this.#clock.transport.state].join()
    if (look === this.#drawn) return
    this.#drawn = look
    this.#sheet.draw({
      lookahead,
      beat,
      left,
      scale,
      ...this.#sizes,
      top: this.#tracks.scrollTop,
      lit: ["playing", "paused"].includes(this.#clock.transport.state),
      silent: (/** @type {string} */ robot) => this.#clock.isSilent(robot),
    })
    this.#scale = scale
    this.#shown = { left, scale, beat, width }
  }

  /** The stretch that is drawn: the beat at its left edge, pixels per beat, the beat that plays, and pixels. */
  get shown() {
    return this.#shown
  }

  /**
   * @param {number} beat
   * @param {number} shown
   * @param {boolean} still
   */
  #follow(beat, shown, still) {
    const wanted = Math.max(beat - shown * PLAYHEAD_AT, 0)
    if (this.#clock.playing && !still) return wanted
    if (beat < this.#left || beat > this.#left + shown * 0.9) return Math.max(beat - shown * 0.1, 0) // turns the page
    return this.#left
  }

  /** @param {Robot} robot */
  #row({ name, color }) {
    const row = document.createElement("li")
    row.dataset.robot = name
    row.style.setProperty("--robot", color)
    const dot = document.createElement("span")
    dot.className = "dot"
    const label = document.createElement("span")
    label.className = name.length > LONG_NAME ? "name long" : "name"
    label.title = name
    label.append(...name.split(/(?<=_)/).flatMap((part) => [part, document.createElement("wbr")]))
    const off = document.createElement("span")
    off.className = "off"
    off.addEventListener("pointerenter", () => (off.title = `at most ${this.#measured.most(name)}`))
    const both = document.createElement("span")
    both.className = "named"
    both.append(label, off)
    row.append(dot, both)
    if (this.#score?.robots[name]?.ends === null) {
      const endless = document.createElement("span")
      Object.assign(endless, { className: "endless", textContent: "∞", title: "endless" })
      row.append(endless)
    }
    row.append(this.#button("mute", "Mute", name), this.#button("solo", "Solo", name))
    return row
  }

  /**
   * @param {string} kind
   * @param {string} word
   * @param {string} name
   */
  #button(kind, word, name) {
    const button = document.createElement("button")
    button.type = "button"
    button.className = kind
    button.textContent = word[0]
    button.title = kind === "mute" ? `Mute: ${name} stands still while the others play` : `Solo: only ${name} and other soloed robots play`
    button.setAttribute("aria-label", `${word} ${name}`)
    button.addEventListener("click", () => {
      const { muted, soloed } = this.#silenced.flip(kind === "mute" ? "muted" : "soloed", name)
      this.#silence(muted, soloed)
    })
    return button
  }

  /** @param {PointerEvent} event */
  #press(event) {
    if (event.button !== 0 || !this.#score) return
    this.#line.setPointerCapture(event.pointerId)
    this.#scrub(event, true)
  }

  /** @param {PointerEvent} event */
  #drag(event) {
    if (this.#scrubbed !== null) this.#scrub(event, performance.now() - this.#sent > SEEK_PERIOD)
    else this.#point(this.#beatOf(event))
  }

  #release() {
    if (this.#scrubbed === null) return
    this.#seek(this.#scrubbed)
    this.#scrubbed = null
  }

  /** @param {PointerEvent} event */
  #beatOf(event) {
    const x = event.clientX - this.#line.getBoundingClientRect().left
    return Math.max(this.#left + x / this.#scale, 0)
  }

  /** @param {number | null} beat */
  #point(beat) {
    this.#pointed = beat
    this.showMeasured()
  }

  /**
   * @param {PointerEvent} event
   * @param {boolean} send
   */
  #scrub(event, send) {
    const pointed = this.#beatOf(event)
    const beat = this.#meetings.find((meeting) => Math.abs(meeting.beat - pointed) * this.#scale < SNAP_DISTANCE)?.beat ?? pointed
    this.#scrubbed = Number(Math.min(beat, this.#score?.beats ?? Infinity).toFixed(3))
    if (!send) return
    this.#sent = performance.now()
    this.#seek(this.#scrubbed)
  }
}

/**
 * @param {Robot} robot
 * @param {string} part
 */
function partRow({ name, color }, part) {
  const row = document.createElement("li")
  row.className = "part"
  row.dataset.of = name
  row.style.setProperty("--robot", color)
  const label = document.createElement("span")
  label.className = "name"
  label.textContent = part.replaceAll("_", " ")
  label.title = `${part} of ${name}`
  row.append(label)
  return row
}

// @ts-check
// The timeline: one row per robot, one item per word, as wide as its duration, and the playhead. Drag to scrub.

import { colors } from "../base/colors.js"
import { button, element, find, findA, robotElement, span, write } from "../base/elements.js"
import { wake } from "../base/frames.js"
import { seek } from "../controls/seek.js"
import { wall } from "../controls/status-wall.js"
import { measured } from "../floor/measured.js"
import { send } from "../net/send.js"
import { clock, formatPosition } from "../score/clock.js"
import { partsOf } from "../score/lookahead.js"
import { program } from "../score/program.js"
import { robotList } from "../score/robot-list.js"
import { Silence } from "../score/silence.js"
import { TimelineSheet } from "./timesheet.js"

/** @import { Robot } from "../score/robot-list.js" */
/** @import { Meeting } from "../floor/meetings.js" */
/** @import { TimelineRow } from "./timesheet.js" */

const LONG_NAME = 12 // letters: a longer name takes two or three smaller lines
const MIN_BEAT_WIDTH = 30 // pixels per beat, at 16 pixels per letter: a longer score scrolls
const PLAYHEAD_AT = 0.25 // where in the view the playhead stays
const CROWD_SIZE = 8 // robots; with more, rows are lower, to leave room for the stage
const MAX_MARKS = 500
const SNAP_DISTANCE = 7 // pixels from a mark to a pointer
const SEEK_PERIOD = 60 // milliseconds between two seeks while scrubbing

export class Timeline {
  #tracks = find("tracks")
  #line = find("playline")
  #list = find("robots-list")
  #sheet = new TimelineSheet(findA("rows", HTMLCanvasElement))
  #left = 0 // the beat at the left edge
  /** @type {number | null} */
  #scrubbed = null // the beat under the pointer
  #sent = 0
  #drawn = ""
  /** The part that is drawn: the beat at its left edge, pixels per beat, the beat that plays, and pixels. */
  shown = { left: 0, scale: 1, beat: 0, width: 0 }
  #sizes = { width: 0, height: 0, letter: 16, head: 0, top: 0 } // read seldom: that has the browser lay the page out
  /** @type {TimelineRow[]} */
  #rows = []
  #silence = new Silence()
  /** @type {number | null} */
  #pointed = null // the beat under a pointer that presses nothing

  constructor() {
    this.#line.addEventListener("pointerdown", (event) => this.#press(event))
    this.#line.addEventListener("pointermove", (event) => this.#drag(event))
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) this.#line.addEventListener(end, () => this.#release())
    this.#line.addEventListener("pointerleave", () => this.#point(null))
    this.#tracks.addEventListener("scroll", () => {
      this.#sizes.top = this.#tracks.scrollTop
      this.touch()
    })
  }

  /** Has the next frame redraw everything. */
  touch() {
    this.#drawn = ""
    this.#sheet.forget()
    wake()
  }

  /** Marks in a robot's row what its senses have decided. @param {Messages["decided"]} decision */
  mark(decision) {
    this.#sheet.marks = [...this.#sheet.marks, decision].slice(-MAX_MARKS)
    this.touch()
  }

  /** Another performance begins: senses have decided nothing yet. */
  restart() {
    this.#sheet.marks = []
    this.touch()
  }

  /** Marks where robots will meet. A pointer near such a mark goes to its beat. @param {Meeting[]} meetings */
  showMeetings(meetings) {
    this.#sheet.meetings = meetings
    this.touch()
  }

  resize() {
    this.#sizes = {
      width: this.#line.clientWidth,
      height: this.#tracks.clientHeight,
      letter: parseFloat(getComputedStyle(this.#tracks).fontSize),
      head: find("robots-head").offsetHeight,
      top: this.#tracks.scrollTop,
    }
    const { top } = this.#list.getBoundingClientRect()
    const boxes = [...this.#list.children].map((row) => row.getBoundingClientRect())
    const rows = boxes.map(({ y, height }, i) => ({ robot: this.#rows[i], y: y - top, row: height }))
    this.#sheet.resize(this.#sizes.width, this.#sizes.height, rows)
    this.touch()
  }

  /** Shows another score. @param {Messages["score"]} score */
  show(score) {
    this.#left = 0
    this.#rows = robotList.playing.flatMap((robot) => partsOf(score, robot.name).map((part) => ({ ...robot, part })))
    this.#tracks.classList.toggle("crowd", this.#rows.length > CROWD_SIZE)
    this.#list.replaceChildren(...this.#rows.map((row) => (row.part === null ? this.#row(row) : partRow(row, row.part))))
    this.showSilence()
    this.showMeasured()
    this.showPosition()
    this.resize()
  }

  /** Shows which robots are muted or soloed, as the latest message says. */
  showSilence() {
    const { muted, soloed } = clock.transport
    this.#silence.take({ muted, soloed })
    for (const row of this.#ownRows()) {
      const { robot = "" } = row.dataset
      row.dataset.silent = String(clock.isSilent(robot))
      row.querySelector(".muted")?.setAttribute("aria-pressed", String(muted.includes(robot)))
      row.querySelector(".soloed")?.setAttribute("aria-pressed", String(soloed.includes(robot)))
    }
    this.touch()
  }

  /** Shows how far off robots are, or were at the beat under the pointer. */
  showMeasured() {
    const rows = this.#ownRows()
    const known = rows.filter(({ dataset: { robot = "" } }) => measured.has(robot))
    const beat = known.length ? this.#pointed : null
    const count = rows.length > CROWD_SIZE ? `${rows.length} robots` : "" // most have to be scrolled to
    find("robots-head").textContent = beat === null ? count : formatPosition(Math.floor(beat), program.bar)
    for (const row of rows) {
      const off = row.querySelector(".off")
      const { robot = "" } = row.dataset
      const text = (beat === null && wall.lost(robot)) || measured.off(robot, beat)
      if (off) write(off, text)
    }
  }

  /** The rows of robots, without those of their body parts. */
  #ownRows() {
    return [...this.#list.querySelectorAll("li")].filter(({ className }) => className !== "part")
  }

  /** Tells screen readers the position. */
  showPosition() {
    const { beats } = clock.transport
    const beat = this.#scrubbed ?? clock.beat()
    const values = {
      "aria-valuenow": Number(beat.toFixed(2)),
      "aria-valuemax": beats ?? Math.ceil(beat) + 1,
      "aria-valuetext": `${program.position}${beats === null ? ", endless" : ` of ${formatPosition(clock.lastBeat - 1, program.bar).replace(/^beat /, "")}`}`,
    }
    for (const [name, value] of Object.entries(values)) this.#line.setAttribute(name, String(value))
  }

  /** Draws if something has changed. @param {boolean} still turns pages instead of scrolling */
  draw(still) {
    const { width, height } = this.#sizes
    const { current } = program
    if (!current || !width || height < 2) return
    const { letter } = this.#sizes
    const least = (MIN_BEAT_WIDTH * letter) / 16
    const beat = this.#scrubbed ?? clock.beat()
    const beats = current.score.beats ?? Infinity
    const fits = beats * least <= width
    const scale = fits ? (width - 2) / Math.max(beats, 1) : least * 1.5
    const shown = width / scale
    if (fits) this.#left = 0
    else if (this.#scrubbed === null) this.#left = this.#follow(beat, shown, still)
    // In whole pixels: copying between pixels is slow and shows nothing new.
    const pixels = scale * Math.min(devicePixelRatio, 2)
    const left = Math.round(this.#left * pixels) / pixels
    const playhead = Math.round((beat - left) * pixels)
    const look = [playhead, left, scale, current.version, clock.transport.state, colors().panel].join()
    if (look === this.#drawn) return
    this.#drawn = look
    this.#sheet.draw({ beat, left, scale, ...this.#sizes })
    this.shown = { left, scale, beat, width }
  }

  /** @param {number} beat @param {number} shown @param {boolean} still */
  #follow(beat, shown, still) {
    const wanted = Math.max(beat - shown * PLAYHEAD_AT, 0)
    if (clock.playing && !still) return wanted
    if (beat < this.#left || beat > this.#left + shown * 0.9) return Math.max(beat - shown * 0.1, 0) // turns the page
    return this.#left
  }

  /** @param {Robot} robot */
  #row(robot) {
    const { name } = robot
    const shown = program.label(name)
    const parts = shown.split(/(?<=_)/).flatMap((part) => [part, element("wbr")])
    const label = element("span", { className: shown.length > LONG_NAME ? "name long" : "name", title: shown }, ...parts)
    const off = span("off")
    off.addEventListener("pointerenter", () => (off.title = `at most ${measured.most(name)}`))
    const endless = element("span", { className: "endless quiet", textContent: "∞", title: "endless" })
    return robotElement(
      "li",
      robot,
      span("dot"),
      element("span", { className: "named" }, label, off),
      ...(program.current?.score.robots[name]?.ends === null ? [endless] : []),
      this.#button("muted", "Mute", name, `Mute: ${shown} stands still while the others play`),
      this.#button("soloed", "Solo", name, `Solo: only ${shown} and other soloed robots play`),
    )
  }

  /** @param {"muted" | "soloed"} kind @param {string} word @param {string} name @param {string} title */
  #button(kind, word, name, title) {
    return button({ className: kind, textContent: word[0], title, ariaLabel: `${word} ${program.label(name)}` }, () => {
      send({ type: "silence", ...this.#silence.flip(kind, name) })
    })
  }

  /** @param {PointerEvent} event */
  #press(event) {
    if (event.button !== 0 || !program.current) return
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
    seek(this.#scrubbed)
    this.#scrubbed = null
    wake()
  }

  /** @param {PointerEvent} event */
  #beatOf(event) {
    const x = event.clientX - this.#line.getBoundingClientRect().left
    return Math.max(this.#left + x / this.shown.scale, 0)
  }

  /** @param {number | null} beat */
  #point(beat) {
    this.#pointed = beat
    this.showMeasured()
  }

  /** @param {PointerEvent} event @param {boolean} send */
  #scrub(event, send) {
    const pointed = this.#beatOf(event)
    const beat = this.#sheet.meetings.find((meeting) => Math.abs(meeting.beat - pointed) * this.shown.scale < SNAP_DISTANCE)?.beat ?? pointed
    this.#scrubbed = Number(Math.min(beat, program.current?.score.beats ?? Infinity).toFixed(3))
    wake()
    if (!send) return
    this.#sent = performance.now()
    seek(this.#scrubbed)
  }
}

/** @param {Robot} robot @param {string} part */
function partRow(robot, part) {
  const row = robotElement("li", robot, element("span", { className: "name", textContent: part.replaceAll("_", " "), title: `${part} of ${program.label(robot.name)}` }))
  row.className = "part"
  return row
}

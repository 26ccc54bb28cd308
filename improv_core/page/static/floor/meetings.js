// @ts-check
// Meetings of robots with each other, or with something in the world: marks that lead to their beats.

import { colors } from "../base/colors.js"
import { write } from "../base/elements.js"
import { redraw } from "../base/frames.js"
import { formatPosition } from "../score/clock.js"

/** @import { Camera, Point } from "./camera.js" */
/** @import { Pen } from "../base/pen.js" */
/** @typedef {{ beat: number, robots: string[], poses: Point[], words: string }} Meeting */
/** @typedef {{ meeting: Meeting, place: Point, shows: boolean }} Mark on the screen, and whether its robots are drawn there */

const MAX_DRAWN = 6 // these are drawn with their robots; of more, only the one that somebody points at
const CLICK_RADIUS = 14 // pixels to a mark
const SIZE = 8 // pixels from a mark's middle to its edge
const CLICK_SLOP = 5 // pixels by which a click may move
const SEEK_TOLERANCE = 0.01 // beats: a seek to a beat has reached it

export class Meetings {
  /** @type {Messages["meetings"] | null} */
  #message = null
  /** @type {Meeting[]} */
  #all = []
  #button
  #seek
  #now
  /** @type {Meeting | null} */
  pointed = null

  /**
   * `button` says how many are ahead, and seeks to the next one.
   * @param {HTMLElement} button
   * @param {(beat: number) => void} seek
   * @param {() => number} now the present beat, or the one at which the next performance begins
   */
  constructor(button, seek, now) {
    this.#button = button
    this.#seek = seek
    this.#now = now
    button.addEventListener("click", () => {
      const next = this.#all.find(({ beat }) => beat > now() + SEEK_TOLERANCE) ?? this.#all[0]
      if (next) seek(next.beat)
    })
  }

  /** @param {Messages["meetings"]} message */
  take(message) {
    this.#message = message
  }

  /**
   * Those of the score with this number, in their order.
   * @param {number | undefined} generation
   * @param {number | null} bar how many beats a bar has
   */
  show(generation, bar) {
    const message = this.#message?.generation === generation ? this.#message : null
    const found = message ? [...message.meetings.map(met), ...message.hits.map(hit)] : []
    this.#all = found
      .sort((one, other) => one.beat - other.beat)
      .map((each) => ({ ...each, words: `${formatPosition(Math.floor(each.beat), bar)}: ${each.words}` }))
    this.pointed = null
    this.showAhead()
    return this.#all
  }

  /** Shows how many are still ahead. */
  showAhead() {
    const ahead = this.#all.filter(({ beat }) => beat >= this.#now())
    const count = ahead.length
    this.#button.hidden = !count
    write(this.#button, count === 1 ? "1 meeting ahead" : `${count} meetings ahead`)
    this.#button.title = [...ahead.slice(0, MAX_DRAWN).map(({ words }) => words), ...(count > MAX_DRAWN ? ["…"] : [])].join("\n")
  }

  /** The marks on the screen. @param {Pick<Camera, "toScreen" | "view">} camera @returns {Mark[]} */
  marks(camera) {
    if (!camera.view) return []
    return this.#all.map((meeting) => {
      const places = meeting.poses.map((pose) => camera.toScreen(pose))
      const middle = (/** @type {"x" | "y"} */ key) => places.reduce((sum, place) => sum + place[key], 0) / places.length
      return { meeting, place: { x: middle("x"), y: middle("y") }, shows: this.#all.length <= MAX_DRAWN || meeting === this.pointed }
    })
  }

  /** Clicks of a canvas seek to the mark under the pointer. @param {HTMLCanvasElement} canvas @param {Camera} camera */
  listen(canvas, camera) {
    let from = { x: 0, y: 0 }
    canvas.addEventListener("pointerdown", ({ offsetX: x, offsetY: y }) => (from = { x, y }))
    canvas.addEventListener("click", ({ offsetX: x, offsetY: y }) => {
      const meeting = Math.hypot(x - from.x, y - from.y) < CLICK_SLOP ? this.at({ x, y }, camera) : null
      if (meeting) this.#seek(meeting.beat)
    })
  }

  /**
   * Shows the meeting that somebody points at, if there is one.
   * @param {HTMLCanvasElement} canvas
   * @param {Point} point of the canvas
   * @param {Camera} camera
   */
  point(canvas, point, camera) {
    const meeting = this.at(point, camera)
    if (meeting !== this.pointed) redraw()
    this.pointed = meeting
    Object.assign(canvas, { title: meeting?.words ?? "" }).style.cursor = meeting ? "pointer" : ""
  }

  /** The one whose mark is at a point of the canvas. @param {Point} point @param {Camera} camera */
  at({ x, y }, camera) {
    const distance = (/** @type {Mark} */ { place }) => Math.hypot(x - place.x, y - place.y)
    const near = this.marks(camera).filter((mark) => distance(mark) < CLICK_RADIUS)
    return near.sort((one, other) => distance(one) - distance(other))[0]?.meeting ?? null
  }
}

/**
 * Draws a mark: a diamond, with an exclamation point if it is large.
 * @param {Pen} pen
 * @param {Point} place
 * @param {number} [size] pixels
 */
export function drawMark(pen, { x, y }, size = SIZE) {
  pen.beginPath()
  for (const [across, up] of [[size, 0], [0, size], [-size, 0], [0, -size]]) pen.lineTo(x + across, y + up)
  pen.closePath()
  pen.fillStyle = colors().bump
  pen.fill()
  pen.strokeStyle = pen.fillStyle = colors().ground
  pen.lineWidth = 1.5
  pen.stroke()
  if (size < SIZE) return
  pen.fillRect(x - 1, y - size * 0.55, 2, size * 0.6)
  pen.fillRect(x - 1, y + size * 0.25, 2, 2)
}

/** @param {Messages["meetings"]["meetings"][number]} meeting */
function met({ robots, beat, distance, more, poses }) {
  const again = more ? `, and ${more === 1 ? "once" : `${more} times`} more` : ""
  return { beat, robots, poses: poses.map(point), words: `${robots.join(" and ")} meet, ${distance.toFixed(2)} m apart${again}` }
}

/** @param {Messages["meetings"]["hits"][number]} hit */
function hit({ robot, thing, beat, pose }) {
  return { beat, robots: [robot], poses: [point(pose)], words: `${robot} hits ${thing === "edge" ? "the edge of the floor" : thing}` }
}

/** @param {number[]} pose */
function point([x, y]) {
  return { x, y }
}

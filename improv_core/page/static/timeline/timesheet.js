// @ts-check
// Draws the timeline on its canvas: a sheet of items that scrolls, and over it the items that play now.

import { colors } from "../base/colors.js"
import { fillRect, penOn } from "../base/pen.js"
import { drawMark } from "../floor/meetings.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"
import { itemsOf } from "./items.js"
import { drawItems, paintRow } from "./row.js"
import { paintRuler } from "./ruler.js"

/** @import { Lookahead } from "../score/lookahead.js" */
/** @import { Meeting } from "../floor/meetings.js" */
/** @import { Pen } from "../base/pen.js" */
/** @import { Robot } from "../score/robot-list.js" */
/** @typedef {Robot & { part: string | null }} TimelineRow of a robot, or of one of its body parts */
/** @typedef {{ robot: TimelineRow, y: number, row: number }} RowPlace where a row begins, and how high it is, in pixels */
/**
 * @typedef {object} TimelineView
 * @property {number} beat
 * @property {number} left the beat at the left edge
 * @property {number} scale pixels per beat
 * @property {number} letter pixels
 * @property {number} head pixels
 * @property {number} top pixels by which rows are scrolled
 */

const SPARE = 0.5 // of the view's width is drawn beyond its right edge

export class TimelineSheet {
  #canvas
  #pen
  /** @type {{ image: ImageBitmap, left: number, right: number, key: string } | null} */
  #sheet = null
  #width = 0
  #height = 0
  #ratio = 1
  /** @type {RowPlace[]} */
  #rows = []
  /** What senses have decided. @type {Messages["decided"][]} */
  marks = []
  /** @type {Meeting[]} */
  meetings = []

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.#canvas = canvas
    this.#pen = penOn(canvas, { alpha: false })
  }

  forget() {
    this.#sheet = null
  }

  /** @param {number} width @param {number} height @param {RowPlace[]} rows below the ruler */
  resize(width, height, rows) {
    this.#rows = rows
    this.#ratio = Math.min(devicePixelRatio, 2)
    this.#width = width
    this.#height = height
    this.#canvas.width = Math.round(width * this.#ratio)
    this.#canvas.height = Math.round(height * this.#ratio)
    this.#canvas.style.height = `${height}px`
    this.#pen.textBaseline = "middle" // a new size forgets it
    this.forget()
  }

  /** @param {TimelineView} view */
  draw(view) {
    const { current } = program
    if (!this.#width || !this.#height || !current) return
    const key = [view.scale, current.version, view.top, colors().panel].join()
    const right = view.left + this.#width / view.scale
    let sheet = this.#sheet
    if (sheet?.key !== key || view.left < sheet.left || right > sheet.right) sheet = this.#paint(current, view, key)
    const pen = this.#pen
    pen.setTransform(1, 0, 0, 1, 0, 0)
    pen.drawImage(sheet.image, Math.round((sheet.left - view.left) * view.scale * this.#ratio), 0)
    pen.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0)
    this.#clipRows(pen, view)
    for (const place of clock.atStart ? [] : this.#visible(view)) {
      const { name, part } = place.robot
      const segments = current.track(name, part)
      const at = current.indexAt(segments, view.beat)
      if (clock.isSilent(name) || !segments[at] || segments[at].start > view.beat) continue
      drawItems({ ...view, ...place, pen, current }, itemsOf(segments, at, at + 1), true)
    }
    pen.restore()
    this.#drawPlayhead(pen, view)
  }

  /** @param {Lookahead} current @param {TimelineView} view @param {string} key */
  #paint(current, view, key) {
    const right = view.left + (this.#width * (1 + SPARE)) / view.scale
    const width = Math.ceil(this.#width * (1 + SPARE) * this.#ratio)
    const canvas = new OffscreenCanvas(width, this.#canvas.height)
    const pen = penOn(canvas, { alpha: false })
    pen.textBaseline = "middle"
    fillRect(pen, colors().panel, 0, 0, canvas.width, canvas.height)
    pen.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0)
    const { beats, bar, scene: first, scenes, scene_names: names } = current.score
    const named = scenes.map((beat, index) => ({ beat, number: first + index + 1, name: names[first + index] ?? "" }))
    paintRuler(pen, { ...view, last: Math.min(right, beats ?? Infinity), bar, scenes: named, height: this.#height, colors: colors() })
    for (const { beat } of this.meetings) drawMark(pen, { x: (beat - view.left) * view.scale, y: view.head * 0.7 }, 6)
    this.#clipRows(pen, view, 1 + SPARE)
    for (const place of this.#visible(view)) {
      paintRow({ ...view, ...place, pen, current }, right, this.meetings, this.marks)
    }
    pen.restore()
    this.#sheet?.image.close()
    this.#sheet = { image: canvas.transferToImageBitmap(), left: view.left, right, key }
    return this.#sheet
  }

  /** The rows that are not scrolled out of view. @param {TimelineView} view */
  #visible({ head, top }) {
    const rows = this.#rows.map((place) => ({ ...place, y: head + place.y - top }))
    return rows.filter(({ y, row }) => y + row > head && y < this.#height)
  }

  /** @param {Pen} pen @param {TimelineView} view @param {number} [times] */
  #clipRows(pen, { head }, times = 1) {
    pen.save()
    pen.beginPath()
    pen.rect(0, head, this.#width * times, this.#height)
    pen.clip()
  }

  /** @param {Pen} pen @param {TimelineView} view */
  #drawPlayhead(pen, { beat, left, scale, letter, head }) {
    const x = Math.min(Math.max((beat - left) * scale, 1), this.#width - 1)
    fillRect(pen, colors().ink, x - 1, head * 0.3, 2, this.#height)
    pen.beginPath()
    pen.moveTo(x - letter * 0.42, 1)
    pen.lineTo(x + letter * 0.42, 1)
    pen.lineTo(x, head * 0.55)
    pen.fill()
  }
}

// @ts-check
// Draws the timeline on its canvas: a sheet of items that scrolls, and over it the items that play now.

import { mix, readColors } from "../base/colors.js"
import { CodePointReader, direction, labels, namesOf, outline, runs, shapes } from "../score/items.js"
import { drawMark } from "../floor/meetings.js"
import { penOn } from "../base/pen.js"
import { FONT, paintRuler } from "./ruler.js"
import { TimelineRows } from "./timerows.js"

/** @import { TimelineRow } from "./timerows.js" */
/** @import { Colors } from "../base/colors.js" */
/** @import { Shape, Voice } from "../score/items.js" */
/** @import { Lookahead } from "../score/lookahead.js" */
/** @import { Meeting } from "../floor/meetings.js" */
/** @import { Messages } from "../net/messages.js" */
/** @import { Pen } from "../base/pen.js" */
/**
 * @typedef {object} TimelineView
 * @property {Lookahead | null} lookahead
 * @property {number} beat
 * @property {number} left the beat at the left edge
 * @property {number} scale pixels per beat
 * @property {number} letter pixels
 * @property {number} head pixels
 * @property {number} row pixels
 * @property {number} top pixels by which rows are scrolled
 * @property {boolean} lit whether what plays is lit
 * @property {(robot: string) => boolean} silent
 */

const SPARE = 0.5 // of the view's width is drawn beyond its right edge
const MOST_ITEMS = 600 // per row: more would be finer than pixels
const MOST_MARKS = 500
const LEAST_HEIGHT = 0.12 // of a lane, so that a robot that is about to stop is seen

export class TimelineSheet {
  #canvas
  #pen
  /** @type {{ image: ImageBitmap, left: number, right: number, key: string } | null} */
  #sheet = null
  #width = 0
  #height = 0
  #ratio = 1
  #rows = new TimelineRows([])
  /** @type {Messages["score"]["robots"]} */
  #robots = {}
  #reader = new CodePointReader("", {})
  /** @type {Messages["decided"][]} */
  #marks = []
  /** @type {Messages["score"]["offsets"]} */
  #offsets = {}
  /** @type {{ beats: number | null, bar: number | null, first: number, scenes: number[], names: string[] }} */
  #ruler = { beats: 0, bar: null, first: 0, scenes: [], names: [] } // no beats if the score is endless
  /** @type {Meeting[]} */
  meetings = []
  #colors = readColors()

  /**
   * Takes the colors of another theme.
   * @param {Colors} colors
   */
  set colors(colors) {
    this.#colors = colors
    this.forget()
  }

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.#canvas = canvas
    this.#pen = penOn(canvas, { alpha: false })
  }

  /**
   * @param {Messages["score"]} score
   * @param {TimelineRows} rows
   */
  show(score, rows) {
    this.#robots = score.robots
    this.#offsets = score.offsets
    this.#ruler = { beats: score.beats, bar: score.bar, first: score.scene, scenes: score.scenes, names: score.scene_names }
    this.#rows = rows
    this.#reader = new CodePointReader(score.text, score.words)
    this.forget()
  }

  forget() {
    this.#sheet = null
  }

  /** @param {Messages["decided"]} decision */
  mark(decision) {
    this.#marks = [...this.#marks, decision].slice(-MOST_MARKS)
  }

  forgetMarks() {
    this.#marks = []
  }

  /**
   * @param {number} width
   * @param {number} height
   */
  resize(width, height) {
    this.#ratio = Math.min(devicePixelRatio, 2)
    this.#width = width
    this.#height = height
    this.#canvas.width = Math.round(width * this.#ratio)
    this.#canvas.height = Math.round(height * this.#ratio)
    this.#canvas.style.height = `${height}px`
    this.forget()
  }

  /** @param {TimelineView} view */
  draw(view) {
    if (!this.#width || !this.#height) return
    const key = [view.scale, view.lookahead?.version, view.top].join()
    const right = view.left + this.#width / view.scale
    let sheet = this.#sheet
    if (sheet?.key !== key || view.left < sheet.left || right > sheet.right) sheet = this.#paint(view, key)
    const pen = this.#pen
    pen.setTransform(1, 0, 0, 1, 0, 0)
    pen.drawImage(sheet.image, Math.round((sheet.left - view.left) * view.scale * this.#ratio), 0)
    pen.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0)
    this.#clipRows(pen, view)
    if (view.lit && view.lookahead) {
      for (const [index, robot] of this.#rows.visible(view, this.#height)) {
        const stretches = view.lookahead.track(robot.name, robot.part)
        const at = view.lookahead.indexAt(stretches, view.beat)
        if (view.silent(robot.name) || !stretches[at] || stretches[at].start > view.beat) continue
        this.#drawItems(pen, this.#rows.inRow(view, index), view.left, this.#rows.y(view, index), robot, shapes(stretches, at, at + 1), true)
      }
    }
    pen.restore()
    this.#drawPlayhead(pen, view)
  }

  /**
   * @param {TimelineView} view
   * @param {string} key
   */
  #paint(view, key) {
    const right = view.left + (this.#width * (1 + SPARE)) / view.scale
    const width = Math.ceil(this.#width * (1 + SPARE) * this.#ratio)
    const canvas = new OffscreenCanvas(width, this.#canvas.height)
    const pen = penOn(canvas, { alpha: false })
    pen.fillStyle = this.#colors.panel
    pen.fillRect(0, 0, canvas.width, canvas.height)
    pen.setTransform(this.#ratio, 0, 0, this.#ratio, 0, 0)
    const { beats, bar, first, scenes, names } = this.#ruler
    const named = scenes.map((beat, index) => ({ beat, number: first + index + 1, name: names[first + index] ?? "" }))
    paintRuler(pen, { ...view, last: Math.min(right, beats ?? Infinity), bar, scenes: named, height: this.#height, colors: this.#colors })
    for (const { beat } of this.meetings) drawMark(pen, { x: (beat - view.left) * view.scale, y: view.head * 0.7 }, this.#colors, 6)
    this.#clipRows(pen, view, 1 + SPARE)
    for (const [index, robot] of this.#rows.visible(view, this.#height)) this.#paintRow(pen, view, right, index, robot)
    pen.restore()
    this.#sheet?.image.close()
    this.#sheet = { image: canvas.transferToImageBitmap(), left: view.left, right, key }
    return this.#sheet
  }

  /**
   * @param {Pen} pen
   * @param {TimelineView} view
   * @param {number} [times]
   */
  #clipRows(pen, { head }, times = 1) {
    pen.save()
    pen.beginPath()
    pen.rect(0, head, this.#width * times, this.#height)
    pen.clip()
  }

  /**
   * @param {Pen} pen
   * @param {TimelineView} whole
   * @param {number} right
   * @param {number} index
   * @param {TimelineRow} robot
   */
  #paintRow(pen, whole, right, index, robot) {
    const view = this.#rows.inRow(whole, index)
    const { lookahead, left, scale, letter } = view
    const y = this.#rows.y(whole, index)
    pen.fillStyle = this.#colors["grid-strong"]
    pen.fillRect(0, Math.round(y + view.row) - 1, this.#width * (1 + SPARE), 1)
    const stretches = lookahead?.track(robot.name, robot.part) ?? []
    const first = lookahead ? lookahead.indexAt(stretches, left) : 0
    let last = first
    while (last < stretches.length && stretches[last].start < right && last - first < MOST_ITEMS) last++
    const items = shapes(stretches, first, last)
    this.#drawItems(pen, view, left, y, robot, items, false)
    pen.textBaseline = "middle"
    pen.textAlign = "left"
    pen.font = `600 ${letter * 0.75}px ${FONT}`
    pen.fillStyle = this.#colors.quiet
    const names = robot.part === null ? labels(stretches, first, last, this.#reader) : [] // no room for them
    names.forEach(({ start, text }, i) => {
      const room = ((names[i + 1]?.start ?? Infinity) - start) * scale - 6
      const fitting = text.split(" › ")
      while (fitting.length && pen.measureText(fitting.join(" › ")).width > room) fitting.pop()
      pen.fillText(fitting.join(" › "), (start - left) * scale + 3, y + view.row * 0.15)
    })
    pen.strokeStyle = this.#colors.ink
    pen.lineWidth = 1.5
    pen.beginPath()
    for (const run of runs(items, this.#reader, (voices) => this.#bracketKey(voices))) {
      const [x, end] = [(run.start - left) * scale + 2, (run.end - left) * scale - 2]
      const bottom = y + view.row - 3
      pen.moveTo(x, bottom - 5)
      pen.lineTo(x, bottom)
      pen.lineTo(end, bottom)
      pen.lineTo(end, bottom - 5)
    }
    pen.stroke()
    for (const { beat, robots } of this.meetings) {
      if (!robot.part && robots.includes(robot.name)) drawMark(pen, { x: (beat - left) * scale, y: y + view.row * 0.55 }, this.#colors)
    }
    this.#paintEnd(pen, view, y, robot)
    this.#paintScenes(pen, view, y, robot)
    if (!robot.part) this.#paintMarks(pen, view, y, robot)
  }

  /**
   * Divides a row into its scenes, and dims what came before its part began.
   * @param {Pen} pen
   * @param {TimelineView} view
   * @param {number} y
   * @param {TimelineRow} robot
   */
  #paintScenes(pen, { left, scale, row }, y, robot) {
    const { begins } = this.#robots[robot.name]
    if (begins > left) {
      const end = (begins - left) * scale
      pen.fillStyle = this.#colors.ground
      pen.fillRect(0, y, end, row - 1)
      pen.fillStyle = robot.color
      pen.fillRect(end - 1.5, y + row * 0.1, 3, row * 0.8)
    }
    pen.fillStyle = this.#colors.ink
    for (const beat of this.#ruler.scenes.slice(1)) pen.fillRect((beat - left) * scale - 1, y, 2, row)
  }

  /**
   * Marks what senses have decided, with the word that asked.
   * @param {Pen} pen
   * @param {TimelineView} view
   * @param {number} y
   * @param {TimelineRow} robot
   */
  #paintMarks(pen, { left, scale, row, letter }, y, robot) {
    pen.font = `700 ${letter * 0.7}px ${FONT}`
    pen.textAlign = "left"
    pen.textBaseline = "middle"
    const own = this.#marks.filter(({ robot: name }) => name === robot.name)
    for (const [index, { beat, sources, held }] of own.entries()) {
      const x = (beat - left) * scale
      if (x < 0) continue
      const [statement, start, end] = sources.at(-1) ?? [-1, 0, 0]
      const offset = this.#offsets[statement]
      const word = offset === undefined ? "" : this.#reader.word([offset + start, offset + end])
      pen.fillStyle = this.#colors.ink
      pen.fillRect(x - 1, y + row * 0.05, 2, row * 0.85)
      const sign = held ? "✓" : "✗"
      const room = ((own[index + 1]?.beat ?? Infinity) - beat) * scale - 8
      const fitting = [`${sign} ${word}`, sign].find((text) => pen.measureText(text).width <= room)
      if (fitting) pen.fillText(fitting, x + 4, y + row * 0.9)
    }
  }

  /**
   * Marks the end of a row, unless it is endless.
   * @param {Pen} pen
   * @param {TimelineView} view
   * @param {number} y
   * @param {TimelineRow} robot
   */
  #paintEnd(pen, { left, scale, row }, y, robot) {
    const { ends } = this.#robots[robot.name]
    if (ends === null) return
    const x = (ends - left) * scale
    pen.fillStyle = robot.color
    pen.fillRect(x - 1.5, y + row * 0.28, 3, row * 0.55)
  }

  /**
   * @param {Pen} pen
   * @param {TimelineView} view
   * @param {number} left
   * @param {number} above
   * @param {TimelineRow} robot
   * @param {Shape[]} items
   * @param {boolean} lit
   */
  #drawItems(pen, view, left, above, robot, items, lit) {
    const { scale, letter, row } = view
    const top = above + row * (robot.part === null ? 0.28 : 0.1)
    const high = row * (robot.part === null ? 0.55 : 0.78)
    items.forEach((item, i) => {
      const { start, end } = item
      const voices = this.#reader.voices(item)
      const x = (start - left) * scale
      const width = (end - start) * scale
      voices.forEach((voice, lane) => {
        const { word, sign, rests, at } = voice
        const tall = high / voices.length
        const y = top + lane * tall
        const gap = width > 4 ? 1 : 0
        pen.fillStyle = mix(this.#colors.panel, robot.color, lit ? 0.95 : rests ? 0.1 : 0.3)
        pen.beginPath()
        const joined = !lit && i > 0 && this.#isHeld(items[i - 1], item, at, lane)
        if (item.parts.length > 1 && voice.axis) this.#trace(pen, item, voice, (beat) => Math.min(Math.max((beat - left) * scale, x + gap), x + width - gap), y + 0.5, tall - 1)
        else pen.roundRect(joined ? x - gap : x + gap, y + 0.5, Math.max(width - (joined ? 0 : gap) - gap, 1), tall - 1, joined ? 0 : Math.min(4, width / 3))
        pen.fill()
        if (joined || width < letter * 0.6) return
        const size = Math.min(letter * 0.82, tall * 0.95)
        pen.font = `600 ${size}px ${FONT}`
        pen.fillStyle = lit ? this.#colors.ground : this.#colors.ink
        pen.textBaseline = "middle"
        pen.textAlign = item.parts.length > 1 ? "center" : "left" // where a shape is highest
        const both = `${sign} ${word}`
        const room = width - 8
        const text = pen.measureText(both).width <= room ? both : sign
        if (text === sign) pen.textAlign = "center"
        pen.fillText(text, pen.textAlign === "center" ? x + width / 2 : x + 5, y + tall / 2 + 0.5)
      })
    })
  }

  /**
   * Traces a voice whose speed changes: as high as it is fast.
   * @param {Pen} pen
   * @param {Shape} item
   * @param {Voice} voice
   * @param {(beat: number) => number} toX
   * @param {number} top
   * @param {number} tall
   */
  #trace(pen, item, voice, toX, top, tall) {
    pen.moveTo(toX(item.start), top + tall)
    for (const [beat, high] of outline(item, voice)) pen.lineTo(toX(beat), top + tall * (1 - Math.max(high, LEAST_HEIGHT)))
    pen.lineTo(toX(item.end), top + tall)
  }

  /**
   * Returns whether a lane holds the word of the previous item while another lane moves on.
   * @param {Shape} before
   * @param {Shape} now
   * @param {number} at
   * @param {number} lane
   */
  #isHeld(before, now, at, lane) {
    const [old, voices] = [this.#reader.voices(before), this.#reader.voices(now)]
    return voices.length > 1 && old[lane]?.at === at && direction(old, voices) === 1
  }

  /** @param {Voice[]} voices */
  #nameKey(voices) {
    return namesOf(voices).map(({ at }) => at).join() || undefined
  }

  /** @param {Voice[]} voices */
  #bracketKey(voices) {
    const opening = voices.map(({ at }) => this.#reader.bracket(at)).find((at) => at !== undefined)
    return opening === undefined ? undefined : `${opening} ${this.#nameKey(voices)}`
  }

  /**
   * @param {Pen} pen
   * @param {TimelineView} view
   */
  #drawPlayhead(pen, { beat, left, scale, letter, head }) {
    const x = Math.min(Math.max((beat - left) * scale, 1), this.#width - 1)
    pen.fillStyle = this.#colors.ink
    pen.fillRect(x - 1, head * 0.3, 2, this.#height)
    pen.beginPath()
    pen.moveTo(x - letter * 0.42, 1)
    pen.lineTo(x + letter * 0.42, 1)
    pen.lineTo(x, head * 0.55)
    pen.fill()
  }
}

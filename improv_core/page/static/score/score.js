// @ts-check
// The text of the program that plays; words light up while they play, in the color of their robot.

import { colors, robotColor } from "../base/colors.js"
import { find } from "../base/elements.js"
import { Highlight } from "../editor/highlight.js"
import { clock } from "./clock.js"
import { partsOf } from "./lookahead.js"
import { program } from "./program.js"

/** @import { Color, Light } from "../editor/highlight.js" */

const MARKS = /(?<comment>#.*)|(?<word>[^\s()[\]|#=$]+)/gu
const MAX_CHARACTERS = 200_000 // characters: beyond, a browser would take long to lay them out

/** The text, where it can only be read. */
export class Score {
  #element = find("score-text")
  #highlight = new Highlight(this.#element)

  /** @param {string} text */
  show(text) {
    const shown = text.slice(0, MAX_CHARACTERS)
    /** @type {Color[]} */
    const marks = []
    for (const { 0: mark, index: start, groups } of shown.matchAll(MARKS)) {
      marks.push({ start, end: start + mark.length, name: groups?.comment ? "comment" : "word" })
    }
    this.#highlight.show(shown, marks, [])
  }

  /**
   * Lights words, given by offset. Scrolls only if none of those that move robots is visible.
   * @param {Map<number, Light>} lights
   */
  light(lights) {
    this.#highlight.light(lights)
    const text = this.#element
    const view = text.getBoundingClientRect()
    if (!view.height || text.scrollHeight <= text.clientHeight) return
    const moving = [...this.#highlight.lit].filter((word) => word.classList.contains("moving")).map((word) => word.getBoundingClientRect())
    const isVisible = moving.some(({ top, bottom }) => top >= view.top && bottom <= view.bottom)
    if (moving.length && !isVisible) text.scrollTop += moving[0].top - view.top - view.height / 3
  }
}

/** Lights the words that play, in the color of the text if several robots play them. */
export class PlayingWords {
  #light
  #lit = ""

  /** @param {(lights: Map<number, Light>) => void} light */
  constructor(light) {
    this.#light = light
  }

  /** Lights everything again: the text has changed, or the colors. */
  forget() {
    this.#lit = ""
  }

  /** Lights what plays now; nothing at the start. */
  show() {
    const lights = clock.atStart ? new Map() : playing()
    const now = JSON.stringify([...lights])
    if (now === this.#lit) return
    this.#lit = now
    this.#light(lights)
  }
}

/** The words that play, by offset. */
function playing() {
  const { current } = program
  const beat = clock.beat()
  /** @type {Map<number, Light>} */
  const lights = new Map()
  const names = Object.keys(current?.score.robots ?? {})
  for (const [index, name] of names.entries()) {
    if (!current || clock.isSilent(name)) continue
    const color = robotColor(index)
    for (const part of partsOf(current.score, name)) {
      const segment = current.at(name, part, beat)
      if (!segment || segment.start > beat) continue
      for (const span of segment.words) {
        const moves = current.text.moves(span)
        for (const at of current.text.wordStarts(span)) {
          lights.set(at, { color: (lights.get(at)?.color ?? color) === color ? color : colors().ink, moves })
        }
      }
    }
  }
  return lights
}

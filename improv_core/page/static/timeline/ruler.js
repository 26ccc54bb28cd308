// @ts-check
// The timeline's ruler: its beats or bars, and the names of its scenes.

import { fillRect, FONT } from "../base/pen.js"
import { formatPosition } from "../score/clock.js"

/** @import { Colors } from "../base/colors.js" */
/** @import { Pen } from "../base/pen.js" */
/** @import { TimelineView } from "./timesheet.js" */
/** @typedef {{ beat: number, number: number, name: string }} Scene counted from 1 */
/**
 * @typedef {Pick<TimelineView, "left" | "scale" | "letter" | "head"> & { bar: number | null, scenes: Scene[], last: number,
 *   height: number, colors: Colors }} Ruler up to a last beat
 */

const MIN_BEAT = 6 // pixels between the lines of beats within a bar

/**
 * Draws lines at beats, or at bars and thinner ones at their beats, and their numbers. With little room, only
 * every second one, fourth, or eighth. Scenes begin with their names.
 * @param {Pen} pen
 * @param {Ruler} ruler
 */
export function paintRuler(pen, ruler) {
  const { left, last, bar, scale, letter, head, height, colors } = ruler
  pen.font = `600 ${letter * 0.8}px ${FONT}`
  const unit = bar ?? 1
  const numbered = (/** @type {number} */ beat) => (bar ? `bar ${beat / bar + 1}` : String(beat + 1))
  const wide = pen.measureText(numbered(unit * Math.ceil(last / unit))).width + letter * 0.8
  const step = unit * 2 ** Math.max(Math.ceil(Math.log2(Math.max(wide, letter * 2.2) / (scale * unit))), 0)
  const xOf = (/** @type {number} */ beat) => Math.round((beat - left) * scale)
  if (bar && step === bar && scale >= MIN_BEAT) {
    pen.fillStyle = colors.grid
    for (let beat = Math.max(Math.floor(left), 0); beat <= last; beat++) pen.fillRect(xOf(beat), head, 1, height)
  }
  const names = namesOf(pen, ruler)
  for (let beat = Math.ceil(left / step - 1) * step; beat <= last; beat += step) {
    const x = xOf(beat)
    fillRect(pen, colors["grid-strong"], x, head * 0.55, bar ? 2 : 1, height)
    pen.fillStyle = colors.quiet
    const covered = names.some((name) => x + wide > name.x && x < name.x + name.wide)
    if (beat >= 0 && beat < last && !covered) pen.fillText(numbered(beat), x + 0.5 + letter * 0.3, head * 0.5)
  }
  names.forEach(({ x, wide, text }, index) => {
    fillRect(pen, colors.panel, x, 0, wide, head - 1)
    pen.fillStyle = colors.ink
    if (index) pen.fillRect(x - 1, head * 0.2, 2, head)
    pen.fillText(text, x + letter * 0.3, head * 0.5)
  })
}

/**
 * The names of scenes that have room, and their places in pixels; none for a single scene without one.
 * @param {Pen} pen
 * @param {Ruler} ruler
 */
function namesOf(pen, { left, bar, scenes, scale, letter }) {
  if (scenes.every(({ number, name }) => number === 1 && !name)) return []
  return scenes.flatMap(({ beat, number, name }, index) => {
    const room = ((scenes[index + 1]?.beat ?? Infinity) - beat) * scale
    const shown = name || `scene ${number}`
    const texts = [`${bar ? formatPosition(beat, bar) : beat + 1} · ${shown}`, shown]
    const labels = texts.map((text) => ({ x: (beat - left) * scale, wide: pen.measureText(text).width + letter * 0.8, text }))
    const fitting = labels.find(({ wide }) => wide <= room)
    return fitting ? [fitting] : []
  })
}

// @ts-check
// Draws a row of the timeline: the items of a robot, or of one of its body parts, and the marks on them.

import { colors, mix } from "../base/colors.js"
import { fillRect, FONT } from "../base/pen.js"
import { drawMark } from "../floor/meetings.js"
import { direction, itemsOf, labels, namesOf, outline, runs } from "./items.js"

/** @import { Item } from "./items.js" */
/** @import { Lookahead } from "../score/lookahead.js" */
/** @import { Meeting } from "../floor/meetings.js" */
/** @import { Pen } from "../base/pen.js" */
/** @import { ProgramText, Voice } from "../score/program-text.js" */
/** @import { RowPlace, TimelineView } from "./timesheet.js" */
/** @typedef {TimelineView & RowPlace & { pen: Pen, current: Lookahead }} Row with all that is needed to draw it */

const MAX_ITEMS = 600 // per row: more would be finer than pixels
const MIN_HEIGHT = 0.12 // of a lane, so that a robot that is about to stop is seen

/**
 * Draws all of a row, up to a beat.
 * @param {Row} place
 * @param {number} right
 * @param {Meeting[]} meetings
 * @param {Messages["decided"][]} decisions
 */
export function paintRow(place, right, meetings, decisions) {
  const { pen, current, robot, left, scale, letter, y, row } = place
  fillRect(pen, colors()["grid-strong"], 0, Math.round(y + row) - 1, (right - left) * scale, 1)
  const segments = current.track(robot.name, robot.part)
  const first = current.indexAt(segments, left)
  let last = first
  while (last < segments.length && segments[last].start < right && last - first < MAX_ITEMS) last++
  const items = itemsOf(segments, first, last)
  drawItems(place, items, false)
  pen.font = `600 ${letter * 0.75}px ${FONT}`
  pen.fillStyle = colors().quiet
  const names = robot.part === null ? labels(segments, first, last, current.text) : [] // no room for them
  names.forEach(({ start, text }, i) => {
    const room = ((names[i + 1]?.start ?? Infinity) - start) * scale - 6
    const fitting = text.split(" › ")
    while (fitting.length && pen.measureText(fitting.join(" › ")).width > room) fitting.pop()
    pen.fillText(fitting.join(" › "), (start - left) * scale + 3, y + row * 0.15)
  })
  pen.strokeStyle = colors().ink
  pen.lineWidth = 1.5
  pen.beginPath()
  for (const run of runs(items, current.text, (voices) => bracketKey(current.text, voices))) {
    const [x, end] = [(run.start - left) * scale + 2, (run.end - left) * scale - 2]
    const bottom = y + row - 3
    pen.moveTo(x, bottom - 5)
    pen.lineTo(x, bottom)
    pen.lineTo(end, bottom)
    pen.lineTo(end, bottom - 5)
  }
  pen.stroke()
  for (const { beat, robots } of meetings) {
    if (!robot.part && robots.includes(robot.name)) drawMark(pen, { x: (beat - left) * scale, y: y + row * 0.55 })
  }
  paintEnds(place)
  if (!robot.part) paintDecisions(place, decisions)
}

/**
 * Divides a row into its scenes, dims what came before its part began, and marks its end, unless it is endless.
 * @param {Row} place
 */
function paintEnds({ pen, current, robot: { name, color }, left, scale, y, row }) {
  const { begins, ends } = current.score.robots[name]
  if (ends !== null) {
    fillRect(pen, color, (ends - left) * scale - 1.5, y + row * 0.28, 3, row * 0.55)
  }
  if (begins > left) {
    const end = (begins - left) * scale
    fillRect(pen, colors().ground, 0, y, end, row - 1)
    fillRect(pen, color, end - 1.5, y + row * 0.1, 3, row * 0.8)
  }
  pen.fillStyle = colors().ink
  for (const beat of current.score.scenes.slice(1)) pen.fillRect((beat - left) * scale - 1, y, 2, row)
}

/**
 * Marks what senses have decided, with the word that asked.
 * @param {Row} place
 * @param {Messages["decided"][]} decisions
 */
function paintDecisions({ pen, current, robot, left, scale, letter, y, row }, decisions) {
  pen.font = `700 ${letter * 0.7}px ${FONT}`
  const own = decisions.filter(({ robot: name }) => name === robot.name)
  for (const [index, { beat, sources, held }] of own.entries()) {
    const x = (beat - left) * scale
    if (x < 0) continue
    const word = sources.slice(-1).flatMap((source) => current.spans(source)).map((span) => current.text.word(span)).join("")
    fillRect(pen, colors().ink, x - 1, y + row * 0.05, 2, row * 0.85)
    const sign = held ? "✓" : "✗"
    const room = ((own[index + 1]?.beat ?? Infinity) - beat) * scale - 8
    const fitting = [`${sign} ${word}`, sign].find((text) => pen.measureText(text).width <= room)
    if (fitting) pen.fillText(fitting, x + 4, y + row * 0.9)
  }
}

/**
 * Draws the words of items, in a lane for each voice.
 * @param {Row} place
 * @param {Item[]} items
 * @param {boolean} lit whether they play
 */
export function drawItems({ pen, current, robot, left, scale, letter, y: above, row }, items, lit) {
  const words = current.text
  const top = above + row * (robot.part === null ? 0.28 : 0.1)
  const high = row * (robot.part === null ? 0.55 : 0.78)
  items.forEach((item, i) => {
    const { start, end } = item
    const voices = words.voices(item)
    const x = (start - left) * scale
    const width = (end - start) * scale
    voices.forEach((voice, lane) => {
      const { word, sign, rests, at } = voice
      const tall = high / voices.length
      const y = top + lane * tall
      const gap = width > 4 ? 1 : 0
      pen.fillStyle = mix(colors().panel, robot.color, lit ? 0.95 : rests ? 0.1 : 0.3)
      pen.beginPath()
      const joined = !lit && i > 0 && isHeld(words.voices(items[i - 1]), voices, at, lane)
      if (item.parts.length > 1 && voice.axis) trace(pen, item, voice, (beat) => Math.min(Math.max((beat - left) * scale, x + gap), x + width - gap), y + 0.5, tall - 1)
      else pen.roundRect(joined ? x - gap : x + gap, y + 0.5, Math.max(width - (joined ? 0 : gap) - gap, 1), tall - 1, joined ? 0 : Math.min(4, width / 3))
      pen.fill()
      if (joined || width < letter * 0.6) return
      const size = Math.min(letter * 0.82, tall * 0.95)
      pen.font = `600 ${size}px ${FONT}`
      pen.fillStyle = lit ? colors().ground : colors().ink
      const [head] = word.split(" ") // without its measure
      const text = [`${sign} ${word}`, `${sign} ${head}`].find((each) => pen.measureText(each).width <= width - 8) ?? sign
      const centers = text === sign || item.parts.length > 1 // where a shape is highest
      pen.fillText(text, centers ? x + (width - pen.measureText(text).width) / 2 : x + 5, y + tall / 2 + 0.5)
    })
  })
}

/**
 * Traces a voice whose speed changes: as high as it is fast.
 * @param {Pen} pen
 * @param {Item} item
 * @param {Voice} voice
 * @param {(beat: number) => number} toX
 * @param {number} top
 * @param {number} tall
 */
function trace(pen, item, voice, toX, top, tall) {
  pen.moveTo(toX(item.start), top + tall)
  for (const [beat, high] of outline(item, voice)) pen.lineTo(toX(beat), top + tall * (1 - Math.max(high, MIN_HEIGHT)))
  pen.lineTo(toX(item.end), top + tall)
}

/**
 * Returns whether a lane holds the word of the previous item while another lane moves on.
 * @param {Voice[]} before
 * @param {Voice[]} now
 * @param {number} at
 * @param {number} lane
 */
function isHeld(before, now, at, lane) {
  return now.length > 1 && before[lane]?.at === at && direction(before, now) === 1
}

/** @param {ProgramText} words @param {Voice[]} voices */
function bracketKey(words, voices) {
  const opening = voices.map(({ at }) => words.bracket(at)).find((at) => at !== undefined)
  const names = namesOf(voices).map(({ at }) => at).join() || undefined
  return opening === undefined ? undefined : `${opening} ${names}`
}

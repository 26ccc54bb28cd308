// @ts-check
// The items of the timeline: the words that play, and the names and brackets around them.

import { AXES } from "../score/program-text.js"

/** @import { Segment } from "../score/lookahead.js" */
/** @import { ProgramText, Voice } from "../score/program-text.js" */
/** @typedef {Pick<Segment, "start" | "end" | "velocity" | "words"> & { parts: Segment[] }} Item segments of one word, at changing speeds */
/** @typedef {{ key: string, start: number, end: number, voices: Voice[], way: number }} Run */
/** @typedef {{ start: number, text: string }} Label the names of phrases that begin at a beat */

const BEFORE = 20 // segments to the left whose names may reach into view

/**
 * The items of the segments from index `first` up to `last`, whole: a ramp plays a word in many segments, each at
 * another speed. At the same speed, the word plays again.
 * @param {Segment[]} segments
 * @param {number} first
 * @param {number} last
 */
export function itemsOf(segments, first, last) {
  while (first > 0 && first < segments.length && goesOn(segments[first - 1], segments[first])) first--
  /** @type {Item[]} */
  const found = []
  for (let i = first; i < segments.length; i++) {
    const item = found.at(-1)
    const segment = segments[i]
    if (item && goesOn(segments[i - 1], segment)) {
      item.parts.push(segment)
      item.end = segment.end
    } else if (i >= last) break
    else found.push({ start: segment.start, end: segment.end, velocity: segment.velocity, words: segment.words, parts: [segment] })
  }
  return found
}

/** Returns whether the same words keep playing, at another speed. @param {Segment} before @param {Segment} now */
function goesOn(before, now) {
  const same = before.words.length === now.words.length && now.words.every(([at], i) => at === before.words[i][0])
  return same && AXES.some((axis) => Math.abs(now.velocity[axis] - before.velocity[axis]) > 1e-9)
}

/**
 * The upper edge of a voice in an item: beats, and how fast it is there, as part of its fastest. Between the middles of
 * two steps it is straight.
 * @param {Item} item
 * @param {Pick<Voice, "axis">} voice
 * @returns {[beat: number, high: number][]}
 */
export function outline({ start, end, parts }, { axis }) {
  const speeds = parts.map(({ velocity }) => (axis ? Math.abs(velocity[axis]) : 1))
  const most = Math.max(...speeds) || 1
  const long = parts.map((part) => part.end - part.start)
  /** @type {[number, number][]} */
  const points = parts.flatMap((part, i) => {
    const [left, right] = [i - 1, i + 1].map((other) => Math.min(long[i], long[other] ?? long[i]) / 2)
    const high = speeds[i] / most
    const [from, to] = [part.start + left, part.end - right]
    return to - from > 1e-9 ? [[from, high], [to, high]] : [[from, high]]
  })
  const edge = (/** @type {number} */ beat, /** @type {number[]} */ [one, high], /** @type {number[]} */ [other, next] = [one, high]) =>
    Math.min(Math.max(one === other ? high : high + ((next - high) / (other - one)) * (beat - one), 0), 1)
  return [[start, edge(start, points[0], points[1])], ...points, [end, edge(end, points[points.length - 1], points[points.length - 2])]]
}

/**
 * Groups of items: for each run with the same key (undefined: none) its start, end and key. A run ends
 * where its words start over, as in a repeat.
 * @param {Item[]} items
 * @param {ProgramText} program
 * @param {(voices: Voice[]) => string | undefined} keyOf
 */
export function runs(items, program, keyOf) {
  /** @type {Run[]} */
  const found = []
  /** @type {Run | null} */
  let run = null
  for (const item of items) {
    const voices = program.voices(item)
    const key = voices.length ? keyOf(voices) : undefined
    const way = run && run.key === key ? direction(run.voices, voices) : 0
    if (run && way !== 0 && (run.way === 0 || run.way === way)) {
      Object.assign(run, { end: item.end, voices, way })
    } else {
      run = key === undefined ? null : { key, start: item.start, end: item.end, voices, way: 0 }
      if (run) found.push(run)
    }
  }
  return found
}

/**
 * The names of phrases, each where it begins, and not again where something within it repeats or ends.
 * @param {Segment[]} segments
 * @param {number} first
 * @param {number} last
 * @param {ProgramText} program
 * @returns {Label[]}
 */
export function labels(segments, first, last, program) {
  /** @type {Label[]} */
  const found = []
  const from = Math.max(first - BEFORE, 0)
  /** @type {Voice["names"]} */
  let before = []
  for (let i = from; i < last; i++) {
    const voices = program.voices(segments[i])
    const names = voices.length ? namesOf(voices) : []
    let same = 0
    while (same < names.length && names[same].at === before[same]?.at) same++
    const text = names.slice(same).map(({ word }) => word).join(" › ")
    if (text && (i > from || i === 0)) found.push({ start: segments[i].start, text })
    before = names
  }
  return found
}

/**
 * 1 if voices move forward in the text, -1 if backward, 0 if neither, because something else begins.
 * @param {Voice[]} before
 * @param {Voice[]} now
 */
export function direction(before, now) {
  if (before.length !== now.length) return 0
  const steps = now.map(({ at }, i) => Math.sign(at - before[i].at))
  if (steps.every((step) => step >= 0) && steps.includes(1)) return 1
  return steps.every((step) => step <= 0) && steps.includes(-1) ? -1 : 0
}

/**
 * The names by which all voices are used, outermost first. A name that stands for several voices is listed with the
 * first of them only.
 * @param {Voice[]} voices
 */
export function namesOf([first, ...others]) {
  return first.names.filter(({ at }, i) => others.every(({ names }) => !names.length || names[i]?.at === at))
}

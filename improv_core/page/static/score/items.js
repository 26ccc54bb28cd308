// @ts-check
// The items of the timeline: the words that play in a stretch, by voice, and the names and brackets around them.

// Signs for words: for each axis that of a positive and that of a negative velocity.
/** @import { Stretch } from "./lookahead.js" */
/** @import { Velocity } from "../base/path.js" */
/** @typedef {Record<string, number[]>} Words the words that move robots: x, y, z, yaw */
/** @typedef {Pick<Stretch, "start" | "end" | "velocity" | "words"> & { parts: Stretch[] }} Shape stretches of one word, at changing speeds */
/** @typedef {{ word: string, sign: string, rests: boolean, axis?: Axis, at: number, names: { word: string, at: number }[] }} Voice */
/** @typedef {"x" | "y" | "z" | "yaw"} Axis */
/** @typedef {{ key: string, start: number, end: number, voices: Voice[], way: number }} Run */
/** @typedef {{ start: number, text: string }} Label the names of phrases that begin at a beat */

const SIGNS = { x: ["↑", "↓"], y: ["←", "→"], z: ["⤒", "⤓"], yaw: ["↰", "↱"] }
const HALF_TURNS = ["↖", "↗"]
const REST = "·"
const POSE = "⇢"
const CHANCE = "chance" // in the place of what dice have left out
const BEFORE = 20 // stretches to the left whose names may reach into view
const AXES = /** @type {const} */ (["x", "y", "z", "yaw"])

/** Reads a program's text by code points, as the server counts. */
export class CodePointReader {
  #points
  #words
  /** @type {Map<number, number> | null} */
  #brackets = null
  /** @type {WeakMap<Pick<Stretch, "words" | "velocity">, Voice[]>} */
  #known = new WeakMap()

  /**
   * `words` are those that move robots, each with its velocity.
   * @param {string} text
   * @param {Words} words
   */
  constructor(text, words) {
    this.#points = Array.from(text)
    this.#words = words
  }

  /** @param {number[]} span */
  word([start, end]) {
    return this.#points.slice(start, end).join("")
  }

  /**
   * The voices of a stretch: for each its word, and the names by which it is used. A stretch lists for each voice first
   * the names, then the word.
   * @param {Pick<Stretch, "words" | "velocity">} stretch
   */
  voices(stretch) {
    let voices = this.#known.get(stretch)
    if (!voices) {
      voices = []
      /** @type {Voice["names"]} */
      let names = []
      for (const span of stretch.words) {
        const word = this.word(span)
        if (word === CHANCE) {
          voices.push({ word, sign: REST, rests: true, at: span[0], names })
          names = []
        } else if (wordStarts(this.#points, span).length > 1) {
          voices.push({ word, sign: POSE, rests: false, at: span[0], names }) // such as `to high`
          names = []
        } else if (Object.hasOwn(this.#words, word)) {
          const [x, y, z, yaw] = this.#words[word]
          voices.push({ word, ...drawn({ x, y, z, yaw }, stretch.velocity), at: span[0], names })
          names = []
        } else names.push({ word, at: span[0] })
      }
      this.#known.set(stretch, voices)
    }
    return voices
  }

  /**
   * The offset of the innermost `[` around an offset, or undefined.
   * @param {number} at
   */
  bracket(at) {
    this.#brackets ??= brackets(this.#points)
    return this.#brackets.get(at)
  }
}

/**
 * The starts of the words in a span: a pose has two, everything else one.
 * @param {string[]} points of the text
 * @param {number[]} span
 */
export function wordStarts(points, [start, end]) {
  const found = []
  for (let at = start; at < end; at++) if (/\S/.test(points[at]) && (at === start || /\s/.test(points[at - 1]))) found.push(at)
  return found
}

/**
 * The drawing of a word's velocity where it makes the velocity `here`: that may be reflected or retraced.
 * @param {Velocity} velocity
 * @param {Velocity} here
 */
function drawn(velocity, here) {
  const axis = AXES.find((each) => velocity[each] !== 0)
  if (!axis) return { sign: REST, rests: true }
  const signs = axis === "yaw" && Math.abs(velocity.yaw) < 1 ? HALF_TURNS : SIGNS[axis]
  const mirrored = here[axis] * velocity[axis] < 0
  return { sign: signs[velocity[axis] > 0 === mirrored ? 1 : 0], rests: false, axis }
}

/**
 * The offset of the innermost `[` for each offset within brackets.
 * @param {string[]} points
 */
function brackets(points) {
  const found = new Map()
  /** @type {number[]} */
  const open = []
  for (let i = 0; i < points.length; i++) {
    const sign = points[i]
    if (sign === "#") while (i + 1 < points.length && points[i + 1] !== "\n") i++
    else if (sign === "[") open.push(i)
    else if (sign === "]") open.pop()
    else if (open.length && !/\s/.test(sign)) found.set(i, open[open.length - 1])
  }
  return found
}

/**
 * The shapes of the stretches from index `first` up to `last`, whole: a ramp plays a word in many stretches, each at
 * another speed. At the same speed, the word plays again.
 * @param {Stretch[]} stretches
 * @param {number} first
 * @param {number} last
 */
export function shapes(stretches, first, last) {
  while (first > 0 && first < stretches.length && goesOn(stretches[first - 1], stretches[first])) first--
  /** @type {Shape[]} */
  const found = []
  for (let i = first; i < stretches.length; i++) {
    const shape = found.at(-1)
    const stretch = stretches[i]
    if (shape && goesOn(stretches[i - 1], stretch)) {
      shape.parts.push(stretch)
      shape.end = stretch.end
    } else if (i >= last) break
    else found.push({ start: stretch.start, end: stretch.end, velocity: stretch.velocity, words: stretch.words, parts: [stretch] })
  }
  return found
}

/**
 * Returns whether the same words keep playing, at another speed.
 * @param {Stretch} before
 * @param {Stretch} now
 */
function goesOn(before, now) {
  const same = before.words.length === now.words.length && now.words.every(([at], i) => at === before.words[i][0])
  return same && AXES.some((axis) => Math.abs(now.velocity[axis] - before.velocity[axis]) > 1e-9)
}

/**
 * The upper edge of a voice in a shape: beats, and how fast it is there, as part of its fastest. Between the middles of
 * two steps it is straight.
 * @param {Shape} shape
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
 * Groups of shapes: for each run with the same key (undefined: none) its start, end and key. A run ends
 * where its words start over, as in a repeat.
 * @param {Shape[]} shapes
 * @param {CodePointReader} reader
 * @param {(voices: Voice[]) => string | undefined} keyOf
 */
export function runs(shapes, reader, keyOf) {
  /** @type {Run[]} */
  const found = []
  /** @type {Run | null} */
  let run = null
  for (const shape of shapes) {
    const voices = reader.voices(shape)
    const key = voices.length ? keyOf(voices) : undefined
    const way = run && run.key === key ? direction(run.voices, voices) : 0
    if (run && way !== 0 && (run.way === 0 || run.way === way)) {
      Object.assign(run, { end: shape.end, voices, way })
    } else {
      run = key === undefined ? null : { key, start: shape.start, end: shape.end, voices, way: 0 }
      if (run) found.push(run)
    }
  }
  return found
}

/**
 * The names of phrases, each where it begins, and not again where something within it repeats or ends.
 * @param {Stretch[]} stretches
 * @param {number} first
 * @param {number} last
 * @param {CodePointReader} reader
 * @returns {Label[]}
 */
export function labels(stretches, first, last, reader) {
  /** @type {Label[]} */
  const found = []
  const from = Math.max(first - BEFORE, 0)
  /** @type {Voice["names"]} */
  let before = []
  for (let i = from; i < last; i++) {
    const voices = reader.voices(stretches[i])
    const names = voices.length ? namesOf(voices) : []
    let same = 0
    while (same < names.length && names[same].at === before[same]?.at) same++
    const text = names.slice(same).map(({ word }) => word).join(" › ")
    if (text && (i > from || i === 0)) found.push({ start: stretches[i].start, text })
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

// @ts-check
// The messages of the server. Anything that does not fit is dropped.

/** @template T @typedef {(value: unknown) => value is T} Check */
/** @template C @typedef {C extends Check<infer T> ? T : never} Checked */
/** @typedef {{ [K in keyof typeof MESSAGES]: { type: K } & Checked<(typeof MESSAGES)[K]> }} Messages by their types */
/** @typedef {Messages[keyof Messages]} Message */

/** @type {(test: (value: unknown) => boolean) => Check<any>} */
const asCheck = (test) => /** @type {Check<any>} */ (test)
/** @type {Check<number>} */
const number = (value) => typeof value === "number" && Number.isFinite(value)
/** @type {Check<number>} */
const positive = (value) => number(value) && value > 0
/** @type {Check<number>} */
const count = (value) => number(value) && Number.isInteger(value) && value >= 0
/** @type {Check<string>} */
const text = (value) => typeof value === "string"
/** @type {Check<boolean>} */
const flag = (value) => typeof value === "boolean"
/** @type {Check<Record<string, unknown>>} */
const object = (value) => typeof value === "object" && value !== null && !Array.isArray(value)
/** @type {<T>(check: Check<T>) => Check<T | null>} */
const nullOr = (check) => (value) => value === null || check(value)
/** @type {<T>(check: Check<T>) => Check<T | undefined>} */
const maybe = (check) => (value) => value === undefined || check(value)
/** @type {<T>(check: Check<T>) => Check<T[]>} */
const listOf = (check) => (value) => Array.isArray(value) && value.every(check)
/** @type {<T>(check: Check<T>) => Check<Record<string, T>>} */
const mapOf = (check) => asCheck((value) => object(value) && Object.values(value).every(check))
/** @type {<T extends Record<string, Check<any>>>(checks: T) => Check<{ [K in keyof T]: Checked<T[K]> }>} */
const shape = (checks) =>
  asCheck((value) => object(value) && Object.entries(checks).every(([key, check]) => check(value[key])))
/** @type {(length: number) => Check<number[]>} */
const numbers = (length) => asCheck((value) => listOf(number)(value) && value.length === length)
/** @type {<T extends string>(...values: T[]) => Check<T>} */
const oneOf = (...values) => asCheck((value) => values.some((each) => each === value))

const pose = shape({ x: number, y: number, z: number, heading: number })
/** @type {Check<[statement: number, start: number, end: number]>} */
const word = (value) => listOf(count)(value) && value.length === 3
/** @type {Check<[start: number, beats: number, x: number, y: number, z: number, yaw: number, words: Checked<typeof word>[]]>} */
const moment = (value) =>
  Array.isArray(value) && value.length === 7 && value.slice(0, 6).every(number) && value[1] > 0 && listOf(word)(value[6])

const edit = shape({ start: count, end: count, text })
const problem = shape({
  start: count,
  end: count,
  file: text,
  line: count,
  severity: text,
  message: text,
  fixes: listOf(shape({ title: text, kind: text, edits: listOf(edit) })),
})

const joint = shape({
  name: text,
  axis: oneOf("x", "y", "z", "yaw"),
  sign: number,
  slides: flag,
  min: nullOr(number),
  max: nullOr(number),
  start: number,
})

const look = {
  profile: text,
  radius: number,
  motions: listOf(text),
  body: listOf(shape({ name: text, joints: listOf(joint), moves: flag })),
}

const paths = shape({
  number: count,
  robots: mapOf(nullOr(shape({ start: numbers(3), strokes: listOf(numbers(6)), certain: count, look: shape(look) }))),
  problem: text,
  waits_for: listOf(text),
})

const bone = shape({
  joint: text,
  carrier: number,
  place: numbers(3),
  turn: numbers(3),
  axis: numbers(3),
  way: oneOf("turns", "slides", "stays"),
  rest: number,
  follows: nullOr(text),
  ratio: number,
  shift: number,
})

const MESSAGES = {
  time: shape({ wall: number }),
  robots: shape({ robots: mapOf(shape({ radius: number, joints: listOf(text) })) }),
  trails: shape({ placed: count, robots: mapOf(shape({ from: count, places: listOf(numbers(4)) })) }),
  measured: shape({ robots: mapOf(shape({ from: count, places: listOf(numbers(13)) })) }),
  program: shape({
    name: text,
    folder: text,
    problems: listOf(shape({ file: text, line: count, column: count, word: text, message: text })),
    count,
    names: maybe(mapOf(text)),
  }),
  poses: shape({ at: number, placed: count, poses: listOf(numbers(4)), joints: mapOf(listOf(number)) }),
  transport: shape({
    generation: count,
    restarted: count,
    state: oneOf("stopped", "waiting", "playing", "paused", "ended"),
    tempo: positive,
    beats: nullOr(number),
    beat: number,
    wall: number,
    performed: number,
    speed: maybe(number),
    muted: maybe(listOf(text)),
    soloed: maybe(listOf(text)),
    backend: maybe(text),
    behind: maybe(number),
    poses: maybe(mapOf(pose)),
  }),
  score: shape({
    generation: count,
    tempo: positive,
    scene: count,
    scenes: listOf(number),
    scene_names: listOf(text),
    bar: nullOr(count),
    beats: nullOr(number),
    text,
    takes_start_poses: flag,
    deadman: nullOr(shape({ button: count })),
    music: nullOr(shape({ file: text, first_beat: number, volume: number })),
    offsets: mapOf(count),
    words: mapOf(numbers(4)),
    robots: mapOf(
      shape({
        ...look,
        dynamics: text,
        speeds: numbers(2),
        start_pose: numbers(4),
        begins: number,
        ends: nullOr(number),
        senses: mapOf(object),
        near: number,
      }),
    ),
    skeletons: mapOf(listOf(bone)),
    world: nullOr(
      shape({
        size: nullOr(numbers(2)),
        walls: listOf(numbers(4)),
        circles: listOf(shape({ x: number, y: number, radius: number })),
        boxes: listOf(shape({ x: number, y: number, width: number, height: number, heading: number })),
      }),
    ),
  }),
  window: shape({
    generation: count,
    from: number,
    to: number,
    robots: mapOf(shape({ pose: nullOr(numbers(4)), moments: listOf(moment), body: mapOf(listOf(moment)), until: number })),
  }),
  misplaced: shape({
    generation: count,
    waits: flag,
    robots: mapOf(shape({ place: pose, pose: nullOr(pose), line: text })),
  }),
  armed: shape({ generation: count, armed: flag, begins: nullOr(number), count: maybe(shape({ beats: count, period: positive })) }),
  meetings: shape({
    generation: count,
    from: number,
    to: number,
    all: flag,
    assumes: flag,
    meetings: listOf(shape({ robots: listOf(text), beat: number, distance: number, more: count, poses: listOf(numbers(4)) })),
    hits: listOf(shape({ robot: text, thing: text, beat: number, pose: numbers(4) })),
  }),
  bumps: shape({ past: flag, bumps: listOf(shape({ at: number, x: number, y: number, robots: listOf(text), thing: text })) }),
  sensed: shape({ generation: count, robot: text, sense: text, value: nullOr(flag), beat: number }),
  fault: shape({ generation: count, robot: text, fault: text, over: flag, response: text, message: text, line: text }),
  why_still: shape({ line: text, resumes: maybe(shape({ scene: number, beat: number })) }),
  vitals: shape({ generation: count, robots: mapOf(shape({ odom: flag, posed: nullOr(number), battery: nullOr(number), instead: oneOf("", "stands", "drives back") })) }),
  link: shape({ host: text, offset: number, error: number, round_trip: number, lag: number }),
  joints: shape({ generation: count, robot: text, positions: mapOf(number) }),
  decided: shape({ generation: count, robot: text, sources: listOf(word), held: flag, beat: number }),
  stopped: shape({ message: maybe(text) }),
  source: shape({ path: text, text, revision: text, toml: text }),
  analyze: shape({ number: count, colors: listOf(count), problems: listOf(problem), count, starts: mapOf(shape({ x: number, y: number, heading: number })) }),
  complete: shape({ number: count, start: count, end: count, words: listOf(shape({ word: text, about: text })) }),
  preview: paths,
  draft: shape({ text, paths }),
  handle: shape({ number: count, offset: count, robot: text, text, place: nullOr(numbers(4)), others: listOf(numbers(4)), pens: mapOf(numbers(2)) }),
  explain: shape({ number: count, start: count, end: count, text, picture: text }),
  write: shape({ number: count, revision: text, problem: text }),
  change: shape({ number: count, edits: listOf(edit), problem: text }),
}

/** The message in a text, or null. @param {string} data @returns {Message | null} */
export function read(data) {
  try {
    const message = JSON.parse(data)
    if (!object(message) || !text(message.type) || !Object.hasOwn(MESSAGES, message.type)) return null
    const kind = /** @type {keyof typeof MESSAGES} */ (message.type)
    return MESSAGES[kind](message) ? /** @type {Message} */ (/** @type {unknown} */ (message)) : null
  } catch {
    return null
  }
}

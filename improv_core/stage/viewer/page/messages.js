// What the server may say. Anything else is dropped: the page shows nothing that it can't make sense of.

const number = (value) => typeof value === "number" && Number.isFinite(value)
const count = (value) => Number.isInteger(value) && value >= 0
const text = (value) => typeof value === "string"
const object = (value) => typeof value === "object" && value !== null && !Array.isArray(value)
const nullOr = (check) => (value) => value === null || check(value)
const maybe = (check) => (value) => value === undefined || check(value)
const listOf = (check) => (value) => Array.isArray(value) && value.every(check)
const mapOf = (check) => (value) => object(value) && Object.values(value).every(check)
const shape = (checks) => (value) => object(value) && Object.entries(checks).every(([key, check]) => check(value[key]))
const numbers = (length) => (value) => listOf(number)(value) && value.length === length
const oneOf = (...values) => (value) => values.includes(value)

const place = shape({ x: number, y: number, z: number, heading: number })
const word = (value) => listOf(count)(value) && value.length === 3
const moment = (value) =>
  Array.isArray(value) && value.length === 7 && value.slice(0, 6).every(number) && value[1] > 0 && listOf(word)(value[6])

const MESSAGES = {
  robots: shape({ robots: mapOf(shape({ radius: number })) }),
  poses: shape({ at: number, placed: count, poses: listOf(numbers(4)) }),
  transport: shape({
    generation: count,
    state: oneOf("stopped", "waiting", "playing", "paused", "ended"),
    tempo: (value) => number(value) && value > 0,
    beats: nullOr(number),
    beat: number,
    wall: number,
    speed: maybe(number),
    muted: maybe(listOf(text)),
    soloed: maybe(listOf(text)),
    backend: maybe(text),
    poses: maybe(mapOf(place)),
  }),
  score: shape({
    generation: count,
    tempo: (value) => number(value) && value > 0,
    beats: nullOr(number),
    text,
    takes_starts: (value) => typeof value === "boolean",
    starts: mapOf(count),
    robots: mapOf(
      shape({
        profile: text,
        dynamics: text,
        radius: number,
        motions: listOf(text),
        start: numbers(4),
        beats: nullOr(number),
      }),
    ),
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
    robots: mapOf(shape({ pose: nullOr(numbers(4)), moments: listOf(moment), until: number })),
  }),
  bumps: shape({ past: (value) => typeof value === "boolean", bumps: listOf(shape({ at: number, x: number, y: number, robots: listOf(text) })) }),
  stopped: shape({ message: maybe(text) }),
}

/** The message in a text of the server's, or null. */
export function read(data) {
  try {
    const message = JSON.parse(data)
    return object(message) && Object.hasOwn(MESSAGES, message.type) && MESSAGES[message.type](message) ? message : null
  } catch {
    return null
  }
}

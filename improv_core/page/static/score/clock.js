// @ts-check
// The position in the score: the latest transport message, advanced by the tempo. There are no messages for beats.

import { clockOffset, withAnswer } from "../net/clock-offset.js"

/** @import { TimeAnswer } from "../net/clock-offset.js" */
/** @typedef {Messages["transport"]} Transport */

export class Clock {
  /** @type {Messages["armed"] | null} */
  armed = null // everything is ready, and waits for a person or a time
  /** @type {Transport} */
  transport = { type: "transport", monotonic: 0, generation: 0, restarted: 0, state: "stopped", beat: 0, beats: 0, tempo: 60, speed: 1, wall: 0, performed: 0, backend: "", behind: 0, muted: [], soloed: [] }

  /** The server's clock minus that of the page's machine, in seconds: over SSH, they are two. */
  #ahead = 0
  /** @type {TimeAnswer[]} */
  #answers = []

  /** A connection begins, perhaps to another server. */
  connect() {
    this.#answers = []
  }

  /** Takes the server's time, which arrives first, but nobody knows how late. @param {Messages["time"]} message */
  takeTime({ wall }) {
    if (this.#answers.length === 0) this.#ahead = wall - Date.now() / 1000
  }

  /** Takes an answer about the server's time, which says more. @param {TimeAnswer} answer */
  takeAnswer(answer) {
    this.#answers = withAnswer(this.#answers, answer)
    this.#ahead = this.ahead - answer.own
  }

  /** By how many seconds the server's Unix time is ahead of the page's `performance.now()`. */
  get ahead() {
    return clockOffset(this.#answers) ?? this.now() - performance.now() / 1000
  }

  /**
   * Takes a transport message. Returns whether playback jumped to another place, such as by a seek or a restart.
   * @param {Messages["transport"]} message
   */
  take(message) {
    const expected = this.beat()
    const { generation } = this.transport
    this.transport = message
    return message.generation !== generation || Math.abs(expected - this.beat()) * (60 / message.tempo) > 0.1
  }

  get playing() {
    return this.transport.state === "playing"
  }

  /** True if nothing plays and the next performance begins at the start. */
  get atStart() {
    return ["stopped", "ended", "waiting"].includes(this.transport.state)
  }

  /** @param {Messages["armed"]} message */
  takeArmed(message) {
    this.armed = message.armed ? message : null
  }

  /** The beats that are counted before beat 0, which is at a Unix time; null if none are. */
  get count() {
    const { begins, count } = this.armed ?? {}
    return begins && count ? { begins, ...count } : null
  }

  /** The beat that is counted now before beat 0, from 1 on, and how much of it has passed; the number is 0 if none is. */
  get counted() {
    return countIn(this.count, this.now())
  }

  /** The server's Unix time, in seconds. */
  now() {
    return Date.now() / 1000 + this.#ahead
  }

  /** Seconds since the latest restart, pauses included. */
  performed() {
    return this.transport.performed + Math.max(this.now() - this.transport.wall, 0)
  }

  /** The position in beats at this moment. */
  beat() {
    const { beat, beats, wall, tempo } = this.transport
    const gone = this.playing ? ((this.now() - wall) * tempo) / 60 : 0
    return Math.min(Math.max(beat + gone, 0), beats ?? Infinity)
  }

  /**
   * The position in beats at a performance time; undefined for one before the latest change, or if nothing plays.
   * @param {number} time
   */
  beatAt(time) {
    const { beat, beats, performed, tempo } = this.transport
    if (!this.playing || time < performed) return undefined
    return Math.min(beat + ((time - performed) * tempo) / 60, beats ?? Infinity)
  }

  /** The number of the last beat, counted from 1; a beat that has only begun counts. */
  get lastBeat() {
    return this.transport.beats === null ? Infinity : Math.max(Math.ceil(this.transport.beats), 1)
  }

  /** The number of the present beat, counted from 1. */
  get countedBeat() {
    return Math.min(Math.floor(this.beat() + 1e-6) + 1, this.lastBeat)
  }

  /** Returns whether a robot stands still while the others play. @param {string} robot */
  isSilent(robot) {
    const { muted, soloed } = this.transport
    return soloed.length > 0 ? !soloed.includes(robot) : muted.includes(robot)
  }
}

/** The time, which is kept only here. */
export const clock = new Clock()

/**
 * The beat that is counted before beat 0, from 1 on, and how much of it has passed; the number is 0 if none is counted.
 * @param {Clock["count"]} count
 * @param {number} now the server's Unix time, in seconds
 */
export function countIn(count, now) {
  if (!count) return { number: 0, passed: 0 }
  const { begins, beats, period } = count
  const left = Math.max((begins - now) / period - 1e-6, 0)
  return left > beats ? { number: 0, passed: 0 } : { number: Math.min(beats - Math.ceil(left) + 1, beats), passed: 1 - (left % 1) }
}

/**
 * A position in words, which count from 1.
 * @param {number} beat whole, from 0
 * @param {number | null} bar how many beats a bar has
 */
export function formatPosition(beat, bar) {
  return bar ? `bar ${Math.floor(beat / bar) + 1}, beat ${(beat % bar) + 1}` : `beat ${beat + 1}`
}

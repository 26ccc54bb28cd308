// @ts-check
// The next part of a score: its segments, fetched from the server piece by piece as time passes.

import { partitionPoint } from "../base/search.js"
import { pointsAlong, poseAfter, poseOf } from "../base/path.js"
import { ProgramText } from "./program-text.js"

/** @import { Pose, Velocity } from "../base/path.js" */
/**
 * @typedef {object} Segment one robot's motion at one velocity
 * @property {number} start in beats
 * @property {number} end in beats
 * @property {number} seconds
 * @property {Velocity} velocity
 * @property {[start: number, end: number][]} words places in the program
 * @property {Pose | null} pose at the start, if it is known
 */

const FETCH_AHEAD = 48 // beats to fetch of an endless score
const SHOW_AHEAD = 24 // beats of it that the stage shows
const KEEP_BEHIND = 8 // past beats to keep
const MIN_PIECE = 16 // beats requested at once; more for few robots, so that the server is busy for 0.1 s at most
const MAX_PIECE = 256 // beats that the server sends at once
const PIECE_WORK = 800 // robots times beats
const MAX_MOMENTS = 40_000 // moments kept
const NEAR = 1e-6 // beats

export class Lookahead {
  #ask
  /** @type {number | null} */
  #asked = null // where the requested piece begins
  #since = 0
  #pause = 0
  #from = 0
  #known = 0 // the beat up to which all paths are known
  #count = 0
  /** @type {number | null} */
  #renewed = null // the beat from which on everything may have changed
  #renews = false // whether the requested piece replaces what is known
  score
  text
  /** @type {Map<string, Segment[]>} */
  robots = new Map() // the moves of their bases
  /** @type {Map<string, Segment[]>} */
  #body = new Map() // the moves of body parts, by robot and part
  version = 0 // changes with what is known

  /**
   * `ask(from, to)` requests a piece from the server.
   * @param {Messages["score"]} score
   * @param {(from: number, to: number) => void} ask
   */
  constructor(score, ask) {
    this.score = score
    this.text = new ProgramText(score.text, score.words)
    this.#ask = ask
  }

  /** Fetches what is needed to show what plays at `beat`. @param {number} beat */
  want(beat) {
    if (this.#asked !== null || performance.now() < this.#pause) return
    if (this.#renewed !== null) {
      this.#known = this.#renewed
      this.#renewed = null
      this.#renews = true
    }
    const end = this.score.beats ?? Infinity
    if (this.#count > MAX_MOMENTS && this.#known <= beat) this.#forget(beat)
    else if (beat < this.#from || beat > this.#known + MIN_PIECE) this.#forget(Math.max(Math.floor(beat) - KEEP_BEHIND, 0))
    const passed = this.score.beats === null && beat - this.#from > 8 * FETCH_AHEAD
    if (passed) this.#forgetBefore(beat - KEEP_BEHIND)
    const horizon = this.score.beats === null ? beat + FETCH_AHEAD : end
    if (this.#known >= Math.min(horizon, end) - NEAR || this.#count > MAX_MOMENTS) return
    this.#asked = this.#known
    this.#since = performance.now()
    const most = this.score.beats === null ? FETCH_AHEAD : MAX_PIECE
    const piece = Math.max(MIN_PIECE, Math.min(Math.floor(PIECE_WORK / Object.keys(this.score.robots).length), most))
    this.#ask(this.#known, Math.min(this.#known + piece, end))
  }

  /**
   * Asks again for everything from shortly before a beat on: senses decide the next moves. Until the answer
   * comes, what is known is shown.
   * @param {number} beat
   */
  renew(beat) {
    this.#renewed = Math.max(Math.floor(beat) - KEEP_BEHIND, 0)
  }

  /** Asks again: the connection was lost, and the answer with it. */
  askAgain() {
    if (this.#renews) this.#renewed = this.#asked
    this.#asked = null
  }

  /** Takes an answer. @param {Messages["window"]} message */
  take({ generation, from, to, robots }) {
    if (generation !== this.score.generation || from !== this.#asked) return
    this.#asked = null
    if (this.#renews) this.#forget(from)
    this.#pause = 2 * performance.now() - this.#since // playing comes first: the server rests as long as it worked
    let reached = to
    for (const [name, { pose, moments, body, until }] of Object.entries(robots)) {
      const { ends } = this.score.robots[name] ?? {}
      if (ends === undefined) continue
      if (moments.length && until < Math.min(to, ends ?? Infinity) - NEAR) reached = Math.min(reached, until)
      this.#add(this.robots, name, pose, moments)
      for (const [part, each] of Object.entries(body)) this.#add(this.#body, keyOf(name, part), null, each)
    }
    this.#known = Math.max(this.#known, reached)
    this.version++
  }

  /** The moves of a robot's base, or of one of its body parts. @param {string} name @param {string | null} part */
  track(name, part) {
    return (part === null ? this.robots.get(name) : this.#body.get(keyOf(name, part))) ?? []
  }

  /**
   * The move at a beat of a robot's base, or of one of its body parts; or undefined.
   * @param {string} name
   * @param {string | null} part
   * @param {number} beat
   */
  at(name, part, beat) {
    const segments = this.track(name, part)
    return segments[this.indexAt(segments, beat)]
  }

  /**
   * The index of the segment that plays at a beat; where none does, the number of segments.
   * @param {Segment[]} segments
   * @param {number} beat
   */
  indexAt(segments, beat) {
    return partitionPoint(segments.length, (i) => segments[i].end <= beat)
  }

  /**
   * The ideal place of a robot at a beat, or null if it is not known.
   * @param {string} name
   * @param {number} beat
   * @returns {Pose | null}
   */
  poseAt(name, beat) {
    const segments = this.robots.get(name)
    if (!segments?.length || beat < segments[0].start - NEAR) return null
    const segment = segments[Math.min(this.indexAt(segments, beat), segments.length - 1)]
    if (!segment.pose) return null
    const part = Math.min(Math.max((beat - segment.start) / (segment.end - segment.start), 0), 1)
    return poseAfter(segment.pose, segment.velocity, segment.seconds * part)
  }

  /** The last beat that the stage shows. @param {number} beat */
  horizon(beat) {
    return this.score.beats ?? Math.ceil(beat / 4) * 4 + SHOW_AHEAD
  }

  /**
   * Points that show how much room all paths take, up to a beat; without paths that senses will end before.
   * @param {number} until
   */
  *points(until) {
    for (const [name, segments] of this.robots) {
      if (Object.keys(this.score.robots[name].senses).length) continue
      if (segments[0]?.pose) yield segments[0].pose
      for (const { start, pose, velocity, seconds } of segments) {
        if (pose && start < until) yield* pointsAlong(pose, velocity, seconds)
      }
    }
  }

  /**
   * @param {Map<string, Segment[]>} tracks
   * @param {string} name
   * @param {number[] | null} pose
   * @param {any[][]} moments
   */
  #add(tracks, name, pose, moments) {
    const segments = tracks.get(name) ?? []
    /** @type {Segment | undefined} */
    let last = segments.at(-1)
    let next = last ? last.pose && poseAfter(last.pose, last.velocity, last.seconds) : pose && poseOf(pose)
    for (const [start, beats, x, y, z, yaw, words] of moments) {
      const end = start + beats
      if (last && end <= last.end + NEAR) continue // this segment was at the end of the piece before, whole
      const velocity = { x, y, z, yaw }
      const seconds = (beats * 60) / this.score.tempo
      last = { start, end, seconds, velocity, pose: next, words: words.flatMap((/** @type {number[]} */ word) => this.spans(word)) }
      next = next && poseAfter(next, velocity, seconds)
      segments.push(last)
      this.#count++
    }
    tracks.set(name, segments)
  }

  /**
   * The place of a word in the program: none if its statement is no longer there.
   * @param {number[]} word its statement, start, and end, as the server counts
   * @returns {[start: number, end: number][]}
   */
  spans([statement, start, end]) {
    const offset = this.score.offsets[statement]
    return offset === undefined ? [] : [[this.text.toUnits(offset + start), this.text.toUnits(offset + end)]]
  }

  /** @param {number} from */
  #forget(from) {
    this.#renews = false
    this.robots.clear()
    this.#body.clear()
    this.#from = this.#known = from
    this.#count = 0
    this.version++
  }

  /** @param {number} beat */
  #forgetBefore(beat) {
    this.#count = 0
    for (const tracks of [this.robots, this.#body]) {
      for (const [name, segments] of tracks) {
        const kept = segments.slice(this.indexAt(segments, beat))
        tracks.set(name, kept)
        this.#count += kept.length
      }
    }
    this.#from = beat
    this.version++
  }
}

/**
 * The body parts that a robot of a score moves, after its base, which is null.
 * @param {Messages["score"]} score
 * @param {string} name
 * @returns {(string | null)[]}
 */
export function partsOf(score, name) {
  const moving = (score.robots[name]?.body ?? []).filter(({ moves }) => moves)
  return [null, ...moving.map((part) => part.name)]
}

/** @param {string} robot @param {string} part */
function keyOf(robot, part) {
  return `${robot} ${part}`
}

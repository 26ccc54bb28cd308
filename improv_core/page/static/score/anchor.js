// @ts-check
// The places of a score's paths in the world. Ideally they begin at the start poses; a program that takes over begins
// where the robots are, and a robot that was pushed or muted continues from where it is.

import { compose, poseOf, transformBetween } from "../base/path.js"

/** @import { Lookahead } from "./lookahead.js" */
/** @import { Pose } from "../base/path.js" */

const CHECK_PERIOD = 0.25 // seconds between two checks
const MAX_OFFSET = 0.1 // meters that a robot may be off its path
const MAX_TURN = 0.3 // radians

export class Anchor {
  /** @type {Map<string, Pose>} */
  #moved = new Map() // robot -> the transform from its ideal pose to its own
  #checked = 0
  version = 0

  /** The robots are at their start poses. */
  clear() {
    this.#moved.clear()
    this.version++
  }

  /** The moves of paths, by robot. */
  get moved() {
    return this.#moved.entries()
  }

  /** The move of a robot's path, or undefined. @param {string} name */
  of(name) {
    return this.#moved.get(name)
  }

  /**
   * Robots are at `poses` at a beat.
   * @param {Lookahead} lookahead
   * @param {Record<string, Pose>} poses
   * @param {number} beat
   */
  set(lookahead, poses, beat) {
    for (const [name, pose] of Object.entries(poses)) this.#check(name, lookahead.poseAt(name, beat), pose, 0.01, 0.01)
  }

  /**
   * Checks now and then whether robots that are at `poses` at a beat are still on their paths.
   * @param {Lookahead} lookahead
   * @param {Record<string, number[]>} poses
   * @param {number} beat
   * @param {number} now
   * @param {(name: string) => boolean} isSilent
   */
  look(lookahead, poses, beat, now, isSilent) {
    if (now - this.#checked < CHECK_PERIOD) return
    this.#checked = now
    for (const [name, pose] of Object.entries(poses)) {
      if (!lookahead.at(name, null, beat) || isSilent(name)) continue
      const ideal = lookahead.poseAt(name, beat)
      this.#check(name, ideal, poseOf(pose), MAX_OFFSET, MAX_TURN)
    }
  }

  /** @param {string} name @param {Pose | null} ideal @param {Pose} pose @param {number} slack @param {number} turn */
  #check(name, ideal, pose, slack, turn) {
    if (!ideal) return
    const before = this.#moved.get(name)
    const expected = before ? compose(before, ideal) : ideal
    const off = Math.hypot(pose.x - expected.x, pose.y - expected.y)
    const turned = 2 * Math.asin(Math.abs(Math.sin((pose.heading - expected.heading) / 2)))
    if (off < slack && turned < turn) return
    this.#moved.set(name, transformBetween(ideal, pose))
    this.version++
  }
}

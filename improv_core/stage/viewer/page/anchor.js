// How the way that a score tells lies in the world. Ideally it begins at the robots' starts; a program that takes over
// begins where they are, and a robot that was pushed or stood still goes on from there.

import { joined, named, shift } from "./path.js"

const CHECKING = 0.25 // seconds between two looks
const SLACK = 0.1 // metres that a robot may be off
const TURN = 0.3 // radians

export class Anchor {
  #moved = new Map() // robot -> what takes its ideal pose to its own
  #checked = 0
  version = 0

  /** The robots are at their starts. */
  clear() {
    this.#moved.clear()
    this.version++
  }

  /** How a robot's way is moved, or undefined. */
  of(name) {
    return this.#moved.get(name)
  }

  /** Robots are at `poses` at a beat. */
  set(outlook, poses, beat) {
    for (const [name, pose] of Object.entries(poses)) this.#check(name, outlook.poseAt(name, beat), pose, 0.01, 0.01)
  }

  /** Looks now and then whether robots that are at `poses`, as messages have them, at a beat are still on their ways. */
  look(outlook, poses, beat, now, isSilent) {
    if (now - this.#checked < CHECKING) return
    this.#checked = now
    for (const [name, pose] of Object.entries(poses)) {
      if (!outlook.at(name, beat) || isSilent(name)) continue
      const ideal = outlook.poseAt(name, beat)
      this.#check(name, ideal, named(pose), SLACK, TURN)
    }
  }

  #check(name, ideal, pose, slack, turn) {
    if (!ideal) return
    const before = this.#moved.get(name)
    const expected = before ? joined(before, ideal) : ideal
    const off = Math.hypot(pose.x - expected.x, pose.y - expected.y)
    const turned = 2 * Math.asin(Math.abs(Math.sin((pose.heading - expected.heading) / 2)))
    if (off < slack && turned < turn) return
    this.#moved.set(name, shift(ideal, pose))
    this.version++
  }
}

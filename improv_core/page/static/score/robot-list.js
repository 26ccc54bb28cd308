// @ts-check
// The robots: those of the score in its order, then others that are still there.

import { robotColor } from "../base/colors.js"
import { kindOf } from "../floor/robots.js"
import { program } from "./program.js"

/** @import { Segment } from "./lookahead.js" */
/** @typedef {RobotList["all"][number]} Robot */

export const RADIUS = 0.3 // meters, until the stage says otherwise

export class RobotList {
  /** @type {Map<string, number>} */
  #radii = new Map() // in the order of poses
  /** @type {Map<string, string[]>} */
  #joints = new Map() // of each robot, in the order of positions
  /** @type {string[]} */
  previewed = [] // robots of the text as it stands

  /** @param {Messages["robots"]} message */
  take({ robots }) {
    this.#radii = new Map(Object.entries(robots).map(([name, { radius }]) => [name, radius]))
    this.#joints = new Map(Object.entries(robots).map(([name, { joints }]) => [name, joints]))
  }

  get names() {
    return [...this.#radii.keys()]
  }

  /** Poses by robot, or null if they are of other robots. @param {number[][]} poses in the order of the robots */
  named(poses) {
    const { names } = this
    return names.length === poses.length ? Object.fromEntries(names.map((name, index) => [name, poses[index]])) : null
  }

  /** The positions of joints by robot and name. @param {Record<string, number[]>} positions */
  posed(positions) {
    return Object.fromEntries(
      Object.entries(positions).map(([name, each]) => {
        const joints = this.#joints.get(name) ?? []
        return [name, Object.fromEntries(each.map((position, index) => [joints[index], position]))]
      }),
    )
  }

  /** The color of a robot of the score, of the stage, or of the paths of a text that doesn't play yet. @param {string} name */
  colorOf(name) {
    return robotColor(Math.max([...new Set([...this.#all, ...this.previewed])].indexOf(name), 0))
  }

  get #all() {
    return [...new Set([...Object.keys(program.current?.score.robots ?? {}), ...this.#radii.keys()])]
  }

  /** All robots, and what is known of each. */
  get all() {
    const { current } = program
    const about = current?.score.robots ?? {}
    return this.#all.map((name, index) => ({
      name,
      color: robotColor(index),
      kind: kindOf(about[name]?.profile ?? "", about[name]?.motions, about[name]?.body),
      body: about[name]?.body ?? [],
      radius: this.#radii.get(name) ?? about[name]?.radius ?? RADIUS,
      path: pathOf(current?.robots.get(name)),
    }))
  }

  /** The robots of the score. */
  get playing() {
    const { robots } = program.current?.score ?? {}
    return this.all.filter(({ name }) => robots && Object.hasOwn(robots, name))
  }
}

/** The robots, which are kept only here. */
export const robotList = new RobotList()

/** @param {Segment[] | undefined} segments */
function pathOf(segments) {
  return segments?.[0]?.pose ? segments : null
}

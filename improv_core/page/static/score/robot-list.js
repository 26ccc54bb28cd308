// @ts-check
// The robots: those of the score in its order, then others that are still there.

import { kindOf } from "../floor/robots.js"

/** @import { Lookahead, Stretch } from "./lookahead.js" */
/** @import { Messages } from "../net/messages.js" */
/** @typedef {ReturnType<RobotList["list"]>[number]} Robot */

export const RADIUS = 0.3 // meters, until the stage says otherwise

export class RobotList {
  /** @type {Map<string, number>} */
  #radii = new Map() // in the order of poses
  /** @type {Map<string, string[]>} */
  #joints = new Map() // of each robot, in the order of positions

  /** @param {Messages["robots"]} message */
  take({ robots }) {
    this.#radii = new Map(Object.entries(robots).map(([name, { radius }]) => [name, radius]))
    this.#joints = new Map(Object.entries(robots).map(([name, { joints }]) => [name, joints]))
  }

  get names() {
    return [...this.#radii.keys()]
  }

  /**
   * Poses by robot, or null if they are of other robots.
   * @param {number[][]} poses in the order of the robots
   */
  named(poses) {
    const { names } = this
    return names.length === poses.length ? Object.fromEntries(names.map((name, index) => [name, poses[index]])) : null
  }

  /**
   * The positions of joints by robot and name.
   * @param {Record<string, number[]>} positions
   */
  posed(positions) {
    return Object.fromEntries(
      Object.entries(positions).map(([name, each]) => {
        const joints = this.#joints.get(name) ?? []
        return [name, Object.fromEntries(each.map((position, index) => [joints[index], position]))]
      }),
    )
  }

  /**
   * All robots, and what is known of each.
   * @param {Lookahead | null} lookahead
   * @param {(index: number) => string} colorOf
   */
  list(lookahead, colorOf) {
    const about = lookahead?.score.robots ?? {}
    return [...new Set([...Object.keys(about), ...this.#radii.keys()])].map((name, index) => ({
      name,
      color: colorOf(index),
      kind: kindOf(about[name]?.profile ?? "", about[name]?.motions, about[name]?.body),
      body: about[name]?.body ?? [],
      radius: this.#radii.get(name) ?? about[name]?.radius ?? RADIUS,
      path: pathOf(lookahead?.robots.get(name)),
    }))
  }
}

/** @param {Stretch[] | undefined} stretches */
function pathOf(stretches) {
  return stretches?.[0]?.pose ? stretches : null
}

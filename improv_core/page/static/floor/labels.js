// @ts-check
// The places of the robots' names: beside their robots, covering no robot and no other name.

/** @typedef {{ left: number, top: number, right: number, bottom: number }} Box in pixels */
/** @typedef {{ name: string, place: { x: number, y: number }, size: number, wide: number, high: number }} Labeled a robot on the screen, and the size of its label */
/** @typedef {(robot: Labeled) => { x: number, y: number }} Side the middle of a label */

const GAP = 1.35 // sizes from a robot's middle to its label

/** @type {Side[]} */
const SIDES = [
  ({ place: { x, y }, size, high }) => ({ x, y: y + GAP * size + high / 2 }),
  ({ place: { x, y }, size, high }) => ({ x, y: y - GAP * size - high / 2 }),
  ({ place: { x, y }, size, wide }) => ({ x: x + GAP * size + wide / 2, y }),
  ({ place: { x, y }, size, wide }) => ({ x: x - GAP * size - wide / 2, y }),
]

export class LabelPlaces {
  /** @type {Map<string, Side>} */
  #sides = new Map() // of the latest frame: a label stays there as long as there is room

  /**
   * The boxes of the labels that have room within `floor`. That of the robot that somebody points at always has.
   * @param {Labeled[]} robots
   * @param {string | null} pointed
   * @param {Box} floor
   */
  place(robots, pointed, floor) {
    const bodies = robots.map(({ place: { x, y }, size }) => around(x, y, 2 * size, 2 * size))
    /** @type {Map<string, Box>} */
    const boxes = new Map()
    const first = robots.filter(({ name }) => name === pointed)
    for (const robot of [...first, ...robots]) {
      if (boxes.has(robot.name)) continue
      const before = this.#sides.get(robot.name) ?? SIDES[0]
      const free = [before, ...SIDES].find((side) => {
        const box = boxOf(robot, side, floor)
        const clear = (/** @type {Box} */ other) => !overlap(box, other)
        return box.top >= floor.top && box.bottom <= floor.bottom && bodies.every(clear) && [...boxes.values()].every(clear)
      })
      if (free) this.#sides.set(robot.name, free)
      else this.#sides.delete(robot.name)
      if (free || robot.name === pointed) boxes.set(robot.name, boxOf(robot, free ?? before, floor))
    }
    return boxes
  }
}

/**
 * A label's box. A long label at an edge is moved inside.
 * @param {Labeled} robot
 * @param {Side} side
 * @param {Box} floor
 */
function boxOf(robot, side, floor) {
  const { x, y } = side(robot)
  const half = robot.wide / 2
  return around(Math.max(Math.min(x, floor.right - half), floor.left + half), y, robot.wide, robot.high)
}

/** @param {number} x @param {number} y @param {number} wide @param {number} high @returns {Box} */
function around(x, y, wide, high) {
  return { left: x - wide / 2, top: y - high / 2, right: x + wide / 2, bottom: y + high / 2 }
}

/** @param {Box} one @param {Box} other */
function overlap(one, other) {
  return one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom
}

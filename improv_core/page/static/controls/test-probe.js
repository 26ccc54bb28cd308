// @ts-check
// For tests: the page's state and display.

/** @import { RobotList } from "../score/robot-list.js" */
/** @import { Clock } from "../score/clock.js" */
/** @import { Measured } from "../floor/measured.js" */
/** @import { Motion } from "../floor/motion.js" */
/** @import { Notices } from "../base/notices.js" */
/** @import { Program } from "../score/program.js" */
/** @import { Sound } from "../sound/sound.js" */
/** @import { Floor } from "../floor/floor.js" */
/** @import { Trails } from "../floor/trails.js" */
/** @import { View } from "../floor/view.js" */

/**
 * @param {{ robotList: RobotList, clock: Clock, measured: Measured, motion: Motion, notices: Notices, program: Program, sound: Sound, floor: Floor, trails: Trails, view: View }} parts
 * @param {() => number} seconds
 */
export function probe({ robotList, clock, measured, motion, notices, program, sound, floor, trails, view }, seconds) {
  return Object.freeze({
    get robots() {
      return structuredClone(view.robots)
    },
    get transport() {
      return structuredClone(clock.transport)
    },
    get beat() {
      return clock.beat()
    },
    get frames() {
      return view.frames
    },
    get connected() {
      return notices.connection === "open"
    },
    /** For each robot, the beat up to which its path is known. */
    get known() {
      return Object.fromEntries([...(program.current?.robots ?? [])].map(([name, path]) => [name, path.at(-1)?.end ?? 0]))
    },
    /** The points of each robot's trail at which one arc ends and the next begins: x, y, and seconds. */
    get trails() {
      return Object.fromEntries(
        Object.entries(view.robots).map(([name, pose]) => {
          const pieces = trails.pieces(name, -Infinity, motion.present(seconds()).at, pose)
          return [name, [...pieces].map(({ pose: { x, y }, at }) => [x, y, at])]
        }),
      )
    },
    /** The drawn places of robots: real ones where they were seen. */
    get drawn() {
      return structuredClone(floor.poses)
    },
    /** The error of each robot, in words, if it is measured. */
    get off() {
      return Object.fromEntries(robotList.names.filter((name) => measured.has(name)).map((name) => [name, measured.off(name)]))
    },
    /** The moves of paths that do not begin at their start poses. */
    get moved() {
      return Object.fromEntries(program.anchor.moved)
    },
    get view() {
      return structuredClone(floor.camera.view)
    },
    /** The position of the song that is heard, in seconds; null if none is, or it plays in grains. */
    get song() {
      return sound.audio?.position(seconds()) ?? null
    },
    /** The names that stand on the floor. */
    get names() {
      return [...floor.names]
    },
    toScreen: (/** @type {number} */ x, /** @type {number} */ y) => floor.camera.toScreen({ x, y }),
  })
}

// @ts-check
// The stage, frame by frame: decides when to draw, and collects what to show.

import { colors } from "../base/colors.js"
import { find } from "../base/elements.js"
import { due, redraw } from "../base/frames.js"
import { figureOf } from "../bodies/body.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"
import { robotList } from "../score/robot-list.js"
import { bounds } from "./camera.js"
import { measured } from "./measured.js"
import { outline } from "./world.js"

/** @import { Positions } from "../bodies/body.js" */
/** @import { Bumps } from "./bumps.js" */
/** @import { Point } from "./camera.js" */
/** @import { Motion } from "./motion.js" */
/** @import { Pose, Velocity } from "../base/path.js" */
/** @import { Parts } from "../page.js" */
/** @typedef {ReturnType<View["scene"]>} Scene */

const stillness = matchMedia("(prefers-reduced-motion: reduce)")
let isStill = stillness.matches // to ask in each frame has the browser compute styles
stillness.addEventListener("change", () => (isStill = stillness.matches))

export class View {
  #parts
  #drawn = 0
  #known = "" // the state of the paths, in short
  /** @type {Point[]} */
  #room = [] // corners of what should be in view
  #fitted = false // whether a view has shown all paths
  #previewed = false // whether the paths of a text are shown that doesn't play
  /** @type {Map<string, { pose: Pose | undefined, seen: number }>} */
  #lost = new Map() // where robots were that nobody can see or reach now
  /** @type {Record<string, Pose>} */
  robots = {}
  /** @type {Record<string, Positions>} */
  joints = {}

  /** @param {Parts} parts of the page, which know what to show */
  constructor(parts) {
    this.#parts = parts
    find("clear").addEventListener("click", () => this.#clearTrails())
  }

  get still() {
    return isStill
  }

  #clearTrails() {
    const { trails, motion } = this.#parts
    const { at } = motion.present(performance.now() / 1000)
    trails.clear(at)
    measured.clear(at)
    redraw()
  }

  /** Draws if there is something new. @param {number} now in seconds @param {number} beat */
  draw(now, beat) {
    const { figures, motion, trails, bumps, floor } = this.#parts
    const present = motion.present(now)
    this.robots = present.robots
    this.joints = robotList.posed(present.joints)
    trails.show(present.placed)
    trails.complete(program.current)
    const until = program.current?.horizon(beat) ?? 0
    this.#lookAtPaths(until)
    const bumping = bumps.show(present.at, now)
    const moving = present.moving || bumping.length > 0
    if (due.draw || moving) {
      due.draw = false
      const more = figures.draw(this.joints, (robot, part, axis) => this.#asked(robot, part, axis, beat))
      const seconds = this.still ? Infinity : now - this.#drawn
      const drawsOn = floor.draw(this.scene(present, beat, until, bumping, seconds), seconds)
      if (drawsOn || moving || more) redraw()
    }
    this.#drawn = now
  }

  /**
   * The commanded speed of a body part now: only the sign counts.
   * @param {string} robot
   * @param {string} part
   * @param {string} axis
   * @param {number} beat
   */
  #asked(robot, part, axis, beat) {
    if (!clock.playing || clock.isSilent(robot)) return 0
    const segment = program.current?.at(robot, part, beat)
    return segment && segment.start <= beat ? segment.velocity[/** @type {keyof Velocity} */ (axis)] : 0
  }

  /** @param {number} until the beat up to which paths are shown */
  #lookAtPaths(until) {
    const { trails, preview, floor } = this.#parts
    if (preview.room.length) this.#appear()
    if (this.#previewed && !preview.isShown) floor.camera.forget() // they needed another room
    this.#previewed = preview.isShown
    const { current, anchor } = program
    const known = [colors().ground, current?.score.generation, current?.version, anchor.version, trails.version, measured.version, until].join()
    if (known === this.#known) return
    this.#known = known
    redraw()
    if (!current) return
    const points = [...current.points(until)]
    const { world } = current.score
    this.#room = points.length || world ? bounds([points, world ? outline(world) : []]) : []
    if (points.length) this.#appear()
  }

  /** The first view of paths appears without easing. */
  #appear() {
    if (!this.#fitted) this.#parts.floor.camera.view = null
    this.#fitted = true
  }

  /**
   * Everything that the stage shows in one frame.
   * @param {ReturnType<Motion["present"]>} present
   * @param {number} beat
   * @param {number} until
   * @param {ReturnType<Bumps["show"]>} bumps
   * @param {number} seconds since the last frame
   */
  scene({ at, placed, moving }, beat, until, bumps, seconds) {
    const { trails, panels, handle, gesturing, preview, startPoses, senses, meetings, misplaced, wall } = this.#parts
    const { muted, soloed } = clock.transport
    const robots = robotList.all.map((robot) => {
      const { name } = robot
      const lost = wall.lost(name)
      const silent = clock.isSilent(name)
      return {
        ...robot,
        label: program.label(name),
        ...this.#whereabouts(name, lost !== "", at, seconds),
        figure: robot.body.length ? figureOf(robot.body, this.joints[name]) : null,
        ideal: lost ? undefined : measured.ideal(name),
        off: lost || measured.off(name),
        moved: program.anchor.of(name),
        fields: lost ? [] : senses.fields(name),
        silent,
        faint: silent || lost,
        lost: lost !== "",
        path: silent || lost ? null : robot.path,
      }
    })
    return {
      at,
      moving,
      beat,
      until,
      bumps,
      room: [...this.#room, ...trails.room, ...measured.room, ...startPoses.room, ...misplaced.room, ...(moving ? [] : preview.room)],
      trails,
      trail: panels.trail,
      ahead: panels.ahead,
      world: program.current?.score.world ?? null,
      preview,
      rings: startPoses.rings,
      gesturing,
      handle,
      meetings: startPoses.rings.length ? null : meetings,
      returnPaths: misplaced.returnPaths,
      still: this.still,
      key: [this.#known, placed, panels.trail, panels.ahead, preview.isShown && preview.version, !clock.playing && beat, gesturing.performs, muted, "|", soloed, "|", [...this.#lost.keys()]].join(),
      robots: [...robots, ...preview.waiting],
    }
  }

  /**
   * The place of a robot, as far as it is known. A lost one stays where it was `seen`, or where it should have been
   * then.
   * @param {string} name
   * @param {boolean} lost
   * @param {number} at seconds of performance
   * @param {number} seconds since the last frame
   */
  #whereabouts(name, lost, at, seconds) {
    const byHand = this.#parts.gesturing.poseOf(name)
    if (byHand) return { pose: byHand, seen: -Infinity } // no trail leads there
    const pose = measured.pose(name, seconds) ?? this.robots[name]
    if (!lost) this.#lost.delete(name)
    else if (!this.#lost.has(name)) this.#lost.set(name, { pose, seen: at })
    return this.#lost.get(name) ?? { pose, seen: Infinity }
  }
}

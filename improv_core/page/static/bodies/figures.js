// @ts-check
// The bodies: for each robot with one a figure, and gauges of its joints. The figure is seen from the front and from its
// right side, or it is a stick figure that turns, if the robot's joints are known from a URDF.

import { element, find, robotElement, span } from "../base/elements.js"
import { robotList } from "../score/robot-list.js"
import { figureOf } from "./body.js"
import { gauge } from "./gauge.js"
import { puppet } from "./puppet.js"
import { clearTurntable, stickFigure } from "./turntable.js"

/** @import { Body, Joint, Positions } from "./body.js" */
/** @import { Robot } from "../score/robot-list.js" */
/** @import { Picture } from "./puppet.js" */
/** @typedef {(robot: string, part: string, axis: Joint["axis"]) => number} Asked returns the commanded speed of a body part */
/** @typedef {{ row: HTMLElement, value: HTMLElement, part: string, joint: Joint, drawn: string }} Row */
/** @typedef {{ card: HTMLElement, body: Body, picture: Picture | null, rows: Row[], drawn: string }} Card */

const MAX_FIGURES = 48 // figures: of more robots, those whose bodies move come first
const FEW = 2 // robots that have much room each
const SOME = 5
const FRAMES_PER_ROUND = 3 // many robots are drawn in turns, each once in this many frames

export class Figures {
  /** @type {Map<string, Card>} */
  #cards = new Map()
  #turn = 0
  /** @type {Map<string, Positions>} */
  #real = new Map() // where joints of real robots are

  /** Shows the bodies of the robots in a score. @param {Messages["score"]} score */
  show(score) {
    const bodies = robotList.playing.filter(({ body }) => body.length)
    const moving = (/** @type {Robot} */ { body }) => Number(body.some(({ moves }) => moves))
    const shown = bodies.length > MAX_FIGURES ? bodies.toSorted((one, other) => moving(other) - moving(one)).slice(0, MAX_FIGURES) : bodies
    clearTurntable()
    this.#cards = new Map(shown.map((robot) => [robot.name, card(robot, this.#picture(robot, score))]))
    find("bodies-list").replaceChildren(...[...this.#cards.values()].map(({ card }) => card))
    find("bodies").dataset.size = shown.length <= FEW ? "large" : shown.length <= SOME ? "medium" : "small"
    find("bodies-more").textContent = bodies.length > shown.length ? `and ${bodies.length - shown.length} more` : ""
    document.body.classList.toggle("with-bodies", shown.length > 0)
  }

  /**
   * A stick figure of a robot, if its joints are known from a URDF; or a figure, if it has a head or arms.
   * @param {Robot} robot
   * @param {Messages["score"]} score
   */
  #picture({ name, body }, { robots, skeletons }) {
    const skeleton = skeletons[robots[name].profile]
    if (skeleton) return stickFigure(name, skeleton)
    return figureOf(body) ? puppet(body) : null
  }

  /** @param {Messages["joints"]} message */
  takeReal({ robot, positions }) {
    this.#real.set(robot, { ...this.#real.get(robot), ...positions })
  }

  /** Another performance begins: nobody has measured anything yet. */
  restart() {
    this.#real.clear()
  }

  /**
   * Draws the figures and gauges that have changed. Returns whether there is more to draw.
   * @param {Record<string, Positions>} joints of each robot; where none are known, they are at their starts
   * @param {Asked} asked
   */
  draw(joints, asked) {
    const turns = this.#cards.size > SOME ? FRAMES_PER_ROUND : 1
    this.#turn = (this.#turn + 1) % turns
    let more = false
    for (const [index, [name, card]] of [...this.#cards].entries()) {
      const positions = joints[name] ?? {}
      const gauges = card.rows.map(({ part, joint }) => {
        return gauge(joint, positions[joint.name] ?? joint.start, joint.sign * asked(name, part, joint.axis), this.#real.get(name)?.[joint.name])
      })
      const now = JSON.stringify([positions, gauges.map(({ held, real }) => [held, real])])
      if (now === card.drawn) continue
      if (index % turns !== this.#turn) {
        more = true
        continue
      }
      card.drawn = now
      card.picture?.draw({ ...starts(card.body), ...positions })
      gauges.forEach((each, index) => drawGauge(card.rows[index], each))
    }
    return more
  }
}

/** @param {Robot} robot @param {Picture | null} picture @returns {Card} */
function card(robot, picture) {
  const { name, body } = robot
  const card = robotElement("li", robot, element("h2", { textContent: name, title: name }))
  if (picture) card.append(picture.svg)
  const groups = body.filter(({ moves }) => moves).map(({ name: part, joints }) => joints.map((joint) => row(part, joint)))
  if (groups.length) card.append(element("div", { className: "gauges" }, ...groups.map((rows) => group(rows))))
  return { card, body, picture, rows: groups.flat(), drawn: "" }
}

/** The starts of a body's joints. @param {Body} body @returns {Positions} */
function starts(body) {
  return Object.fromEntries(body.flatMap(({ joints }) => joints.map(({ name, start }) => [name, start])))
}

/** The gauges of one body part, under its name. @param {Row[]} rows */
function group(rows) {
  const name = span("part", rows[0]?.part.replaceAll("_", " "))
  return element("div", {}, name, ...rows.map(({ row }) => row))
}

/** @param {string} part @param {Joint} joint @returns {Row} */
function row(part, joint) {
  const { ends, start } = gauge(joint, joint.start, 0)
  const className = ["gauge", ...["least", "most"].filter((_, index) => ends[index])].join(" ")
  const words = joint.name.split("_")
  const textContent = words.filter((word) => !part.split("_").includes(word)).join(" ") || words.join(" ")
  const value = span("value")
  const row = element(
    "div",
    { className, role: "img" },
    element("span", { className: "joint" }, element("bdi", { textContent })), // cut off at its beginning, where names are alike
    element("span", { className: "track" }, element("span", { className: "real" })),
    value,
  )
  row.style.setProperty("--start", String(start))
  return { row, value, part, joint, drawn: "" }
}

/**
 * Draws a gauge, if it has changed: browsers take long for hundreds that may have.
 * @param {Row} gauged
 * @param {ReturnType<typeof gauge>} now
 */
function drawGauge(gauged, { at, real, held, words }) {
  const { row, value, joint } = gauged
  const drawn = `${at.toFixed(3)} ${real?.toFixed(3)} ${held} ${words}`
  if (drawn === gauged.drawn) return
  gauged.drawn = drawn
  row.style.setProperty("--at", at.toFixed(3))
  row.dataset.held = String(held)
  row.classList.toggle("measured", real !== null)
  if (real !== null) row.style.setProperty("--real", real.toFixed(3))
  value.textContent = words.split(",")[0]
  const limits = [joint.min, joint.max].map((limit) => (limit === null ? "no limit" : gauge(joint, limit, 0).words))
  row.title = `${joint.name}: ${words} (${limits.join(" to ")})`
  row.setAttribute("aria-label", row.title)
}

// @ts-check
// The bodies: for each robot with one a figure, and gauges of its joints. The figure is seen from the front and from its
// right side, or it is a stick figure that turns, if the robot's joints are known from a URDF.

import { figureOf, HEAD } from "./body.js"
import { find } from "../base/elements.js"
import { gauge } from "./gauge.js"
import { BAR, view } from "./puppet.js"
import { Turntable } from "./turntable.js"

/** @import { Body, Joint, Positions } from "./body.js" */
/** @import { Robot } from "../score/robot-list.js" */
/** @import { Messages } from "../net/messages.js" */
/** @import { ViewName } from "./puppet.js" */
/** @import { Turned } from "./turntable.js" */
/** @typedef {(robot: string, part: string, axis: Joint["axis"]) => number} Asked returns the commanded speed of a body part */
/** @typedef {{ row: HTMLElement, value: HTMLElement, part: string, joint: Joint, drawn: string }} Row */
/** @typedef {{ card: HTMLElement, body: Body, views: Map<ViewName, Shapes>, sticks: Turned | null, rows: Row[], drawn: string }} Card */
/** @typedef {ReturnType<typeof shapes>} Shapes */

const SVG = "http://www.w3.org/2000/svg"
const MOST_FIGURES = 48 // figures: of more robots, those whose bodies move come first
const FEW = 2 // robots that have much room each
const SOME = 5
const FRAMES_PER_ROUND = 3 // many robots are drawn in turns: so many frames until it is each one's turn again
const SIDE_VIEW_AT = 1.08 // where the view from the side is, beside the one from the front
const EYE = 0.26 // of a head's radius

export class Figures {
  /** @type {Map<string, Card>} */
  #cards = new Map()
  #turn = 0
  #turntable = new Turntable()
  /** @type {Map<string, Positions>} */
  #real = new Map() // where joints of real robots are

  /**
   * Shows the bodies of the robots in a score.
   * @param {Messages["score"]} score
   * @param {Robot[]} robots
   */
  show(score, robots) {
    const bodies = robots.map((robot) => ({ robot, body: score.robots[robot.name].body })).filter(({ body }) => body.length)
    const moving = (/** @type {Body} */ body) => Number(body.some(({ moves }) => moves))
    const shown = bodies.length > MOST_FIGURES ? bodies.toSorted((one, other) => moving(other.body) - moving(one.body)).slice(0, MOST_FIGURES) : bodies
    this.#turntable.clear()
    this.#cards = new Map(shown.map(({ robot, body }) => [robot.name, card(robot, body, this.#sticks(robot.name, score))]))
    find("bodies-list").replaceChildren(...[...this.#cards.values()].map(({ card }) => card))
    find("bodies").dataset.size = shown.length <= FEW ? "large" : shown.length <= SOME ? "medium" : "small"
    find("bodies-more").textContent = bodies.length > shown.length ? `and ${bodies.length - shown.length} more` : ""
    document.body.classList.toggle("with-bodies", shown.length > 0)
  }

  /**
   * The stick figure of a robot, if its joints are known from a URDF.
   * @param {string} name
   * @param {Messages["score"]} score
   */
  #sticks(name, score) {
    const skeleton = score.skeletons[score.robots[name].profile]
    return skeleton ? this.#turntable.add(name, skeleton) : null
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
      card.sticks?.draw({ ...starts(card.body), ...positions })
      const figure = card.views.size ? figureOf(card.body, positions) : null
      if (figure) for (const [view, shapes] of card.views) drawView(figure, view, shapes)
      gauges.forEach((each, index) => drawGauge(card.rows[index], each))
    }
    return more
  }
}

/**
 * @param {Robot} robot
 * @param {Body} body
 * @param {Turned | null} sticks
 * @returns {Card}
 */
function card({ name, color }, body, sticks) {
  const card = document.createElement("li")
  card.dataset.body = name
  card.style.setProperty("--robot", color)
  const title = document.createElement("h2")
  title.textContent = title.title = name
  card.append(title)
  const views = new Map()
  if (sticks) card.append(sticks.svg)
  else if (figureOf(body)) {
    const picture = element("svg", { viewBox: `-0.64 ${-BAR - 0.03} ${SIDE_VIEW_AT + 0.5 + 0.64} ${BAR + 0.08}`, "aria-hidden": "true" })
    for (const [view, x] of /** @type {[ViewName, number][]} */ ([["front", 0], ["side", SIDE_VIEW_AT]])) {
      const made = shapes(view, body)
      made.group.setAttribute("transform", `translate(${x} 0)`)
      views.set(view, made)
      picture.append(made.group)
    }
    card.append(picture)
  }
  const list = document.createElement("div")
  list.className = "gauges"
  const groups = body.filter(({ moves }) => moves).map(({ name: part, joints }) => joints.map((joint) => row(part, joint)))
  list.append(...groups.map((rows) => group(rows)))
  if (groups.length) card.append(list)
  return { card, body, views, sticks, rows: groups.flat(), drawn: "" }
}

/**
 * The starts of a body's joints.
 * @param {Body} body
 * @returns {Positions}
 */
function starts(body) {
  return Object.fromEntries(body.flatMap(({ joints }) => joints.map(({ name, start }) => [name, start])))
}

/**
 * The gauges of one body part, under its name.
 * @param {Row[]} rows
 */
function group(rows) {
  const group = document.createElement("div")
  const name = document.createElement("span")
  name.className = "part"
  name.textContent = rows[0]?.part.replaceAll("_", " ") ?? ""
  group.append(name, ...rows.map(({ row }) => row))
  return group
}

/**
 * @param {string} part
 * @param {Joint} joint
 * @returns {Row}
 */
function row(part, joint) {
  const row = document.createElement("div")
  const { ends, start } = gauge(joint, joint.start, 0)
  row.className = ["gauge", ...["least", "most"].filter((_, index) => ends[index])].join(" ")
  row.style.setProperty("--start", String(start))
  row.setAttribute("role", "img")
  const label = document.createElement("span")
  label.className = "joint"
  const words = joint.name.split("_")
  const text = document.createElement("bdi") // the label is cut off at its beginning, where names are alike
  text.textContent = words.filter((word) => !part.split("_").includes(word)).join(" ") || words.join(" ")
  label.append(text)
  const track = document.createElement("span")
  track.className = "track"
  const real = document.createElement("span")
  real.className = "real"
  track.append(real)
  const value = document.createElement("span")
  value.className = "value"
  row.append(label, track, value)
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

/**
 * The shapes of a view, from the back to the front.
 * @param {ViewName} view
 * @param {Body} body
 */
function shapes(view, body) {
  const group = element("g", { class: view })
  const figure = figureOf(body)
  const arms = (figure?.arms ?? []).map(({ side }) => {
    const arm = element("g", { class: view === "side" && side > 0 ? "arm behind" : "arm" })
    const [limb, hand] = [element("path"), element("circle", { r: "0.045" })]
    arm.append(limb, hand)
    return { arm, limb, hand }
  })
  const half = view === "front" ? 0.2 : 0.14
  const trunk = element("path", { class: "trunk", d: `M${-half} -0.06C${-half} -0.3 ${-half * 0.7} -0.5 ${-half * 0.75} -0.6Q0 -0.72 ${half * 0.75} -0.6C${half * 0.7} -0.5 ${half} -0.3 ${half} -0.06Z` })
  const base = element("rect", { class: "base", x: String(-half - 0.05), y: "-0.1", width: String(2 * half + 0.1), height: "0.1", rx: "0.05" })
  const buttons = view === "front" ? [-0.3, -0.4, -0.5].map((y) => element("circle", { class: "button", cx: "0", cy: String(y), r: "0.02" })) : []
  const head = element("circle", { class: "head", r: String(HEAD.radius) })
  const hat = element("path", { class: "hat" })
  const eyes = [0, 1].map(() => element("circle", { class: "eye", r: String(HEAD.radius * EYE) }))
  const pupils = [0, 1].map(() => element("circle", { class: "pupil", r: String(HEAD.radius * EYE * 0.55) }))
  const nose = element("circle", { class: "nose", r: String(HEAD.radius * 0.2) })
  const strings = element("path", { class: "strings" })
  const bar = element("path", { class: "bar", d: `M${-half - 0.1} ${-BAR}H${half + 0.1}` })
  const [behind, before] = [true, false].map((hidden) => arms.filter(({ arm }) => arm.classList.contains("behind") === hidden))
  const neck = element("path", { class: "neck", d: "M0 -0.58V-0.74" })
  const order = [strings, bar, ...behind.map(({ arm }) => arm), base, neck, trunk, ...buttons, head, ...eyes, ...pupils, nose, hat]
  group.append(...order, ...before.map(({ arm }) => arm))
  return { group, arms, head, hat, eyes, pupils, nose, strings }
}

/**
 * @param {import("./body.js").Figure} figure
 * @param {ViewName} name
 * @param {Shapes} shapes
 */
function drawView(figure, name, shapes) {
  const { arms, head, strings } = view(figure, name)
  arms.forEach(({ d, hand }, index) => {
    shapes.arms[index].limb.setAttribute("d", d)
    put(shapes.arms[index].hand, hand)
  })
  put(shapes.head, head.middle)
  shapes.hat.setAttribute("d", head.hat)
  shapes.eyes.forEach((eye, index) => put(eye, head.eyes[index]))
  shapes.pupils.forEach((pupil, index) => put(pupil, head.eyes[index]))
  put(shapes.nose, head.nose)
  shapes.strings.setAttribute("d", strings)
}

/**
 * Puts a circle somewhere, or hides it.
 * @param {Element} circle
 * @param {[x: number, y: number] | null} place
 */
function put(circle, place) {
  circle.setAttribute("visibility", place ? "visible" : "hidden")
  if (!place) return
  circle.setAttribute("cx", place[0].toFixed(3))
  circle.setAttribute("cy", place[1].toFixed(3))
}

/**
 * @param {string} name
 * @param {Record<string, string>} attributes
 */
function element(name, attributes = {}) {
  const made = document.createElementNS(SVG, name)
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value)
  return made
}

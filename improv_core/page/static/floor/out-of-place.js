// @ts-check
// Robots that are not in their places, so the dance doesn't begin: what to do, and arrows that show it.

import { colors } from "../base/colors.js"
import { element, find } from "../base/elements.js"
import { refit } from "../base/frames.js"
import { announce } from "../base/notices.js"
import { send } from "../net/send.js"
import { drawFacing } from "./rings.js"
import { drawText, textPicture } from "./texts.js"

/** @import { Camera } from "./camera.js" */
/** @import { Pen } from "../base/pen.js" */
/** @import { Pose } from "../base/path.js" */
/** @typedef {{ name: string, from: Pose | null, to: Pose }} ReturnPath from where a robot stands to its place; null if nobody knows where that is */

const HEAD = 11 // pixels: an arrow's head
const SIZE = 13 // pixels from a robot's middle to its edge
const MAX_LINES = 4

export class Misplaced {
  /** @type {ReturnPath[]} */
  returnPaths = []
  #panel = find("misplaced")
  #title = find("misplaced-title")
  #list = find("misplaced-list")
  #anyway = find("anyway")

  constructor() {
    find("in-place").addEventListener("click", () => send({ type: "resume" }))
    this.#anyway.addEventListener("click", () => send({ type: "resume", anyway: true }))
  }

  /** @param {Messages["misplaced"]} message */
  take({ robots, waits }) {
    const found = Object.entries(robots)
    this.returnPaths = found.map(([name, { place, pose }]) => ({ name, from: pose, to: place }))
    const lines = found.slice(0, MAX_LINES).map(([, { line }]) => line)
    if (found.length > MAX_LINES) lines.push(`… and ${found.length - MAX_LINES} more`)
    this.#list.replaceChildren(...lines.map((line) => element("li", { textContent: line })))
    const title = found.length ? "Not in place" : "All robots are in place"
    if (waits && this.#title.textContent !== title) announce(`${title}: ${lines.join(", ")}`)
    this.#title.textContent = waits ? title : ""
    this.#panel.hidden = !waits
    this.#anyway.hidden = !found.length
    document.body.classList.toggle("misplaced", waits)
    refit()
  }

  /** The place of a drawn thing. */
  get room() {
    return this.returnPaths.flatMap(({ from, to }) => (from ? [from, to] : [to]))
  }
}

/**
 * Draws where a robot stands, where it should stand, and an arrow from there to there.
 * @param {Pen} pen
 * @param {ReturnPath} path
 * @param {Pick<Camera, "toScreen">} camera
 * @param {string} color
 */
export function drawReturnPath(pen, { name, from, to }, camera, color) {
  const end = camera.toScreen(to)
  const begin = from && camera.toScreen(from)
  if (begin) drawText(pen, textPicture(name, 14, colors().ink, devicePixelRatio), begin.x, begin.y + 2 * SIZE)
  for (const [width, style] of /** @type {const} */ ([[6, colors().ground], [2.5, color]])) {
    pen.lineWidth = width
    pen.strokeStyle = style
    pen.setLineDash([5, 4])
    drawFacing(pen, end, to.heading, SIZE, 0.6 * SIZE, 1.5 * SIZE)
    pen.setLineDash([])
    if (!from || !begin) continue
    drawFacing(pen, begin, from.heading, SIZE, 0.6 * SIZE, 1.5 * SIZE)
    const far = Math.hypot(end.x - begin.x, end.y - begin.y)
    if (far < 1) continue
    const [across, down] = [(end.x - begin.x) / far, (end.y - begin.y) / far]
    const head = Math.min(HEAD, far / 2)
    pen.beginPath()
    pen.moveTo(begin.x, begin.y)
    pen.lineTo(end.x, end.y)
    for (const side of [1, -1]) {
      pen.moveTo(end.x, end.y)
      pen.lineTo(end.x - head * (across - 0.6 * side * down), end.y - head * (down + 0.6 * side * across))
    }
    pen.stroke()
  }
}

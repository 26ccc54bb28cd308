// @ts-check
// Stick figures that turn by dragging, or with the arrow keys. All of a page are seen from the same side.

import { svgElement, svgPaths } from "../base/elements.js"
import { dragged, FROM_RIGHT, StickFigure } from "./stick-figure.js"

/** @import { Positions } from "./body.js" */
/** @import { Picture } from "./puppet.js" */
/** @import { Skeleton } from "./skeleton.js" */
/** @import { Sight } from "./stick-figure.js" */

const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }
const PER_KEY = 12 // pixels that a key drags

export class Turntable {
  /** @type {Sight} */
  #sight = FROM_RIGHT
  /** @type {(() => void)[]} */
  #redraw = []

  /** Other figures follow: forgets those that there are. They are seen from where these were. */
  clear() {
    this.#redraw = []
  }

  /**
   * @param {string} name of the robot
   * @param {Skeleton} skeleton
   * @returns {Picture}
   */
  add(name, skeleton) {
    const figure = new StickFigure(skeleton)
    const label = `${name}: drag it or press arrow keys to turn it`
    const svg = svgElement("svg", { class: "sticks", viewBox: "-1.05 -1.05 2.1 2.1", role: "img", tabindex: "0", "aria-label": label })
    const drawPaths = svgPaths(svg, ["floor", "still", "moving", "joints"])
    /** @type {Positions} */
    let latest = {}
    const draw = () => drawPaths(figure.seen(latest, this.#sight))
    this.#redraw.push(draw)
    this.#listen(svg)
    return { svg, draw: (positions) => ((latest = positions), draw()) }
  }

  /** @param {SVGSVGElement} svg */
  #listen(svg) {
    let from = { x: 0, y: 0 }
    svg.addEventListener("pointerdown", ({ pointerId, clientX: x, clientY: y }) => {
      svg.setPointerCapture(pointerId)
      from = { x, y }
    })
    svg.addEventListener("pointermove", ({ pointerId, clientX: x, clientY: y }) => {
      if (!svg.hasPointerCapture(pointerId)) return
      this.#drag(x - from.x, y - from.y)
      from = { x, y }
    })
    svg.addEventListener("dblclick", () => this.#look(FROM_RIGHT))
    svg.addEventListener("keydown", (event) => {
      const way = event.key in KEYS && KEYS[/** @type {keyof typeof KEYS} */ (event.key)]
      if (!way || event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return
      event.preventDefault()
      this.#drag(PER_KEY * way[0], PER_KEY * way[1])
    })
  }

  /**
   * @param {number} right
   * @param {number} down
   */
  #drag(right, down) {
    this.#look(dragged(this.#sight, right, down))
  }

  /** @param {Sight} sight */
  #look(sight) {
    this.#sight = sight
    for (const draw of this.#redraw) draw()
  }
}

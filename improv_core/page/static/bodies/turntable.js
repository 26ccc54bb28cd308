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

/** @type {Sight} */
let sight = FROM_RIGHT
/** @type {(() => void)[]} */
let redrawAll = []

/** Other figures follow: forgets those that there are. They are seen from where these were. */
export function clearTurntable() {
  redrawAll = []
}

/**
 * A picture of a robot's skeleton.
 * @param {string} name of the robot
 * @param {Skeleton} skeleton
 * @returns {Picture}
 */
export function stickFigure(name, skeleton) {
  const figure = new StickFigure(skeleton)
  const label = `${name}: drag it or press arrow keys to turn it`
  const svg = svgElement("svg", { class: "sticks", viewBox: "-1.05 -1.05 2.1 2.1", role: "img", tabindex: "0", "aria-label": label })
  const drawPaths = svgPaths(svg, ["floor", "still", "moving", "joints"])
  /** @type {Positions} */
  let latest = {}
  const draw = () => drawPaths(figure.seen(latest, sight))
  redrawAll.push(draw)
  listen(svg)
  return { svg, draw: (positions) => ((latest = positions), draw()) }
}

/** @param {SVGSVGElement} svg */
function listen(svg) {
  let from = { x: 0, y: 0 }
  svg.addEventListener("pointerdown", ({ pointerId, clientX: x, clientY: y }) => {
    svg.setPointerCapture(pointerId)
    from = { x, y }
  })
  svg.addEventListener("pointermove", ({ pointerId, clientX: x, clientY: y }) => {
    if (!svg.hasPointerCapture(pointerId)) return
    look(dragged(sight, x - from.x, y - from.y))
    from = { x, y }
  })
  svg.addEventListener("dblclick", () => look(FROM_RIGHT))
  svg.addEventListener("keydown", (event) => {
    const way = event.key in KEYS && KEYS[/** @type {keyof typeof KEYS} */ (event.key)]
    if (!way || event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return
    event.preventDefault()
    look(dragged(sight, PER_KEY * way[0], PER_KEY * way[1]))
  })
}

/** @param {Sight} from where all figures are seen now */
function look(from) {
  sight = from
  for (const draw of redrawAll) draw()
}

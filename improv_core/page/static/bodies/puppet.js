// @ts-check
// A figure from the front and from its right side, as paths of an SVG: x to the right, y down, the floor at 0.

import { svgElement, svgPaths } from "../base/elements.js"
import { figureOf, HEAD, onHead, places } from "./body.js"
import { line } from "./vectors.js"

/** @import { Body, Figure, Head, Positions } from "./body.js" */
/** @import { Place } from "./vectors.js" */
/** @typedef {[x: number, y: number]} Point */
/** @typedef {{ d: string, hand: Point, behind: boolean }} DrawnArm */
/** @typedef {{ middle: Point, eyes: (Point | null)[], nose: Point | null, hat: string }} DrawnHead what looks away is null */
/** @typedef {keyof typeof VIEWS} ViewName */
/** @typedef {{ svg: SVGSVGElement, draw: (positions: Positions) => void }} Picture of a body whose joints are at these positions */

const BAR = 1.14 // the height of the bar that the strings hang from
const EYES = 0.42 // to each side, in a head's radii
const EYE = 0.26 * HEAD.radius
const AHEAD = 0.15 // a face that looks at us at least by that much is seen
const SIDE_VIEW_AT = 1.08 // where the view from the side is, beside the one from the front
// From the back to the front.
const PARTS = /** @type {const} */ ([
  "strings", "bar", "limb behind", "hand behind", "base", "neck", "trunk", "button", "head", "eye", "pupil", "nose", "hat", "limb", "hand",
])

/** @satisfies {Record<string, { seen: (place: Place) => Point, toUs: (place: Place) => number }>} */
const VIEWS = {
  front: { seen: ([, y, z]) => [y, -z], toUs: ([x]) => x },
  side: { seen: ([x, , z]) => [x, -z], toUs: ([, y]) => -y },
}

/** A picture of a body that has a figure. @param {Body} body @returns {Picture} */
export function puppet(body) {
  const svg = svgElement("svg", { viewBox: `-0.64 ${-BAR - 0.03} ${SIDE_VIEW_AT + 0.5 + 0.64} ${BAR + 0.08}`, class: "puppet", "aria-hidden": "true" })
  const views = /** @type {const} */ (["front", "side"]).map((name, index) => {
    const group = svgElement("g", { class: name, transform: `translate(${index * SIDE_VIEW_AT} 0)` })
    svg.append(group)
    return { name, draw: svgPaths(group, PARTS) }
  })
  const draw = (/** @type {Positions} */ positions) => {
    const figure = figureOf(body, positions)
    if (figure) for (const { name, draw } of views) draw(pathsOf(figure, name))
  }
  return { svg, draw }
}

/** @param {Figure} figure @param {ViewName} name @returns {Record<typeof PARTS[number], string>} */
function pathsOf(figure, name) {
  const { arms, head, strings } = view(figure, name)
  const half = name === "front" ? 0.2 : 0.14
  const [behind, before] = [true, false].map((hidden) => arms.filter(({ behind }) => behind === hidden))
  const limbs = (/** @type {DrawnArm[]} */ some) => some.map(({ d }) => d).join("")
  const hands = (/** @type {DrawnArm[]} */ some) => circles(some.map(({ hand }) => hand), 0.045)
  return {
    strings,
    bar: `M${-half - 0.1} ${-BAR}H${half + 0.1}`,
    "limb behind": limbs(behind),
    "hand behind": hands(behind),
    base: `M${-half} -0.1H${half}a0.05 0.05 0 0 1 0 0.1H${-half}a0.05 0.05 0 0 1 0 -0.1Z`,
    neck: "M0 -0.58V-0.74",
    trunk: `M${-half} -0.06C${-half} -0.3 ${-half * 0.7} -0.5 ${-half * 0.75} -0.6Q0 -0.72 ${half * 0.75} -0.6C${half * 0.7} -0.5 ${half} -0.3 ${half} -0.06Z`,
    button: name === "front" ? circles([[0, -0.3], [0, -0.4], [0, -0.5]], 0.02) : "",
    head: circles([head.middle], HEAD.radius),
    eye: circles(head.eyes, EYE),
    pupil: circles(head.eyes, EYE * 0.55),
    nose: circles([head.nose], HEAD.radius * 0.2),
    hat: head.hat,
    limb: limbs(before),
    hand: hands(before),
  }
}

/** Circles around those of the points that are seen. @param {(Point | null)[]} points @param {number} radius */
function circles(points, radius) {
  const half = (/** @type {number} */ across) => `a${radius} ${radius} 0 1 0 ${across} 0`
  const seen = points.filter((point) => point !== null)
  return seen.map(([x, y]) => `M${(x - radius).toFixed(3)} ${y.toFixed(3)}${half(2 * radius)}${half(-2 * radius)}`).join("")
}

/**
 * A figure as it is seen. From the front, its left arm is on our right.
 * @param {Figure} figure
 * @param {ViewName} name
 */
export function view({ head, arms }, name) {
  const { seen, toUs } = VIEWS[name]
  const drawn = arms.map((arm) => {
    const { shoulder, elbow, hand } = places(arm)
    const points = [shoulder, elbow, hand].map(seen)
    return { d: line(points), hand: points[2], behind: name === "side" && arm.side > 0 }
  })
  const face = head ?? { yaw: 0, pitch: 0 }
  const top = seen(onHead(face, [0, 0, 1]))
  const ends = [top, ...drawn.map(({ hand }) => hand)]
  return { arms: drawn, head: seenHead(face, seen, toUs), strings: ends.map(([x, y]) => line([[x, y], [x * 0.6, -BAR]])).join("") }
}

/**
 * @param {Head} head
 * @param {(place: Place) => Point} seen
 * @param {(place: Place) => number} toUs
 * @returns {DrawnHead}
 */
function seenHead(head, seen, toUs) {
  const on = (/** @type {Place} */ face) => {
    const place = onHead(head, face)
    return toUs(place) > AHEAD * HEAD.radius ? seen(place) : null
  }
  const middle = seen([0, 0, HEAD.height])
  const tip = seen(onHead(head, [-0.15, 0, 1.75]))
  const brim = seen(onHead(head, [0, 0, 0.55]))
  const long = Math.hypot(tip[0] - brim[0], tip[1] - brim[1]) || 1
  const aside = 0.9 * HEAD.radius
  const across = [(-(tip[1] - brim[1]) / long) * aside, ((tip[0] - brim[0]) / long) * aside]
  const hat = line([[brim[0] - across[0], brim[1] - across[1]], tip, [brim[0] + across[0], brim[1] + across[1]]])
  const nose = seen(onHead(head, [1.12, 0, -0.12]))
  const eyes = [-EYES, EYES].map((aside) => on([Math.sqrt(1 - EYES ** 2 - 0.04), aside, 0.2]))
  return { middle, eyes, nose: toUs(onHead(head, [1, 0, 0])) > -AHEAD * HEAD.radius ? nose : null, hat: `${hat}Z` }
}

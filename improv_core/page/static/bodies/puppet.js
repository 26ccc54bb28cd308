// @ts-check
// A figure from the front and from its right side, as shapes of an SVG: x to the right, y down, the floor at 0.

import { HEAD, onHead, places } from "./body.js"

/** @import { Figure, Head, Place } from "./body.js" */
/** @typedef {[x: number, y: number]} Point */
/** @typedef {{ d: string, hand: Point, behind: boolean }} DrawnArm */
/** @typedef {{ middle: Point, eyes: (Point | null)[], nose: Point | null, hat: string }} DrawnHead what looks away is null */
/** @typedef {{ arms: DrawnArm[], head: DrawnHead, strings: string }} View */
/** @typedef {keyof typeof VIEWS} ViewName */

export const BAR = 1.14 // the height of the bar that the strings hang from
const EYES = 0.42 // to each side, in a head's radii
const AHEAD = 0.15 // a face that looks at us at least by that much is seen

/** @satisfies {Record<string, { seen: (place: Place) => Point, toUs: (place: Place) => number }>} */
const VIEWS = {
  front: { seen: ([, y, z]) => [y, -z], toUs: ([x]) => x },
  side: { seen: ([x, , z]) => [x, -z], toUs: ([, y]) => -y },
}

/**
 * A figure as it is seen. From the front, its left arm is on our right.
 * @param {Figure} figure
 * @param {ViewName} name
 * @returns {View}
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

/** @param {Point[]} points */
function line(points) {
  return `M${points.map((point) => point.map((each) => each.toFixed(3)).join(" ")).join("L")}`
}

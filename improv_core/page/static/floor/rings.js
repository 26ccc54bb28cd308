// @ts-check
// The rings where robots start: where they are on the screen, how large, and which one is under a hand.

import { colors } from "../base/colors.js"
import { strokeWithEdge } from "../base/pen.js"

/** @import { Camera, Point } from "./camera.js" */
/** @import { Pen } from "../base/pen.js" */
/** @typedef {{ name: string, x: number, y: number, heading: number, color: string, chosen: boolean }} Ring in meters and radians */
/** @typedef {Ring & { place: Point, tip: Point, size: number }} Placed a ring, and the tip of its arrow, in pixels */

const SIZE = 16 // pixels from a ring's middle to its edge, where there is room
const MIN_SIZE = 5
const SHARE = 0.29 // of the distance to the nearest other ring, so that their arrows don't touch
const ARROW = 2.4 // sizes from a ring's middle to its arrow's tip
const GRAB_RADIUS = 24 // pixels to a ring, or to a tip

/**
 * The rings on the screen. Those that are close to each other are smaller.
 * @param {Ring[]} rings
 * @param {Pick<Camera, "toScreen">} camera
 * @returns {Placed[]}
 */
export function placeRings(rings, camera) {
  const places = rings.map((ring) => camera.toScreen(ring))
  return rings.map((ring, index) => {
    const place = places[index]
    let nearest = Infinity
    places.forEach(({ x, y }, other) => {
      if (other !== index) nearest = Math.min(nearest, Math.hypot(x - place.x, y - place.y))
    })
    const size = Math.min(Math.max(SHARE * nearest, MIN_SIZE), SIZE)
    const reach = ARROW * size
    return { ...ring, place, size, tip: { x: place.x + reach * Math.cos(ring.heading), y: place.y - reach * Math.sin(ring.heading) } }
  })
}

/**
 * The ring or arrow that is nearest to a point of the screen, if one is near.
 * @param {Point} point
 * @param {Placed[]} rings
 */
export function nearestRing(point, rings) {
  /** @type {{ name: string, part: "place" | "tip", distance: number } | null} */
  let best = null
  for (const ring of rings) {
    for (const part of /** @type {const} */ (["place", "tip"])) {
      const distance = Math.hypot(point.x - ring[part].x, point.y - ring[part].y)
      if (distance < Math.min(GRAB_RADIUS, best?.distance ?? Infinity)) best = { name: ring.name, part, distance }
    }
  }
  return best
}

/** @param {Pen} pen @param {Placed} ring */
export function drawRing(pen, { heading, place, tip, size, color, chosen }) {
  const [cos, sin] = [Math.cos(heading), -Math.sin(heading)]
  const [back, side] = [0.56 * size, 0.44 * size]
  const width = Math.max((chosen ? 5 : 3) * (size / SIZE), chosen ? 2.5 : 1.5)
  pen.beginPath()
  pen.arc(place.x, place.y, size, 0, 2 * Math.PI)
  pen.moveTo(place.x + size * cos, place.y + size * sin)
  pen.lineTo(tip.x, tip.y)
  pen.lineTo(tip.x - back * cos + side * sin, tip.y - back * sin - side * cos)
  pen.moveTo(tip.x, tip.y)
  pen.lineTo(tip.x - back * cos - side * sin, tip.y - back * sin + side * cos)
  strokeWithEdge(pen, color, width, (2 * size) / SIZE)
}

/**
 * Draws a circle with a line at its front.
 * @param {Pen} pen
 * @param {Point} place
 * @param {number} heading
 * @param {number} size
 * @param {number} near pixels from the middle to the line's beginning
 * @param {number} far and to its end
 */
export function drawFacing(pen, { x, y }, heading, size, near, far) {
  const [cos, sin] = [Math.cos(heading), -Math.sin(heading)]
  pen.beginPath()
  pen.arc(x, y, size, 0, 2 * Math.PI)
  pen.moveTo(x + near * cos, y + near * sin)
  pen.lineTo(x + far * cos, y + far * sin)
  pen.stroke()
}

/**
 * Draws around a robot that it was last seen there.
 * @param {Pen} pen
 * @param {Point} place
 * @param {number} size of the robot, in pixels
 */
export function drawLost(pen, { x, y }, size) {
  pen.beginPath()
  pen.setLineDash([size / 3, size / 4])
  pen.arc(x, y, size * 1.25, 0, 2 * Math.PI)
  pen.strokeStyle = colors().bump
  pen.lineWidth = 2.5
  pen.stroke()
  pen.setLineDash([])
}

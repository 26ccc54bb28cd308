// @ts-check
// The world around the robots: the walls of the floor, and obstacles.

/** @import { Point } from "./camera.js" */
/** @import { Pen } from "../base/pen.js" */
/** @typedef {{ x: number, y: number, radius: number }} Circle */
/** @typedef {{ x: number, y: number, width: number, height: number, heading: number }} Box */
/** @typedef {{ size: number[] | null, walls: number[][], circles: Circle[], boxes: Box[] }} World */

/**
 * Paints a world with a pen in meters; `scale` is pixels per meter.
 * @param {Pen} pen
 * @param {World} world
 * @param {number} scale
 * @param {string} color
 */
export function paintWorld(pen, world, scale, color) {
  pen.strokeStyle = pen.fillStyle = color
  pen.lineWidth = 4 / scale
  pen.beginPath()
  if (world.size) pen.rect(-world.size[0] / 2, -world.size[1] / 2, world.size[0], world.size[1]) // the origin is its middle
  for (const [x1, y1, x2, y2] of world.walls) {
    pen.moveTo(x1, y1)
    pen.lineTo(x2, y2)
  }
  pen.stroke()
  for (const { x, y, radius } of world.circles) {
    pen.beginPath()
    pen.arc(x, y, radius, 0, 2 * Math.PI)
    pen.fill()
  }
  for (const { x, y, width, height, heading } of world.boxes) {
    pen.save()
    pen.translate(x, y)
    pen.rotate(heading)
    pen.fillRect(-width / 2, -height / 2, width, height)
    pen.restore()
  }
}

/** Points that show how much room a world takes. @param {World} world @returns {Generator<Point>} */
export function* outline(world) {
  if (world.size) {
    const [x, y] = world.size.map((length) => length / 2)
    yield* [{ x: -x, y: -y }, { x, y }]
  }
  for (const [x1, y1, x2, y2] of world.walls) yield* [{ x: x1, y: y1 }, { x: x2, y: y2 }]
  for (const { x, y, radius } of world.circles) yield* [{ x: x - radius, y: y - radius }, { x: x + radius, y: y + radius }]
  for (const { x, y, width, height, heading } of world.boxes) {
    const [cos, sin] = [Math.cos(heading) / 2, Math.sin(heading) / 2].map(Math.abs)
    const [across, up] = [width * cos + height * sin, width * sin + height * cos]
    yield* [{ x: x - across, y: y - up }, { x: x + across, y: y + up }]
  }
}

// @ts-check
// The look of each kind of robot from above, nose to the right, in units of its radius. Drawn once, then copied.

import { figureOf } from "../bodies/body.js"
import { penOn, picture } from "../base/pen.js"

/** @import { Body } from "../bodies/body.js" */
/** @import { Pen } from "../base/pen.js" */
/** @typedef {keyof typeof KINDS} Kind */

export const DARK = "#1c2330"
export const REACH = 1.75 // how far a picture extends from its middle, in radii

/**
 * A picture of a robot, `REACH` radii from its middle to each side.
 * @param {Kind} kind
 * @param {string} color
 * @param {string} shade
 * @param {number} radius
 * @param {number} ratio
 */
export function robotPicture(kind, color, shade, radius, ratio) {
  return picture([kind, color, shade, radius, ratio].join(" "), () => {
    const size = Math.ceil(radius * REACH * 2 * ratio)
    const canvas = new OffscreenCanvas(size, size)
    const pen = penOn(canvas)
    pen.translate(size / 2, size / 2)
    pen.scale(radius * ratio, -radius * ratio) // the world's y is up
    pen.lineJoin = pen.lineCap = "round"
    KINDS[kind](pen, color, shade)
    return canvas
  })
}

/**
 * The kind of picture that suits a profile: the one in its name, or one for what the robot can do.
 * @param {string} profile
 * @param {string[]} [motions]
 * @param {Body} [body]
 * @returns {Kind}
 */
export function kindOf(profile, motions = [], body = []) {
  const named = NAMED.find((kind) => profile.includes(kind))
  if (named) return named
  if (figureOf(body)?.head) return "puppet"
  if (motions.includes("climb") && !motions.includes("strafe")) return "quadrotor"
  return motions.includes("strafe") && !motions.includes("climb") ? "holonomic" : "disc"
}

const NAMED = /** @type {const} */ (["turtlesim", "burger", "waffle", "turtlebot4", "holonomic", "quadrotor"])

/** @satisfies {Record<string, (pen: Pen, color: string, shade: string) => void>} */
const KINDS = {
  disc(pen, color) {
    const touch = Math.acos(1 / 1.38) // the tangents from the nose's tip touch the disc at this angle
    pen.beginPath()
    pen.arc(0, 0, 1, touch, -touch + 2 * Math.PI)
    pen.lineTo(1.38, 0)
    pen.closePath()
    fill(pen, color)
    edge(pen, color, 0.16)
    eyes(pen, 0.42, 0.4, 0.27)
  },

  puppet(pen, color) {
    polygon(pen, [[0.84, 0.5], [1.38, 0], [0.84, -0.5]], color)
    disc(pen, 0, 0, 1, color)
  },

  turtlesim(pen, color, shade) {
    for (const side of [-1, 1]) {
      ellipse(pen, 0.62, side * 0.82, 0.42, 0.21, side * 0.75, color)
      ellipse(pen, -0.66, side * 0.74, 0.34, 0.18, side * -0.7, color)
    }
    polygon(pen, [[-0.85, 0.14], [-1.25, 0], [-0.85, -0.14]], color)
    ellipse(pen, 1.08, 0, 0.4, 0.34, 0, color)
    ellipse(pen, 0, 0, 1, 0.88, 0, color)
    ellipse(pen, 0, 0, 0.84, 0.72, 0, shade)
    pen.beginPath()
    for (let i = 0; i < 6; i++) {
      const [x, y] = [Math.cos((i * Math.PI) / 3), Math.sin((i * Math.PI) / 3)]
      pen.moveTo(0.36 * x, 0.32 * y)
      pen.lineTo(0.82 * x, 0.7 * y)
    }
    for (let i = 0; i <= 6; i++) pen.lineTo(0.36 * Math.cos((i * Math.PI) / 3), 0.32 * Math.sin((i * Math.PI) / 3))
    edge(pen, color, 0.09)
    eyes(pen, 1.16, 0.18, 0.13)
  },

  burger(pen, color, shade) {
    for (const side of [-1, 1]) box(pen, 0, side * 0.92, 0.78, 0.26, 0.1, DARK)
    box(pen, -0.06, 0, 1.66, 1.5, 0.5, color)
    disc(pen, -0.2, 0, 0.46, shade)
    disc(pen, -0.2, 0, 0.26, DARK)
    eyes(pen, 0.5, 0.32, 0.19)
  },

  waffle(pen, color, shade) {
    for (const side of [-1, 1]) box(pen, 0.34, side * 0.93, 0.62, 0.24, 0.09, DARK)
    box(pen, -0.08, 0, 1.8, 1.62, 0.2, color)
    pen.beginPath()
    for (const line of [-0.62, -0.3]) {
      pen.moveTo(line, -0.66)
      pen.lineTo(line, 0.66)
    }
    for (const line of [-0.4, 0, 0.4]) {
      pen.moveTo(-0.86, line)
      pen.lineTo(0.06, line)
    }
    edge(pen, shade, 0.08)
    disc(pen, -0.1, 0, 0.34, DARK)
    eyes(pen, 0.58, 0.4, 0.2)
  },

  turtlebot4(pen, color, shade) {
    disc(pen, 0, 0, 1, color)
    pen.beginPath()
    pen.arc(0, 0, 0.92, -1.1, 1.1)
    edge(pen, DARK, 0.16)
    disc(pen, -0.12, 0, 0.66, shade)
    disc(pen, -0.3, 0, 0.27, DARK)
    eyes(pen, 0.4, 0.28, 0.18)
  },

  holonomic(pen, color, shade) {
    for (const angle of [Math.PI / 3, Math.PI, -Math.PI / 3]) {
      pen.save()
      pen.rotate(angle)
      for (const part of [-0.3, -0.1, 0.1, 0.3]) box(pen, 0.98, part, 0.26, 0.17, 0.07, DARK)
      pen.restore()
    }
    polygon(pen, [[0.86, 0.34], [0.14, 0.86], [-0.84, 0.36], [-0.84, -0.36], [0.14, -0.86], [0.86, -0.34]], color)
    edge(pen, color, 0.2)
    disc(pen, -0.12, 0, 0.4, shade)
    eyes(pen, 0.56, 0.28, 0.19)
  },

  quadrotor(pen, color, shade) {
    const arms = [[1, 1], [1, -1], [-1, 1], [-1, -1]].map(([x, y]) => [x * 0.82, y * 0.82])
    pen.beginPath()
    for (const [x, y] of arms) {
      pen.moveTo(0, 0)
      pen.lineTo(x, y)
    }
    edge(pen, color, 0.2)
    for (const [x, y] of arms) {
      disc(pen, x, y, 0.6, `${color}50`)
      pen.beginPath()
      pen.arc(x, y, 0.6, 0, 2 * Math.PI)
      edge(pen, color, 0.07)
      disc(pen, x, y, 0.12, DARK)
    }
    box(pen, 0.06, 0, 1.05, 0.74, 0.34, color)
    box(pen, -0.14, 0, 0.5, 0.44, 0.2, shade)
    eyes(pen, 0.4, 0.2, 0.15)
  },
}

/** @param {Pen} pen @param {number} x @param {number} y @param {number} radius */
function eyes(pen, x, y, radius) {
  for (const side of [-1, 1]) {
    disc(pen, x, side * y, radius, "#ffffff")
    disc(pen, x + radius * 0.3, side * y, radius * 0.55, DARK)
  }
}

/** @param {Pen} pen @param {number} x @param {number} y @param {number} radius @param {string} color */
export function disc(pen, x, y, radius, color) {
  ellipse(pen, x, y, radius, radius, 0, color)
}

/** @type {(pen: Pen, x: number, y: number, width: number, height: number, angle: number, color: string) => void} */
function ellipse(pen, x, y, width, height, angle, color) {
  pen.beginPath()
  pen.ellipse(x, y, width, height, angle, 0, 2 * Math.PI)
  fill(pen, color)
}

/** @type {(pen: Pen, x: number, y: number, width: number, height: number, round: number, color: string) => void} */
function box(pen, x, y, width, height, round, color) {
  pen.beginPath()
  pen.roundRect(x - width / 2, y - height / 2, width, height, round)
  fill(pen, color)
}

/** @param {Pen} pen @param {number[][]} points @param {string} color */
function polygon(pen, points, color) {
  pen.beginPath()
  for (const [x, y] of points) pen.lineTo(x, y)
  pen.closePath()
  fill(pen, color)
}

/** @param {Pen} pen @param {string} color */
function fill(pen, color) {
  pen.fillStyle = color
  pen.fill()
}

/** @param {Pen} pen @param {string} color @param {number} width */
function edge(pen, color, width) {
  pen.strokeStyle = color
  pen.lineWidth = width
  pen.stroke()
}

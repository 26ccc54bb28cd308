// @ts-check
// Vectors in space, and lines through points of a picture.

/** @typedef {[x: number, y: number, z: number]} Place forward, to the left, and up */
/** @typedef {[Place, Place, Place]} Axes of a frame */

/**
 * A vector turned about an axis of length 1 (Rodrigues' formula).
 * @param {number[]} axis
 * @param {number} angle
 * @param {Place} vector
 * @returns {Place}
 */
export function about([x, y, z], angle, [a, b, c]) {
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)]
  const rest = (x * a + y * b + z * c) * (1 - cos)
  return [a * cos + (y * c - z * b) * sin + x * rest, b * cos + (z * a - x * c) * sin + y * rest, c * cos + (x * b - y * a) * sin + z * rest]
}

/**
 * A vector that is known in a frame.
 * @param {Axes} axes
 * @param {number[]} vector
 * @returns {Place}
 */
export function along([x, y, z], [a, b, c]) {
  return [x[0] * a + y[0] * b + z[0] * c, x[1] * a + y[1] * b + z[1] * c, x[2] * a + y[2] * b + z[2] * c]
}

/** @param {Place} one @param {Place} other @returns {Place} */
export function plus(one, other) {
  return [one[0] + other[0], one[1] + other[1], one[2] + other[2]]
}

/** A path of an SVG through points. @param {[x: number, y: number][]} points */
export function line(points) {
  return `M${points.map((point) => point.map((each) => each.toFixed(3)).join(" ")).join("L")}`
}

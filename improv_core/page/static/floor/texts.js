// @ts-check
// Texts on the stage, as pictures: text with an edge is slow to draw.

import { colors } from "../base/colors.js"
import { FONT, penOn, picture } from "../base/pen.js"

/** @import { Pen } from "../base/pen.js" */
/** @typedef {{ image: ImageBitmap, width: number, height: number }} TextPicture its size in CSS pixels */

/**
 * A picture of a text, with an edge that keeps it legible over trails.
 * @param {string} text
 * @param {number} size pixels
 * @param {string} color
 * @param {number} ratio device pixels per CSS pixel
 * @returns {TextPicture}
 */
export function textPicture(text, size, color, ratio) {
  const { ground } = colors()
  const image = picture([text, size, color, ground, ratio].join(" "), () => {
    const font = `600 ${size}px ${FONT}`
    const measuring = penOn(new OffscreenCanvas(1, 1))
    measuring.font = font
    const width = Math.ceil(measuring.measureText(text).width + size)
    const canvas = new OffscreenCanvas(width * ratio, size * 1.8 * ratio)
    const pen = penOn(canvas)
    Object.assign(pen, { font, textAlign: "center", textBaseline: "middle", lineJoin: "round", lineWidth: size * 0.3 })
    pen.scale(ratio, ratio)
    pen.strokeStyle = ground
    pen.strokeText(text, width / 2, size * 0.9)
    pen.fillStyle = color
    pen.fillText(text, width / 2, size * 0.9)
    return canvas
  })
  return { image, width: image.width / ratio, height: image.height / ratio } // canvases have whole pixels
}

/**
 * Draws such a picture around a point.
 * @param {Pen} pen
 * @param {TextPicture} picture
 * @param {number} x
 * @param {number} y
 */
export function drawText(pen, { image, width, height }, x, y) {
  pen.drawImage(image, Math.round(x - width / 2), Math.round(y - height / 2), width, height)
}

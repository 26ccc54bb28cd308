// @ts-check
// The pens that draw on canvases, and pictures that are drawn once, then copied: that is faster than to draw them again.

import { colors } from "./colors.js"

/** @typedef {CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D} Pen */

export const FONT = `system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif`

/**
 * @param {HTMLCanvasElement | OffscreenCanvas} canvas
 * @param {CanvasRenderingContext2DSettings} [settings]
 * @returns {Pen}
 */
export function penOn(canvas, settings) {
  const pen = /** @type {Pen | null} */ (canvas.getContext("2d", settings))
  if (!pen) throw new Error("this browser can't draw")
  return pen
}

/** Fills a rectangle. @type {(pen: Pen, color: string, x: number, y: number, width: number, height: number) => void} */
export function fillRect(pen, color, x, y, width, height) {
  pen.fillStyle = color
  pen.fillRect(x, y, width, height)
}

/** Draws along the path, with an edge that shows it on anything, too. @type {(pen: Pen, color: string, width: number, edge?: number) => void} */
export function strokeWithEdge(pen, color, width, edge = 2) {
  pen.strokeStyle = colors().ground
  pen.lineWidth = width + 2 * edge
  pen.stroke()
  pen.strokeStyle = color
  pen.lineWidth = width
  pen.stroke()
}

const MAX_PICTURES = 600

/** @type {Map<string, ImageBitmap>} */
const pictures = new Map()

/** The picture with this key; the first time, it is drawn. @param {string} key @param {() => OffscreenCanvas} draw */
export function picture(key, draw) {
  const known = pictures.get(key)
  if (known) return known
  if (pictures.size >= MAX_PICTURES) pictures.clear()
  const made = draw().transferToImageBitmap() // copied faster than a canvas, which might change
  pictures.set(key, made)
  return made
}

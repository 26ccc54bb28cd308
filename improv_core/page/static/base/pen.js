// @ts-check
// The pens that draw on canvases.

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

// @ts-check
// The robot that somebody points at, on the stage or in a list. Its name is shown even where there is little room.

import { find } from "../base/elements.js"

/** @import { Point } from "./camera.js" */

const LISTS = ["robots-list", "senses", "start-poses-list"]

/**
 * Calls `point` with the name of the robot under the pointer, or of the list's row that has the focus, or null.
 * @param {HTMLCanvasElement} canvas
 * @param {(point: Point) => string | null} robotAt a point of the canvas
 * @param {(name: string | null) => void} point
 */
export function listen(canvas, robotAt, point) {
  for (const kind of /** @type {const} */ (["pointermove", "pointerdown"])) {
    canvas.addEventListener(kind, ({ offsetX, offsetY }) => point(robotAt({ x: offsetX, y: offsetY })))
  }
  canvas.addEventListener("pointerleave", ({ pointerType }) => pointerType === "mouse" && point(null))
  for (const list of LISTS) {
    for (const kind of ["pointerover", "focusin"]) find(list).addEventListener(kind, ({ target }) => point(rowOf(target)))
    for (const kind of ["pointerleave", "focusout"]) find(list).addEventListener(kind, () => point(null))
  }
}

/** @param {EventTarget | null} target */
function rowOf(target) {
  const row = target instanceof Element ? target.closest("[data-robot]") : null
  return row instanceof HTMLElement ? (row.dataset.robot ?? null) : null
}

// @ts-check
// Gestures on the stage: drag to pan, wheel or pinch to zoom, double-click to fit.

/** @import { Camera, Point } from "./camera.js" */
/**
 * What a pointer has grabbed, until that pointer lets go of it, or a second one on the canvas zooms.
 * @typedef {{ move: (to: Point) => void, release: (zooms: boolean) => void }} Hold
 */

const ZOOM_PER_PIXEL = 0.0015 // of a zoom, by pixel

/**
 * Moves the camera. `grab(point, freely)` returns a hold of what is at a point of the canvas, or null to pan the camera
 * instead. `changed` is called when the view has changed.
 * @param {HTMLCanvasElement} canvas
 * @param {Camera} camera
 * @param {(point: Point, freely: () => boolean) => Hold | null} grab
 * @param {() => void} changed
 */
export function listenForGestures(canvas, camera, grab, changed) {
  /** @type {Map<number, Point>} */
  const fingers = new Map() // pointer -> its place
  /** @type {Hold | null} */
  let hold = null
  let alt = false
  const place = (/** @type {MouseEvent} */ event) => {
    const { left, top } = canvas.getBoundingClientRect()
    return { x: event.clientX - left, y: event.clientY - top }
  }
  const release = (/** @type {boolean} */ zooms) => {
    hold?.release(zooms)
    hold = null
    camera.held = false
  }

  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || !camera.view) return
    canvas.setPointerCapture(event.pointerId)
    fingers.set(event.pointerId, place(event))
    release(true)
    hold = fingers.size === 1 ? grab(place(event), () => alt) : null
    camera.held = hold !== null
  })
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId)
    if (!before) return
    const now = place(event)
    alt = event.altKey
    if (hold) hold.move(now)
    else if (fingers.size === 1) camera.pan(now.x - before.x, now.y - before.y)
    else {
      const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, point]) => point)
      const apart = (/** @type {Point} */ point) => Math.hypot(point.x - other.x, point.y - other.y)
      camera.zoom(apart(now) / Math.max(apart(before), 1), { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 })
      camera.pan((now.x - before.x) / 2, (now.y - before.y) / 2)
    }
    fingers.set(event.pointerId, now)
    changed()
  })
  for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) {
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId) && release(false))
  }
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault()
      if (!camera.view) return
      camera.zoom(Math.exp(-event.deltaY * ZOOM_PER_PIXEL * (event.deltaMode ? 20 : 1)), place(event))
      changed()
    },
    { passive: false },
  )
  canvas.addEventListener("dblclick", () => {
    camera.fit()
    changed()
  })
}

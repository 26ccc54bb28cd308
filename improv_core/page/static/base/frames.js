// @ts-check
// The next frame: whatever changes what the stage shows, or what covers it, leaves a note here. There are frames only
// while something changes, so that a page at rest costs next to nothing, and a hidden one nothing.

const REST_PERIOD = 100 // milliseconds between two looks while nothing is due

/** What the next frame has to do: draw the stage, and before that fit it to what covers it. */
export const due = { draw: true, fit: true }

let isAsked = false // for the next frame
let rest = 0 // the timer that asks for it
/** @type {() => boolean} */
let show = () => false

/** Shows a frame whenever one is asked for, and at once another if `frame` returns true. @param {() => boolean} frame */
export function showFrames(frame) {
  show = frame
  wake()
}

/** Asks for a frame. */
export function wake() {
  if (!isAsked) requestAnimationFrame(next)
  isAsked = true
}

/** Has the next frame draw the stage. */
export function redraw() {
  due.draw = true
  wake()
}

/** Has the next frame fit the stage to what covers it, and draw it. */
export function refit() {
  due.fit = true
  redraw()
}

function next() {
  isAsked = false
  clearTimeout(rest)
  if (show()) wake()
  else rest = window.setTimeout(look, REST_PERIOD)
}

/** Looks whether something has changed by itself. To ask the browser for a frame would cost more. */
function look() {
  if (document.hidden) wake()
  else if (!isAsked) next()
}

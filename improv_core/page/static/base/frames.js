// @ts-check
// The next frame: whatever changes what the stage shows, or what covers it, leaves a note here. There are frames only
// while something changes, so that a page at rest costs next to nothing, and a hidden one nothing.

const REST_PERIOD = 100 // milliseconds between two looks while nothing is due
const WRITING_TIME = 1000 // milliseconds after a key for which frames leave the processor
const QUICK = 8 // milliseconds: keys need not wait for shorter frames; after longer ones, there is a break,
const BREAK = 4 // times as long as the frame,
const LONGEST_BREAK = 250 // milliseconds

/** What the next frame has to do: draw the stage, before that fit it to what covers it, and paint new paths of the text. */
export const due = { draw: true, fit: true, paths: false }

let isAsked = false // for the next frame
let isWanted = false // another one, during a break
let written = -Infinity // when somebody wrote last
let rest = 0 // the timer that asks for it
let pause = 0 // the timer of a break,
let resume = () => {} // and what ends it
/** @type {() => boolean} */
let show = () => false

/** Shows a frame whenever one is asked for, and at once another if `frame` returns true. @param {() => boolean} frame */
export function showFrames(frame) {
  show = frame
  wake()
}

/** Asks for a frame. */
export function wake() {
  isWanted = isAsked
  if (!isAsked) requestAnimationFrame(next)
  isAsked = true
}

/** Somebody writes: for a while, frames take breaks in which keys are shown, unless the machine is fast. */
export function makeWay() {
  written = performance.now()
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

/** Has the next frames paint paths of the text, without a break: somebody waits for them. */
export function redrawPaths() {
  due.paths = true
  redraw()
  resume()
}

/** The milliseconds of a frame in which it may paint what rarely changes: more of them where a break follows. */
export const paintTime = () => (performance.now() < written + WRITING_TIME ? 16 : 3)

function next() {
  clearTimeout(rest)
  isAsked = true // for the break, too
  isWanted = false
  const begun = performance.now()
  const more = show()
  const end = () => {
    clearTimeout(pause)
    resume = () => {}
    isAsked = false
    if (more || isWanted) wake()
    else rest = window.setTimeout(look, REST_PERIOD)
  }
  const rests = () => {
    const taken = performance.now() - begun
    pause = window.setTimeout(end, taken < QUICK || due.paths ? 0 : Math.min(BREAK * taken, LONGEST_BREAK))
    resume = end
  }
  if (begun > written + WRITING_TIME) end()
  else setTimeout(rests) // once it is painted, too
}

/** Looks whether something has changed by itself. To ask the browser for a frame would cost more. */
function look() {
  if (document.hidden) wake()
  else if (!isAsked) next()
}

// @ts-check
// The next frame: whatever changes what the stage shows, or what covers it, leaves a note here. There are frames only
// while something changes, so that a page at rest costs next to nothing, and a hidden one nothing.

const REST_PERIOD = 100 // milliseconds between two looks while nothing is due
const WRITING_TIME = 1000 // milliseconds after a key for which frames leave the processor
const KEY_TIME = 50 // milliseconds after a key in which it is shown, and its colors,
const QUICK = 10 // milliseconds: keys need not wait for shorter frames; after longer ones, there is a break,
const BREAK = 8 // times as long as the frame,
const LONGEST_BREAK = 400 // milliseconds,
const LONGEST_WAIT = 600 // and with the time for keys, if one follows the other

/** What the next frame has to do: draw the stage, before that fit it to what covers it, and paint new paths of the text. */
export const due = { draw: true, fit: true, paths: false }

let isAsked = false // for the next frame
let isWanted = false // another one, while it is shown
let written = -Infinity // when somebody wrote last
let shown = -Infinity // when the latest frame was shown,
let taken = 0 // and for how many milliseconds that kept the page busy
let rest = 0 // the timer of the next look
let pause = 0 // the timer that ends a break
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
  if (!isAsked) ask()
}

/** Asks the browser for a frame, after the break if there is one. */
function ask() {
  clearTimeout(pause)
  pause = 0
  isAsked = true
  const delay = delayForKeys()
  if (delay) pause = window.setTimeout(ask, delay)
  else requestAnimationFrame(next)
}

/** The milliseconds until keys let a frame begin. */
function delayForKeys() {
  if (due.paths || taken < QUICK || !isWriting()) return 0
  const rested = shown + Math.min(BREAK * taken, LONGEST_BREAK)
  return Math.max(Math.min(Math.max(rested, written + KEY_TIME), shown + LONGEST_WAIT) - performance.now(), 0)
}

/** Somebody has pressed a key: unless the machine is fast, that is shown first, and for a while frames take breaks. */
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
  if (pause) ask()
}

/** Whether somebody has just written: then frames leave the processor to keys. */
export const isWriting = () => performance.now() < written + WRITING_TIME

function next() {
  if (delayForKeys()) return ask() // for a key since it was asked for
  clearTimeout(rest)
  isAsked = true
  isWanted = false
  const begun = performance.now()
  const more = show()
  const end = () => {
    shown = performance.now()
    taken = shown - begun
    isAsked = false
    if (more || isWanted) wake()
    else rest = window.setTimeout(look, REST_PERIOD)
  }
  if (begun > written + WRITING_TIME) end()
  else setTimeout(end) // once it is painted, too
}

/** Looks whether something has changed by itself. To ask the browser for a frame would cost more. */
function look() {
  if (document.hidden) wake()
  else if (!isAsked) next()
}

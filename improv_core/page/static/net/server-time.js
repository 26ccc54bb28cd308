// @ts-check
// Asks what time it is at the server: a few times when a connection begins, and then on and on while there is sound,
// which has to be exact.

import { clock } from "../score/clock.js"
import { fetchTime } from "./backend.js"

const FIRST_DELAYS = [0, 50, 100, 200, 400, 800] // milliseconds after which the page first asks
const PERIOD = 2000 // milliseconds between two questions after that
let timer = 0

/** Asks a few times. */
export function askTime() {
  for (const wait of FIRST_DELAYS) setTimeout(ask, wait)
}

/** Asks on and on from now, or no longer. @param {boolean} on */
export function keepAsking(on) {
  if (on === timer > 0) return
  clearInterval(timer)
  timer = on ? window.setInterval(ask, PERIOD) : 0
  if (on) askTime()
}

async function ask() {
  const sent = performance.now() / 1000
  const wall = await fetchTime()
  const received = performance.now() / 1000
  if (wall !== null) clock.takeAnswer({ sent, wall, received, own: Date.now() / 1000 - received })
}

// @ts-check
// Asks what time it is at the server: a few times when a connection begins, and then on and on while there is sound,
// which has to be exact.

import { fetchTime } from "./backend.js"

/** @import { Clock } from "../score/clock.js" */

const FIRST_DELAYS = [0, 50, 100, 200, 400, 800] // milliseconds after which the page first asks
const PERIOD = 2000 // milliseconds between two questions after that

export class ServerTime {
  #clock
  #timer = 0

  /** @param {Clock} clock takes the answers */
  constructor(clock) {
    this.#clock = clock
  }

  /** A connection begins. */
  connect() {
    this.#clock.connect()
    this.#askFirst()
  }

  /** Asks on and on from now, or no longer. @param {boolean} on */
  keepAsking(on) {
    if (on === this.#timer > 0) return
    clearInterval(this.#timer)
    this.#timer = on ? window.setInterval(() => this.#ask(), PERIOD) : 0
    if (on) this.#askFirst()
  }

  #askFirst() {
    for (const wait of FIRST_DELAYS) setTimeout(() => this.#ask(), wait)
  }

  async #ask() {
    const sent = performance.now() / 1000
    const wall = await fetchTime()
    const received = performance.now() / 1000
    if (wall !== null) this.#clock.takeAnswer({ sent, wall, received, own: Date.now() / 1000 - received })
  }
}

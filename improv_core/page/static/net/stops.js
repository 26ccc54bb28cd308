// @ts-check
// The stops of this page: each is sent again, over a connection of its own, until it is confirmed that it was obeyed.

import { notices } from "../base/notices.js"
import { randomName } from "../base/random.js"
import { withToken } from "./token.js"

const RESEND_DELAY = 500 // milliseconds until a stop is sent again that is not confirmed
const TIMEOUT = 8000 // milliseconds that an answer may take: a stage that hangs may still read what it was sent
const MAX_WAITING = 3 // that may wait for an answer at the same time: browsers open only six connections
const NOTICE_DELAY = 300 // milliseconds after which the page shows that a stop is not confirmed

/** The number of stops that somebody has pressed, and of those that were obeyed. */
export class PressedStops {
  #pressed = 0
  #confirmed = 0
  #late = 0 // the timer

  /** The number of the latest stop if it is not confirmed; otherwise 0. */
  get waiting() {
    return this.#confirmed < this.#pressed ? this.#pressed : 0
  }

  /** Somebody stops the robots. The number of this stop. */
  press() {
    if (!this.waiting) this.#late = window.setTimeout(() => notices.waitForStop(true, ""), NOTICE_DELAY)
    return ++this.#pressed
  }

  /** A stop was obeyed, and with it all earlier ones. @param {number} [number] of all, if it is left out */
  confirm(number = this.#pressed) {
    this.#confirmed = Math.max(number, this.#confirmed)
    if (this.waiting) return
    clearTimeout(this.#late)
    notices.waitForStop(false, "")
  }
}

export class Stops extends PressedStops {
  page = randomName()
  #asked = 0 // how many wait for an answer
  #ended = false // true once nobody answers anymore
  #again = 0 // the timer

  press() {
    const number = super.press()
    if (this.#ended) this.confirm()
    else this.#send()
    return number
  }

  /** There is a server again. */
  begin() {
    this.#ended = false
  }

  /** All robots were stopped, and nobody will confirm what still waits. */
  end() {
    this.#ended = true
    this.confirm()
  }

  async #send() {
    const number = this.waiting
    clearTimeout(this.#again)
    if (!number) return
    this.#again = window.setTimeout(() => this.#send(), RESEND_DELAY)
    if (this.#asked >= MAX_WAITING) return
    this.#asked++
    const address = withToken("stop", { page: this.page, number: String(number) })
    // It is sent even if the page is closed at once.
    const options = { method: "POST", keepalive: true, signal: AbortSignal.timeout(TIMEOUT) }
    const answer = await fetch(address, options).catch(() => null)
    this.#asked--
    const who = answer?.status === 202 ? await answer.text().catch(() => "") : ""
    if (answer?.status === 204) this.confirm(number)
    else if (who && number === this.waiting) notices.waitForStop(true, who)
  }
}

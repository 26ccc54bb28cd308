// @ts-check
// The deadman button of a gamepad: robots move only while somebody holds it.

import { find, write } from "../base/elements.js"
import { send } from "../net/send.js"


const SEND_PERIOD = 100 // milliseconds between two messages that the button is held

export class Deadman {
  /** @type {number | null} */
  #button = null
  #held = false
  #sent = -Infinity

  constructor() {
    // A hidden page draws no frames, so it would miss that the button is let go.
    document.addEventListener("visibilitychange", () => this.look(performance.now()))
  }

  /** True if robots move only while a button is held. */
  get isRequired() {
    return this.#button !== null
  }

  /** @param {Messages["score"]["deadman"]} deadman what the score requires */
  require(deadman) {
    this.#button = deadman?.button ?? null
    this.look(performance.now())
  }

  /**
   * Looks at the gamepads, which have no events; called at every frame while a button is required.
   * @param {number} now in milliseconds
   */
  look(now) {
    const button = this.#button
    const gamepads = button === null || document.hidden ? [] : connected()
    const held = button !== null && !!gamepads?.some((gamepad) => gamepad?.buttons[button]?.pressed)
    if (held && now - this.#sent >= SEND_PERIOD) {
      send({ type: "held" })
      this.#sent = now
    }
    if (this.#held && !held) {
      send({ type: "released" })
      this.#sent = -Infinity
    }
    this.#held = held
    find("deadman").hidden = button === null || held
    write(find("deadman"), gamepads ? `hold button ${button} to move` : "open this page in a browser to use a gamepad")
  }
}

/** The gamepads; null if the browser does not let this frame see them. */
function connected() {
  try {
    return navigator.getGamepads().filter((gamepad) => gamepad?.connected)
  } catch {
    return null
  }
}

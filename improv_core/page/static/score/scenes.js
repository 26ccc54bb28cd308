// @ts-check
// Scenes by their names: which one plays, and a way to begin with another one.

import { find, findA } from "../base/elements.js"

/** @import { Clock } from "./clock.js" */
/** @import { Messages } from "../net/messages.js" */

export class Scenes {
  #clock
  #list = findA("scene", HTMLSelectElement)
  /** @type {number[]} */
  #begins = []

  /**
   * `seek` asks the server to continue at a beat.
   * @param {Clock} clock
   * @param {(beat: number) => void} seek
   */
  constructor(clock, seek) {
    this.#clock = clock
    this.#list.addEventListener("change", () => seek(this.#begins[this.#list.selectedIndex]))
  }

  /** @param {Pick<Messages["score"], "scene" | "scenes" | "scene_names">} score */
  show({ scene, scenes, scene_names: names }) {
    this.#begins = scenes
    const options = scenes.map((_, index) => new Option(names[scene + index] || `scene ${scene + index + 1}`))
    this.#list.replaceChildren(...options)
    find("scenes").hidden = scenes.length < 2
    this.showPosition()
  }

  /** Shows which scene plays. */
  showPosition() {
    const beat = this.#clock.atStart ? 0 : this.#clock.beat() + 1e-6
    const now = Math.max(this.#begins.findLastIndex((begin) => begin <= beat), 0)
    if (this.#begins.length && this.#list.selectedIndex !== now) this.#list.selectedIndex = now
  }
}

// @ts-check
// Formations: a button for each, which offers the lines for improv.toml.

import { find, findA } from "./elements.js"
import { Offer } from "./offer.js"
import { LIMITS } from "./requests.js"

/** @import { Request } from "./requests.js" */
/** @import { Messages } from "./messages.js" */

/** @type {Record<string, { shape: "line" | "circle" | "grid", facing: "in" | "out" }>} */
const CHOICES = {
  line: { shape: "line", facing: "in" },
  "circle-in": { shape: "circle", facing: "in" },
  "circle-out": { shape: "circle", facing: "out" },
  grid: { shape: "grid", facing: "in" },
}
const WIDTHS = 5 // between robots, unless somebody says otherwise

export class Formation {
  #distance = findA("formation-distance", HTMLInputElement)
  #offer
  #chosen = "" // of CHOICES
  #send
  /** Whether robots start there when it plays next. */
  #plays = false

  /**
   * `send` offers a formation to the server.
   * @param {(request: Request) => void} send
   */
  constructor(send) {
    this.#send = send
    this.#offer = new Offer("formation-offer", () => this.#ask())
    for (const name of Object.keys(CHOICES)) {
      find(`form-${name}`).addEventListener("click", () => this.#take(this.#chosen === name && !this.#plays ? "" : name))
    }
    ;[this.#distance.min, this.#distance.max] = LIMITS.form.distance.map(String)
    this.#distance.addEventListener("input", () => this.#take(this.#chosen))
  }

  /** From now on, robots start in the formation when it plays next. */
  play() {
    this.#plays = this.#offer.plays = true
  }

  /** @param {Messages["score"]} score */
  show({ robots, takes_start_poses }) {
    this.#offer.writes = takes_start_poses
    const widest = 2 * Math.max(...Object.values(robots).map(({ radius }) => radius))
    if (widest > 0) this.#distance.min = String(widest)
    if (!this.#chosen && widest > 0) this.#distance.value = String(Number((WIDTHS * widest).toFixed(1)))
    this.#choose(this.#chosen)
  }

  /** Somebody has chosen. @param {string} name */
  #take(name) {
    this.#choose(name)
    if (this.#plays && name && this.#distance.checkValidity()) this.#ask()
  }

  #ask() {
    this.#send({ type: "form", ...CHOICES[this.#chosen], distance: this.#distance.valueAsNumber })
  }

  /** @param {string} name */
  #choose(name) {
    this.#chosen = name
    for (const each of Object.keys(CHOICES)) find(`form-${each}`).setAttribute("aria-pressed", String(each === name))
    const valid = name && this.#distance.checkValidity()
    this.#offer.show(valid ? this.#lines(CHOICES[name]) : "")
  }

  /** @param {typeof CHOICES[string]} choice */
  #lines({ shape, facing }) {
    const lines = ["[formation]", `shape = "${shape}"`, `distance = ${this.#distance.valueAsNumber}`]
    return [...lines, ...(shape === "circle" ? [`facing = "${facing}"`] : [])].join("\n")
  }
}

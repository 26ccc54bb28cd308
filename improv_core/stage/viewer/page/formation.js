// @ts-check
// Formations: a button for each, which offers the lines for improv.toml.

import { find, findA } from "./elements.js"
import { Offer } from "./offer.js"

/** @import { Request } from "./connection.js" */
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

  /**
   * `send` offers a formation to the server.
   * @param {(request: Request) => void} send
   */
  constructor(send) {
    this.#offer = new Offer("formation-offer", () => {
      send({ type: "form", ...CHOICES[this.#chosen], distance: this.#distance.valueAsNumber })
    })
    for (const name of Object.keys(CHOICES)) {
      find(`form-${name}`).addEventListener("click", () => this.#choose(this.#chosen === name ? "" : name))
    }
    this.#distance.addEventListener("input", () => this.#choose(this.#chosen))
  }

  /** @param {Messages["score"]} score */
  show({ robots, takes_start_poses }) {
    this.#offer.writes = takes_start_poses
    const widest = 2 * Math.max(...Object.values(robots).map(({ radius }) => radius))
    if (widest > 0) this.#distance.min = String(widest)
    if (!this.#chosen && widest > 0) this.#distance.value = String(Number((WIDTHS * widest).toFixed(1)))
    this.#choose(this.#chosen)
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

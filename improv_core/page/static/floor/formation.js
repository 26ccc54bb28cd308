// @ts-check
// Formations: a button for each, which has its line written into the program, or offers those for improv.toml.

import { find, findA } from "../base/elements.js"
import { tomlLines } from "../editor/toml-lines.js"
import { LIMITS } from "../net/limits.js"
import { changes } from "../score/changes.js"


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
  #showToml = tomlLines("formation-toml")
  #chosen = "" // of CHOICES

  constructor() {
    for (const name of Object.keys(CHOICES)) {
      find(`form-${name}`).addEventListener("click", () => this.#take(this.#chosen === name && !changes.write ? "" : name))
    }
    ;[this.#distance.min, this.#distance.max] = LIMITS.arrange.distance.map(String)
    this.#distance.addEventListener("input", () => this.#choose(this.#chosen))
    this.#distance.addEventListener("change", () => this.#take(this.#chosen))
  }

  /** @param {Messages["score"]} score */
  show({ robots }) {
    const widest = 2 * Math.max(...Object.values(robots).map(({ radius }) => radius))
    if (widest > 0) this.#distance.min = String(widest)
    if (!this.#chosen && widest > 0) this.#distance.value = String(Number((WIDTHS * widest).toFixed(1)))
    this.#choose(this.#chosen)
  }

  /** Somebody has chosen. @param {string} name */
  #take(name) {
    this.#choose(name)
    if (name && this.#distance.reportValidity()) changes.write?.({ type: "arrange", ...CHOICES[name], distance: this.#distance.valueAsNumber })
  }

  /** @param {string} name */
  #choose(name) {
    this.#chosen = name
    for (const each of Object.keys(CHOICES)) find(`form-${each}`).setAttribute("aria-pressed", String(each === name))
    const valid = name && this.#distance.checkValidity()
    this.#showToml(valid && !changes.write ? this.#lines(CHOICES[name]) : "")
  }

  /** @param {typeof CHOICES[string]} choice */
  #lines({ shape, facing }) {
    const lines = ["[formation]", `shape = "${shape}"`, `distance = ${this.#distance.valueAsNumber}`]
    return [...lines, ...(shape === "circle" ? [`facing = "${facing}"`] : [])].join("\n")
  }
}

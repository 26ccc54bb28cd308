// @ts-check
// Dances to begin with. Only on a website: it brings them along.

import { find, findA } from "../base/elements.js"

/** @typedef {{ name: string, text: string, toml: string, picture: string }} Example with the picture of its paths, as SVG */

export class Examples {
  #dialog = findA("examples", HTMLDialogElement)
  #play

  /** @param {(text: string, toml: string) => void} play takes the dance that somebody chooses, which plays at once */
  constructor(play) {
    this.#play = play
    find("show-examples").hidden = false
    find("show-examples").addEventListener("click", () => this.#open())
  }

  async #open() {
    this.#dialog.showModal()
    const list = find("examples-list")
    if (list.childElementCount) return
    try {
      const answer = await fetch("examples.json")
      /** @type {Example[]} */
      const examples = await answer.json()
      list.replaceChildren(...examples.map((example) => this.#row(example)))
    } catch {
      find("examples-line").textContent = "The examples can't be loaded: try again once there is a network."
    }
  }

  /** @param {Example} example */
  #row({ name, text, toml, picture }) {
    const item = document.createElement("li")
    const button = document.createElement("button")
    button.type = "button"
    const image = new Image()
    image.alt = ""
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(picture)}`
    button.append(image, name)
    button.addEventListener("click", () => {
      this.#dialog.close()
      this.#play(text, toml)
    })
    item.append(button)
    return item
  }
}

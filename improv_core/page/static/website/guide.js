// @ts-check
// The tutorial and exercises, page by page, on a card beside the stage. Only on a website: it brings them along.

import { find, findA } from "../base/elements.js"
import { settings } from "../base/keys.js"

/** @typedef {{ part: string, title: string, html: string }} Page its HTML is a file of this website */

export class Guide {
  #pages = findA("guide-page", HTMLSelectElement)
  #text = find("guide-text")
  #play
  /** @type {Page[]} */
  #all = []

  /** @param {(text: string) => void} play takes a program of the guide, which plays at once */
  constructor(play) {
    this.#play = play
    find("show-guide").hidden = false
    find("show-guide").addEventListener("click", () => this.#load())
    this.#pages.addEventListener("change", () => this.#show(this.#pages.selectedIndex))
    find("guide-back").addEventListener("click", () => this.#show(this.#pages.selectedIndex - 1))
    find("guide-on").addEventListener("click", () => this.#show(this.#pages.selectedIndex + 1))
  }

  async #load() {
    if (this.#all.length) return
    try {
      const answer = await fetch("guide.json")
      this.#all = await answer.json()
    } catch {
      this.#text.textContent = "The tutorial can't be loaded: try again once there is a network."
      return
    }
    for (const part of new Set(this.#all.map((page) => page.part))) {
      const group = document.createElement("optgroup")
      group.label = part
      const titles = this.#all.filter((page) => page.part === part).map(({ title }) => title)
      group.append(...titles.map((title, i) => new Option(`${i + 1}. ${title}`)))
      this.#pages.append(group)
    }
    const latest = Number(settings.get("guide", 0))
    this.#show(latest in this.#all ? latest : 0)
  }

  /** @param {number} index */
  #show(index) {
    settings.set("guide", index)
    this.#pages.selectedIndex = index
    find("guide-back").toggleAttribute("disabled", index === 0)
    find("guide-on").toggleAttribute("disabled", index === this.#all.length - 1)
    const { body } = new DOMParser().parseFromString(this.#all[index].html, "text/html")
    this.#text.replaceChildren(...body.childNodes)
    this.#text.scrollTop = 0
    for (const program of this.#text.querySelectorAll("pre.program")) {
      const button = document.createElement("button")
      button.type = "button"
      button.textContent = "Play this"
      button.addEventListener("click", () => this.#play(program.textContent ?? ""))
      program.after(button)
    }
  }
}

// @ts-check
// The tutorial and exercises, page by page, on a card beside the stage.

import { button, element, find, findA } from "../base/elements.js"
import { isWebsite } from "../net/backend.js"
import { textAt } from "../net/resources.js"
import { settings } from "../base/storage.js"

/** @typedef {{ part: string, title: string, html: string }} Page its HTML comes with Improv */

/** @param {(text: string) => void} take takes a program of the guide */
export function offerGuide(take) {
  const menu = findA("guide-page", HTMLSelectElement)
  const text = find("guide-text")
  /** @type {Page[]} */
  let pages = []

  /** @param {number} index */
  function show(index) {
    settings.set("guide", index)
    menu.selectedIndex = index
    find("guide-back").toggleAttribute("disabled", index === 0)
    find("guide-on").toggleAttribute("disabled", index === pages.length - 1)
    const { body } = new DOMParser().parseFromString(pages[index].html, "text/html")
    text.replaceChildren(...body.childNodes)
    text.scrollTop = 0
    for (const program of text.querySelectorAll("pre.program")) {
      // Before it, since a small card cuts off the end of a long program.
      program.before(button({ textContent: isWebsite ? "Play this" : "Take this" }, () => take(program.textContent ?? "")))
    }
  }

  find("show-guide").addEventListener("click", async () => {
    if (pages.length) return
    const loaded = await textAt("guide.json")
    if (!loaded) {
      text.textContent = "The tutorial can't be loaded: try again once there is a network."
      return
    }
    pages = JSON.parse(loaded)
    for (const part of new Set(pages.map((page) => page.part))) {
      const titles = pages.filter((page) => page.part === part).map(({ title }) => title)
      menu.append(element("optgroup", { label: part }, ...titles.map((title, i) => new Option(`${i + 1}. ${title}`))))
    }
    const latest = Number(settings.get("guide", 0))
    show(latest in pages ? latest : 0)
  })
  menu.addEventListener("change", () => show(menu.selectedIndex))
  find("guide-back").addEventListener("click", () => show(menu.selectedIndex - 1))
  find("guide-on").addEventListener("click", () => show(menu.selectedIndex + 1))
}

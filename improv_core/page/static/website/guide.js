// @ts-check
// The tutorial and exercises, page by page, on a card beside the stage. Only on a website: it brings them along.

import { button, element, find, findA } from "../base/elements.js"
import { settings } from "../base/storage.js"

/** @typedef {{ part: string, title: string, html: string }} Page its HTML is a file of this website */

/** @param {(text: string) => void} play takes a program of the guide, which plays at once */
export function offerGuide(play) {
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
      program.after(button({ textContent: "Play this" }, () => play(program.textContent ?? "")))
    }
  }

  find("show-guide").hidden = false
  find("show-guide").addEventListener("click", async () => {
    if (pages.length) return
    try {
      const answer = await fetch("guide.json")
      pages = await answer.json()
    } catch {
      text.textContent = "The tutorial can't be loaded: try again once there is a network."
      return
    }
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

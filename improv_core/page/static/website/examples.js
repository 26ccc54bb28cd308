// @ts-check
// Dances to begin with. Only on a website: it brings them along.

import { button, element, find, findA, svgAddress } from "../base/elements.js"

/** @typedef {{ name: string, text: string, toml: string, picture: string }} Example with the picture of its paths, as SVG */

/** @param {(text: string, toml: string) => void} play takes the dance that somebody chooses, which plays at once */
export function offerExamples(play) {
  const dialog = findA("examples", HTMLDialogElement)
  const list = find("examples-list")
  /** @param {Example} example */
  const row = ({ name, text, toml, picture }) => {
    const choose = button({}, () => {
      dialog.close()
      play(text, toml)
    })
    choose.append(element("img", { alt: "", src: svgAddress(picture) }), name)
    return element("li", {}, choose)
  }
  find("show-examples").hidden = false
  find("show-examples").addEventListener("click", async () => {
    dialog.showModal()
    if (list.childElementCount) return
    try {
      const answer = await fetch("examples.json")
      /** @type {Example[]} */
      const examples = await answer.json()
      list.replaceChildren(...examples.map(row))
    } catch {
      find("examples-line").textContent = "The examples can't be loaded: try again once there is a network."
    }
  })
}

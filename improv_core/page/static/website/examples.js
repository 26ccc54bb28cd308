// @ts-check
// Dances to begin with.

import { robotColor } from "../base/colors.js"
import { button, element, find, findA, svgAddress } from "../base/elements.js"
import { figureOf } from "../bodies/body.js"
import { puppet } from "../bodies/puppet.js"
import { textAt } from "../net/resources.js"

/** @import { Body } from "../bodies/body.js" */
/** @typedef {{ name: string, text: string, toml: string, picture: string, bodies: Body[] }} Example with the picture of its paths, as SVG */

/** @param {(text: string, toml: string) => void} take takes the dance that somebody chooses */
export function offerExamples(take) {
  const dialog = findA("examples", HTMLDialogElement)
  const list = find("examples-list")
  /** @param {Example} example */
  const row = ({ name, text, toml, picture, bodies }) => {
    const choose = button({}, () => {
      dialog.close()
      take(text, toml)
    })
    choose.append(element("img", { alt: "", src: svgAddress(picture) }), ...bodies.slice(0, 1).flatMap(figure), name)
    return element("li", {}, choose)
  }
  find("show-examples").addEventListener("click", async () => {
    dialog.show() // not modal, so that Stop stays reachable
    if (list.childElementCount) return
    const line = find("examples-line")
    line.textContent = "Loading…"
    const text = await textAt("examples.json")
    /** @type {Example[]} */
    const examples = JSON.parse(text ?? "[]")
    list.replaceChildren(...examples.map(row))
    line.textContent = text ? "" : "The examples can't be loaded: try again once there is a network."
  })
}

/** The figure of the first robot at the start of the dance, if its body has one. @param {Body} body */
function figure(body) {
  if (!figureOf(body)) return []
  const { svg, draw } = puppet(body)
  draw({})
  svg.style.setProperty("--robot", robotColor(0))
  return [svg]
}

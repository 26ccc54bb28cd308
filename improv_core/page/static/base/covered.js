// @ts-check
// The covered part of the stage on each side, so that the view keeps to the rest.

import { find } from "./elements.js"

const FOOT = 56 // pixels at the bottom of the stage for the scale and the tools
const BESIDE = 0.6 // of the stage's width: a card or list that is wider lies above or below the robots, not beside them

/**
 * The covered pixels on each side, and the strip at the bottom that is left for the scale.
 * @param {boolean} presenting
 */
export function insets(presenting) {
  const hall = box("hall")
  const card = document.querySelector("#hall .card[open]")?.getBoundingClientRect()
  const senses = box("senses")
  const tools = find(presenting ? "presenting" : "tools")
  const foot = Math.max(tools.offsetHeight + 20, FOOT)
  const isBeside = (/** @type {DOMRect} */ each) => each.width <= hall.width * BESIDE
  let [top, left, bottom] = [8, 0, foot]
  if (presenting) {
    const [beat, stop] = [box("status"), box("stop")] // they lie on the stage, unless Stop lies on the program
    if (hall.height > hall.width) top = Math.max(top, beat.height)
    else left = beat.width
    if (stop.left < hall.right) top = Math.max(top, stop.bottom - hall.top)
  }
  for (const line of document.querySelectorAll("#show-wall.trouble, #stands, #gesture, .editing #hint > :is(h2, p)")) {
    const { height, bottom: end } = line.getBoundingClientRect()
    if (height) top = Math.max(top, end - hall.top + 8) // no robot and no name must be under it
  }
  for (const list of [senses, box("misplaced")]) {
    if (list.width && isBeside(list)) left = Math.max(left, list.right - hall.left)
    else if (list.width) top = Math.max(top, list.bottom - hall.top)
  }
  if (card && isBeside(card)) left = Math.max(left, card.right - hall.left)
  else if (card) bottom += hall.bottom - card.top
  return { insets: { top, bottom, left }, strip: { foot, width: hall.width - left - tools.offsetWidth - 40 } }
}

/** @param {string} id */
function box(id) {
  return find(id).getBoundingClientRect()
}

// @ts-check
// Nothing that is being pressed may move: otherwise it isn't there when it is released, and the press is lost.

import { find } from "./elements.js"

let isPressed = false
/** @type {(() => void)[]} */
const waiting = []

/** Moves controls, once nothing is being pressed. @param {() => void} move */
export function whenReleased(move) {
  if (isPressed) waiting.push(move)
  else move()
}

function release() {
  isPressed = false
  setTimeout(() => !isPressed && waiting.splice(0).forEach((move) => move())) // after the click
}

/** Watches what is pressed. */
export function watchPresses() {
  // What is dragged on the floor is no control, and the text follows it.
  addEventListener("pointerdown", ({ target }) => (isPressed = target !== find("stage")), true)
  addEventListener("pointerup", release, true)
  addEventListener("pointercancel", release, true)
  addEventListener("blur", release)
}

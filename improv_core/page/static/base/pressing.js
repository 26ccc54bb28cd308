// @ts-check
// Nothing that is being pressed may move: otherwise it isn't there when it is released, and the press is lost.

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
  addEventListener("pointerdown", () => (isPressed = true), true)
  addEventListener("pointerup", release, true)
  addEventListener("pointercancel", release, true)
  addEventListener("blur", release)
}

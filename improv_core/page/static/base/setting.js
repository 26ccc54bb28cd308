// @ts-check
// A button that turns a setting on and off.

import { find } from "./elements.js"
import { settings } from "./storage.js"

/**
 * Has the button with this name turn a setting on and off. Returns whether it is on.
 * @param {string} name
 * @param {(on: boolean) => void} [changed]
 * @param {boolean} [first] whether it is on until somebody presses the button
 */
export function setting(name, changed = () => {}, first = true) {
  const button = find(name)
  const isOn = () => button.getAttribute("aria-pressed") === "true"
  const show = (/** @type {boolean} */ on) => {
    button.setAttribute("aria-pressed", String(on))
    changed(on)
  }
  show(Boolean(settings.get(name, first)))
  button.addEventListener("click", () => {
    show(!isOn())
    settings.set(name, isOn())
  })
  return isOn
}

// @ts-check
// A button that turns a setting on and off.

import { find } from "./elements.js"
import { settings } from "./storage.js"

/**
 * Has a button turn a setting on and off, which is on until somebody turns it off. Returns whether it is on.
 * @param {string} name
 * @param {(on: boolean) => void} [changed]
 */
export function setting(name, changed = () => {}) {
  const button = find(name)
  const isOn = () => button.getAttribute("aria-pressed") === "true"
  const show = (/** @type {boolean} */ on) => {
    button.setAttribute("aria-pressed", String(on))
    changed(on)
  }
  show(Boolean(settings.get(name, true)))
  button.addEventListener("click", () => {
    show(!isOn())
    settings.set(name, isOn())
  })
  return isOn
}

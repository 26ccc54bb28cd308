// @ts-check
// Scenes by their names: which one plays, and a way to begin with another one.

import { find, findA } from "../base/elements.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"
import { seek } from "./seek.js"


const list = findA("scene", HTMLSelectElement)
list.addEventListener("change", () => seek(begins()[list.selectedIndex]))

/** The beats at which scenes begin. */
const begins = () => program.current?.score.scenes ?? []

/** @param {Messages["score"]} score */
export function showScenes({ scene, scenes, scene_names: names }) {
  list.replaceChildren(...scenes.map((_, index) => new Option(names[scene + index] || `scene ${scene + index + 1}`)))
  find("scenes").hidden = scenes.length < 2
  showScene()
}

/** Shows which scene plays. */
export function showScene() {
  const beat = clock.atStart ? 0 : clock.beat() + 1e-6
  const now = Math.max(begins().findLastIndex((begin) => begin <= beat), 0)
  if (list.options.length && list.selectedIndex !== now) list.selectedIndex = now
}

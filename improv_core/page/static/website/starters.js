// @ts-check
// Small programs to begin with. They replace what is written, which can be undone.

import { findA } from "../base/elements.js"

/** @import { Saving } from "../editor/saving.js" */

/** @type {[name: string, program: string][]} */
export const STARTERS = [
  [
    "a square",
    `beat 60
turtle1 $ repeat 4 (forward left)
`,
  ],
  [
    "a flower",
    `beat 120
petal = repeat 4 (forward || left)
turtle1 $ repeat 6 (petal left halfright)
`,
  ],
  [
    "a canon",
    `beat 100
wave = (forward || halfleft) (forward || halfright)
ada bo cleo $ canon 2 (wave reflect sagittal wave)
`,
  ],
  [
    "a puppet",
    `beat 80
ada is puppet
wave = to high [right left right left] [right left right left] to start
ada $ forward || head left
ada $ right_arm wave || head (right right left rest)
`,
  ],
]

/**
 * Offers them. (A website has more of them, with pictures.)
 * @param {Saving} saving
 */
export function offerStarters(saving) {
  const menu = findA("starters", HTMLSelectElement)
  menu.hidden = false
  menu.append(...STARTERS.map(([name]) => new Option(name)))
  menu.addEventListener("change", () => {
    const [, program] = STARTERS[menu.selectedIndex - 1] ?? []
    menu.selectedIndex = 0
    if (program) saving.replace(program)
  })
}

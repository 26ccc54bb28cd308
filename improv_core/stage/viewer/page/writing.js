// @ts-check
// What helps to write and to pass on a program, besides the editor: words to tap, dances to begin with, links, files.

import { Class, isClass } from "./class.js"
import { findA } from "./elements.js"
import { Examples } from "./examples.js"
import { Guide } from "./guide.js"
import { isWebsite } from "./home.js"
import { Share } from "./share.js"
import { offerStarters } from "./starters.js"
import { getToml, setToml } from "./worker-home.js"
import { WordRow } from "./word-row.js"

/** @import { Saving } from "./saving.js" */

/**
 * @param {Saving} saving
 * @param {() => number} getBeat where the dance stands, if somebody has paused it
 */
export function offerHelp(saving, getBeat) {
  new WordRow(findA("text", HTMLTextAreaElement))
  if (isWebsite) {
    const play = (/** @type {string} */ text, toml = "") => {
      if (toml !== getToml()) setToml(toml)
      saving.replace(text)
      saving.write()
    }
    new Examples(play)
    new Guide(play)
    new Share(saving, getBeat)
  } else offerStarters(saving)
  if (isClass) new Class(saving)
}

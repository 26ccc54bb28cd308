// @ts-check
// Aids for writing and passing on a program, besides the editor: words to tap, dances to begin with, links, files.

import { Class, isClass } from "../website/class.js"
import { findA } from "../base/elements.js"
import { Examples } from "../website/examples.js"
import { Guide } from "../website/guide.js"
import { isWebsite } from "../net/backend.js"
import { Share } from "../website/share.js"
import { offerStarters } from "../website/starters.js"
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
      saving.replace(text, toml)
      saving.write()
    }
    new Examples(play)
    new Guide(play)
    new Share(saving, getBeat)
  } else offerStarters(saving)
  if (isClass) new Class(saving)
}

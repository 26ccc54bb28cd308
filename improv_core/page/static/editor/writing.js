// @ts-check
// Aids for writing and passing on a program, besides the editor: words to tap, dances to begin with, links, files.

import { isClass, joinClass } from "../website/class.js"
import { findA } from "../base/elements.js"
import { offerExamples } from "../website/examples.js"
import { offerGuide } from "../website/guide.js"
import { isWebsite } from "../net/backend.js"
import { offerSharing } from "../website/share.js"
import { offerStarters } from "../website/starters.js"
import { offerWords } from "./word-row.js"

/** @import { Saving } from "./saving.js" */

/**
 * @param {Saving} saving
 * @param {() => number} getBeat where the dance stands, if somebody has paused it
 */
export function offerHelp(saving, getBeat) {
  offerWords(findA("text", HTMLTextAreaElement))
  if (isWebsite) {
    const play = (/** @type {string} */ text, toml = "") => {
      saving.replace(text, toml)
      saving.write()
    }
    offerExamples(play)
    offerGuide(play)
    offerSharing(saving, getBeat)
  } else offerStarters(saving)
  if (isClass) joinClass(saving)
}

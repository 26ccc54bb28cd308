// @ts-check
// Aids for writing and passing on a program, besides the editor: words to tap, dances to begin with, links, files.

import { isClass, joinClass } from "../website/class.js"
import { findA } from "../base/elements.js"
import { offerExamples } from "../website/examples.js"
import { offerGuide } from "../website/guide.js"
import { isWebsite } from "../net/backend.js"
import { offerSharing } from "../website/share.js"
import { offerWords } from "./word-row.js"

/** @import { Saving } from "./saving.js" */
/** @import { Still } from "../website/still.js" */

/**
 * @param {Saving} saving
 * @param {() => number} getBeat where the dance stands, if somebody has paused it
 * @param {(text: string) => Still} getStill the picture of a text's paths
 */
export function offerHelp(saving, getBeat, getStill) {
  offerWords(findA("text", HTMLTextAreaElement))
  // On a website, that plays at once. Elsewhere, real robots may play, and a file is written: that takes another press.
  const take = (/** @type {string} */ text, toml = "") => {
    saving.replace(text, isWebsite ? toml : undefined)
    if (isWebsite) saving.write()
  }
  offerExamples(take)
  offerGuide(take)
  offerSharing(saving, getBeat, getStill)
  if (isClass) joinClass(saving)
}

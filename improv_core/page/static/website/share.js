// @ts-check
// Passes a program on: as a link, as a QR code, or as a file. Only on a website, which anybody can open.

import { find, findA, svgAddress } from "../base/elements.js"
import { chooseFile, saveText, textOf } from "./files.js"
import { TOO_LONG, UNFIT, fragmentOf, isTooLong, workIn } from "./link.js"
import { drawCode, getToml, setToml } from "../net/worker-backend.js"

/** @import { Saving } from "../editor/saving.js" */

const MOST_IN_CODE = 2_900 // characters: a QR code of this size can still be read from a screen

/**
 * @param {Saving} saving has the text on the page
 * @param {() => number} getBeat the position of a paused dance: people who open the link begin there
 */
export function offerSharing(saving, getBeat) {
  const dialog = findA("sharing", HTMLDialogElement)
  const address = findA("link", HTMLInputElement)
  const toml = findA("toml", HTMLTextAreaElement)
  const code = findA("code", HTMLImageElement)
  const say = (/** @type {string} */ line) => (find("sharing-line").textContent = line)

  async function showLink() {
    const { origin, pathname } = location
    const work = { text: saving.text, toml: getToml(), beat: getBeat() }
    const fragment = await fragmentOf(work)
    const link = `${origin}${pathname}${fragment}`
    const problem = isTooLong(link) ? TOO_LONG : typeof (await workIn(fragment)) === "string" ? UNFIT : ""
    find("linked").hidden = problem !== ""
    address.value = problem ? "" : link
    say(problem)
    const begins = work.beat ? `; it begins at beat ${Math.floor(work.beat) + 1}, where it is paused` : ""
    find("link-length").textContent = `${link.length.toLocaleString("en")} characters; all of the dance is in it${begins}`
    const drawn = !problem && link.length <= MOST_IN_CODE ? await drawCode(link) : null
    code.hidden = !drawn
    if (drawn) code.src = svgAddress(drawn)
  }

  find("share").hidden = false
  find("share").addEventListener("click", async () => {
    toml.value = getToml()
    findA("toml-part", HTMLDetailsElement).open = toml.value !== ""
    dialog.showModal()
    await showLink()
  })
  find("copy-link").addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(address.value)
      say("Copied.")
    } catch {
      address.select()
      say("Press Ctrl+C to copy it.")
    }
  })
  find("save-file").addEventListener("click", async () => say(await saveText("dance.improv", saving.text)))
  find("choose-file").addEventListener("click", async () => {
    const chosen = await chooseFile()
    if (!chosen) return
    const text = await textOf(chosen)
    if (text === null) say(`${chosen.name} is no text of at most 100,000 characters: choose an .improv file`)
    else {
      dialog.close()
      saving.replace(text)
    }
  })
  find("use-toml").addEventListener("click", async () => {
    const kept = setToml(toml.value)
    await showLink()
    say(kept ? "This holds from the next time on that you play." : "This browser has no room to keep it.")
  })
}

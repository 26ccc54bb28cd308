// @ts-check
// Passes a program on: as a link to a website, which anybody can open, as a QR code, or as a file.

import { find, findA, svgAddress } from "../base/elements.js"
import { saveText, textOf } from "./files.js"
import { TOO_LONG, UNFIT, fragmentOf, isTooLong, workIn } from "./link.js"
import { settings } from "../base/storage.js"
import { isWebsite, keptToml } from "../net/backend.js"
import { drawCode } from "../net/worker-backend.js"

/** @import { Saving } from "../editor/saving.js" */
/** @import { Still } from "./still.js" */

const NO_SITE = "To get a link, enter the address of a website that improv site has built."
const MAX_IN_CODE = 2_900 // characters: a QR code of this size can still be read from a screen
const MAX_WITH_STILL = 2_000 // characters: a longer link has no room for a picture

/**
 * @param {Saving} saving has the text on the page
 * @param {() => number} getBeat the position of a paused dance: people who open the link begin there
 * @param {(text: string) => Still} getStill the picture that they see first
 */
export function offerSharing(saving, getBeat, getStill) {
  const dialog = findA("sharing", HTMLDialogElement)
  const address = findA("link", HTMLInputElement)
  const toml = findA("toml", HTMLTextAreaElement)
  const code = findA("code", HTMLImageElement)
  const site = findA("site", HTMLInputElement)
  const say = (/** @type {string} */ line) => (find("sharing-line").textContent = line)

  async function showLink() {
    const work = { text: saving.text, toml: saving.toml, beat: getBeat(), still: getStill(saving.text) }
    const pictured = await fragmentOf(work)
    const fragment = pictured.length > MAX_WITH_STILL ? await fragmentOf({ ...work, still: [] }) : pictured
    const link = `${isWebsite ? location.origin + location.pathname : site.value}${fragment}`
    const problem = !isWebsite && (!site.value || !site.validity.valid) ? NO_SITE : isTooLong(link) ? TOO_LONG : typeof (await workIn(fragment)) === "string" ? UNFIT : ""
    find("linked").hidden = problem !== ""
    address.value = problem ? "" : link
    say(problem)
    const begins = work.beat ? `; it begins at beat ${Math.floor(work.beat) + 1}, where it is paused` : ""
    find("link-length").textContent = `${link.length.toLocaleString("en")} characters; all of the dance is in it${begins}`
    code.hidden = !isWebsite || problem !== "" || link.length > MAX_IN_CODE // its room is kept, so nothing moves later
    code.removeAttribute("src")
    const drawn = code.hidden ? null : await drawCode(link)
    if (drawn) code.src = svgAddress(drawn)
  }

  site.value = String(settings.get("site", ""))
  site.addEventListener("input", () => {
    settings.set("site", site.value)
    showLink()
  })
  find("share").addEventListener("click", async () => {
    toml.value = saving.toml
    findA("toml-part", HTMLDetailsElement).open = toml.value !== ""
    dialog.show()
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
  const chosen = findA("open-file", HTMLInputElement)
  find("choose-file").addEventListener("click", () => chosen.click())
  chosen.addEventListener("change", async () => {
    const [file] = chosen.files ?? []
    if (!file) return
    chosen.value = ""
    const text = await textOf(file)
    if (text === null) say(`${file.name} is no text of at most 100,000 characters: choose an .improv file`)
    else {
      dialog.close()
      saving.replace(text)
    }
  })
  find("use-toml").addEventListener("click", async () => {
    const kept = keptToml.set(toml.value)
    await showLink()
    say(kept ? "This holds from the next time on that you play." : "This browser has no room to keep it.")
  })
}

// @ts-check
// Passes a program on: as a link, as a QR code, or as a file. Only on a website, which anybody can open.

import { find, findA } from "./elements.js"
import { TOO_LONG, fragmentOf, isTooLong } from "./link.js"
import { download } from "./save.js"
import { drawCode, getToml } from "./worker-home.js"

/** @import { Saving } from "./saving.js" */

const MOST_IN_CODE = 2_900 // characters: a QR code of this size can still be read from a screen

export class Share {
  #dialog = findA("sharing", HTMLDialogElement)
  #link = findA("link", HTMLInputElement)
  #saving

  /** @param {Saving} saving has the text on the page */
  constructor(saving) {
    this.#saving = saving
    find("share").hidden = false
    find("share").addEventListener("click", () => this.#open())
    find("copy-link").addEventListener("click", () => this.#copy())
    find("save-file").addEventListener("click", () => {
      download("dance.improv", new Blob([saving.text], { type: "text/plain;charset=utf-8" }))
    })
    const file = findA("open-file", HTMLInputElement)
    find("choose-file").addEventListener("click", () => file.click())
    file.addEventListener("change", async () => {
      const chosen = file.files?.[0]
      file.value = ""
      if (!chosen) return
      const text = await textOf(chosen)
      if (text === null) this.#say(`${chosen.name} is no text of at most 100,000 characters: choose an .improv file`)
      else {
        saving.replace(text)
        this.#dialog.close()
      }
    })
  }

  async #open() {
    this.#say("")
    const { origin, pathname } = location
    const work = { text: this.#saving.text, toml: getToml(), beat: 0 }
    const link = `${origin}${pathname}${await fragmentOf(work)}`
    const tooLong = isTooLong(link)
    find("linked").hidden = tooLong
    this.#link.value = tooLong ? "" : link
    if (tooLong) this.#say(TOO_LONG)
    else find("link-length").textContent = `${link.length.toLocaleString("en")} characters; all of the dance is in it`
    this.#dialog.showModal()
    const code = findA("code", HTMLImageElement)
    const drawn = link.length <= MOST_IN_CODE ? await drawCode(link) : null
    code.hidden = !drawn
    if (drawn) code.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(drawn)}`
  }

  async #copy() {
    try {
      await navigator.clipboard.writeText(this.#link.value)
      this.#say("Copied.")
    } catch {
      this.#link.select()
      this.#say("Press Ctrl+C to copy it.")
    }
  }

  /** @param {string} line */
  #say(line) {
    find("sharing-line").textContent = line
  }
}

/** The text in a file; null if it is too long or no text. @param {File} file */
async function textOf(file) {
  if (file.size > 400_000) return null
  try {
    const text = new TextDecoder("utf-8", { fatal: true }).decode(await file.arrayBuffer()).replaceAll("\r\n", "\n")
    return text.length <= 100_000 ? text : null
  } catch {
    return null
  }
}

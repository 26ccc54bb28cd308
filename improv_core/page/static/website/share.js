// @ts-check
// Passes a program on: as a link, as a QR code, or as a file. Only on a website, which anybody can open.

import { find, findA } from "../base/elements.js"
import { chooseFile, saveText, textOf } from "./files.js"
import { TOO_LONG, UNFIT, fragmentOf, isTooLong, workIn } from "./link.js"
import { drawCode, getToml, setToml } from "../net/worker-backend.js"

/** @import { Saving } from "../editor/saving.js" */

const MOST_IN_CODE = 2_900 // characters: a QR code of this size can still be read from a screen

export class Share {
  #dialog = findA("sharing", HTMLDialogElement)
  #link = findA("link", HTMLInputElement)
  #toml = findA("toml", HTMLTextAreaElement)
  #saving
  #getBeat

  /**
   * @param {Saving} saving has the text on the page
   * @param {() => number} getBeat the position of a paused dance: people who open the link begin there
   */
  constructor(saving, getBeat) {
    this.#saving = saving
    this.#getBeat = getBeat
    find("share").hidden = false
    find("share").addEventListener("click", () => this.#open())
    find("copy-link").addEventListener("click", () => this.#copy())
    find("save-file").addEventListener("click", async () => this.#say(await saveText("dance.improv", saving.text)))
    find("choose-file").addEventListener("click", () => this.#openFile())
    find("use-toml").addEventListener("click", async () => {
      const kept = setToml(this.#toml.value)
      await this.#show()
      this.#say(kept ? "This holds from the next time on that you play." : "This browser has no room to keep it.")
    })
  }

  async #open() {
    this.#toml.value = getToml()
    findA("toml-part", HTMLDetailsElement).open = this.#toml.value !== ""
    this.#dialog.showModal()
    await this.#show()
  }

  /** Shows the link. */
  async #show() {
    const { origin, pathname } = location
    const work = { text: this.#saving.text, toml: getToml(), beat: this.#getBeat() }
    const fragment = await fragmentOf(work)
    const link = `${origin}${pathname}${fragment}`
    const problem = isTooLong(link) ? TOO_LONG : typeof (await workIn(fragment)) === "string" ? UNFIT : ""
    find("linked").hidden = problem !== ""
    this.#link.value = problem ? "" : link
    this.#say(problem)
    const begins = work.beat ? `; it begins at beat ${Math.floor(work.beat) + 1}, where it is paused` : ""
    find("link-length").textContent = `${link.length.toLocaleString("en")} characters; all of the dance is in it${begins}`
    const code = findA("code", HTMLImageElement)
    const drawn = !problem && link.length <= MOST_IN_CODE ? await drawCode(link) : null
    code.hidden = !drawn
    if (drawn) code.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(drawn)}`
  }

  async #openFile() {
    const chosen = await chooseFile()
    if (!chosen) return
    const text = await textOf(chosen)
    if (text === null) this.#say(`${chosen.name} is no text of at most 100,000 characters: choose an .improv file`)
    else {
      this.#dialog.close()
      this.#saving.replace(text)
    }
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

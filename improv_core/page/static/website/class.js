// @ts-check
// Sends the dance to the teacher of a class. Only on a website that the server of a class shows.

import { find, findA } from "../base/elements.js"
import { decoded } from "./link.js"

/** @import { Saving } from "../editor/saving.js" */

const KEY = "improv.class"
const IN_LINK = /^#class=([A-Za-z0-9]{1,12})$/
const SEND_PERIOD = 1100 // milliseconds: one dance in a second

/** True if this page belongs to a class. */
export const isClass = document.querySelector('meta[name="improv-class"]') !== null

export class Class {
  #dialog = findA("class", HTMLDialogElement)
  #name = findA("class-name", HTMLInputElement)
  #code = findA("class-code", HTMLInputElement)
  #saving
  #secret = sessionStorage.getItem(KEY) ?? ""

  /** @param {Saving} saving has the text on the page */
  constructor(saving) {
    this.#saving = saving
    find("hand-in").hidden = false
    find("hand-in").addEventListener("click", () => (this.#secret ? this.#send() : this.#dialog.showModal()))
    find("class-join").addEventListener("click", () => this.#join())
    find("class-close").addEventListener("click", () => this.#dialog.close())
    this.#dialog.addEventListener("keydown", (event) => event.key === "Enter" && event.target !== find("class-close") && this.#join())
    const code = IN_LINK.exec(decoded(location.hash))?.[1]
    if (!code) return
    this.#code.value = code
    history.replaceState(null, "", location.pathname)
    if (!this.#secret) this.#dialog.showModal()
  }

  async #join() {
    const answer = await post("join", JSON.stringify({ code: this.#code.value, name: this.#name.value }))
    find("class-line").textContent = answer.problem ?? ""
    if (!answer.secret) return
    this.#secret = answer.secret
    sessionStorage.setItem(KEY, answer.secret)
    this.#dialog.close()
    say(`You are in the class as ${answer.name}.`)
  }

  async #send() {
    let answer = await post("send", this.#saving.text, this.#secret)
    if (answer.status === 429) {
      await new Promise((done) => setTimeout(done, SEND_PERIOD))
      answer = await post("send", this.#saving.text, this.#secret)
    }
    say(answer.problem ?? `Sent at ${new Date().toLocaleTimeString()}.`)
    if (answer.status !== 403) return
    this.#secret = ""
    sessionStorage.removeItem(KEY)
    this.#dialog.showModal()
  }
}

/** @param {string} line */
function say(line) {
  find("handed-in").textContent = line
}

/**
 * @param {string} what
 * @param {string} body
 * @param {string} secret of the child, once it has joined
 * @returns {Promise<{ status: number, secret?: string, name?: string, problem?: string }>}
 */
async function post(what, body, secret = "") {
  try {
    const answer = await fetch(`class/${what}`, { method: "POST", headers: { Authorization: `Bearer ${secret}` }, body })
    return { status: answer.status, ...(await answer.json().catch(() => ({ problem: "this can't be sent: ask your teacher" }))) }
  } catch {
    return { status: 0, problem: "the class can't be reached: ask your teacher" }
  }
}

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

/** @param {Saving} saving has the text on the page */
export function joinClass(saving) {
  const dialog = findA("class", HTMLDialogElement)
  const name = findA("class-name", HTMLInputElement)
  const code = findA("class-code", HTMLInputElement)
  let secret = sessionStorage.getItem(KEY) ?? ""

  async function join() {
    const answer = await post("join", JSON.stringify({ code: code.value, name: name.value }))
    find("class-line").textContent = answer.problem ?? ""
    if (!answer.secret) return
    secret = answer.secret
    sessionStorage.setItem(KEY, secret)
    dialog.close()
    say(`You are in the class as ${answer.name}.`)
  }

  async function send() {
    let answer = await post("send", saving.text, secret)
    if (answer.status === 429) {
      await new Promise((done) => setTimeout(done, SEND_PERIOD))
      answer = await post("send", saving.text, secret)
    }
    say(answer.problem ?? `Sent at ${new Date().toLocaleTimeString()}.`)
    if (answer.status !== 403) return
    secret = ""
    sessionStorage.removeItem(KEY)
    dialog.showModal()
  }

  find("hand-in").hidden = false
  find("hand-in").addEventListener("click", () => (secret ? send() : dialog.showModal()))
  find("class-join").addEventListener("click", join)
  find("class-close").addEventListener("click", () => dialog.close())
  dialog.addEventListener("keydown", (event) => event.key === "Enter" && event.target !== find("class-close") && join())
  const linked = IN_LINK.exec(decoded(location.hash))?.[1]
  if (!linked) return
  code.value = linked
  history.replaceState(null, "", location.pathname)
  if (!secret) dialog.showModal()
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

// @ts-check
// Sends the dance to the teacher of a class. Only on a website that the server of a class shows.

import { find, findA } from "../base/elements.js"
import { store, stored } from "../base/storage.js"
import { answered, asked, describe, MAX_TRIES, UNSENT } from "./handing-in.js"
import { decoded } from "./link.js"

/** @import { Saving } from "../editor/saving.js" */
/** @typedef {{ secret: string, name: string, code: string, received?: string, at?: number }} Child a child in the class with this code, and the dance that the class has */

const KEY = "improv.class"
const LEFT = "improv.class.left"
const IN_LINK = /^#class=([A-Za-z0-9]{1,12})$/
const SEND_PERIOD = 1100 // milliseconds: one dance in a second
const SIGN_PERIOD = 30_000 // milliseconds
const PATIENCE = 15_000 // milliseconds for an answer

/** True if this page belongs to a class. */
export const isClass = document.querySelector('meta[name="improv-class"]') !== null

/** @param {Saving} saving has the text on the page */
export function joinClass(saving) {
  const dialog = findA("class", HTMLDialogElement)
  const name = findA("class-name", HTMLInputElement)
  const code = findA("class-code", HTMLInputElement)
  let child = /** @type {Child | null} */ (null)
  let state = UNSENT
  let sendsNext = false // as soon as the child has joined
  let isJoining = false

  async function join() {
    if (isJoining) return
    isJoining = true
    const answer = await post("join", JSON.stringify({ code: code.value, name: name.value }))
    isJoining = false
    find("class-line").textContent = answer.problem ?? ""
    if (!answer.secret) return
    become({ secret: answer.secret, name: answer.name ?? "", code: code.value.replace(/\W/g, "").toUpperCase() })
    dialog.close()
    if (sendsNext) send()
  }

  async function send() {
    const isOnItsWay = state.state === "sending"
    state = asked(state, saving.text)
    show()
    if (isOnItsWay) return
    const secret = child?.secret
    let answer = await post("send", state.text, secret)
    for (let tries = 1; answer.status === 429 && tries < MAX_TRIES; tries++) {
      await new Promise((done) => setTimeout(done, SEND_PERIOD))
      answer = await post("send", state.text, secret)
    }
    if (!child || child.secret !== secret) return // another one has joined meanwhile
    state = answered(state, answer, Date.now())
    if (state.state === "sent") become({ ...child, received: state.received, at: state.at })
    if (answer.status === 403) {
      leave()
      ask(true)
    }
    show()
    if (state.again) send()
  }

  /** Another lesson has begun, or the teacher has sent this child out. */
  function leave() {
    name.value = child?.name ?? ""
    code.value = ""
    become(null)
  }

  /** Asks for the child's name. @param {boolean} sends the dance after that */
  function ask(sends) {
    sendsNext = sends
    if (!dialog.open) dialog.showModal()
  }

  /** @param {Child | null} another */
  function become(another) {
    store(KEY, another)
    take(another)
  }

  /** @param {Child | null} kept by this browser, which has one place in the class, whatever its tabs */
  function take(kept) {
    const { received = "", at = 0 } = kept ?? {}
    const isAnother = kept !== null && kept.secret !== child?.secret
    state = { ...(isAnother ? UNSENT : state), received, at }
    child = kept
    show()
    if (isAnother) sign("here")
  }

  /** Tells the class that this page is open, or that it closes. @param {"here" | "left"} what */
  function sign(what) {
    if (!child) return
    const { secret } = child
    const answer = fetch(`class/${what}`, { method: "POST", headers: { Authorization: `Bearer ${secret}` }, keepalive: true })
    answer.then(({ status }) => {
      if (status !== 403 || child?.secret !== secret || state.state === "sending") return
      leave()
      state = { ...UNSENT, state: "out" }
      show()
    }, () => null) // the next sign may arrive
  }

  function show() {
    const line = describe(state, saving.text)
    find("handed-in").textContent = child ? `${child.name}: ${line}` : state.problem || state.state === "out" ? line : ""
    find("not-me").textContent = child && `Not ${child.name}?`
    find("not-me").hidden = !child
    find("handed-in").classList.toggle("wrong", state.state === "failed")
  }

  for (const id of ["hand-in", "help-send"]) find(id).hidden = false
  find("hand-in").addEventListener("click", () => (child ? send() : ask(true)))
  find("not-me").addEventListener("click", () => {
    name.value = ""
    ask(false)
  })
  dialog.addEventListener("submit", (event) => {
    event.preventDefault()
    join()
  })
  find("class-close").addEventListener("click", () => dialog.close())
  saving.noticed = show
  addEventListener("storage", ({ key }) => {
    if (key === LEFT) setTimeout(() => sign("here"), SEND_PERIOD) // after the sign of the tab that was closed
    else take(stored(KEY)) // another tab has joined or sent
  })
  take(stored(KEY))
  setInterval(() => sign("here"), SIGN_PERIOD)
  document.addEventListener("visibilitychange", () => document.hidden || sign("here")) // it may have slept
  addEventListener("pagehide", () => {
    sign("left")
    store(LEFT, Date.now())
  })
  const linked = IN_LINK.exec(decoded(location.hash))?.[1]
  if (!linked) return
  code.value = linked
  history.replaceState(null, "", location.pathname)
  if (child?.code === linked) return
  name.value = child?.name ?? ""
  become(null) // of another lesson
  ask(false)
}

/**
 * @param {string} what
 * @param {string} body
 * @param {string} secret of the child, once it has joined
 * @returns {Promise<{ status: number, secret?: string, name?: string, problem?: string }>}
 */
async function post(what, body, secret = "") {
  try {
    const headers = { Authorization: `Bearer ${secret}` }
    const answer = await fetch(`class/${what}`, { method: "POST", headers, body, signal: AbortSignal.timeout(PATIENCE) })
    return { status: answer.status, ...(await answer.json().catch(() => ({ problem: "this can't be sent: ask your teacher" }))) }
  } catch {
    return { status: 0, problem: "the class doesn't answer: tap Send again, or ask your teacher" }
  }
}

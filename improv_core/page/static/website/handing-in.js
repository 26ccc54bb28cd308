// @ts-check
// The state of a child's dance on its way to the teacher: one at a time, shown truthfully.

import { when } from "../base/when.js"

/**
 * @typedef {object} HandingIn
 * @property {"unsent" | "sending" | "sent" | "failed" | "out"} state "out": of the class
 * @property {string} text that is or was sent last
 * @property {string} received the text that the class has received last
 * @property {number} at when it has, in milliseconds since 1970; 0 if never
 * @property {string} problem why the class has not received the text
 * @property {boolean} again send again as soon as the answer is there: the text has changed since
 */
/** @typedef {{ status: number, problem?: string }} Answer */

export const MAX_TRIES = 5 // of a dance that follows another one too soon

/** @type {HandingIn} */
export const UNSENT = { state: "unsent", text: "", received: "", at: 0, problem: "", again: false }

/**
 * Somebody wants to send a text. One that is on its way isn't sent twice.
 * @param {HandingIn} now
 * @param {string} text
 * @returns {HandingIn}
 */
export function asked(now, text) {
  if (now.state === "sending") return { ...now, again: now.text !== text }
  return { ...now, state: "sending", text, problem: "", again: false }
}

/**
 * The class has answered, or nobody has.
 * @param {HandingIn} now
 * @param {Answer} answer
 * @param {number} at
 * @returns {HandingIn}
 */
export function answered(now, { status, problem }, at) {
  if (status === 200) return { ...now, state: "sent", received: now.text, at, problem: "" }
  return { ...now, state: "failed", problem: problem ?? "ask your teacher", again: false }
}

/** What the child reads, while this text is on its page. @param {HandingIn} now @param {string} text */
export function describe({ state, received, at, problem }, text) {
  if (state === "sending") return "Sending…"
  if (state === "failed") return `Not received: ${problem}.`
  if (state === "out") return "You are no longer in the class: tap Send to join again."
  if (!at) return "Not sent yet."
  return received === text ? `Sent at ${when(at)}.` : `Changed since you sent it at ${when(at)}.`
}

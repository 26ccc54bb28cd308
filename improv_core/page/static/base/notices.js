// @ts-check
// The page's messages to people: its connection, and news for screen readers.

import { button, find, write } from "./elements.js"
import { refit } from "./frames.js"

/** @typedef {"opening" | "open" | "lost" | "refused" | "over"} Connection */

/** @type {Partial<Record<Connection, string>>} */
const NOTICES = {
  lost: "Disconnected. Trying again…",
  refused:
    "This address works only once. To open the page again, press o in the terminal where Improv runs, or open it from your editor.",
}
const RESTARTED =
  "Improv was started again. Open its page once more from your editor, or press o in the terminal: this tab continues then, too."
const BRIEF_TIME = 2500 // milliseconds for which it is shown what a key did

/** @param {string} who has yet to obey it, if that is known */
const unconfirmed = (who) => `Stop is not confirmed yet${who && ` by ${who}`}. Trying again…`
const OVER = "The performance is over. Play again from your editor or terminal."
const EDITED = "Improv has ended. To continue, run improv edit in the terminal. This browser keeps text that isn't saved."

export class Notices {
  #ending = "" // why the stage has ended, if it has
  #notice = "" // about the connection
  #wasOpen = false
  #unconfirmed = "" // that a stop is not confirmed
  /** @type {Connection} */
  connection = "opening"

  /** @param {Messages["stopped"]} message the last one of the stage */
  takeStopped({ message }) {
    this.#ending = message ? `The stage has failed: ${message}. Play again.` : document.body.classList.contains("editing") ? EDITED : OVER
  }

  /** @param {"open" | "lost" | "refused"} now */
  change(now) {
    if (now === "open") [this.#ending, this.#wasOpen] = ["", true]
    const over = now === "lost" && this.#ending !== ""
    const notice = over ? this.#ending : now === "refused" && this.#wasOpen ? RESTARTED : (NOTICES[now] ?? "")
    if (notice || this.connection !== "opening") announce(notice || "Connected again")
    this.connection = over ? "over" : now
    document.body.dataset.connection = this.connection
    this.#notice = notice
    this.#show()
  }

  /** @param {string} line about what is still being loaded */
  load(line) {
    this.#notice = line
    this.#show()
  }

  /**
   * @param {boolean} waits whether a stop that somebody has pressed has not been confirmed for a while
   * @param {string} who has yet to obey it, if that is known
   */
  waitForStop(waits, who) {
    this.#unconfirmed = waits ? unconfirmed(who) : ""
    if (waits) announce(this.#unconfirmed)
    this.#show()
  }

  /**
   * @param {Messages["why_still"]} message says why real robots stand; its line is empty if they don't
   * @param {(beat: number) => void} resume continues from a beat, after a stop that nobody asked for
   */
  takeWhyStill({ line, resumes }, resume) {
    find("stands").hidden = !line
    find("stands").replaceChildren(line)
    if (resumes) {
      const { scene, beat } = resumes
      for (const [place, from] of /** @type {const} */ ([["scene", scene], ["beat", beat]]))
        find("stands").append(" ", button({ textContent: `Resume from this ${place}` }, () => resume(from)))
    }
    if (line) announce(line)
    refit()
  }

  /** True while the page is connected. */
  get isOpen() {
    return this.connection === "open"
  }

  #show() {
    const notice = this.#unconfirmed || this.#notice
    find("notice").hidden = !notice
    find("notice").textContent = notice
    find("notice").classList.toggle("urgent", this.#unconfirmed !== "")
  }
}

/** Tells screen readers. @param {string} text */
export function announce(text) {
  write(find("news"), text)
}

let briefly = 0 // the timer that hides what was done

/** Shows for a while what a key or a hand did. @param {string} line */
export function showBriefly(line) {
  find("did").textContent = line
  find("did").hidden = false
  announce(line)
  clearTimeout(briefly)
  briefly = window.setTimeout(() => (find("did").hidden = true), BRIEF_TIME)
}

export const notices = new Notices()

// @ts-check
// What the page tells people: whether it is connected, and news for those who listen.

import { find } from "./elements.js"

/** @import { Messages } from "./messages.js" */
/** @typedef {"opening" | "open" | "lost" | "refused" | "over"} Connection */

/** @type {Partial<Record<Connection, string>>} */
const NOTICES = {
  lost: "Disconnected. Trying again…",
  refused: "This link has expired: it opens the page once. Open the page again from your editor or terminal.",
}
const OVER = "The performance is over. Play again from your editor or terminal."

export class Notices {
  #ending = "" // why the stage has ended, if it has
  /** @type {Connection} */
  connection = "opening"

  /** @param {Messages["stopped"]} message the last one of the stage */
  end({ message }) {
    this.#ending = message ? `The stage has failed: ${message}. Play again.` : OVER
  }

  /** @param {"open" | "lost" | "refused"} now */
  change(now) {
    if (now === "open") this.#ending = ""
    const over = now === "lost" && this.#ending !== ""
    const notice = over ? this.#ending : (NOTICES[now] ?? "")
    if (notice || this.connection !== "opening") this.announce(notice || "Connected again")
    this.connection = over ? "over" : now
    document.body.dataset.connection = this.connection
    find("notice").hidden = !notice
    find("notice").textContent = notice
  }

  /** @param {string} text for screen readers */
  announce(text) {
    if (find("news").textContent !== text) find("news").textContent = text
  }
}

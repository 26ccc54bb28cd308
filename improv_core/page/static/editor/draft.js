// @ts-check
// What becomes of a text that is being written: which version of the file it is an edit of, and what is kept of it in
// the browser, so that no text is lost: unsaved text, and the one of two versions that was not chosen.

import { randomName } from "../base/random.js"

/** @typedef {{ path: string, text: string, revision: string }} Source a version of the file */
/** @typedef {{ text: string, time: number }} Other a text that was put aside, and when, in milliseconds since 1970 */
/** @typedef {{ path: string, text: string, revision: string, others: Other[], time: number }} Kept */

const KEY = "improv.draft."
const TAB = "improv.tab"

export class Draft {
  #key = KEY + tab()
  /** @type {Source} */
  base
  /** @type {Source | null} */
  changed = null // what another program has put into the file since then
  /** @type {Other[]} */
  #others = [] // texts that somebody may want back, until somebody drops them
  isKept = true // whether the browser keeps texts

  /** @param {Source} source what the file holds when the page is opened */
  constructor(source) {
    this.base = source
  }

  /** The text to begin with: of this tab before it was reloaded, or of the file. */
  begin() {
    const kept = read(this.#key)
    const own = kept?.path === this.base.path ? kept : null
    this.#others = own ? own.others : adopted(this.base)
    if (!own || own.text === this.base.text) return this.base.text
    if (own.revision !== this.base.revision) {
      this.changed = this.base
      this.base = { ...this.base, text: "", revision: own.revision }
    }
    return own.text
  }

  /**
   * Takes what the file holds now, while the page has a text. Returns the text to show, if that is another.
   * @param {Source} source
   * @param {string} text
   * @param {string | null} writing the text that is just being saved
   */
  take(source, text, writing) {
    const clean = text === this.base.text && !this.changed
    if (source.revision === this.base.revision) {
      this.base = source
      this.changed = null
    } else if (source.text === text || source.text === writing) {
      this.base = source
      this.changed = null
    } else if (clean) {
      this.base = source
      return source.text
    } else this.changed = source
    return null
  }

  /** @param {string} text */
  isSaved(text) {
    return !this.changed && text === this.base.text
  }

  /**
   * Chooses between the file's version and the text of the page; the other one is kept. Returns the text to show.
   * @param {"file" | "mine"} which
   * @param {string} text
   */
  choose(which, text) {
    if (!this.changed) return text
    this.base = this.changed
    this.changed = null
    this.#others.push({ text: which === "file" ? text : this.base.text, time: Date.now() })
    return which === "file" ? this.base.text : text
  }

  /** The text that can be had instead of this one, if there is one. @param {string} text */
  other(text) {
    return this.#others.findLast((each) => each.text !== text) ?? null
  }

  /** The other text. Both are kept, and this one's turn comes last. @param {string} text */
  swap(text) {
    const other = this.other(text)
    if (!other) return text
    const own = this.#others.find((each) => each.text === text) ?? { text, time: Date.now() }
    this.#others = [own, ...this.#others.filter((each) => each.text !== text)]
    return other.text
  }

  /** Drops the other text. @param {string} text that stays */
  drop(text) {
    const other = this.other(text)
    this.#others = this.#others.filter((each) => each !== other && each.text !== text)
  }

  /** This text is in the file now, as revision. @param {string} text @param {string} revision */
  wrote(text, revision) {
    this.base = { ...this.base, text, revision }
    this.#others = this.#others.filter((each) => each.text !== text)
  }

  /**
   * Keeps what is not in the file, across reloads and the end of the browser.
   * @param {string} text
   */
  keep(text) {
    try {
      if (this.isSaved(text) && !this.#others.length) localStorage.removeItem(this.#key)
      else {
        const { path, revision } = this.base
        /** @type {Kept} */
        const kept = { path, text, revision, others: this.#others, time: Date.now() }
        localStorage.setItem(this.#key, JSON.stringify(kept))
      }
      this.isKept = true
    } catch {
      this.isKept = false
    }
  }
}

/** A name for this tab, which lasts as long as the tab does. */
function tab() {
  try {
    const known = sessionStorage.getItem(TAB) ?? randomName()
    sessionStorage.setItem(TAB, known)
    return known
  } catch {
    return randomName()
  }
}

/**
 * The latest text that another tab has left unsaved, and what was put aside there. From now on, this tab keeps it; a tab that still has it keeps it too.
 * @param {Source} source
 * @returns {Other[]}
 */
function adopted({ path, text }) {
  try {
    const found = Object.keys(localStorage)
      .filter((key) => key.startsWith(KEY))
      .map((key) => ({ key, kept: read(key) }))
      .filter(({ kept }) => kept?.path === path && (kept.text !== text || kept.others.length))
      .sort((one, two) => (two.kept?.time ?? 0) - (one.kept?.time ?? 0))[0]
    if (!found?.kept) return []
    localStorage.removeItem(found.key)
    const { others, ...own } = found.kept
    return [...others, { text: own.text, time: own.time }].filter((each) => each.text !== text)
  } catch {
    return []
  }
}

/**
 * @param {string} key
 * @returns {Kept | null}
 */
function read(key) {
  try {
    const kept = JSON.parse(localStorage.getItem(key) ?? "null")
    if (!kept || typeof kept.text !== "string" || typeof kept.revision !== "string") return null
    const before = typeof kept.other === "string" ? [{ text: kept.other, time: kept.time }] : [] // earlier pages kept one
    return { ...kept, others: kept.others ?? before }
  } catch {
    return null
  }
}

// @ts-check
// What becomes of a text that is being written: which version of the file it is an edit of, and what is kept of it in
// the browser, so that no text is lost: unsaved text, and the one of two versions that was not chosen.

/** @typedef {{ path: string, text: string, revision: string }} Source a version of the file */
/** @typedef {{ path: string, text: string, revision: string, other: string | null, time: number }} Kept */

const KEY = "improv.draft."
const TAB = "improv.tab"

export class Draft {
  #key = KEY + tab()
  /** @type {Source} */
  base
  /** @type {Source | null} */
  changed = null // what another program has put into the file since then
  /** @type {string | null} */
  other = null // a text that somebody may want back
  isKept = true // whether the browser keeps texts

  /** @param {Source} source what the file holds when the page is opened */
  constructor(source) {
    this.base = source
  }

  /** The text to begin with: of this tab before it was reloaded, or of the file. */
  begin() {
    const kept = read(this.#key)
    const own = kept?.path === this.base.path ? kept : null
    this.other = own ? own.other : adopted(this.base)
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
    this.other = which === "file" ? text : this.base.text
    return which === "file" ? this.base.text : text
  }

  /** The other text, for which this one is kept. @param {string} text */
  swap(text) {
    const other = this.other ?? text
    this.other = text
    return other
  }

  /**
   * Keeps what is not in the file, across reloads and the end of the browser.
   * @param {string} text
   */
  keep(text) {
    if (this.other === text) this.other = null
    try {
      if (this.isSaved(text) && this.other === null) localStorage.removeItem(this.#key)
      else {
        const { path, revision } = this.base
        /** @type {Kept} */
        const kept = { path, text, revision, other: this.other, time: Date.now() }
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
    const known = sessionStorage.getItem(TAB) ?? crypto.randomUUID()
    sessionStorage.setItem(TAB, known)
    return known
  } catch {
    return crypto.randomUUID()
  }
}

/**
 * The latest text that another tab has left unsaved. From now on, this tab keeps it; a tab that still has it keeps it too.
 * @param {Source} source
 */
function adopted({ path, text }) {
  try {
    const found = Object.keys(localStorage)
      .filter((key) => key.startsWith(KEY))
      .map((key) => ({ key, kept: read(key) }))
      .filter(({ kept }) => kept?.path === path && kept.text !== text)
      .sort((one, two) => (two.kept?.time ?? 0) - (one.kept?.time ?? 0))[0]
    if (!found?.kept) return null
    localStorage.removeItem(found.key)
    return found.kept.text
  } catch {
    return null
  }
}

/**
 * @param {string} key
 * @returns {Kept | null}
 */
function read(key) {
  try {
    const kept = JSON.parse(localStorage.getItem(key) ?? "null")
    return kept && typeof kept.text === "string" && typeof kept.revision === "string" ? kept : null
  } catch {
    return null
  }
}

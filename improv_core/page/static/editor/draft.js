// @ts-check
// A text that somebody is writing: the version of the file that it edits, and the texts that the browser keeps, so that
// none is lost: unsaved text, the one of two versions that was not chosen, and a text that a link or an example has
// replaced. On a website, where there are no files, the improv.toml goes with its text.

import { stored } from "../base/storage.js"
import { randomName } from "../base/random.js"

/** @typedef {{ path: string, text: string, revision: string }} Source a version of the file */
/** @typedef {{ text: string, toml?: string }} Work a text and, on a website, its improv.toml */
/** @typedef {Work & { time: number }} Other what was put aside, and when, in milliseconds since 1970 */
/** @typedef {Other & { path: string, revision: string, others: Other[], saved?: boolean }} StoredDraft `saved`: only for its others */

const KEY = "improv.draft."
export const REPLACED = `${KEY}before a link` // begins the keys of what links have replaced
const TAB = "improv.tab"

export class Draft {
  #key = KEY + tab()
  /** @type {Source} */
  base
  /** @type {Source | null} */
  changed = null // the text that another program has put into the file since then
  /** @type {Other[]} */
  #others = [] // texts that somebody may want back, until somebody drops them
  /** @type {string[]} */
  #otherKeys = [] // keys under which it is kept, too, until this tab keeps it
  /** @type {string | undefined} */
  #toml // of the text on the page, while the improv.toml in use belongs to the file
  isKept = true // whether the browser keeps texts

  /** @param {Source} source what the file holds when the page is opened */
  constructor(source) {
    this.base = source
  }

  /**
   * The text to begin with: of this tab before it was reloaded, or of the file. On a website, where nobody else writes
   * that, the latest text of other tabs comes before it, too.
   * @param {string} [toml] in use: only on a website
   */
  begin(toml) {
    const kept = readDraft(this.#key)
    const isKept = kept?.path === this.base.path
    const file = { text: this.base.text, toml }
    const found = otherDrafts(this.base.path, isKept ? null : file)
    const continues = (/** @type {StoredDraft} */ draft) => !draft.saved && draft.revision === this.base.revision && draft.toml === toml
    const own = isKept ? kept : toml === undefined ? null : found.find(({ key, draft }) => !key.startsWith(REPLACED) && continues(draft))?.draft
    this.#otherKeys = found.map(({ key }) => key)
    const others = found.flatMap(({ draft }) => (draft.saved || draft === own ? draft.others : [...draft.others, draft]))
    this.#others = [...(isKept ? kept.others : []), ...others].map(({ text, toml, time }) => ({ text, toml, time })).filter((each) => !isSame(each, file))
    if (!own || own.saved || own.text === this.base.text) return this.base.text
    if (own.revision !== this.base.revision) {
      this.changed = this.base
      this.base = { ...this.base, text: "", revision: own.revision }
      this.#toml = own.toml
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
    if (source.revision === this.base.revision || source.text === text || source.text === writing) {
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
   * Chooses between the file's version and what is on the page; the other one is kept. Returns what to show.
   * @param {"file" | "mine"} which
   * @param {Work} work on the page, with the improv.toml in use
   * @returns {Work}
   */
  choose(which, { text, toml }) {
    if (!this.changed) return { text, toml }
    this.base = this.changed
    this.changed = null
    const mine = { text, toml: this.#toml ?? toml }
    const file = { text: this.base.text, toml }
    this.putAside(which === "file" ? mine : file)
    return which === "file" ? file : mine
  }

  /** The alternatives to this text, if there are any. @param {Work} work */
  other(work) {
    return this.#others.findLast((each) => !isSame(each, work)) ?? null
  }

  /** The other one. Both are kept, and this one's turn comes last. @param {Work} work @returns {Work} */
  swap(work) {
    const other = this.other(work)
    if (!other) return work
    const own = this.#others.find((each) => isSame(each, work)) ?? { ...work, time: Date.now() }
    this.#others = [own, ...this.#others.filter((each) => !isSame(each, work))]
    return other
  }

  /** Keeps what is about to be replaced. @param {Work} work */
  putAside(work) {
    this.#others = [...this.#others.filter((each) => !isSame(each, work)), { ...work, time: Date.now() }]
  }

  /** Drops the other one. @param {Work} work that stays */
  drop(work) {
    const other = this.other(work)
    this.#others = this.#others.filter((each) => each !== other && !isSame(each, work))
  }

  /** This is saved now, as revision. @param {Work} work @param {string} revision */
  wrote(work, revision) {
    this.base = { ...this.base, text: work.text, revision }
    this.#others = this.#others.filter((each) => !isSame(each, work))
  }

  /** Keeps what is not in the file, across reloads and the end of the browser. @param {Work} work */
  keep({ text, toml }) {
    try {
      const saved = this.isSaved(text)
      if (saved && !this.#others.length) localStorage.removeItem(this.#key)
      else {
        const { path, revision } = this.base
        const own = this.changed ? (this.#toml ?? toml) : toml
        /** @type {StoredDraft} */
        const draft = { path, text, toml: own, revision, others: this.#others, saved, time: Date.now() }
        localStorage.setItem(this.#key, JSON.stringify(draft))
      }
      this.isKept = true
      for (const key of this.#otherKeys.splice(0)) localStorage.removeItem(key)
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
 * The texts that links have replaced and, for a tab without its own text, the text of the latest other tab that is not
 * in the file. From now on, this tab keeps it; a tab that still has it keeps it too.
 * @param {string} path
 * @param {Work | null} file
 * @returns {{ key: string, draft: StoredDraft }[]} the latest last
 */
function otherDrafts(path, file) {
  try {
    const found = Object.keys(localStorage)
      .filter((key) => key.startsWith(KEY))
      .flatMap((key) => {
        const draft = readDraft(key)
        return draft?.path === path ? [{ key, draft }] : []
      })
      .sort((one, two) => one.draft.time - two.draft.time)
    const replaced = found.filter(({ key }) => key.startsWith(REPLACED))
    if (!file) return replaced
    const hasMore = (/** @type {StoredDraft} */ draft) => draft.others.length > 0 || (!draft.saved && !isSame(draft, file))
    const tabs = found.filter(({ key, draft }) => !key.startsWith(REPLACED) && hasMore(draft))
    return [...tabs.slice(-1), ...replaced]
  } catch {
    return []
  }
}

/** Returns whether both are the same, as far as known: earlier pages kept no improv.toml. @param {Work} one @param {Work} other */
function isSame(one, other) {
  return one.text === other.text && (one.toml === undefined || other.toml === undefined || one.toml === other.toml)
}

/** @param {string} key @returns {StoredDraft | null} */
function readDraft(key) {
  const draft = stored(key)
  if (typeof draft?.text !== "string" || typeof draft.revision !== "string") return null
  const before = typeof draft.other === "string" ? [{ text: draft.other, time: draft.time }] : [] // earlier pages kept one
  return { ...draft, others: draft.others ?? before }
}

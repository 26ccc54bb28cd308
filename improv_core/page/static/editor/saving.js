// @ts-check
// Saves the text that is written on the page, and shows whether it is saved, and in which versions there is more of it.

import { Draft } from "./draft.js"
import { find, write } from "../base/elements.js"
import { keyOf } from "../base/keys.js"
import { notices } from "../base/notices.js"
import { when } from "../base/when.js"
import { keptToml } from "../net/backend.js"
import { send } from "../net/send.js"

/** @import { Work } from "./draft.js" */
/**
 * @typedef {object} Page
 * @property {() => string} getText
 * @property {(text: string) => void} set puts another program's text in
 * @property {(text: string) => void} replace puts a text in that somebody has chosen
 * @property {() => void} wrote the text is about to be saved
 * @property {() => boolean} changes whether the text is about to change by itself: it is saved after that
 */

const KEEP_DELAY = 200 // milliseconds after a key until the browser keeps the text: that takes as long as to show the key

export class Saving {
  #page
  #keeping = 0 // the timer that has it kept
  /** @type {Draft | null} */
  #draft = null // from when the server says that the program may be written here
  #number = 0 // of texts that were saved
  /** @type {Work | null} */
  #writing = null // the text that is being saved
  #again = false // save again as soon as that is done
  #problem = "" // why the text could not be saved
  #toml = "" // of the file
  /** @type {Work | null} */
  #brought = null // the text that replaced the one on the page
  noticed = () => {} // called when the text has changed

  /** @param {Page} page */
  constructor(page) {
    this.#page = page
    find("write").addEventListener("click", () => this.write())
    find("use-file").addEventListener("click", () => this.#choose("file"))
    find("keep-mine").addEventListener("click", () => this.#choose("mine"))
    find("swap").addEventListener("click", () => {
      if (this.#draft) this.#put(this.#draft.swap(this.#work))
      this.show() // the text may be the same as before
    })
    find("forget").addEventListener("click", () => {
      this.#draft?.drop(this.#work)
      this.show()
    })
    addEventListener("keydown", (event) => {
      const saves = (event.ctrlKey || event.metaKey) && ["Enter", "s"].includes(keyOf(event))
      if (!this.open || !saves || event.isComposing) return
      event.preventDefault()
      if (!event.repeat) this.write()
    })
    addEventListener("pagehide", () => this.#draft?.keep(this.#work))
    addEventListener("beforeunload", (event) => {
      if (this.#draft && !this.#draft.isKept && !this.isSaved) event.preventDefault()
    })
  }

  /** True if the program can be written here. */
  get open() {
    return this.#draft !== null
  }

  /** The text on the page. */
  get text() {
    return this.#page.getText()
  }

  /** The improv.toml with which that text plays. */
  get toml() {
    return keptToml.get() ?? this.#toml
  }

  /** That text and, on a website, its improv.toml. */
  get #work() {
    return { text: this.text, toml: keptToml.get() }
  }

  /**
   * Puts another text in its place and, on a website, another improv.toml. Only the text can be undone, so one's own of both
   * are kept.
   * @param {string} text
   * @param {string} [toml]
   */
  replace(text, toml) {
    const work = this.#work
    const isBrought = work.text === this.#brought?.text && work.toml === this.#brought.toml
    if (toml !== undefined && toml !== work.toml && work.toml && !isBrought) this.#draft?.putAside(work)
    this.#brought = { text, toml: toml ?? work.toml }
    this.#put(this.#brought)
  }

  /** @param {Work} work */
  #put({ text, toml }) {
    if (toml !== undefined && toml !== keptToml.get()) keptToml.set(toml)
    this.#page.replace(text)
  }

  get isSaved() {
    return this.#draft?.isSaved(this.text) ?? true
  }

  /** Takes the content of the file. Returns whether this is the first time. @param {Messages["source"]} source */
  takeSource(source) {
    this.#toml = source.toml
    if (this.#draft) {
      const text = this.#draft.take(source, this.text, this.#writing?.text ?? null)
      if (text !== null) this.#page.set(text)
      this.show()
      return false
    }
    this.#draft = new Draft(source)
    document.body.classList.add("editing")
    find("file-name").textContent = source.path.split(/[\\/]/).at(-1) ?? ""
    find("file-name").title = source.path
    this.#page.set(this.#draft.begin(keptToml.get()))
    this.show()
    return true
  }

  /** @param {Messages["write"]} message */
  takeWritten({ revision, problem }) {
    if (this.#writing !== null && this.#draft && !problem) {
      this.#draft.wrote(this.#writing, revision)
    }
    this.#writing = null
    this.#problem = problem
    this.show()
    if (this.#again) this.write()
  }

  /** The connection has changed: what was being saved gets no answer. */
  reconnect() {
    this.#writing = null
    this.show()
  }

  /** Somebody has edited the text. */
  edited() {
    this.#problem = ""
    clearTimeout(this.#keeping)
    this.#keeping = window.setTimeout(() => this.show(), KEEP_DELAY)
    this.#showState()
    this.noticed()
  }

  /** Saves the text, and has it played. */
  write() {
    if (!this.#draft || !notices.isOpen || this.#page.changes()) return
    if (this.#draft.changed) {
      find("use-file").focus()
      return
    }
    this.#again = this.#writing !== null
    if (this.#again) return
    this.#writing = this.#work
    this.#problem = ""
    send({ type: "write", number: ++this.#number, text: this.#writing.text, revision: this.#draft.base.revision })
    this.#page.wrote()
    this.show()
  }

  /** Somebody has stopped or paused the robots: a save that still waits must not move them. */
  halt() {
    this.#again = false
  }

  /** Keeps the text, and shows what is saved, and the other text, if there is one. */
  show() {
    const draft = this.#draft
    if (!draft) return
    const work = this.#work
    draft.keep(work)
    this.#showState()
    find("write").setAttribute("aria-disabled", String(!notices.isOpen))
    const { changed } = draft
    const other = draft.other(work)
    find("versions").hidden = !changed && !other
    find("versions-text").textContent = changed
      ? `${find("file-name").textContent} was changed in another tab or program, and your text is not saved. Choose one: the other is kept here.`
      : other && `Another ${called(work, other)}, from ${when(other.time)}, is kept in this browser until you forget it.`
    for (const id of ["use-file", "keep-mine"]) find(id).hidden = !changed
    for (const id of ["swap", "forget"]) find(id).hidden = Boolean(changed)
  }

  #showState() {
    const isKept = this.#draft?.isKept ?? true
    const saved = this.isSaved
    const unsaved = isKept ? "not saved yet" : "not saved: this browser keeps nothing"
    write(find("file-state"), this.#problem || (this.#writing !== null ? "saving…" : saved ? "saved" : unsaved))
    find("file-state").classList.toggle("wrong", this.#problem !== "" || (!saved && !isKept))
  }

  /** @param {"file" | "mine"} which */
  #choose(which) {
    if (this.#draft) this.#put(this.#draft.choose(which, this.#work))
    this.#problem = ""
    this.show() // the text may be the same as before
  }
}

/** Describes the difference of the other one. @param {Work} work @param {Work} other */
function called(work, other) {
  if (other.text === work.text) return "improv.toml"
  return other.toml && other.toml !== work.toml ? "text with its improv.toml" : "text"
}

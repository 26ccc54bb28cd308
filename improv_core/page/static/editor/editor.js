// @ts-check
// The program as text that can be written. The text control is the browser's own; this module keeps what belongs to it
// up to date: colors, diagnostics, completions, hovers, and the words that play.

import { CodePoints } from "../base/code-points.js"
import { find, findA } from "../base/elements.js"
import { makeWay } from "../base/frames.js"
import { notices } from "../base/notices.js"
import { whenReleased } from "../base/pressing.js"
import { Handle } from "../floor/handle.js"
import { Preview } from "../floor/preview.js"
import { startPoses } from "../floor/start-poses.js"
import { send } from "../net/send.js"
import { showProblem } from "../score/changes.js"
import { program } from "../score/program.js"
import { changed, isSame, readColors, readProblems } from "./analysis.js"
import { listDiagnostics, listenForArrows } from "./diagnostics.js"
import { applyEdits, difference, marksAfter, offsetsAfter } from "./edits.js"
import { Highlight } from "./highlight.js"
import { Offer } from "./offer.js"
import { PendingChanges } from "./pending-changes.js"
import { Saving } from "./saving.js"
import { Tooltip } from "./tooltip.js"
import { Undoing } from "./undoing.js"

/** @import { Edit, Span } from "./edits.js" */
/** @import { Color, Light } from "./highlight.js" */
/** @import { Diagnostic } from "./diagnostics.js" */

const DIAGNOSTICS_DELAY = 400 // milliseconds without a key after which diagnostics are shown, and the handle: half a word is no word
const CURSOR_MARGIN = 8 // pixels around the cursor that stay in view

export class Editor {
  #control = findA("text", HTMLTextAreaElement)
  #highlight = new Highlight(find("highlight"))
  offer = new Offer(this.#control, {
    sent: () => (this.#sent === this.#number ? this.#number : null),
    codePoints: () => this.#codePoints,
    place: (offset) => this.#highlight.place(offset),
    replace: (text) => this.#replace(text),
  })
  #tooltip = new Tooltip(this.#control, (x, y) => this.#explain(x, y))
  #text = ""
  #codePoints = new CodePoints("")
  #number = 0 // of the text
  #asking = false // about colors and diagnostics
  #sent = -1 // the number of the text that the server was sent,
  /** @type {number | undefined} */
  #analyzed // of the one about which it has answered,
  /** @type {number[]} */
  #numbers = [] // and those of its colors
  #replacing = false // a text by another, in one step or more
  #undoing = new Undoing(this.#control)
  #edited = -Infinity // when, in milliseconds
  #calm = 0 // the timer that shows diagnostics
  /** @type {Color[]} */
  #colors = []
  /** @type {Diagnostic[]} */
  #diagnostics = []
  #count = 0 // of diagnostics, also of those that the server has not sent
  /** @type {Diagnostic[]} */
  #shown = [] // of the diagnostics
  #listed = "" // the problems in the list, and their text
  /** @type {Map<number, Light>} */
  #lights = new Map() // on the words that play, by their offsets in the played text

  handle = new Handle(() => ({ number: this.#known, offset: this.writtenAt ?? 0 }), (change) => this.pendingChanges.add(change))
  preview = new Preview(() => this.#known !== null && this.#preview())

  constructor() {
    const control = this.#control
    control.addEventListener("input", (event) => this.#take(event instanceof InputEvent ? event : null))
    control.addEventListener("keydown", (event) => this.#press(event))
    for (const kind of ["focus", "blur"]) control.addEventListener(kind, () => setTimeout(() => whenReleased(() => this.#showFocus())))
    control.addEventListener("scroll", () => (control.scrollTop = 0)) // only the paper scrolls
    find("paper").addEventListener("scroll", () => {
      this.offer.move()
      this.#look()
    })
    listenForArrows()
    // Errors, a bar, or a phone's keyboard may cover the line that is written, and other lines may come into view.
    const sizes = new ResizeObserver((changes) => {
      if (document.activeElement === control && changes.some(({ target }) => target.id === "paper")) this.#reveal()
      this.#look()
    })
    for (const id of ["paper", "sheet"]) sizes.observe(find(id))
    this.saving = new Saving({
      getText: () => this.#text,
      set: (text) => this.#set(text),
      replace: (text) => this.#replace(text),
      wrote: () => this.#showDiagnostics(),
      changes: () => {
        startPoses.tell()
        return this.pendingChanges.saveAfter()
      },
    })
    this.pendingChanges = new PendingChanges({
      known: () => this.#known,
      cursor: () => this.#codePoints.toPoints(control.selectionEnd),
      edit: (edits, bends, again) => this.#edit(edits, bends, again),
      say: (problem) => {
        showProblem(problem)
        if (problem) this.#analyze() // the rings move back
      },
      save: () => this.saving.write(),
    })
  }

  /** True if the program can be written here. */
  get open() {
    return this.saving.open
  }

  /** The number of the text, once the server has it. */
  get #known() {
    return this.#analyzed === this.#number ? this.#number : null
  }

  /** The place of the cursor, in code points, if the program can be written here. */
  get writtenAt() {
    return this.open ? this.#codePoints.toPoints(this.#control.selectionEnd) : undefined
  }

  /** True if the text is saved and plays, or was played last. */
  get isPlayed() {
    return this.#text === program.text && this.saving.isSaved && !this.pendingChanges.open
  }

  /** Takes the content of the file. Returns whether this is the first time. @param {Messages["source"]} source */
  takeSource(source) {
    const first = this.saving.takeSource(source)
    this.#analyze() // the robots may have changed, too
    return first
  }

  /** The connection has changed. */
  reconnect() {
    this.#sent = -1
    this.#analyzed = undefined
    this.#asking = false
    this.pendingChanges.forget()
    if (this.open) this.#analyze()
    this.saving.reconnect()
  }

  /** Lights words of the played text, given by offset. @param {Map<number, Light>} lights */
  light(lights) {
    this.#lights = lights
    this.#light()
  }

  #showFocus() {
    const writes = document.activeElement === this.#control
    document.body.classList.toggle("writing", writes)
    find("stop-key").textContent = writes ? "Esc" : "Space" // Space is a letter here
  }

  /** @param {InputEvent | null} event */
  #take(event) {
    if (this.#replacing) return
    if (event?.inputType === "historyUndo") this.#undoing.restore(this.#text)
    this.#edited = performance.now()
    makeWay()
    this.#refresh()
    // A phone's keyboard composes every word.
    const typed = ["insertText", "insertCompositionText", "deleteContentBackward"].includes(event?.inputType ?? "")
    if (typed) this.offer.begin(false)
    else this.offer.end()
    requestAnimationFrame(() => this.#reveal()) // the frame lays the page out anyway
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    if (event.isComposing) return
    this.#tooltip.hide()
    if (event.key === " " && event.ctrlKey) {
      event.preventDefault()
      this.offer.begin(true)
    } else if (!event.ctrlKey && !event.metaKey && !event.altKey && this.offer.takes(event)) event.preventDefault()
    else if (/^(Arrow|Home|End|Page|Enter)/.test(event.key)) this.offer.end() // the cursor leaves the word
  }

  /** Puts another text in; the cursor stays where it is in what has not changed. @param {string} text */
  #set(text) {
    const { value, selectionStart, selectionEnd } = this.#control
    const edit = difference(value, text)
    const [start, end] = [selectionStart, selectionEnd].map((offset) =>
      offset <= edit.start ? offset : Math.max(edit.start, offset + text.length - value.length),
    )
    this.#put(edit, text)
    this.#control.setSelectionRange(start, end)
    this.offer.end() // it was about the text before
    this.#refresh()
  }

  /**
   * Puts another text in, as if it had been typed.
   * @param {string} text
   * @param {Edit} [only] the edit that makes it, if it is only one: the cursor is behind it then
   * @param {boolean} [again] whether this takes the place of the latest edit, so that both are undone at once
   * @returns {boolean} whether there is an edit to undo: not if the place of the latest one is taken by the text before it
   */
  #replace(text, only, again = false) {
    const score = find("score")
    const { hidden } = score
    score.hidden = false // also while a card or somebody hides it: only what is shown can be undone
    score.classList.add("changing")
    this.#control.focus()
    this.#replacing = true
    if (again) {
      document.execCommand("undo")
      this.#undoing.restore(this.#text)
    }
    const before = this.#control.value
    const end = only && before.length - (text.length - only.start - only.text.length)
    this.#put(only && end !== undefined ? { ...only, end } : difference(before, text), text)
    this.#replacing = false
    score.classList.remove("changing")
    score.hidden = hidden
    this.offer.end() // nobody has typed
    this.#refresh()
    this.#reveal()
    return before !== text
  }

  /**
   * Makes edits that count in code points, as if they had been typed. The focus stays where it is.
   * @param {Edit[]} edits
   * @param {boolean} [bends] whether the cursor is to be at the beginning of the word that is bent, so that it stays there
   * @param {boolean} [again] as in `#replace`
   */
  #edit(edits, bends, again) {
    const focus = document.activeElement
    const units = edits.map((edit) => this.#codePoints.inUnits(edit))
    const isUndone = this.#replace(applyEdits(this.#text, units), units.length === 1 ? units[0] : undefined, again)
    if (bends) this.#control.setSelectionRange(units[0].start, units[0].start)
    if (focus instanceof HTMLElement) focus.focus()
    return isUndone
  }

  /** With the focus, the edit can be undone. @param {Edit} edit @param {string} text after it */
  #put({ start, end, text: put }, text) {
    const control = this.#control
    if (control.value === text) return
    this.#undoing.note(text)
    if (document.activeElement === control) {
      control.setSelectionRange(start, end)
      document.execCommand(put ? "insertText" : "delete", false, put)
    }
    if (control.value !== text) control.value = text
  }

  /** The text may have changed. */
  #refresh() {
    const text = this.#control.value.toWellFormed() // halves of characters can't be saved
    if (text !== this.#text) {
      const edit = difference(this.#text, text)
      this.#text = text
      this.#codePoints = new CodePoints(text)
      this.#number++
      this.#colors = marksAfter(this.#colors, edit)
      this.#diagnostics = marksAfter(this.#diagnostics, edit)
      this.#shown = marksAfter(this.#shown, edit)
      this.#analyze()
      this.saving.edited()
    }
    this.#draw()
  }

  #analyze() {
    if (this.#asking || !notices.isOpen) return
    this.#asking = true
    this.#sent = this.#number
    send({ type: "analyze", number: this.#number, text: this.#text, known: this.#analyzed })
    this.preview.edit(this.#text)
    this.#preview()
  }

  #preview() {
    if (this.preview.isOn) send({ type: "preview", number: this.#number, known: this.preview.known })
  }

  /** @param {Messages["preview"]} message */
  takePreview(message) {
    this.preview.take(message, message.number === this.#number ? this.#text : null)
  }

  /** @param {Messages["analyze"]} message */
  takeAnalysis(message) {
    this.#asking = false
    this.#numbers = changed(this.#numbers, message.colors)
    this.#analyzed = message.number
    if (message.number !== this.#number) {
      this.#analyze()
      this.offer.ask()
      return
    }
    this.pendingChanges.ask()
    if (Object.keys(message.starts).length) startPoses.place(message.starts)
    const colors = readColors(this.#numbers, this.#codePoints)
    if (!isSame(colors, this.#colors)) {
      this.#colors = colors
      this.#draw()
    }
    this.takeProblems(message)
  }

  /** @param {Omit<Messages["check"], "type">} message */
  takeProblems({ number, problems, count }) {
    if (number !== this.#number) return
    this.#diagnostics = readProblems(problems, this.#codePoints)
    this.#count = count
    clearTimeout(this.#calm)
    const rest = this.#edited + DIAGNOSTICS_DELAY - performance.now()
    if (rest <= 0) this.#showDiagnostics()
    else this.#calm = window.setTimeout(() => whenReleased(() => this.#showDiagnostics()), rest)
  }

  #showDiagnostics() {
    this.handle.look()
    if (hasErrors(this.#shown) && !hasErrors(this.#diagnostics)) find("problems").hidden = true // all were fixed
    this.#shown = this.#diagnostics
    const number = this.#number
    const listed = JSON.stringify([number, this.#count, this.#shown])
    if (listed !== this.#listed) {
      listDiagnostics(
        this.#shown,
        this.#count,
        this.#text,
        (offset) => this.#go(offset),
        (edits) => number === this.#number && this.#replace(applyEdits(this.#text, edits), edits.length === 1 ? edits[0] : undefined),
      )
    }
    this.#listed = listed // the same rows stay, so that a button that is being pressed is not replaced
    this.#draw()
  }

  /** Draws, with colors for what is visible now. */
  #look() {
    this.#highlight.look(find("paper"))
    this.#draw()
  }

  #draw() {
    this.#highlight.show(this.#text, this.#colors, this.#shown.filter(({ file }) => !file))
    const { style } = find("sheet")
    const digits = String(Math.max(String(this.#highlight.lines).length, 2))
    if (style.getPropertyValue("--digits") !== digits) style.setProperty("--digits", digits) // that lays all out again
    this.#light()
  }

  /** Lights what plays, where the text is still as it was played. */
  #light() {
    this.#highlight.light(this.#lights.size ? offsetsAfter(this.#lights, difference(program.text, this.#text)) : this.#lights)
  }

  /** @param {number} x @param {number} y */
  #explain(x, y) {
    const word = this.#highlight.wordAt(x, y)
    if (!word) return false
    send({ type: "explain", number: this.#number, offset: this.#codePoints.toPoints(word.start) })
    return true
  }

  /** @param {Messages["explain"]} message */
  takeExplanation(message) {
    if (message.number !== this.#number) return
    this.#tooltip.show([...this.#wrongAt(message), message.text].join("\n"), message.picture)
  }

  /** The messages about a place, which counts in code points. @param {Span} place */
  #wrongAt(place) {
    const { start, end } = this.#codePoints.inUnits(place)
    return this.#shown.filter((each) => !each.file && each.start < end && each.end > start).map(({ message }) => message)
  }

  /** @param {number} offset */
  #go(offset) {
    this.#control.focus()
    this.#control.setSelectionRange(offset, offset)
    this.#reveal()
  }

  /** Scrolls to the cursor. */
  #reveal() {
    const paper = find("paper")
    const { top, bottom } = paper.getBoundingClientRect()
    if (top === bottom) return // it is hidden
    const place = this.#highlight.place(this.#control.selectionEnd)
    if (place.top < top + CURSOR_MARGIN) paper.scrollTop -= top + CURSOR_MARGIN - place.top
    else if (place.bottom > bottom - CURSOR_MARGIN) paper.scrollTop += place.bottom - bottom + CURSOR_MARGIN
  }
}

/** @param {Diagnostic[]} found */
const hasErrors = (found) => found.some(({ severity }) => severity === "error")

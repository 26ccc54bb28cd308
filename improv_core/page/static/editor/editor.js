// @ts-check
// The program as text that can be written. The text control is the browser's own; this module keeps what belongs to it
// up to date: colors, diagnostics, completions, hovers, and the words that play.

import { applyEdits, difference, marksAfter } from "./edits.js"
import { find, findA } from "../base/elements.js"
import { Highlight } from "./highlight.js"
import { listDiagnostics, listenForArrows } from "./diagnostics.js"
import { PendingChanges } from "./pending-changes.js"
import { Completions } from "./completions.js"
import { CodePoints } from "./code-points.js"
import { Saving } from "./saving.js"
import { toml } from "../net/backend.js"
import { Tooltip } from "./tooltip.js"

/** @import { Request } from "../net/requests.js" */
/** @import { Edit } from "./edits.js" */
/** @import { Color } from "./highlight.js" */
/** @import { Messages } from "../net/messages.js" */
/** @import { Diagnostic } from "./diagnostics.js" */
/** @import { StartPose } from "../net/requests.js" */
/**
 * @typedef {object} Starts
 * @property {() => void} finish has what was moved written
 * @property {(starts: Record<string, StartPose>) => void} place takes where robots start according to the text
 * @property {(problem: string) => void} say why nothing was written, if there is a reason
 */

const DIAGNOSTICS_DELAY = 400 // milliseconds without a key after which diagnostics are shown: half a word is one
const CURSOR_MARGIN = 8 // pixels around the cursor that stay in view
const PART_OF_WORD = /^[\p{L}\p{M}\p{N}_\u200C\u200D]*$/u

export class Editor {
  #send
  #connected = false
  #control = findA("text", HTMLTextAreaElement)
  #highlight = new Highlight(find("highlight"))
  #completions = new Completions(this.#control, (word) => this.#pick(word))
  #tooltip = new Tooltip(this.#control, (x, y) => this.#explain(x, y))
  #text = ""
  #codePoints = new CodePoints("")
  #number = 0 // of the text
  #asking = false // about colors and diagnostics
  #analyzed = -1 // the number of the text that the server has
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
  /** @type {{ start: number, end: number, asked: boolean } | null} */
  #offering = null // for what is written here
  #played = ""
  #playedCodePoints = new CodePoints("")
  #starts
  /** @type {Map<number, string>} */
  #places = new Map() // of the words that play, in code points of the played text

  /**
   * `send` asks the server for something.
   * @param {(request: Request) => void} send
   * @param {Starts} starts
   */
  constructor(send, starts) {
    this.#send = send
    this.#starts = starts
    const control = this.#control
    control.addEventListener("input", (event) => this.#take(event instanceof InputEvent ? event : null))
    control.addEventListener("keydown", (event) => this.#press(event))
    control.addEventListener("compositionstart", () => this.#endOffer())
    control.addEventListener("focus", () => (find("stop-key").textContent = "Esc")) // Space is a letter here
    control.addEventListener("blur", () => (find("stop-key").textContent = "Space"))
    for (const kind of ["blur", "pointerdown"]) control.addEventListener(kind, () => this.#endOffer())
    find("paper").addEventListener("scroll", () => this.#moveOffer())
    listenForArrows()
    // Errors, a bar, or a phone's keyboard may cover the line that is written.
    new ResizeObserver(() => document.activeElement === control && this.#reveal()).observe(find("paper"))
    this.saving = new Saving(send, {
      getText: () => this.#text,
      set: (text) => this.#set(text),
      replace: (text) => this.#replace(text),
      getToml: toml.get,
      setToml: toml.set,
      wrote: () => this.#showDiagnostics(),
      changes: () => {
        starts.finish()
        return this.pendingChanges.saveAfter()
      },
    })
    this.pendingChanges = new PendingChanges(send, {
      known: () => (this.#analyzed === this.#number ? this.#number : null),
      edit: (edits) => this.#edit(edits),
      say: (problem) => {
        starts.say(problem)
        if (problem) this.#analyze() // the rings move back
      },
      save: () => this.saving.write(),
    })
  }

  /** True if the program can be written here. */
  get open() {
    return this.saving.open
  }

  /** True if the text is saved and plays, or was played last. */
  get isPlayed() {
    return this.#text === this.#played && this.saving.isSaved && !this.pendingChanges.open
  }

  /** Takes the content of the file. Returns whether this is the first time. @param {Messages["source"]} source */
  takeSource(source) {
    const first = this.saving.takeSource(source)
    this.#analyze() // the robots may have changed, too
    return first
  }

  /** @param {Messages["analyze" | "complete" | "explain" | "write" | "change"]} message */
  takeAnswer(message) {
    if (message.type === "write") this.saving.takeWritten(message)
    else if (message.type === "change") this.pendingChanges.take(message)
    else if (message.type === "analyze") this.#takeAnalysis(message)
    else if (message.number !== this.#number) return
    else if (message.type === "complete") this.#takeWords(message)
    else this.#tooltip.show([...this.#wrongAt(message.start, message.end), message.text].join("\n"), message.picture)
  }

  /** @param {boolean} connected */
  connect(connected) {
    this.#connected = connected
    this.#analyzed = -1
    this.#asking = false
    this.pendingChanges.forget()
    if (connected && this.open) this.#analyze()
    this.saving.connect(connected)
  }

  /** The program that plays now. @param {{ text: string }} score */
  show({ text }) {
    this.#played = text.replace(/\r\n?/g, "\n")
    this.#playedCodePoints = new CodePoints(this.#played)
  }

  /** Lights words of the played text, given by offset in code points. @param {Map<number, string>} places */
  light(places) {
    this.#places = places
    this.#light()
  }

  /** @param {InputEvent | null} event */
  #take(event) {
    this.#edited = performance.now()
    this.#refresh()
    // A phone's keyboard composes every word.
    const typed = ["insertText", "insertCompositionText", "deleteContentBackward"].includes(event?.inputType ?? "")
    if (typed) this.#complete(false)
    else this.#endOffer()
    this.#reveal()
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    if (event.isComposing) return
    this.#tooltip.hide()
    if (event.key === " " && event.ctrlKey) {
      event.preventDefault()
      this.#complete(true)
    } else if (!event.ctrlKey && !event.metaKey && !event.altKey) {
      if (this.#completions.takes(event)) event.preventDefault()
      else if (event.key.startsWith("Arrow") || event.key === "Enter") this.#endOffer()
    }
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
    this.#endOffer() // it was about the text before
    this.#refresh()
  }

  /** Puts another text in, as if it had been typed. @param {string} text */
  #replace(text) {
    const score = find("score")
    const { hidden } = score
    score.hidden = false // also while a card or somebody hides it: only what is shown can be undone
    score.classList.add("changing")
    this.#control.focus()
    this.#put(difference(this.#control.value, text), text)
    score.classList.remove("changing")
    score.hidden = hidden
    this.#endOffer() // nobody has typed
    this.#refresh()
    this.#reveal()
  }

  /** Makes edits that count in code points, as if they had been typed. The focus stays where it is. @param {Edit[]} edits */
  #edit(edits) {
    const focus = document.activeElement
    const inUnits = edits.map(({ start, end, text }) => ({ start: this.#codePoints.toUnits(start), end: this.#codePoints.toUnits(end), text }))
    this.#replace(applyEdits(this.#text, inUnits))
    if (focus instanceof HTMLElement) focus.focus()
  }

  /**
   * With the focus, the edit can be undone.
   * @param {Edit} edit
   * @param {string} text after it
   */
  #put({ start, end, text: put }, text) {
    const control = this.#control
    if (control.value === text) return
    if (document.activeElement === control) {
      control.setSelectionRange(start, end)
      document.execCommand(put ? "insertText" : "delete", false, put)
    }
    if (control.value !== text) control.value = text
  }

  /** The text may have changed. */
  #refresh() {
    const text = wellFormed(this.#control.value)
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
    if (this.#asking || !this.#connected) return
    this.#asking = true
    this.#send({ type: "analyze", number: this.#number, text: this.#text })
  }

  /** @param {Messages["analyze"]} message */
  #takeAnalysis({ number, colors, problems, count, starts }) {
    this.#asking = false
    if (number !== this.#number) {
      this.#analyze()
      return
    }
    this.#analyzed = number
    if (this.#offering) this.#askForWords()
    this.pendingChanges.ask()
    if (Object.keys(starts).length) this.#starts.place(starts)
    this.#colors = []
    for (let i = 0, at = 0; i < colors.length; i += 3) {
      const start = at + colors[i]
      at = start + colors[i + 1]
      this.#colors.push({ start: this.#codePoints.toUnits(start), end: this.#codePoints.toUnits(at), kind: colors[i + 2] })
    }
    /** @type {<T extends { start: number, end: number }>(span: T) => T} */
    const inUnits = (span) => ({ ...span, start: this.#codePoints.toUnits(span.start), end: this.#codePoints.toUnits(span.end) })
    this.#diagnostics = problems.map((problem) => ({
      ...inUnits(problem),
      fixes: problem.fixes.map((fix) => ({ ...fix, edits: fix.edits.map(inUnits) })),
    }))
    this.#count = count
    clearTimeout(this.#calm)
    const rest = this.#edited + DIAGNOSTICS_DELAY - performance.now()
    if (rest <= 0) this.#showDiagnostics()
    else this.#calm = window.setTimeout(() => this.#showDiagnostics(), rest)
    this.#draw()
  }

  #showDiagnostics() {
    this.#shown = this.#diagnostics
    const number = this.#number
    const listed = JSON.stringify([number, this.#count, this.#shown])
    if (listed !== this.#listed) {
      listDiagnostics(
        this.#shown,
        this.#count,
        this.#text,
        (offset) => this.#go(offset),
        (edits) => number === this.#number && this.#replace(applyEdits(this.#text, edits)),
      )
    }
    this.#listed = listed // the same rows stay, so that a button that is being pressed is not replaced
    this.#draw()
  }

  #draw() {
    this.#highlight.show(this.#text, this.#colors, this.#shown.filter(({ file }) => !file))
    find("sheet").style.setProperty("--digits", String(Math.max(String(this.#highlight.lines).length, 2)))
    this.#control.scrollTop = 0
    this.#light()
  }

  /** Lights what plays, where the text is still as it was played. */
  #light() {
    const { start, end, text } = difference(this.#played, this.#text)
    /** @type {Map<number, string>} */
    const places = new Map()
    for (const [place, color] of this.#places) {
      const offset = this.#playedCodePoints.toUnits(place)
      if (offset < start) places.set(offset, color)
      else if (offset >= end) places.set(offset + text.length - (end - start), color)
    }
    this.#highlight.light(places)
  }

  /** @param {boolean} asked whether somebody has asked for it, instead of only writing */
  #complete(asked) {
    const { value, selectionStart, selectionEnd: end } = this.#control
    if (selectionStart !== end) {
      this.#offering = null
      return
    }
    // Until the server answers, a word that is shown also takes the place of what has been typed since.
    let start = Math.min(this.#offering?.start ?? end, end)
    if (!PART_OF_WORD.test(value.slice(start, end))) {
      this.#endOffer()
      start = end
    }
    this.#offering = { start, end, asked }
    if (this.#analyzed === this.#number) this.#askForWords()
  }

  /** Only once the server has the text. */
  #askForWords() {
    const offset = this.#codePoints.toPoints(this.#control.selectionEnd)
    this.#send({ type: "complete", number: this.#number, offset })
  }

  /** @param {Messages["complete"]} message */
  #takeWords({ start, end, words }) {
    const [from, to] = [this.#codePoints.toUnits(start), this.#codePoints.toUnits(end)]
    const offering = this.#offering
    if (!offering || offering.end !== this.#control.selectionEnd || to !== offering.end) return
    const begun = this.#text.slice(from, to)
    const complete = words.some(({ word }) => word === begun)
    const isListed = words.length > 0 && (offering.asked || (begun !== "" && !complete))
    if (!isListed) this.#endOffer()
    this.#offering = { ...offering, start: from }
    this.#completions.tap(complete ? [] : words, begun)
    if (isListed) this.#completions.show(words, this.#highlight.place(from))
  }

  /** The text has scrolled: the words go along, as long as what they belong to is in view. */
  #moveOffer() {
    if (!this.#offering || !this.#completions.open) return
    const { top, bottom } = find("paper").getBoundingClientRect()
    const place = this.#highlight.place(this.#offering.start)
    if (place.bottom < top || place.top > bottom) this.#endOffer()
    else this.#completions.move(place)
  }

  #endOffer() {
    this.#offering = null
    this.#completions.hide()
  }

  /** @param {string} word */
  #pick(word) {
    if (!this.#offering) return
    const { start, end } = this.#offering
    this.#offering = null
    this.#replace(this.#text.slice(0, start) + word + this.#text.slice(end))
    this.#control.setSelectionRange(start + word.length, start + word.length)
  }

  /**
   * @param {number} x
   * @param {number} y
   */
  #explain(x, y) {
    const word = this.#highlight.wordAt(x, y)
    if (!word) return false
    this.#send({ type: "explain", number: this.#number, offset: this.#codePoints.toPoints(word.start) })
    return true
  }

  /** The messages about a place, which counts in code points. @param {number} start @param {number} end */
  #wrongAt(start, end) {
    const [from, to] = [this.#codePoints.toUnits(start), this.#codePoints.toUnits(end)]
    return this.#shown.filter((each) => !each.file && each.start < to && each.end > from).map(({ message }) => message)
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
    if (!paper.checkVisibility()) return
    const { top, bottom } = paper.getBoundingClientRect()
    const place = this.#highlight.place(this.#control.selectionEnd)
    if (place.top < top + CURSOR_MARGIN) paper.scrollTop -= top + CURSOR_MARGIN - place.top
    else if (place.bottom > bottom - CURSOR_MARGIN) paper.scrollTop += place.bottom - bottom + CURSOR_MARGIN
  }
}

/** Without halves of characters, which can't be saved. @param {string} text */
function wellFormed(text) {
  return text.replace(/[\uD800-\uDBFF](?![\uDC00-\uDFFF])|(?<![\uD800-\uDBFF])[\uDC00-\uDFFF]/g, "\uFFFD")
}

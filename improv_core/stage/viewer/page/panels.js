// @ts-check
// The panels, the cards, the tools of the stage, and their keys.

import { download, drawPng, record } from "./save.js"
import { listen, settings } from "./keys.js"

import { find, findA } from "./elements.js"

/** @import { Camera } from "./camera.js" */
/** @import { Controls } from "./controls.js" */
/**
 * @typedef {object} Page
 * @property {() => void} touch has the next frame draw
 * @property {() => void} resize
 * @property {(text: string) => void} announce
 * @property {() => Promise<string | null>} getPicture the paths as SVG
 * @property {() => void} clearTrails
 * @property {() => void} cue
 * @property {() => string} getStem what to call files that are saved, without an ending
 * @property {Controls} controls
 * @property {Camera} camera
 * @property {HTMLCanvasElement} canvas
 */

const SMALL = matchMedia("(max-width: 720px), (max-height: 520px)")
/** @type {Record<string, string>} */
const CARDS = { help: "show-help", save: "save-button", "start-poses": "start-poses-button" }
const PAN = 60 // pixels
const ZOOM = 1.25

export class Panels {
  #page
  /** @type {(() => Promise<Blob>) | null} */
  #recording = null // ends a recording
  #writing = false // whether the program can be written
  #trails = findA("trail", HTMLSelectElement)
  trail = Infinity // seconds
  ahead = true
  presenting = false

  /**
   * `page` is everything that panels act on.
   * @param {Page} page
   */
  constructor(page) {
    this.#page = page
    for (const name of ["timeline", "score"]) {
      const wide = name === "timeline" ? !SMALL.matches : !SMALL.matches && innerWidth >= 1000
      this.#open(name, settings.get(name, wide) && !SMALL.matches)
      find(`show-${name}`).addEventListener("click", () => this.#toggle(name))
    }
    SMALL.addEventListener("change", () => {
      const extra = this.#writing ? "timeline" : "score"
      if (SMALL.matches && !find("timeline").hidden) this.#open(extra, false)
    })
    for (const [card, button] of Object.entries(CARDS)) {
      find(button).addEventListener("click", () => this.#turn(card))
      find(card).querySelector(".close")?.addEventListener("click", () => this.#shut(card))
    }
    const press = {
      clear: page.clearTrails,
      "zoom-in": () => this.#zoom(ZOOM),
      "zoom-out": () => this.#zoom(1 / ZOOM),
      ahead: () => this.#turnAhead(),
      present: () => this.#turnPresent(),
      fit: () => this.#fit(),
      record: () => this.#record(),
      "save-svg": () => this.#save(".svg", (svg) => new Blob([svg], { type: "image/svg+xml" })),
      "save-png": () => this.#save(".png", drawPng),
    }
    for (const [id, action] of Object.entries(press)) find(id).addEventListener("click", action)
    this.#trails.addEventListener("change", () => this.#setTrail(Number(this.#trails.value)))
    this.#showTrail(Number(settings.get("trail", "Infinity")))
    this.#listen()
  }

  /** Ends the recording: the dance is over. */
  finish() {
    if (this.#recording) this.#record()
  }

  /** Shows the program, which can be written. */
  openScore() {
    this.#writing = true
    this.#open("score", true)
    if (SMALL.matches) this.#open("timeline", false)
    this.#page.resize()
  }

  showFit() {
    find("fit").setAttribute("aria-pressed", String(this.#page.camera.fits))
  }

  #listen() {
    const { controls, clearTrails, cue, camera, touch } = this.#page
    const letters = find("letters")
    letters.setAttribute("aria-pressed", String(settings.get("letters", true)))
    letters.addEventListener("click", () => {
      letters.setAttribute("aria-pressed", String(letters.getAttribute("aria-pressed") !== "true"))
      settings.set("letters", letters.getAttribute("aria-pressed") === "true")
    })
    const pan = (/** @type {number} */ x, /** @type {number} */ y) => () => {
      camera.pan(x * PAN, y * PAN)
      this.showFit()
      touch()
    }
    const stop = (/** @type {KeyboardEvent} */ event) => {
      if (event.key !== "Escape" || !this.#card("help").open) controls.stop()
      if (event.key === "Escape") for (const card of Object.keys(CARDS)) if (this.#card(card).open) this.#shut(card)
    }
    const keys = {
      k: () => controls.playOrPause(),
      p: () => this.#turnPresent(),
      r: () => controls.restart(),
      n: () => controls.step(),
      "[": () => controls.slower(),
      "]": () => controls.faster(),
      "+": () => this.#zoom(ZOOM),
      "=": () => this.#zoom(ZOOM),
      "-": () => this.#zoom(1 / ZOOM),
      f: () => this.#fit(),
      t: () => this.#setTrail(this.trail ? 0 : Infinity),
      x: clearTrails,
      c: cue,
      a: () => this.#turnAhead(),
      l: () => this.#toggle("timeline"),
      s: () => this.#toggle("score"),
      "?": () => this.#turn("help"),
      ArrowLeft: () => controls.seekBy(-1),
      ArrowRight: () => controls.seekBy(1),
      Home: () => controls.seek(0),
    }
    const shifted = { ArrowLeft: pan(1, 0), ArrowRight: pan(-1, 0), ArrowUp: pan(0, 1), ArrowDown: pan(0, -1) }
    listen(stop, keys, shifted, () => letters.getAttribute("aria-pressed") === "true")
  }

  /**
   * @param {string} name
   * @param {boolean} open
   */
  #open(name, open) {
    find(name).hidden = !open
    find(`show-${name}`).setAttribute("aria-expanded", String(open))
  }

  /** @param {string} name */
  #toggle(name) {
    const open = find(name).hidden
    this.#open(name, open)
    settings.set(name, open)
    if (open && SMALL.matches) this.#open(name === "score" ? "timeline" : "score", false) // there is room for one only
    this.#page.resize()
  }

  /** @param {string} card */
  #card(card) {
    return findA(card, HTMLDialogElement)
  }

  /** @param {string} card */
  #turn(card) {
    if (this.#card(card).open) this.#shut(card)
    else {
      for (const other of Object.keys(CARDS)) if (this.#card(other).open) this.#shut(other)
      this.#card(card).show() // not modal, so that Stop stays reachable
      find(CARDS[card]).setAttribute("aria-expanded", "true")
    }
    this.#page.resize()
  }

  /** @param {string} card */
  #shut(card) {
    this.#card(card).close()
    find(CARDS[card]).setAttribute("aria-expanded", "false")
    find(CARDS[card]).focus()
    this.#page.resize()
  }

  /** @param {number} length */
  #showTrail(length) {
    this.trail = length
    this.#trails.value = String(length)
  }

  /** @param {number} length */
  #setTrail(length) {
    this.#showTrail(length)
    settings.set("trail", String(length))
    this.#page.touch()
  }

  #turnAhead() {
    this.ahead = !this.ahead
    find("ahead").setAttribute("aria-pressed", String(this.ahead))
    this.#page.touch()
  }

  /** The stage and the beat alone, or everything again. Not the browser's full screen: there, Escape wouldn't reach us. */
  #turnPresent() {
    this.presenting = !this.presenting
    document.body.classList.toggle("presenting", this.presenting)
    find("present").setAttribute("aria-pressed", String(this.presenting))
    for (const card of Object.keys(CARDS)) if (this.#card(card).open) this.#shut(card)
    this.#page.resize()
  }

  /** @param {number} factor */
  #zoom(factor) {
    if (!this.#page.camera.view) return
    this.#page.camera.zoom(factor)
    this.showFit()
    this.#page.touch()
  }

  #fit() {
    this.#page.camera.fit()
    this.showFit()
    this.#page.touch()
  }

  /**
   * @param {string} ending
   * @param {(svg: string) => Blob | Promise<Blob>} make
   */
  async #save(ending, make) {
    const svg = await this.#page.getPicture()
    if (svg) download(`${this.#page.getStem()}${ending}`, await make(svg))
    else this.#page.announce("No picture yet. Save a program first.")
  }

  async #record() {
    const button = find("record")
    const show = (/** @type {string} */ text, /** @type {boolean} */ on) => {
      button.textContent = text
      button.setAttribute("aria-pressed", String(on))
      document.body.dataset.recording = String(on)
    }
    if (!this.#recording) {
      this.#recording = record(this.#page.canvas)
      if (this.#recording) show("Stop and save the video", true)
      else this.#page.announce((button.textContent = "This browser can't record video"))
      return
    }
    const end = this.#recording
    this.#recording = null
    show("Record a video", false)
    download(`${this.#page.getStem()}.webm`, await end())
  }
}

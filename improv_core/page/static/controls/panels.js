// @ts-check
// The panels, the cards, the tools of the stage, and their keys.

import { find, findA } from "../base/elements.js"
import { redraw, refit } from "../base/frames.js"
import { isOpen, listen } from "../base/keys.js"
import { showBriefly } from "../base/notices.js"
import { setting } from "../base/setting.js"
import { settings } from "../base/storage.js"
import { faster, playOrPause, restart, setSpeed, slower, step, stop } from "./controls.js"
import { seek, seekBy } from "./seek.js"

/** @import { Camera } from "../floor/camera.js" */

const SMALL_SCREEN = matchMedia("(max-width: 720px), (max-height: 520px)")
/** @type {Record<string, string>} */
const CARDS = { help: "show-help", guide: "show-guide", save: "save-button", sound: "sound-button", "start-poses": "start-poses-button", wall: "show-wall" }
const PAN_STEP = 60 // pixels
const ZOOM_STEP = 1.25

export class Panels {
  #camera
  #trails = findA("trail", HTMLSelectElement)
  /** The actions of controls, by their ids. @type {Record<string, () => string | void>} each returns what it did, in a word or two */
  #actions
  trail = Infinity // seconds
  #isAhead = setting("ahead", redraw)
  presenting = false

  /** @param {Camera} camera */
  constructor(camera) {
    this.#camera = camera
    for (const name of /** @type {const} */ (["timeline", "score"])) this.#openUsual(name)
    SMALL_SCREEN.addEventListener("change", () => {
      const extra = document.body.classList.contains("editing") ? "timeline" : "score"
      if (!SMALL_SCREEN.matches) this.#openUsual(extra)
      else if (!find("timeline").hidden) this.#open(extra, false)
      refit()
    })
    const buttons = {
      play: playOrPause,
      restart,
      step,
      slower,
      normal: () => setSpeed(1),
      faster,
      "show-timeline": () => this.#toggle("timeline"),
      "show-score": () => this.#toggle("score"),
      "zoom-in": () => this.#zoom(ZOOM_STEP),
      "zoom-out": () => this.#zoom(1 / ZOOM_STEP),
      fit: () => this.#fit(),
      present: () => this.#turnPresent(),
      "present-end": () => this.#turnPresent(),
      "present-program": () => this.#turnPart("program"),
      "present-beat": () => this.#turnPart("beat"),
      "show-more": () => this.#showMore(find("show-more").getAttribute("aria-expanded") !== "true"),
      ...Object.fromEntries(Object.entries(CARDS).map(([card, button]) => [button, () => this.#turn(card)])),
    }
    for (const [id, action] of Object.entries(buttons)) find(id).addEventListener("click", action)
    this.#actions = { ...buttons, trail: () => this.#setTrail(this.trail ? 0 : Infinity) }
    for (const card of Object.keys(CARDS)) find(card).querySelector(".close")?.addEventListener("click", () => this.#shut(card))
    this.#trails.addEventListener("change", () => this.#setTrail(Number(this.#trails.value)))
    this.#showTrail(Number(settings.get("trail", "Infinity")))
    this.#listen()
  }

  /** Shows the program, which can be written. */
  openScore() {
    this.#open("score", true)
    if (SMALL_SCREEN.matches) this.#open("timeline", false)
    refit()
  }

  /** The view has changed. */
  showFit() {
    find("fit").setAttribute("aria-pressed", String(this.#camera.showsAll))
    redraw()
  }

  #listen() {
    const letters = setting("letters")
    setting("show-bodies", (on) => document.body.classList.toggle("without-bodies", !on))
    setting("numbers", (on) => document.body.classList.toggle("numbered", on))
    const pan = (/** @type {number} */ x, /** @type {number} */ y) => () => {
      this.#camera.pan(x * PAN_STEP, y * PAN_STEP)
      this.showFit()
    }
    const stopOrClose = (/** @type {KeyboardEvent} */ event) => {
      if (event.key !== "Escape" || !isOpen()) return stop()
      const over = document.querySelector("dialog[open]:not(.card)")
      if (over instanceof HTMLDialogElement) return over.close()
      this.#shutAll()
      this.#showMore(false)
    }
    /** @type {Record<string, () => void>} */
    const positions = { ArrowLeft: () => seekBy(-1), ArrowRight: () => seekBy(1), Home: () => seek(0) }
    const shifted = { ArrowLeft: pan(1, 0), ArrowRight: pan(-1, 0), ArrowUp: pan(0, 1), ArrowDown: pan(0, -1) }
    listen({ stop: stopOrClose, actionOf: (key) => positions[key] ?? this.#actionOf(key), shifted, lettersWork: letters, say: showBriefly })
  }

  /** The action of the control with a key, unless that is hidden, also by what is presented. @param {string} key */
  #actionOf(key) {
    const unused = this.presenting ? "#more, #panels, #caption" : "#presenting"
    const all = /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(`[aria-keyshortcuts~="${CSS.escape(key)}" i]`))
    const control = [...all].find((each) => !each.hidden && !each.closest(unused))
    return control && (this.#actions[control.id] ?? (() => pressed(control)))
  }

  /** Shows what there is room for, unless somebody has hidden it. @param {"timeline" | "score"} name */
  #openUsual(name) {
    const wide = name === "timeline" || innerWidth >= 1000
    this.#open(name, settings.get(name, wide) && !SMALL_SCREEN.matches)
  }

  /** @param {string} name @param {boolean} open */
  #open(name, open) {
    find(name).hidden = !open && !(this.presenting && name === "score")
    find(`show-${name}`).setAttribute("aria-expanded", String(open))
  }

  /** @param {string} name */
  #toggle(name) {
    const open = find(name).hidden
    this.#open(name, open)
    settings.set(name, open)
    if (open && SMALL_SCREEN.matches) this.#open(name === "score" ? "timeline" : "score", false) // there is room for one only
    refit()
    return `${name} ${open ? "shown" : "hidden"}`
  }

  /** @param {boolean} open whether the tools are shown that a narrow stage has no room for */
  #showMore(open) {
    find("show-more").setAttribute("aria-expanded", String(open))
  }

  /** @param {string} card */
  #card(card) {
    return findA(card, HTMLDialogElement)
  }

  /** @param {string} card */
  #turn(card) {
    if (this.#card(card).open) this.#shut(card)
    else {
      this.#shutAll()
      this.#showMore(false)
      this.#card(card).show() // not modal, so that Stop stays reachable
      find(CARDS[card]).setAttribute("aria-expanded", "true")
      if (card === "guide") this.openScore()
      if (card === "start-poses") this.#fit() // the rings have to be in view
    }
    refit()
  }

  /** @param {string} card */
  #shut(card) {
    this.#card(card).close()
    const button = find(CARDS[card])
    button.setAttribute("aria-expanded", "false")
    ;(button.checkVisibility() ? button : find("show-more")).focus()
    refit()
  }

  #shutAll() {
    for (const card of Object.keys(CARDS)) if (this.#card(card).open) this.#shut(card)
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
    redraw()
    return length ? "trails on" : "trails off"
  }

  /** True if the paths ahead are shown. */
  get ahead() {
    return this.#isAhead()
  }

  /**
   * The stage, the program, and the beat, or everything again. Not the browser's full screen: there, Escape wouldn't
   * reach us.
   */
  #turnPresent() {
    this.presenting = !this.presenting
    document.body.classList.toggle("presenting", this.presenting)
    find("present").setAttribute("aria-pressed", String(this.presenting))
    this.#open("score", find("show-score").getAttribute("aria-expanded") === "true")
    this.#shutAll()
    if (!document.activeElement?.checkVisibility()) find("stage").focus() // keys work on
    refit()
    return this.presenting ? "present" : "present ended"
  }

  /** Shows or hides a part of what is presented. @param {"program" | "beat"} part */
  #turnPart(part) {
    const hidden = document.body.classList.toggle(`without-${part}`)
    find(`present-${part}`).setAttribute("aria-pressed", String(!hidden))
    refit()
    return `${part} ${hidden ? "hidden" : "shown"}`
  }

  /** @param {number} factor */
  #zoom(factor) {
    if (!this.#camera.view) return
    this.#camera.zoom(factor)
    this.showFit()
    return factor > 1 ? "zoom in" : "zoom out"
  }

  #fit() {
    this.#camera.fit()
    this.showFit()
    return "fit"
  }
}

/** Presses a button. Returns what that did. @param {HTMLElement} button */
function pressed(button) {
  button.click()
  const state = { true: " on", false: " off" }[button.getAttribute("aria-pressed") ?? ""] ?? ""
  return button.title.split(" (")[0] + state
}

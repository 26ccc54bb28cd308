// What can be shown, hidden and taken away: the panels, the cards, the tools of the stage, and their keys.

import { download, drawPng, record } from "./takeaway.js"
import { listen, settings } from "./keys.js"

const SMALL = matchMedia("(max-width: 720px), (max-height: 520px)")
const CARDS = { help: "show-help", save: "save-button", starts: "starts-button" }
const PAN = 60 // pixels
const ZOOM = 1.25

const find = (id) => document.getElementById(id)

export class Panels {
  #page
  #recording = null // ends the recording
  trail = Infinity // seconds
  ahead = true

  /** `page` is what panels do something with: see page.js. */
  constructor(page) {
    this.#page = page
    for (const name of ["timeline", "score"]) {
      const wide = name === "timeline" ? !SMALL.matches : !SMALL.matches && innerWidth >= 1000
      this.#open(name, settings.get(name, wide) && !SMALL.matches)
      find(`show-${name}`).addEventListener("click", () => this.#toggle(name))
    }
    SMALL.addEventListener("change", () => SMALL.matches && !find("timeline").hidden && this.#open("score", false))
    for (const [card, button] of Object.entries(CARDS)) {
      find(button).addEventListener("click", () => this.#turn(card))
      find(card).querySelector(".close").addEventListener("click", () => this.#shut(card))
    }
    const press = { clear: page.clearTrails, "zoom-in": () => this.#zoom(ZOOM), "zoom-out": () => this.#zoom(1 / ZOOM) }
    Object.assign(press, { ahead: () => this.#turnAhead(), fit: () => this.#fit(), record: () => this.#record() })
    press["save-svg"] = () => this.#save("improv.svg", (svg) => new Blob([svg], { type: "image/svg+xml" }))
    press["save-png"] = () => this.#save("improv.png", drawPng)
    for (const [id, action] of Object.entries(press)) find(id).addEventListener("click", action)
    find("trail").addEventListener("change", () => this.#setTrail(Number(find("trail").value)))
    this.#setTrail(Number(settings.get("trail", "Infinity")))
    this.#listen()
  }

  /** The dance is over: so is its video. */
  finish() {
    if (this.#recording) this.#record()
  }

  showFit() {
    find("fit").setAttribute("aria-pressed", String(this.#page.camera.fits))
  }

  #listen() {
    const { controls, clearTrails, camera, touch } = this.#page
    const letters = find("letters")
    letters.setAttribute("aria-pressed", String(settings.get("letters", true)))
    letters.addEventListener("click", () => {
      letters.setAttribute("aria-pressed", String(letters.getAttribute("aria-pressed") !== "true"))
      settings.set("letters", letters.getAttribute("aria-pressed") === "true")
    })
    const pan = (x, y) => () => {
      camera.pan(x * PAN, y * PAN)
      this.showFit()
      touch()
    }
    const stop = (event) => {
      controls.stop()
      if (event.key === "Escape") for (const card of Object.keys(CARDS)) if (find(card).open) this.#shut(card)
    }
    const keys = {
      p: () => controls.playOrPause(),
      r: () => controls.restart(),
      n: () => controls.step(),
      "[": () => controls.slower(),
      "]": () => controls.faster(),
      "+": () => this.#zoom(ZOOM),
      "=": () => this.#zoom(ZOOM),
      "-": () => this.#zoom(1 / ZOOM),
      f: () => this.#fit(),
      t: () => this.#setTrail(this.trail ? 0 : Infinity),
      c: clearTrails,
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

  #open(name, open) {
    find(name).hidden = !open
    find(`show-${name}`).setAttribute("aria-expanded", String(open))
  }

  #toggle(name) {
    const open = find(name).hidden
    this.#open(name, open)
    settings.set(name, open)
    if (open && SMALL.matches) this.#open(name === "score" ? "timeline" : "score", false) // there is room for one
    this.#page.resize()
  }

  #turn(card) {
    if (find(card).open) this.#shut(card)
    else {
      for (const other of Object.keys(CARDS)) if (find(other).open) this.#shut(other)
      find(card).show() // not modal: Stop stays in reach
      find(CARDS[card]).setAttribute("aria-expanded", "true")
    }
    this.#page.resize()
  }

  #shut(card) {
    find(card).close()
    find(CARDS[card]).setAttribute("aria-expanded", "false")
    find(CARDS[card]).focus()
    this.#page.resize()
  }

  #setTrail(length) {
    this.trail = length
    find("trail").value = String(length)
    settings.set("trail", String(length))
    this.#page.touch()
  }

  #turnAhead() {
    this.ahead = !this.ahead
    find("ahead").setAttribute("aria-pressed", String(this.ahead))
    this.#page.touch()
  }

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

  async #save(name, make) {
    const svg = await this.#page.getPicture()
    if (svg) download(name, await make(svg))
    else this.#page.announce("There is no picture yet: save a program first")
  }

  async #record() {
    const button = find("record")
    const show = (text, on) => {
      button.textContent = text
      button.setAttribute("aria-pressed", String(on))
      document.body.dataset.recording = String(on)
    }
    if (!this.#recording) {
      this.#recording = record(this.#page.canvas)
      if (this.#recording) show("Stop and save the video", true)
      else this.#page.announce((button.textContent = "This browser can't record"))
      return
    }
    const end = this.#recording
    this.#recording = null
    show("Record a video", false)
    download("improv.webm", await end())
  }
}

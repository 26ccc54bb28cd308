// @ts-check
// The sound of a dance: its song, from the server or from a file that somebody drops onto the page, and a click.

import { element, find, findA } from "../base/elements.js"
import { announce, notices, showBriefly } from "../base/notices.js"
import { setting } from "../base/setting.js"
import { settings } from "../base/storage.js"
import { fetchSong } from "../net/resources.js"
import { keepAsking } from "../net/server-time.js"
import { changes } from "../score/changes.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"
import { tomlLines } from "../editor/toml-lines.js"
import { MIN_TAPS, tapped, tempoOf } from "./tapping.js"
import { Waveform } from "./waveform.js"

/** @import { Audio, Song } from "./audio.js" */
/** @import { Transport } from "../score/clock.js" */
/** @typedef {NonNullable<Messages["score"]["music"]>} Music */

const UNLOCK_TIMEOUT = 300 // milliseconds in which a browser turns sound on, if it does without a click
const MAX_BYTES = 128 * 1024 * 1024 // of a file, as at the server

export class Sound {
  #showToml = tomlLines("sound-toml")
  #waveform = new Waveform((firstBeat) => this.#moveSong(firstBeat), () => this.#tellFirstBeat())
  /** @type {number[]} */
  #taps = []
  /** The place to which people have moved the song, and the score's place then. @type {{ name: string, firstBeat: number, told: number } | null} */
  #placed = null
  /** @type {Promise<Audio> | null} */
  #audio = null
  /** @type {Audio | null} */
  #loaded = null
  #generation = 0 // of the score whose song was asked for
  /** @type {{ file: string, tag: string, buffer: AudioBuffer } | null} */
  #served = null
  /** @type {{ name: string, buffer: AudioBuffer } | null} */
  #dropped = null
  #clicks = false
  /** The beats on which somebody performs without a dance. @type {Transport | null} */
  #performed = null

  constructor() {
    find("tap").addEventListener("click", () => this.#tap())
    find("use-tempo").addEventListener("click", () => this.#useTempo())
    for (const gesture of ["click", "keydown", "pointerup"]) addEventListener(gesture, () => this.#turnOn(), true)
    addEventListener("dragover", (event) => {
      if (event.dataTransfer?.types.includes("Files")) event.preventDefault()
    })
    addEventListener("drop", (event) => {
      const file = event.dataTransfer?.files[0]
      if (!file) return
      event.preventDefault()
      this.#take(file)
    })
    find("remove-song").addEventListener("click", () => {
      this.#dropped = null
      this.#showToml("") // the lines to copy were about it
      this.#showSong()
      this.run()
    })
    const volume = findA("volume", HTMLInputElement)
    volume.value = String(settings.get("volume", 1))
    volume.addEventListener("input", () => {
      settings.set("volume", Number(volume.value))
      this.#loaded?.follow()
    })
    const chosen = findA("song-file", HTMLInputElement)
    find("choose-song").addEventListener("click", () => chosen.click())
    chosen.addEventListener("change", () => {
      const [file] = chosen.files ?? []
      if (file) this.#take(file)
      chosen.value = ""
    })
    setting("clicks", (on) => this.#setClicks(on), false)
  }

  /** The sound that plays, for measurements. */
  get audio() {
    return this.#loaded
  }

  /** The connection has changed: without the server, nobody knows whether robots still dance. */
  reconnect() {
    if (notices.isOpen && this.#music) this.#load(this.#music)
    this.run()
  }

  /** Takes the song of the score. */
  show() {
    const { generation = 0 } = program.current?.score ?? {}
    const music = this.#music
    if (music?.file !== this.#served?.file) this.#served = null
    if (music?.file && generation !== this.#generation) this.#load(music)
    this.#generation = generation
    this.#showSong()
    this.run()
  }

  /** Draws the song under the timeline. @param {{ left: number, scale: number, beat: number, width: number }} shown */
  draw(shown) {
    this.#waveform.draw(shown)
  }

  /** Clicks on the beats of a transport, although nothing plays, or no longer. @param {Transport | null} transport */
  async clickFor(transport) {
    if (transport === this.#performed) return
    this.#performed = transport
    if (transport) await this.#ready()
    this.run()
  }

  /** True if there is something to play. */
  get #has() {
    return this.#clicks || this.#performed !== null || this.#song !== null
  }

  /** The song of the score. */
  get #music() {
    return program.current?.score.music ?? null
  }

  /** @returns {Song | null} */
  get #song() {
    const buffer = (this.#dropped ?? this.#served)?.buffer
    return buffer ? { buffer, firstBeat: this.#firstBeat, volume: (this.#music?.volume ?? 1) * Number(settings.get("volume", 1)) } : null
  }

  get #name() {
    return this.#dropped?.name ?? this.#served?.file ?? ""
  }

  /** The place of beat 0 in the song: the one to which people have moved it, until improv.toml has a new one. */
  get #firstBeat() {
    const told = this.#music?.first_beat ?? 0
    return this.#placed?.name === this.#name && this.#placed.told === told ? this.#placed.firstBeat : told
  }

  /** Gets the song from the server, unless it is here already. @param {Music} music */
  async #load({ file }) {
    const audio = await this.#ready()
    const answer = await fetchSong(file, this.#served?.tag ?? "")
    if (this.#music?.file !== file || answer.same) return
    this.#served = null
    const size = answer.bytes?.byteLength ?? 0
    const buffer = answer.bytes && (await decoded(audio, answer.bytes))
    if (this.#music?.file !== file) return
    if (buffer) this.#served = { file, tag: answer.tag, buffer }
    this.#showLine(buffer ? "" : answer.problem || `${file} ${whyNot(size, answer.type)}.`)
    this.#showSong()
    this.run()
  }

  /** Takes a file that somebody has dropped onto the page, or chosen. It stays in this browser. @param {File} file */
  async #take(file) {
    const audio = await this.#ready()
    this.#turnOn()
    const buffer = file.size > MAX_BYTES ? null : await file.arrayBuffer().then((bytes) => decoded(audio, bytes), () => null)
    if (buffer) {
      this.#dropped = { name: file.name, buffer }
      this.#showToml("")
      const kept = settings.get(`first beat of ${file.name}`, null)
      this.#placed = typeof kept === "number" ? { name: file.name, firstBeat: kept, told: this.#music?.first_beat ?? 0 } : null
    }
    this.#showLine(buffer ? "" : `${file.name} ${whyNot(file.size, file.type)}.`)
    this.#showSong()
    this.run()
  }

  /** @param {boolean} clicks */
  async #setClicks(clicks) {
    this.#clicks = clicks
    if (clicks) await this.#ready()
    this.run()
  }

  /** Sound itself, loaded once it is needed. */
  #ready() {
    this.#audio ??= import("./audio.js").then(({ Audio }) => {
      this.#loaded = new Audio(() => ({ clicks: this.#clicks, song: this.#song, performed: this.#performed }), () => this.#showOff())
      setTimeout(() => this.#showOff(), UNLOCK_TIMEOUT)
      return this.#loaded
    })
    return this.#audio
  }

  async #turnOn() {
    if (!this.#loaded || this.#loaded.isOn) return // at most keys
    await this.#loaded.turnOn()
    this.#showOff()
  }

  /** Plays, or doesn't, now that something has changed. */
  run() {
    const runs = this.#has && notices.isOpen && (clock.playing || clock.count !== null || this.#performed !== null)
    this.#loaded?.run(runs)
    keepAsking(runs)
    this.#showOff()
  }

  /** Says that sound needs a click, if it does. */
  #showOff() {
    find("sound-on").hidden = !this.#has || (this.#loaded?.isOn ?? true)
  }

  /** Shows a line on the stage and in the card, which may cover that. @param {string} line */
  #showLine(line) {
    for (const id of ["song-line", "song-problem"]) Object.assign(find(id), { textContent: line, hidden: !line })
    if (line) announce(line)
  }

  #showSong() {
    const { tempo = 60, bar = null } = program.current?.score ?? {}
    find("song-name").textContent = this.#name || "none: drop a file onto this page, or"
    find("remove-song").hidden = !this.#dropped
    this.#waveform.show(this.#song?.buffer ?? null, this.#name, { firstBeat: this.#firstBeat, tempo, bar })
  }

  /** Has beat 0 elsewhere in the song. @param {number} firstBeat in seconds */
  #moveSong(firstBeat) {
    this.#placed = { name: this.#name, firstBeat, told: this.#music?.first_beat ?? 0 }
    this.#showSong()
    this.#loaded?.follow()
  }

  /** Has that written, or shows the line to copy. */
  #tellFirstBeat() {
    if (this.#dropped) settings.set(`first beat of ${this.#dropped.name}`, this.#firstBeat)
    if (changes.write && this.#music && !this.#dropped) {
      changes.write({ type: "tune", key: "first_beat", value: this.#firstBeat })
      showBriefly(`Writing first_beat = ${this.#firstBeat} into improv.toml`)
    } else this.#showLines("To keep this, copy these lines into improv.toml.", `[music]\nfirst_beat = ${this.#firstBeat}`)
  }

  #tap() {
    this.#taps = tapped(this.#taps, performance.now() / 1000)
    const tempo = tempoOf(this.#taps)
    const left = MIN_TAPS - this.#taps.length
    find("tapped").textContent = tempo === null ? `${left} more` : `${tempo} beats a minute`
    find("use-tempo").hidden = tempo === null
    find("use-tempo").textContent = `beat ${tempo}`
    find("use-tempo").title = `Set the tempo of the program to ${tempo}`
  }

  #useTempo() {
    const tempo = tempoOf(this.#taps)
    if (tempo === null) return
    if (changes.write) changes.write({ type: "tune", key: "beat", value: tempo })
    else this.#showLines("Copy this line into the program, in place of the one with beat.", `beat ${tempo}`)
  }

  /** @param {string} where @param {string} lines */
  #showLines(where, lines) {
    find("sound-toml-where").textContent = where
    this.#showToml(lines)
  }
}

/** Why a file can't be played. @param {number} size in bytes @param {string} type */
function whyNot(size, type) {
  if (!size) return "is empty"
  if (size > MAX_BYTES) return `has more than ${MAX_BYTES / 1024 ** 2} MB`
  if (!element("audio").canPlayType(type)) return "can't be played: this browser doesn't know its format"
  return "can't be played: it is damaged, or so long that this browser has no room for its sound"
}

/** @param {Audio} audio @param {ArrayBuffer} bytes */
function decoded(audio, bytes) {
  return audio.decode(bytes).catch(() => null)
}

// @ts-check
// Plays a song and clicks with Web Audio, as music.js decides. Loaded only if there is something to play.

import { notices } from "../base/notices.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"
import { align } from "./grains.js"
import { beatLine, click, countLine, follow, heard, hearing, shift, songLine } from "./music.js"

/** @import { Transport } from "../score/clock.js" */
/** @import { Act, BeatLine, ClickAct, Clicks, Hearing, Plays } from "./music.js" */
/** @typedef {{ source: AudioBufferSourceNode, gain: GainNode, at: number, falls: number }} Voice `falls`: from when on it becomes silent */
/** @typedef {{ buffer: AudioBuffer, firstBeat: number, volume: number }} Song */
/** @typedef {{ clicks: boolean, song: Song | null, performed: Transport | null }} Sounds that people want */

const SURE_AFTER = 2 // looks after which the delay of the sound is known,
const BEGINNING = 1 // or seconds of the context: hidden pages look rarely
const CHECK_PERIOD = 40 // milliseconds between two looks
const LEAD = 0.02 // seconds from a decision to the sound
const SCHEDULE_AHEAD = 0.3 // seconds that are scheduled
const HIDDEN_AHEAD = 2.5 // the same while the page is hidden: browsers wake it once a second
const FADE_TIME = 0.012 // seconds in which a sound rises, and in which the one before falls
const CLICK_TIME = 0.03 // seconds of a click
const [HIGH, LOW] = [1760, 1175] // hertz

export class Audio {
  #context = new AudioContext({ latencyHint: "interactive" })
  #volume = new GainNode(this.#context)
  /** @type {Hearing[]} */
  #hearings = []
  /** @type {Plays} */
  #plays = null
  /** @type {Voice[]} */
  #voices = []
  /** @type {Clicks} */
  #clicks = null
  /** @type {{ source: OscillatorNode, at: number }[]} */
  #clicking = []
  /** @type {AudioBuffer | null} */
  #buffer = null
  /** @type {Float32Array} */
  #samples = new Float32Array()
  #timer = 0
  #wanted

  /**
   * `changed` is called when the browser turns sound on or off.
   * @param {() => Sounds} wanted
   * @param {() => void} changed
   */
  constructor(wanted, changed) {
    this.#wanted = wanted
    this.#context.addEventListener("statechange", changed)
    this.#volume.connect(this.#context.destination)
  }

  /** True if the browser lets this page make sound. */
  get isOn() {
    return this.#context.state === "running"
  }

  /** Asks the browser to let this page make sound, which needs a click. */
  async turnOn() {
    if (!this.isOn) await this.#context.resume()
  }

  /** @param {ArrayBuffer} bytes @returns {Promise<AudioBuffer>} */
  decode(bytes) {
    return this.#context.decodeAudioData(bytes)
  }

  /** Follows the performance from now on, or no longer. @param {boolean} on */
  run(on) {
    if (on && !this.#timer) this.#timer = window.setInterval(() => this.follow(), CHECK_PERIOD)
    if (!on) {
      clearInterval(this.#timer)
      this.#timer = 0
    }
    this.follow()
  }

  /** Does what has to be done now. */
  follow() {
    const context = this.#context
    const latest = this.isOn ? hearing(context.getOutputTimestamp?.() ?? {}, context, performance.now() / 1000) : null
    if (!latest) return
    this.#hearings = heard(this.#hearings, latest)
    if (this.#hearings.length < SURE_AFTER && context.currentTime < BEGINNING) return
    const { clicks, song, performed } = this.#wanted()
    const { tempo = 60, bar = null } = program.current?.score ?? {}
    const lead = shift(this.#hearings) - clock.ahead
    const { transport } = clock
    const line = notices.isOpen ? beatLine(transport, lead - (transport.behind ?? 0)) : null // real robots are ahead
    const count = notices.isOpen ? countLine(clock.count, lead) : null
    const now = this.#context.currentTime + LEAD
    const until = now + (document.hidden ? HIDDEN_AHEAD : SCHEDULE_AHEAD)
    this.#followSong(song, line, tempo, now, until)
    const clicked = performed ? beatLine(performed, lead) : clicks ? (line ?? count) : null
    const [next, acts] = click(this.#clicks, clicked, { now, ahead: until, bar })
    this.#clicks = next
    for (const act of acts) this.#doClick(act)
  }

  /**
   * The position in the song that is heard at a time of the page, in seconds; null if it is silent or in grains.
   * @param {number} page
   */
  position(page) {
    const time = page + shift(this.#hearings)
    if (this.#plays?.kind !== "song" || time < this.#plays.time) return null
    return this.#plays.position + (time - this.#plays.time) * this.#plays.speed
  }

  /**
   * @param {Song | null} song
   * @param {BeatLine | null} line
   * @param {number} tempo
   * @param {number} now
   * @param {number} ahead
   */
  #followSong(song, line, tempo, now, ahead) {
    const buffer = song?.buffer ?? null
    if (buffer !== this.#buffer) {
      if (this.#plays) this.#do({ act: "end", at: now })
      this.#plays = null
      this.#buffer = buffer
      this.#samples = buffer?.getChannelData(0) ?? new Float32Array()
    }
    this.#volume.gain.value = song?.volume ?? 1
    const wanted = song && songLine(line, { firstBeat: song.firstBeat, tempo })
    const [next, acts] = follow(this.#plays, wanted, {
      now,
      ahead,
      length: buffer?.duration ?? 0,
      align: (from, to) => align(this.#samples, buffer?.sampleRate ?? 1, from, to),
    })
    this.#plays = next
    for (const act of acts) this.#do(act)
  }

  /** @param {Act} act */
  #do(act) {
    if (act.act === "end") {
      for (const voice of this.#voices) fall(voice, act.at)
      this.#voices = []
    } else if (act.act === "bend") {
      for (const { source } of this.#voices) source.playbackRate.setValueAtTime(act.speed, act.at)
    } else {
      const voice = this.#voice(this.#buffer, act.at, this.#volume)
      voice.source.playbackRate.value = act.act === "start" ? act.speed : 1
      voice.source.start(act.at, act.position)
      if (act.act === "grain") fall(voice, act.at + act.length)
    }
  }

  /**
   * A sound that rises at a time, and is forgotten once it has ended.
   * @param {AudioBuffer | null} buffer
   * @param {number} at
   * @param {AudioNode} to
   */
  #voice(buffer, at, to) {
    const gain = new GainNode(this.#context, { gain: 0 })
    gain.gain.setValueAtTime(0, at)
    gain.gain.linearRampToValueAtTime(1, at + FADE_TIME)
    gain.connect(to)
    const voice = { source: new AudioBufferSourceNode(this.#context, { buffer }), gain, at, falls: Infinity }
    voice.source.connect(gain)
    voice.source.addEventListener("ended", () => {
      gain.disconnect()
      this.#voices = this.#voices.filter((each) => each !== voice)
    })
    this.#voices.push(voice)
    return voice
  }

  /** @param {ClickAct} act */
  #doClick(act) {
    if (act.act === "unclick") {
      for (const { source, at } of this.#clicking) if (at >= act.at) source.stop()
      this.#clicking = []
      return
    }
    const gain = new GainNode(this.#context)
    gain.gain.setValueAtTime(0.5, act.at)
    gain.gain.exponentialRampToValueAtTime(0.001, act.at + CLICK_TIME)
    gain.connect(this.#context.destination)
    const source = new OscillatorNode(this.#context, { frequency: act.high ? HIGH : LOW })
    source.connect(gain)
    source.start(act.at)
    source.stop(act.at + CLICK_TIME)
    source.addEventListener("ended", () => gain.disconnect())
    this.#clicking = [...this.#clicking.filter(({ at }) => at > act.at - 5), { source, at: act.at }]
  }
}

/** Has a sound fall from a time on, and end. @param {Voice} voice @param {number} from */
function fall(voice, from) {
  const { source, gain, at, falls } = voice
  if (from <= at) source.stop()
  if (from <= at || from >= falls) return
  voice.falls = Math.max(from, at + FADE_TIME) // it rises first
  gain.gain.cancelScheduledValues(voice.falls)
  gain.gain.setValueAtTime(1, voice.falls)
  gain.gain.linearRampToValueAtTime(0, voice.falls + FADE_TIME)
  source.stop(voice.falls + FADE_TIME)
}

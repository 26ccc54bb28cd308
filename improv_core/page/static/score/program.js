// @ts-check
// The program that plays and the one that takes over next: the state of each, and the places of its paths.

import { Anchor } from "./anchor.js"
import { Lookahead } from "./lookahead.js"
import { clock, formatPosition } from "./clock.js"
import { fetchPicture } from "../net/backend.js"
import { send } from "../net/send.js"

/** @import { Pose } from "../base/path.js" */

export class Program {
  /** @type {Promise<string | null> | null} */
  #picture = null // of its paths, as SVG
  /** @type {{ poses: Record<string, Pose>, beat: number } | null} */
  #moved = null // where the robots are, until it is known where they ideally would be
  /** @type {Lookahead | null} */
  current = null
  /** @type {Lookahead | null} */
  next = null
  anchor = new Anchor()
  text = "" // that plays, or was played last
  name = "" // of its file
  folder = ""
  /** @type {Record<string, string>} */
  #names = {} // those of children, in a class

  /** Takes the name of the program. @param {Messages["program"]} message */
  take({ name, folder, names = {} }) {
    this.name = name
    this.folder = folder
    this.#names = names
  }

  /** The name that people read beside a robot. @param {string} robot */
  label(robot) {
    return this.#names[robot] ?? robot
  }

  /** Takes a score. Returns whether it plays already. @param {Messages["score"]} message */
  takeScore(message) {
    const { generation } = message
    this.next = new Lookahead(message, (from, to) => send({ type: "window", generation, from, to }))
    return this.#turnTo(clock.transport.generation)
  }

  /** Takes a transport. Returns whether another program has taken over. @param {Messages["transport"]} message */
  takeTransport({ generation, poses, beat }, /** @type {boolean} */ jumped) {
    const turned = this.#turnTo(generation)
    if (jumped && clock.atStart) this.anchor.clear()
    else if (jumped && this.current && poses) this.#moved = { poses, beat }
    return turned
  }

  /** @param {Messages["window"]} message */
  takeWindow(message) {
    for (const each of [this.current, this.next]) each?.take(message)
  }

  /** The connection was lost, and the answers with it. */
  reconnect() {
    for (const each of [this.current, this.next]) each?.askAgain()
  }

  /** Asks for what will be needed soon. @param {number} beat */
  want(beat) {
    this.current?.want(beat)
    this.next?.want(0)
  }

  /**
   * Moves paths to where their robots are.
   * @param {{ at: number, poses: Record<string, number[]> } | undefined} newest
   * @param {number} now in seconds
   */
  place(newest, now) {
    if (!this.current?.version) return
    if (this.#moved) this.anchor.set(this.current, this.#moved.poses, this.#moved.beat)
    this.#moved = null
    this.#picture ??= fetchPicture() // kept for when the stage is gone
    const beat = newest && clock.beatAt(newest.at)
    if (newest && beat !== undefined) {
      this.anchor.look(this.current, newest.poses, beat, now, (name) => clock.isSilent(name))
    }
  }

  /** The number of beats in a bar; null if the program doesn't say it. */
  get bar() {
    return this.current?.score.bar ?? null
  }

  /** The present position, counted from 1, in words. */
  get position() {
    return formatPosition(clock.countedBeat - 1, this.bar)
  }

  /** The name of files that are saved, without an ending. */
  get stem() {
    return this.name.replace(/\.[^.]*$/, "") || "improv"
  }

  /** The paths as SVG, or null. */
  async getPicture() {
    return (await this.#picture) ?? (this.#picture = fetchPicture())
  }

  /** @param {number} generation */
  #turnTo(generation) {
    if (this.next?.score.generation !== generation) return false
    this.current = this.next
    this.text = this.current.score.text.replace(/\r\n?/g, "\n")
    this.next = this.#picture = null
    this.anchor.clear()
    return true
  }
}

/** The program, which is kept only here. */
export const program = new Program()

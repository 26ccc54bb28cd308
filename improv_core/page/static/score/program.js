// @ts-check
// The program that plays and the one that takes over next: the state of each, and the places of its paths.

import { Anchor } from "./anchor.js"
import { Lookahead } from "./lookahead.js"
import { fetchPicture } from "../net/backend.js"

/** @import { Clock } from "./clock.js" */
/** @import { Request } from "../net/requests.js" */
/** @import { Messages } from "../net/messages.js" */
/** @import { Pose } from "../base/path.js" */

export class Program {
  #clock
  #send
  /** @type {Promise<string | null> | null} */
  #picture = null // of its paths, as SVG
  /** @type {{ poses: Record<string, Pose>, beat: number } | null} */
  #moved = null // where the robots are, until it is known where they ideally would be
  /** @type {Lookahead | null} */
  current = null
  /** @type {Lookahead | null} */
  next = null
  anchor = new Anchor()

  /**
   * @param {Clock} clock
   * @param {(request: Request) => void} send
   */
  constructor(clock, send) {
    this.#clock = clock
    this.#send = send
  }

  /** Takes a score. Returns whether it plays already. @param {Messages["score"]} message */
  takeScore(message) {
    const { generation } = message
    this.next = new Lookahead(message, (from, to) => this.#send({ type: "window", generation, from, to }))
    return this.#turnTo(this.#clock.transport.generation)
  }

  /** Takes a transport. Returns whether another program has taken over. @param {Messages["transport"]} message */
  takeTransport({ generation, poses, beat }, /** @type {boolean} */ jumped) {
    const turned = this.#turnTo(generation)
    if (jumped && this.#clock.atStart) this.anchor.clear()
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
    const beat = newest && this.#clock.beatAt(newest.at)
    if (newest && beat !== undefined) {
      this.anchor.look(this.current, newest.poses, beat, now, (name) => this.#clock.isSilent(name))
    }
  }

  /** The paths as SVG, or null. */
  async getPicture() {
    return (await this.#picture) ?? (this.#picture = fetchPicture())
  }

  /** @param {number} generation */
  #turnTo(generation) {
    if (this.next?.score.generation !== generation) return false
    this.current = this.next
    this.next = this.#picture = null
    this.anchor.clear()
    return true
  }
}

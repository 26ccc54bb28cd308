// @ts-check
// Seeks: the dance continues at another beat.

import { clock } from "../score/clock.js"
import { send } from "../net/send.js"

const STEP_WINDOW = 2000 // milliseconds in which another step starts from the target of the last one, unless the server has confirmed it
const NO_TARGET = { beat: 0, at: -Infinity }

let target = NO_TARGET // of the last seek, until the server confirms it

/** @param {number} beat */
export function seek(beat) {
  const { generation, beats } = clock.transport
  if (!generation) return
  target = { beat: Math.min(Math.max(beat, 0), beats ?? Infinity), at: performance.now() }
  send({ type: "seek", beat: target.beat })
}

/** Seeks to the next whole beat, or the one before. @param {number} beats */
export function seekBy(beats) {
  const waits = performance.now() - target.at < STEP_WINDOW && !clock.playing
  const beat = waits ? target.beat : clock.beat()
  seek(beats > 0 ? Math.floor(beat + 1e-6) + beats : Math.ceil(beat - 0.25) + beats)
}

/** Takes what the server says: it may have come where it was to go. */
export function confirmSeek() {
  if (clock.transport.beat === target.beat) target = NO_TARGET
}

// @ts-check
// The shape of a song under the timeline: how loud it is, and where in it each pixel and each beat is. Pure.

/** @typedef {{ loud: Float32Array, perSecond: number, seconds: number }} Shape the loudness of the song, from 0 to 1, `perSecond` times a second */
/** @typedef {{ left: number, scale: number, width: number }} Stretch of the timeline: the beat at its left edge, pixels per beat, and pixels */
/** @typedef {{ firstBeat: number, tempo: number }} Fit where beat 0 is in the song, in seconds, and its tempo */

const FINEST = 200 // times a second

/**
 * The shape of a song, from its samples.
 * @param {{ sampleRate: number, length: number, numberOfChannels: number, getChannelData: (channel: number) => Float32Array }} buffer
 * @returns {Shape}
 */
export function shapeOf(buffer) {
  const step = Math.max(Math.round(buffer.sampleRate / FINEST), 1)
  const loud = new Float32Array(Math.ceil(buffer.length / step))
  for (let channel = 0; channel < buffer.numberOfChannels; channel++) {
    const samples = buffer.getChannelData(channel)
    for (let at = 0; at < samples.length; at++) {
      const value = Math.abs(samples[at])
      const place = Math.floor(at / step)
      if (value > loud[place]) loud[place] = value
    }
  }
  return { loud, perSecond: buffer.sampleRate / step, seconds: buffer.length / buffer.sampleRate }
}

/**
 * The loudness of the song at each pixel of a stretch of the timeline; -1 where there is no song.
 * @param {Shape} shape
 * @param {Fit} fit
 * @param {Stretch} stretch
 */
export function loudness({ loud, perSecond, seconds }, { firstBeat, tempo }, { left, scale, width }) {
  const pixel = 60 / tempo / scale // seconds
  return Float32Array.from({ length: width }, (_, x) => {
    const from = firstBeat + (left * 60) / tempo + x * pixel
    if (from < 0 || from >= seconds) return -1
    const end = Math.min(Math.max(Math.ceil((from + pixel) * perSecond), Math.floor(from * perSecond) + 1), loud.length)
    let most = 0
    for (let place = Math.floor(from * perSecond); place < end; place++) most = Math.max(most, loud[place])
    return most
  })
}

/**
 * The place of beat 0 after the song was moved by this many pixels to the right, in seconds, to the millisecond.
 * @param {Fit} fit
 * @param {number} scale
 * @param {number} pixels
 */
export function firstBeatAfter({ firstBeat, tempo }, scale, pixels) {
  return rounded(firstBeat - (pixels / scale) * (60 / tempo))
}

/** A place of beat 0 that may be written: to the millisecond, and within the limits of improv.toml. @param {number} seconds */
export function rounded(seconds) {
  return Math.min(Math.max(Math.round(seconds * 1000) / 1000, -3600), 3600) + 0
}

// @ts-check
// A program as a link: it is in the fragment of the address, which no browser sends anywhere.

import { isStill } from "./still.js"

/** @import { Still } from "./still.js" */
/** @typedef {{ text: string, toml: string, beat: number, still: Still }} Work a program, its improv.toml, where to begin, and its paths */

const KEY = "dance="
const MAX_BYTES = 200_000 // bytes of what a link holds: longer programs are files
const MAX_LINK_CHARACTERS = 8_000 // characters of a link that all mail and chat programs take
// Characters that don't show, or that show others in another order: nobody could read what such a link plays.
const HIDDEN = /[\u0000-\u0008\u000B-\u001F\u007F-\u009F\u200B\u200E\u200F\u2028-\u202E\u2060-\u2069\uFEFF]/

export const TOO_LONG = `this dance is too long for a link (${MAX_LINK_CHARACTERS.toLocaleString("en")} characters): save it as a file`
export const UNFIT = "this dance can't be a link: it is too long, or has characters that don't show; save it as a file"
export const BROKEN = "this link is broken, perhaps because its end is missing: ask for it again"
export const STRANGE = "this link holds something that isn't a dance: it was not opened"
export const LATER = "this link was made by a later version of Improv: open it on a newer page"

/** The fragment that holds some work. @param {Work} work */
export async function fragmentOf({ text, toml, beat, still }) {
  const held = { v: 1, text, ...(toml && { toml }), ...(beat && { beat }), ...(still.length && { still }) }
  const bytes = new TextEncoder().encode(JSON.stringify(held))
  return `#${KEY}${inBase64(await piped(bytes, new CompressionStream("deflate-raw"), Infinity))}`
}

/** Returns whether a link with this fragment is too long to pass on. @param {string} link */
export const isTooLong = (link) => link.length > MAX_LINK_CHARACTERS

/**
 * The work in a fragment, or a line that says why there is none; null if it is no link of ours.
 * @param {string} fragment
 * @returns {Promise<Work | string | null>}
 */
export async function workIn(fragment) {
  const link = decoded(fragment)
  if (!link.startsWith(`#${KEY}`)) return null
  /** @type {unknown} */
  let found
  try {
    const bytes = await piped(fromBase64(link.slice(KEY.length + 1)), new DecompressionStream("deflate-raw"), MAX_BYTES)
    if (!bytes) return STRANGE
    found = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes))
  } catch {
    return BROKEN
  }
  if (typeof found !== "object" || found === null || !("v" in found) || typeof found.v !== "number") return STRANGE
  if (found.v > 1) return LATER
  const { text, toml = "", beat = 0, still } = /** @type {Record<string, unknown>} */ (found)
  if (typeof text !== "string" || typeof toml !== "string" || typeof beat !== "number" || !(beat >= 0)) return STRANGE
  return HIDDEN.test(text) || HIDDEN.test(toml) ? STRANGE : { text, toml, beat, still: isStill(still) ? still : [] }
}

/**
 * A fragment as it was made: some programs that pass links on write `=` as `%3D`, or even as `%253D`.
 * @param {string} fragment
 */
export function decoded(fragment) {
  let link = fragment
  try {
    for (let times = 0; times < 3; times++) link = decodeURIComponent(link)
  } catch {
    // it has a % of its own
  }
  return link
}

/**
 * The output of a stream for bytes; null if that is more than `most`.
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @param {CompressionStream | DecompressionStream} stream
 * @param {number} most
 */
async function piped(bytes, stream, most) {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader()
  /** @type {Uint8Array<ArrayBuffer>[]} */
  const pieces = []
  let length = 0
  for (let { done, value } = await reader.read(); !done; { done, value } = await reader.read()) {
    length += value?.length ?? 0
    if (length > most) {
      await reader.cancel()
      return null
    }
    if (value) pieces.push(value)
  }
  return new Uint8Array(await new Blob(pieces).arrayBuffer())
}

/** @param {Uint8Array | null} bytes */
function inBase64(bytes) {
  const characters = Array.from(bytes ?? [], (byte) => String.fromCharCode(byte)).join("")
  return btoa(characters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")
}

/** @param {string} text */
function fromBase64(text) {
  const characters = atob(text.replaceAll("-", "+").replaceAll("_", "/"))
  return Uint8Array.from(characters, (character) => character.charCodeAt(0))
}

// @ts-check
// The song, the paths, and the time, from the server.

import { withToken } from "./token.js"

/** @typedef {{ bytes: ArrayBuffer | null, tag: string, same: boolean, problem: string, type: string }} SongAnswer */

/** @type {SongAnswer} */
const NONE = { bytes: null, tag: "", same: false, problem: "", type: "" }

/**
 * The song that the server has, or the website's gallery; `same` if it is the one with this tag. `problem` says why there
 * is none.
 * @param {string} file
 * @param {string} tag
 * @returns {Promise<SongAnswer>}
 */
export async function fetchSong(file, tag) {
  const songs = document.querySelector('meta[name="improv-songs"]')?.getAttribute("content")?.split(" ")
  if (songs && !songs.includes(file)) return { ...NONE, problem: `This website doesn't have ${file}: drop it onto this page.` }
  const address = songs ? new URL(`songs/${file}`, location.href) : withToken("song")
  const problem = `${file} did not arrive: reload this page.`
  try {
    const answer = await fetch(address, { headers: tag ? { "If-None-Match": tag } : {} })
    if (answer.status === 304) return { ...NONE, tag, same: true }
    if (!answer.ok) return { ...NONE, problem }
    const type = answer.headers.get("Content-Type") ?? ""
    if (type.startsWith("text/plain")) return { ...NONE, problem: await answer.text() }
    return { ...NONE, bytes: await answer.arrayBuffer(), tag: answer.headers.get("ETag") ?? "", type }
  } catch {
    return { ...NONE, problem }
  }
}

/** The paths as SVG, drawn by the server; null if there are none, or no server. */
export const fetchPaths = () => textAt("path.svg")

/** The server's Unix time, in seconds; null if it doesn't answer. @returns {Promise<number | null>} */
export async function fetchTime() {
  const time = Number((await textAt("time")) ?? NaN)
  return Number.isFinite(time) ? time : null
}

/** The text at a path of the server, or of the website; null if there is none. @param {string} path */
export async function textAt(path) {
  try {
    const answer = await fetch(withToken(path))
    return answer.ok ? await answer.text() : null
  } catch {
    return null
  }
}

/** The time of this browser, which is that of its workers, too. */
export const ownTime = async () => Date.now() / 1000

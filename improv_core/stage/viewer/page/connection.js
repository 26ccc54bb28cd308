// @ts-check
// The WebSocket to the server, opened again whenever it closes.

import { read } from "./messages.js"
import { withToken } from "./token.js"

/** @import { Message } from "./messages.js" */
/** @typedef {{ x: number, y: number, heading: number }} StartPose in meters and degrees */
/**
 * @typedef {{ type: "hush" | "pause" | "resume" | "restart" | "held" | "released" | "cue" }
 *   | { type: "seek", beat: number }
 *   | { type: "speed", factor: number }
 *   | { type: "silence", muted: string[], soloed: string[] }
 *   | { type: "key", key: string, held: boolean }
 *   | { type: "force", robot: string, sense: string, value: boolean | null }
 *   | { type: "place", start_poses: Record<string, StartPose> }
 *   | { type: "form", shape: "line" | "circle" | "grid", distance: number, facing: "in" | "out" }
 *   | { type: "analyze", number: number, text: string }
 *   | { type: "complete" | "explain", number: number, offset: number }
 *   | { type: "write", number: number, text: string, revision: string }
 *   | { type: "window", generation: number, from: number, to: number }} Request what a page may ask for
 */

const FIRST_DELAY = 250
const LONGEST_DELAY = 3000

/**
 * Keeps a connection. `onChange` gets "refused" if the server expects another token. Returns a function that sends a
 * request, or does nothing while there is no connection.
 * @param {(message: Message) => void} onMessage
 * @param {(now: "open" | "lost" | "refused") => void} onChange
 * @returns {(request: Request) => void}
 */
export function connect(onMessage, onChange) {
  const address = withToken("live")
  address.protocol = address.protocol.replace("http", "ws")
  /** @type {WebSocket} */
  let socket
  let delay = FIRST_DELAY

  function open() {
    socket = new WebSocket(address)
    socket.onopen = () => {
      delay = FIRST_DELAY
      onChange("open")
    }
    socket.onmessage = (event) => {
      const message = read(event.data)
      if (message) onMessage(message)
    }
    socket.onclose = async () => {
      onChange("lost")
      setTimeout(open, delay)
      delay = Math.min(delay * 1.5, LONGEST_DELAY)
      // A refused handshake looks like no server at all; an ordinary request tells them apart.
      const answer = await fetch(withToken("token"), { method: "HEAD" }).catch(() => null)
      if (answer?.status === 403) onChange("refused")
    }
  }

  open()
  return (request) => {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(request))
  }
}

// @ts-check
// The WebSocket to the server, opened again whenever it closes. Stops also go over a connection of their own.

import { Stops } from "./stops.js"
import { framed, isReplaced, withToken } from "./token.js"

/** @typedef {PageRequest | { type: "press", number: number }} Sent */

const FIRST_DELAY = 250
const LONGEST_DELAY = 3000

/**
 * Keeps a connection. `onChange` gets "refused" if the server expects another token. Returns a function that sends a
 * request; while there is no connection, it sends only stops, until one is confirmed.
 * @param {(message: Message) => void} onMessage
 * @param {(now: "open" | "lost" | "refused") => void} onChange
 * @returns {(request: PageRequest) => void}
 */
export function connect(onMessage, onChange) {
  const stops = new Stops()
  const address = withToken("live", { page: stops.page, ...(framed && { framed: "true" }) })
  address.protocol = address.protocol.replace("http", "ws")
  /** @type {WebSocket} */
  let socket
  let delay = FIRST_DELAY

  function open() {
    socket = new WebSocket(address)
    socket.onopen = () => {
      delay = FIRST_DELAY
      stops.begin()
      if (stops.waiting) put({ type: "press", number: stops.waiting })
      onChange("open")
    }
    socket.onmessage = (event) => {
      /** @type {Message} */
      const message = JSON.parse(event.data)
      if (message.type === "stopped" && !message.message) stops.end()
      onMessage(message)
    }
    socket.onclose = async () => {
      onChange("lost")
      setTimeout(open, delay)
      delay = Math.min(delay * 1.5, LONGEST_DELAY)
      // A refused handshake looks like no server at all; an ordinary request tells them apart.
      const answer = await fetch(withToken("token"), { method: "HEAD" }).catch(() => null)
      if (answer?.status === 403) {
        stops.end()
        if (isReplaced()) location.reload()
        else onChange("refused")
      }
    }
  }

  /** @param {Sent} request */
  function put(request) {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(request))
  }

  open()
  return (request) => put(request.type === "stop" ? { type: "press", number: stops.press() } : request)
}

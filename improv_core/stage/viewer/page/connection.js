// The WebSocket to the server, opened again whenever it closes.

import { read } from "./messages.js"

const FIRST_DELAY = 250
const LONGEST_DELAY = 3000

/**
 * Keeps a connection. `onMessage` gets each message; `onChange` gets "open", "lost", or "refused" (the server is there,
 * but wants another token). Returns a function that sends a message, or does nothing while there is no connection.
 */
export function connect(onMessage, onChange) {
  const token = new URLSearchParams(location.search).get("token") ?? ""
  const address = new URL(`live?token=${encodeURIComponent(token)}`, location.href)
  address.protocol = address.protocol.replace("http", "ws")
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
      // A refused handshake looks like no server at all; the page's own address tells them apart.
      const page = await fetch(location.href, { method: "HEAD" }).catch(() => null)
      if (page?.status === 403) onChange("refused")
    }
  }

  open()
  return (message) => {
    if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message))
  }
}

// @ts-check
// The token that every request to the server needs. The server puts it into the page once, for a ticket. The browser
// keeps it for this exact address, so that a tab can be reloaded, or opened again. Once the process ends, it opens
// nothing. In a frame it is neither kept nor read: any local server may frame this page.

import { findA } from "../base/elements.js"
import { store, stored } from "../base/storage.js"

const KEY = "improv.token"
const given = findA("token", HTMLMetaElement).content

/** True if this page is in a frame, as in VS Code. */
export const framed = window.top !== window.self

if (given && !framed) store(KEY, given)

/** Empty if the page was opened without a valid ticket, and this browser has no token for it. */
export const token = given || framed ? given : storedToken()

// The ticket is used up. Without it, the address can be reloaded and bookmarked. On a website, what others put there goes,
// and the dance of a link stays.
if (location.search) history.replaceState(null, "", location.pathname + location.hash)

function storedToken() {
  return String(stored(KEY) ?? "")
}

/** True if this browser has another token by now: Improv was started again, and another tab has opened its page. */
export const isReplaced = () => !framed && !["", token].includes(storedToken())

/** An address on the server, with the token. @param {string} path @param {Record<string, string>} more values */
export function withToken(path, more = {}) {
  return new URL(`${path}?${new URLSearchParams({ token, ...more })}`, location.href)
}

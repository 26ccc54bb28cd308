// @ts-check
// The token that every request to the server needs. The server puts it into the page once; it stays in this tab.

import { findA } from "./elements.js"

const KEY = "improv.token"
const given = findA("token", HTMLMetaElement).content

/** Empty if the page was opened without a valid ticket. */
export const token = given ? keep(given) : kept()

// The ticket is used up. Without it, the address can be reloaded and bookmarked.
history.replaceState(null, "", location.pathname)

/** @param {string} token */
function keep(token) {
  try {
    sessionStorage.setItem(KEY, token)
  } catch {
    // without storage, the page can't be reloaded
  }
  return token
}

function kept() {
  try {
    return sessionStorage.getItem(KEY) ?? ""
  } catch {
    return ""
  }
}

/**
 * An address on the server, with the token.
 * @param {string} path
 */
export function withToken(path) {
  return new URL(`${path}?token=${encodeURIComponent(token)}`, location.href)
}

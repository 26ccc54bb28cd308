// @ts-check
// The elements of index.html by their ids. All of them exist, so a missing one is a mistake of ours.

/** @param {string} id */
export function find(id) {
  return findA(id, HTMLElement)
}

/**
 * @template {HTMLElement} T
 * @param {string} id
 * @param {{ new (): T }} kind
 * @returns {T}
 */
export function findA(id, kind) {
  const element = document.getElementById(id)
  if (!(element instanceof kind)) throw new Error(`the page has no ${kind.name} called ${id}`)
  return element
}

// @ts-check
// The elements of index.html by their ids, and the children of those that change. All elements with ids exist, so a missing
// one is a mistake of ours.

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

/**
 * Has a parent hold a child for each name, in this order. A child that is there already stays, and is not made again:
 * somebody may be pressing it.
 * @param {HTMLElement} parent
 * @param {string[]} names
 * @param {(name: string) => HTMLElement} make
 */
export function syncChildren(parent, names, make) {
  const children = () => /** @type {HTMLElement[]} */ ([...parent.children])
  const before = new Map(children().map((child) => [child.dataset.name, child]))
  for (const child of children()) if (!names.includes(child.dataset.name ?? "")) child.remove()
  names.forEach((name, i) => {
    const at = children()[i]
    if (at?.dataset.name === name) return
    const child = before.get(name) ?? make(name)
    child.dataset.name = name
    parent.insertBefore(child, at ?? null)
  })
}

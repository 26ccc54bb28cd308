// @ts-check
// Values that this browser keeps, if it keeps any.

/** The value that is kept under a key, or null. @param {string} key */
export function stored(key) {
  try {
    return JSON.parse(localStorage.getItem(key) ?? "null")
  } catch {
    return null
  }
}

/** Keeps a value. Returns whether this browser had room for it. @param {string} key @param {unknown} value */
export function store(key, value) {
  try {
    localStorage.setItem(key, JSON.stringify(value))
    return true
  } catch {
    return false
  }
}

/** Settings that last, if the browser keeps them. */
export const settings = {
  /** @param {string} name @param {unknown} otherwise */
  get: (name, otherwise) => stored(`improv.${name}`) ?? otherwise,
  /** @param {string} name @param {unknown} value */
  set: (name, value) => store(`improv.${name}`, value),
}

// @ts-check
// Names that nobody else has. `crypto.randomUUID` is missing where a class loads the page, over plain HTTP.

export function randomName() {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("")
}

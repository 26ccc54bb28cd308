// @ts-check
// Keeps the website in the browser, so that the second visit needs no network. `improv site` writes the first lines.

/** @typedef {{ addEventListener: (type: string, listen: (event: any) => void) => void, skipWaiting: () => Promise<void>, clients: { claim: () => Promise<void> }, registration: { scope: string } }} Scope */

const scope = /** @type {Scope} */ (/** @type {unknown} */ (self))
const { version, files } = /** @type {{ version: string, files: string[] }} */ (Reflect.get(self, "SITE"))
const NAME = `improv ${scope.registration.scope} `
const own = NAME + version

scope.addEventListener("install", (event) => event.waitUntil(keepAll()))
scope.addEventListener("message", (event) => event.data === "take over" && scope.skipWaiting()) // of a page that is ready
scope.addEventListener("activate", (event) => event.waitUntil(forgetOthers().then(() => scope.clients.claim())))
scope.addEventListener("fetch", (event) => {
  if (event.request.method === "GET") event.respondWith(answer(event.request))
})

async function keepAll() {
  const cache = await caches.open(own)
  await cache.addAll(files.map((file) => new Request(file, { cache: "no-cache" })))
}

async function forgetOthers() {
  const others = (await caches.keys()).filter((name) => name.startsWith(NAME) && name !== own)
  await Promise.all(others.map((name) => caches.delete(name)))
}

/** @param {Request} request */
async function answer(request) {
  const cache = await caches.open(own)
  return (await cache.match(request, { ignoreSearch: true })) ?? fetch(request)
}

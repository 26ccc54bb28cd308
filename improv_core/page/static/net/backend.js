// @ts-check
// The place of Improv: behind a server, or on a website, in a worker of this browser.

import { connect as connectToServer } from "./connection.js"
import { connect as connectToWorker, drawPaths, getToml, setToml } from "./worker-backend.js"
import * as server from "./resources.js"

/** True if this page is a website that has all of Improv with it. */
export const isWebsite = document.querySelector('meta[name="improv-worker"]') !== null

document.body.classList.toggle("website", isWebsite)

export const connect = isWebsite ? connectToWorker : connectToServer

/** Promises the paths as SVG; null if there are none, or nobody can draw them. */
export const fetchPicture = isWebsite ? drawPaths : server.fetchPaths

/** Promises the Unix time of what plays, in seconds. */
export const fetchTime = isWebsite ? server.ownTime : server.fetchTime

/** The improv.toml that this browser keeps with the program: none behind a server, which has a file. */
export const keptToml = isWebsite ? { get: getToml, set: setToml } : { get: () => undefined, set: (/** @type {string} */ _) => false }

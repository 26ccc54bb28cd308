// @ts-check
// Where Improv runs: behind a server, or on a website, in a worker of this browser.

import { connect as connectToServer } from "./connection.js"
import { connect as connectToWorker, drawPaths } from "./worker-home.js"
import { fetchPaths } from "./save.js"

/** Whether this page is a website that has all of Improv with it. */
export const isWebsite = document.querySelector('meta[name="improv-worker"]') !== null

export const connect = isWebsite ? connectToWorker : connectToServer

/** Promises the paths as SVG; null if there are none, or nobody can draw them. */
export const fetchPicture = isWebsite ? drawPaths : fetchPaths

// @ts-check
// Requests to Improv, wherever it is.

/** @import { Request } from "./requests.js" */

/** @type {(request: Request) => void} */
let way = () => {}

/** Sends a request: while there is no connection, only a stop. @param {Request} request */
export function send(request) {
  way(request)
}

/** Has requests go this way from now on. @param {(request: Request) => void} put */
export function sendBy(put) {
  way = put
}

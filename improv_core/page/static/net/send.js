// @ts-check
// Requests to Improv, wherever it is.


/** @type {(request: PageRequest) => void} */
let way = () => {}

/** Sends a request: while there is no connection, only a stop. @param {PageRequest} request */
export function send(request) {
  way(request)
}

/** Has requests go this way from now on. @param {(request: PageRequest) => void} put */
export function sendBy(put) {
  way = put
}

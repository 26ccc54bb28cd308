// @ts-check
// By how many seconds the server's clock is ahead of the page's, from questions about the time and their answers.

/** @typedef {{ sent: number, wall: number, received: number }} TimeAnswer the page's seconds, and the server's Unix time in between */

const KEPT = 8

/**
 * The answers to go by after another one. If the server's clock was set meanwhile, the earlier ones don't count.
 * @param {TimeAnswer[]} answers
 * @param {TimeAnswer} answer
 */
export function answered(answers, answer) {
  const fits = answers.every(({ sent, wall, received }) => wall - received <= answer.wall - answer.sent && answer.wall - answer.received <= wall - sent)
  return [...(fits ? answers : []), answer].slice(-KEPT)
}

/** By how much it is ahead according to the answer that was the fastest; null without one. @param {TimeAnswer[]} answers */
export function aheadBy(answers) {
  const [best] = [...answers].sort((one, two) => one.received - one.sent - (two.received - two.sent))
  return best ? best.wall - (best.sent + best.received) / 2 : null
}

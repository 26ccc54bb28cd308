// @ts-check
// By how many seconds the server's clock is ahead of the page's, from questions about the time and their answers.

/**
 * @typedef {{ sent: number, wall: number, received: number, own: number }} TimeAnswer
 * the page's seconds, the server's Unix time in between, and by how much the Unix time of the page's machine is ahead of
 * the page's seconds
 */

const MAX_ANSWERS = 12
const SLACK = 0.002 // seconds: clocks have whole milliseconds, and drift

/**
 * The answers to go by after another one. If the server's clock was set meanwhile, the earlier ones don't count.
 * @param {TimeAnswer[]} answers
 * @param {TimeAnswer} answer
 */
export function withAnswer(answers, answer) {
  const all = [...answers, answer]
  const [least, most] = bounds(all)
  return least <= most + SLACK ? all.slice(-MAX_ANSWERS) : [answer]
}

/**
 * By how much it is ahead; null without an answer. No answer allows more than some of it: the server read its clock after
 * the question was sent, and before the answer was received. If the clock of the page's machine fits all of them, it is
 * probably the server's, too, and then nothing is more exact.
 * @param {TimeAnswer[]} answers
 */
export function clockOffset(answers) {
  const latest = answers.at(-1)
  if (!latest) return null
  const [least, most] = bounds(answers)
  return latest.own >= least - SLACK && latest.own <= most + SLACK ? latest.own : (least + most) / 2
}

/** @param {TimeAnswer[]} answers */
function bounds(answers) {
  const least = Math.max(...answers.map(({ wall, received }) => wall - received))
  return [least, Math.min(...answers.map(({ wall, sent }) => wall - sent))]
}

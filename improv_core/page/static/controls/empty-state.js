// @ts-check
// The steps until something plays: the file to save, the part that it lacks, and its errors.

import { element, find } from "../base/elements.js"
import { notices } from "../base/notices.js"
import { clock } from "../score/clock.js"
import { program } from "../score/program.js"


/** Shows why a program that was saved can't play. @param {Messages["program"]} message */
export function showProblems({ name, problems, count }) {
  find("problems").hidden = !problems.length
  const errors = count === 1 ? "an error" : `${count} errors`
  find("problems-title").textContent = `${name} can't play: fix ${errors} and save it again`
  find("problems-list").replaceChildren(...problems.map((problem) => row(problem, name)))
  if (problems.length < count) find("problems-list").append(element("li", { textContent: `and ${count - problems.length} more` }))
}

/** Shows what is missing: a program, or robots in it. */
export function showHint() {
  const { name, folder, current } = program
  const played = clock.transport.generation > 0
  const robots = !current || Object.keys(current.score.robots).length > 0
  const editing = document.body.classList.contains("editing")
  find("hint").hidden = !notices.isOpen || (played && robots)
  find("hint-example").hidden = editing && !played
  const notPlayed = editing ? "Press Save and play to see it dance" : `Save ${name || "or play a program"} to see it dance`
  find("hint-title").textContent = played ? `${name || "This program"} has no robots` : notPlayed
  find("hint-text").textContent = played
    ? "Write the name of a robot, a dollar sign, and what it does. For example:"
    : folder && `${name} is in ${folder}`
  document.body.classList.toggle("empty", !played || !robots)
}

/** @param {Messages["program"]["problems"][number]} problem @param {string} program */
function row({ file, line, word, message }, program) {
  const where = [file !== program && file, line && `line ${line}`].filter(Boolean).join(", ")
  const summary = element("summary", {}, ...(where ? [element("b", { textContent: where }), " "] : []), message)
  return element("li", {}, element("details", {}, summary, ...(word ? [element("code", { textContent: word })] : [])))
}

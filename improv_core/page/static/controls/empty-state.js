// @ts-check
// The steps until something plays: the file to save, the part that it lacks, and its errors.

import { find } from "../base/elements.js"

/** @import { Messages } from "../net/messages.js" */

export class EmptyState {
  #name = ""
  #folder = ""

  /** @param {Messages["program"]} message */
  take({ name, folder, problems, count }) {
    this.#name = name
    this.#folder = folder
    find("problems").hidden = !problems.length
    const errors = count === 1 ? "an error" : `${count} errors`
    find("problems-title").textContent = `${name} can't play: fix ${errors} and save it again`
    find("problems-list").replaceChildren(...problems.map((problem) => row(problem, name)))
    if (problems.length < count) find("problems-list").append(Object.assign(document.createElement("li"), { textContent: `and ${count - problems.length} more` }))
  }

  /** The name of saved files, without an ending. */
  get stem() {
    return this.#name.replace(/\.[^.]*$/, "") || "improv"
  }

  /**
   * Shows what is missing: a program, or robots in it.
   * @param {boolean} open whether the page is connected
   * @param {boolean} played whether there is a program
   * @param {boolean} robots whether it has robots
   */
  show(open, played, robots) {
    find("hint").hidden = !open || (played && robots)
    const editing = document.body.classList.contains("editing")
    find("hint-example").hidden = editing && !played
    find("hint-title").textContent = editing && !played
      ? `Press Play to see ${this.#name} dance`
      : played
        ? `${this.#name || "This program"} has no robots`
        : this.#name
          ? `Save ${this.#name} to see it dance`
          : "Save a program to see it dance"
    find("hint-text").textContent = played
      ? "Write the name of a robot, a dollar sign, and what it does. For example:"
      : this.#folder && `It is in ${this.#folder}`
    document.body.classList.toggle("empty", !played || !robots)
  }
}

/**
 * @param {Messages["program"]["problems"][number]} problem
 * @param {string} program
 */
function row({ file, line, word, message }, program) {
  const item = document.createElement("li")
  const details = document.createElement("details")
  const summary = document.createElement("summary")
  const where = [file !== program && file, line && `line ${line}`].filter(Boolean).join(", ")
  if (where) summary.append(Object.assign(document.createElement("b"), { textContent: where }), " ")
  summary.append(message)
  details.append(summary)
  if (word) details.append(Object.assign(document.createElement("code"), { textContent: word }))
  item.append(details)
  return item
}

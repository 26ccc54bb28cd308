// @ts-check
// Where the cursor was before each edit that the page made, for its undo: the browser selects what such an edit replaced.

const MAX_KEPT = 100

export class Undoing {
  #control
  /** @type {{ before: string, after: string, start: number, end: number }[]} */
  #edits = []

  /** @param {HTMLTextAreaElement} control */
  constructor(control) {
    this.#control = control
  }

  /** Notes where the cursor is before an edit. @param {string} after the text after it */
  note(after) {
    const { value: before, selectionStart: start, selectionEnd: end } = this.#control
    this.#edits = [...this.#edits.slice(-MAX_KEPT), { before, after, start, end }]
  }

  /** Puts the cursor back, if the page made the edit that was undone. @param {string} undone the text before the undo */
  restore(undone) {
    const edit = this.#edits.findLast(({ before, after }) => before === this.#control.value && after === undone)
    if (edit) this.#control.setSelectionRange(edit.start, edit.end)
  }
}

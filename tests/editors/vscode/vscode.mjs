// As much of VS Code as src/words.ts asks for, with one program in sight.

export const document = { uri: "file:///dance.improv", version: 1, languageId: "improv" }
export let lit = []

class Event {
  #listeners = new Set()
  on = (listener) => {
    this.#listeners.add(listener)
    return { dispose: () => this.#listeners.delete(listener) }
  }
  fire = (event) => this.#listeners.forEach((listener) => listener(event))
}

const closed = new Event()
const shown = new Event()

/** Types something. */
export function type() {
  document.version += 1
}

export function close() {
  workspace.textDocuments = []
  window.visibleTextEditors = []
  closed.fire(document)
  shown.fire()
}

export function open() {
  workspace.textDocuments = [document]
  lit = []
  window.visibleTextEditors = [{ document, setDecorations: (_, ranges) => (lit = ranges) }]
  shown.fire()
}

export class Range {
  constructor(...place) {
    return place
  }
}
export class ThemeColor {}
export const DecorationRangeBehavior = { ClosedClosed: 1 }
export const Disposable = { from: (...all) => ({ dispose: () => all.forEach((each) => each.dispose()) }) }
export const window = {
  createTextEditorDecorationType: () => ({ dispose: () => undefined }),
  onDidChangeVisibleTextEditors: shown.on,
}
export const workspace = {
  getConfiguration: () => ({ get: () => true }),
  onDidCloseTextDocument: closed.on,
  onDidChangeConfiguration: new Event().on,
}

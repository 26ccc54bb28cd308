// As much of VS Code as some parts of the extension ask for, with one program in sight.

export const document = { uri: "file:///dance.improv", version: 1, languageId: "improv" }
export let lit = []
/** The commands that were asked for, and the warnings that were shown. */
export let asked = []
export let warnings = []
let isSilent = false

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
  asked = []
  warnings = []
  isSilent = false
  env.uiKind = UIKind.Web
  window.state.focused = true
  window.visibleTextEditors = [{ document, setDecorations: (_, ranges) => (lit = ranges) }]
  shown.fire()
}

/** Whether the window leaves commands unanswered from now on. */
export function answerNothing(now) {
  isSilent = now
}

export const UIKind = { Desktop: 1, Web: 2 }
export const env = { uiKind: UIKind.Web, remoteName: undefined }
export const commands = {
  executeCommand: (name) => {
    asked.push(name)
    return isSilent ? new Promise(() => undefined) : Promise.resolve()
  },
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
  state: { focused: true },
  createTextEditorDecorationType: () => ({ dispose: () => undefined }),
  onDidChangeVisibleTextEditors: shown.on,
  showWarningMessage: async (message) => warnings.push(message),
}
export const workspace = {
  getConfiguration: () => ({ get: () => true }),
  onDidCloseTextDocument: closed.on,
  onDidChangeConfiguration: new Event().on,
}

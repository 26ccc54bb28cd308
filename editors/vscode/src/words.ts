// Highlights the words that the server says are lit.

import {
  DecorationRangeBehavior,
  Disposable,
  Range,
  TextDocument,
  TextEditor,
  ThemeColor,
  window,
  workspace,
} from "vscode";

/** What is lit in a version of a document: start line, start column, end line, end column of each word. */
export interface Lit {
  uri: string;
  version: number;
  ranges: readonly (readonly [number, number, number, number])[];
}

export class LitWords implements Disposable {
  private readonly highlight = window.createTextEditorDecorationType({
    backgroundColor: new ThemeColor("improv.playingBackground"),
    outline: "1px solid",
    outlineColor: new ThemeColor("improv.playingBorder"),
    borderRadius: "3px",
    rangeBehavior: DecorationRangeBehavior.ClosedClosed,
  });
  private readonly listening = Disposable.from(
    workspace.onDidCloseTextDocument((document) => this.isOf(document) && this.show(undefined)), // it may come back changed
    workspace.onDidChangeConfiguration((event) => event.affectsConfiguration("improv.highlight") && this.paint()),
    window.onDidChangeVisibleTextEditors(() => this.paint()),
  );
  private lit?: Lit;

  /** Shows what is lit now; undefined: nothing plays any more. */
  show(lit: Lit | undefined): void {
    this.lit = lit;
    this.paint();
  }

  dispose(): void {
    this.listening.dispose();
    this.highlight.dispose();
  }

  private paint(): void {
    const isWanted = workspace.getConfiguration("improv").get("highlight.playing", true);
    for (const editor of window.visibleTextEditors) {
      if (editor.document.languageId !== "improv") continue;
      if (isWanted && this.lit && this.isOf(editor.document)) this.light(editor, this.lit);
      else editor.setDecorations(this.highlight, []);
    }
  }

  /** Who types is ahead of the server: until it has caught up, highlights move with the text. */
  private light(editor: TextEditor, { version, ranges }: Lit): void {
    if (ranges.length > 0 && editor.document.version !== version) return;
    const words = ranges.map((word) => new Range(...word));
    editor.setDecorations(this.highlight, words);
  }

  private isOf(document: TextDocument): boolean {
    return document.uri.toString() === this.lit?.uri;
  }
}

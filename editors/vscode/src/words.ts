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

/** Start line, start column, end line, end column. */
type Place = readonly [number, number, number, number];

/** What is lit in a version of a document. */
export interface Lit {
  uri: string;
  version: number;
  ranges: readonly Place[];
}

/** What was just played in a version of a document. */
export interface Evaluated {
  uri: string;
  version: number;
  range: Place;
}

const FLASH = 200; // milliseconds

export class LitWords implements Disposable {
  private readonly highlight = window.createTextEditorDecorationType({
    backgroundColor: new ThemeColor("improv.playingBackground"),
    outline: "1px solid",
    outlineColor: new ThemeColor("improv.playingBorder"),
    borderRadius: "3px",
    rangeBehavior: DecorationRangeBehavior.ClosedClosed,
  });
  private readonly flashing = window.createTextEditorDecorationType({
    backgroundColor: new ThemeColor("editor.selectionBackground"),
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

  /** Shows for a moment what was just played. */
  flash({ uri, version, range }: Evaluated): void {
    for (const editor of window.visibleTextEditors) {
      if (editor.document.uri.toString() !== uri || editor.document.version !== version) continue;
      editor.setDecorations(this.flashing, [new Range(...range)]);
      setTimeout(() => editor.setDecorations(this.flashing, []), FLASH);
    }
  }

  dispose(): void {
    this.listening.dispose();
    this.flashing.dispose();
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

// Highlights the words that play, by its own clock: the server reports once what is to come.

import { Disposable, Range, TextDocument, TextDocumentChangeEvent, ThemeColor, window, workspace } from "vscode";
import { edited, Evaluated, playing, reaches, WordRange } from "./moments";
import { beatAt, isSilent, Transport } from "./transport";

const SHORTEST = 30; // ms between two changes on the screen
const AHEAD = 4; // ask for more this many beats before the known ones end
const PATIENCE = 500; // ms before asking again

/** Asks the server what plays from a beat on. */
export type RequestMoments = (beat: number) => Promise<Evaluated | undefined>;

export class PlayingWords implements Disposable {
  private readonly highlight = window.createTextEditorDecorationType({
    backgroundColor: new ThemeColor("improv.playingBackground"),
    outline: "1px solid",
    outlineColor: new ThemeColor("improv.playingBorder"),
    borderRadius: "3px",
  });
  private readonly listening = Disposable.from(
    workspace.onDidChangeTextDocument((event) => this.follow(event)),
    workspace.onDidCloseTextDocument((document) => this.forget(document)),
    workspace.onDidChangeConfiguration((event) => event.affectsConfiguration("improv.highlight") && this.paint()),
    window.onDidChangeVisibleTextEditors(() => this.paint()),
  );
  private readonly known = new Map<number, Evaluated>(); // by generation: one plays, the next takes over
  private transport?: Transport;
  private timer?: NodeJS.Timeout;
  private asking = false;

  constructor(private readonly request: RequestMoments) {}

  /** Learns what plays from now on. */
  expect(evaluated: Evaluated): void {
    for (const old of this.known.keys()) {
      if (old !== this.transport?.generation) this.known.delete(old);
    }
    const isCurrent = documentOf(evaluated)?.version === evaluated.version; // nobody typed meanwhile
    this.known.set(evaluated.generation, isCurrent ? evaluated : unknown(evaluated));
    this.paint();
  }

  /** Follows the server's clock; undefined: nothing plays any more. */
  setTransport(transport: Transport | undefined): void {
    this.transport = transport;
    if (!transport) this.known.clear(); // the next server counts its generations from the beginning
    this.paint();
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.listening.dispose();
    this.highlight.dispose();
  }

  private paint(): void {
    clearTimeout(this.timer);
    const evaluated = this.evaluated();
    if (!evaluated || !this.transport) return this.show(undefined, []);
    const transport = this.transport;
    const beat = beatAt(transport);
    const { ranges, next } = playing(evaluated, beat, (robot) => isSilent(transport, robot));
    this.show(evaluated.uri, ranges);

    const isKnown = reaches(evaluated, beat) && reaches(evaluated, beat + AHEAD);
    if (!isKnown) void this.requestMore(beat);
    const change = transport.state === "playing" ? ((next - beat) * 60_000) / transport.tempo : Infinity;
    const wait = isKnown ? change : Math.min(change, PATIENCE);
    if (wait < 2 ** 31) this.timer = setTimeout(() => this.paint(), Math.max(wait, SHORTEST));
  }

  /** What is known about what plays now, if its words are to be highlighted. */
  private evaluated(): Evaluated | undefined {
    const isActive = this.transport?.state === "playing" || this.transport?.state === "paused";
    const isWanted = workspace.getConfiguration("improv").get("highlight.playing", true);
    const evaluated = this.known.get(this.transport?.generation ?? -1);
    return isActive && isWanted && evaluated && documentOf(evaluated) ? evaluated : undefined;
  }

  private show(uri: string | undefined, words: WordRange[]): void {
    const ranges = words.map((word) => new Range(...word));
    for (const editor of window.visibleTextEditors) {
      if (editor.document.languageId !== "improv") continue;
      editor.setDecorations(this.highlight, editor.document.uri.toString() === uri ? ranges : []);
    }
  }

  private follow({ document, contentChanges }: TextDocumentChangeEvent): void {
    const uri = document.uri.toString();
    for (const [generation, evaluated] of this.known) {
      if (evaluated.uri !== uri) continue;
      const ranges = contentChanges.reduce(edited, evaluated.ranges);
      this.known.set(generation, { ...evaluated, version: document.version, ranges });
    }
    if (contentChanges.length > 0) this.paint();
  }

  /** A document that is opened again may hold another text. */
  private forget(document: TextDocument): void {
    for (const [generation, evaluated] of this.known) {
      if (evaluated.uri === document.uri.toString()) this.known.set(generation, unknown(evaluated));
    }
  }

  /** Learns what plays from a beat on, unless somebody types meanwhile. */
  private async requestMore(beat: number): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    const more = await this.request(beat).catch(() => undefined);
    if (more && more.generation === this.transport?.generation && documentOf(more)?.version === more.version) {
      this.known.set(more.generation, more);
    }
    setTimeout(() => (this.asking = false), PATIENCE);
    this.paint();
  }
}

/** Until the server reports where the words are now, nothing is highlighted. */
function unknown(evaluated: Evaluated): Evaluated {
  return { ...evaluated, robots: {}, from: Infinity };
}

function documentOf(evaluated: Evaluated): TextDocument | undefined {
  return workspace.textDocuments.find((each) => each.uri.toString() === evaluated.uri);
}

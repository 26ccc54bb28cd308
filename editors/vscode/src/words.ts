// Lights up the words that play, by a clock of its own: the server says once what is to come.

import { Disposable, Range, TextDocument, TextDocumentChangeEvent, ThemeColor, window, workspace } from "vscode";
import { beatAt, isSilent, Transport } from "./clock";
import { edited, Evaluated, Known, Place, playing, reaches } from "./moments";

const SHORTEST = 30; // ms between two changes on the screen
const AHEAD = 4; // beats before the known ones end, at which more are asked for
const PATIENCE = 500; // ms before asking again

/** Asks what plays from a beat on. */
type Ask = (beat: number) => Promise<Evaluated | undefined>;

export class PlayingWords implements Disposable {
  private readonly light = window.createTextEditorDecorationType({
    backgroundColor: new ThemeColor("improv.playingBackground"),
    outline: "1px solid",
    outlineColor: new ThemeColor("improv.playingBorder"),
    borderRadius: "3px",
  });
  private readonly listening = Disposable.from(
    workspace.onDidChangeTextDocument((event) => this.follow(event)),
    workspace.onDidCloseTextDocument((document) => this.lose(document)),
    workspace.onDidChangeConfiguration((event) => event.affectsConfiguration("improv.highlight") && this.paint()),
    window.onDidChangeVisibleTextEditors(() => this.paint()),
  );
  private readonly known = new Map<number, Known>(); // by generation: one plays, the next may wait to take over
  private transport?: Transport;
  private timer?: NodeJS.Timeout;
  private asking = false;

  constructor(private readonly ask: Ask) {}

  /** Takes what is to come from a save on. */
  expect(evaluated: Evaluated): void {
    for (const old of this.known.keys()) {
      if (old !== this.transport?.generation) this.known.delete(old);
    }
    const isCurrent = documentOf(evaluated)?.version === evaluated.version; // nobody has typed meanwhile
    this.known.set(evaluated.generation, isCurrent ? { ...evaluated, from: 0 } : unknown(evaluated));
    this.paint();
  }

  /** Goes on from where the server says that it is; from nothing, where nothing plays any more. */
  take(transport: Transport | undefined): void {
    this.transport = transport;
    if (!transport) this.known.clear(); // the next server counts its generations anew
    this.paint();
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.listening.dispose();
    this.light.dispose();
  }

  private paint(): void {
    clearTimeout(this.timer);
    const evaluated = this.evaluated();
    if (!evaluated || !this.transport) return this.show(undefined, []);
    const transport = this.transport;
    const beat = beatAt(transport);
    const { places, next } = playing(evaluated, beat, (robot) => isSilent(transport, robot));
    this.show(evaluated.uri, places);

    const isKnown = reaches(evaluated, beat) && reaches(evaluated, beat + AHEAD);
    if (!isKnown) void this.askOn(beat);
    const change = transport.state === "playing" ? ((next - beat) * 60_000) / transport.tempo : Infinity;
    const wait = isKnown ? change : Math.min(change, PATIENCE);
    if (wait < 2 ** 31) this.timer = setTimeout(() => this.paint(), Math.max(wait, SHORTEST));
  }

  /** What is known of what plays, where its words are to be lit. */
  private evaluated(): Known | undefined {
    const isLit = this.transport?.state === "playing" || this.transport?.state === "paused";
    const isWanted = workspace.getConfiguration("improv").get("highlight.playing", true);
    const evaluated = this.known.get(this.transport?.generation ?? -1);
    return isLit && isWanted && evaluated && documentOf(evaluated) ? evaluated : undefined;
  }

  private show(uri: string | undefined, places: Place[]): void {
    const ranges = places.map((place) => new Range(...place));
    for (const editor of window.visibleTextEditors) {
      if (editor.document.languageId !== "improv") continue;
      editor.setDecorations(this.light, editor.document.uri.toString() === uri ? ranges : []);
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

  /** Who opens a document again may find another text in it. */
  private lose(document: TextDocument): void {
    for (const [generation, evaluated] of this.known) {
      if (evaluated.uri === document.uri.toString()) this.known.set(generation, unknown(evaluated));
    }
  }

  /** Gets what plays from a beat on, unless somebody types meanwhile. */
  private async askOn(beat: number): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    const more = await this.ask(beat).catch(() => undefined);
    if (more && more.generation === this.transport?.generation && documentOf(more)?.version === more.version) {
      this.known.set(more.generation, { ...more, from: beat });
    }
    setTimeout(() => (this.asking = false), PATIENCE);
    this.paint();
  }
}

/** Before the server has said where the words are now, nothing is lit. */
function unknown(evaluated: Evaluated): Known {
  return { ...evaluated, robots: {}, from: Infinity };
}

function documentOf(evaluated: Evaluated): TextDocument | undefined {
  return workspace.textDocuments.find((each) => each.uri.toString() === evaluated.uri);
}

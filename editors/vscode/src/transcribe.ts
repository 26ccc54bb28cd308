// Recorded or drawn paths, as words at the cursor.

import { commands, window } from "vscode";

const FILTERS = { "Recordings and drawings": ["csv", "tsv", "mcap", "db3", "svg"] };

/** Asks for files, and inserts the program for their paths at the cursor. */
export async function transcribeRecording(): Promise<void> {
  const editor = window.activeTextEditor;
  const files = await window.showOpenDialog({ canSelectMany: true, filters: FILTERS, openLabel: "Transcribe" });
  if (!editor || !files) return;
  const text = await commands.executeCommand<string | null>("improv.transcribe", ...files.map(({ fsPath }) => fsPath));
  if (typeof text === "string") await editor.edit((edit) => edit.replace(editor.selection, text));
}

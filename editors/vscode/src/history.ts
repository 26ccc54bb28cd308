// The programs that played, to choose one and see it.

import { commands, window, workspace } from "vscode";

interface Played {
  id: string;
  played: string;
  name: string;
  line: string;
}

/** Offers the programs that played, the latest first, and opens the chosen one as a new document. */
export async function showHistory(): Promise<void> {
  const programs = (await commands.executeCommand<Played[] | undefined>("improv.history")) ?? [];
  const choices = programs.map(({ id, played, name, line }) => ({ id, label: line, description: `${name}, ${played}` }));
  const placeHolder = programs.length > 0 ? "A program to open as a new document" : "Nothing has played yet";
  const chosen = await window.showQuickPick(choices, { title: "Improv: programs that played", placeHolder });
  if (!chosen) return;
  const content = await commands.executeCommand<string | null>("improv.history", chosen.id);
  if (typeof content !== "string") return;
  await window.showTextDocument(await workspace.openTextDocument({ language: "improv", content }));
}

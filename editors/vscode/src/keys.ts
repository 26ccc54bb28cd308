// Holds the key of a sense, or releases it.

import { commands, window } from "vscode";

export async function holdKey(): Promise<void> {
  const key = await window.showInputBox({ title: "Hold or release the key of a sense", prompt: "A letter or a digit" });
  if (key) {
    await commands.executeCommand("improv.key", key);
  }
}

// Escape pressed twice stops the robots.

import { commands } from "vscode";

const LONGEST = 600; // ms between the two. A chord of two keys would swallow the key after the first Escape.

/** What to run at each Escape. `close` is the command of VS Code that Escape would have run without us. */
export function stopOnSecondEscape(): (close?: string) => Promise<void> {
  let last = 0;
  return async (close) => {
    const isSecond = Date.now() - last < LONGEST;
    last = isSecond ? 0 : Date.now();
    if (isSecond) await commands.executeCommand("improv.stop");
    if (close) await commands.executeCommand(close);
  };
}

// The extension where no server can run, such as on vscode.dev: colors and snippets, and a reason for everything else.

import { commands, ExtensionContext } from "vscode";
import { showInformation } from "./messages";

const WHY = "This window has only colors and snippets for Improv. To check programs and move robots, open them in VS Code on a computer.";

export function activate(context: ExtensionContext): void {
  const { contributes } = context.extension.packageJSON as { contributes: Record<string, { command: string }[]> };
  const all = [...(contributes["commands"] ?? []), ...(contributes["keybindings"] ?? [])].map(({ command }) => command);
  const explain = (): unknown => showInformation(WHY);
  for (const name of new Set(all)) {
    context.subscriptions.push(commands.registerCommand(name, explain));
  }
}

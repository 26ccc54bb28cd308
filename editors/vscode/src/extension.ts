// Starts the language server. All that Improv can do is in there; here is only what the editor needs to be told.

import { commands, ExtensionContext, window, workspace } from "vscode";
import { LanguageClient } from "vscode-languageclient/node";

export async function activate(context: ExtensionContext): Promise<void> {
  const settings = workspace.getConfiguration("improv");
  const command = settings.get<string>("server.path") || "improv-ls";

  const client = new LanguageClient(
    "improv",
    "Improv",
    { command },
    {
      documentSelector: [{ language: "improv" }],
      initializationOptions: settings, // known before the first document is opened; the server asks for changes
      middleware: {
        // The client registers the server's commands. From the palette they come without arguments.
        executeCommand: (name, given, next) =>
          next(name, name === "improv.play" && given.length === 0 ? activeDocument() : given),
      },
    },
  );
  context.subscriptions.push(client);

  try {
    await client.start();
  } catch {
    const open = "Open settings";
    const message = `Improv needs its language server, and "${command}" does not start: install Improv, or say where it is.`;
    if ((await window.showErrorMessage(message, open)) === open) {
      await commands.executeCommand("workbench.action.openSettings", "improv.server.path");
    }
  }
}

function activeDocument(): string[] {
  const editor = window.activeTextEditor;
  return editor ? [editor.document.uri.toString()] : [];
}

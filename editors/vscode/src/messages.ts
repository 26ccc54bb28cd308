// Every message of the extension that VS Code shows as a notification or a dialog.

import { window } from "vscode";

/**
 * The text with every link taken apart. In a notification, VS Code turns `[label](command:…)` into a link that runs the
 * command, even in a workspace that is not trusted, and the text may come from the server, a file, or a setting.
 */
export function withoutLinks(text: string): string {
  return text.replaceAll("](", "] (");
}

export function showInformation<T extends string>(message: string, ...choices: T[]): Thenable<T | undefined> {
  return window.showInformationMessage(withoutLinks(message), ...choices);
}

export function showWarning<T extends string>(message: string, ...choices: T[]): Thenable<T | undefined> {
  return window.showWarningMessage(withoutLinks(message), ...choices);
}

export function showError<T extends string>(message: string, ...choices: T[]): Thenable<T | undefined> {
  return window.showErrorMessage(withoutLinks(message), ...choices);
}

/** Asks in a dialog; false if the person cancels. */
export async function confirm(question: string, detail: string, choice: string): Promise<boolean> {
  const options = { modal: true, detail: withoutLinks(detail) };
  return (await window.showInformationMessage(withoutLinks(question), options, choice)) === choice;
}

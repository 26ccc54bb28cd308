// A first program, for the walkthrough.

import { window, workspace } from "vscode";

const FIRST_DANCE = `# Your first dance: four steps and four quarter turns make a square.
# Press Ctrl+Enter to make the robot move. Change a word and press it again. Alt+. stops the robot.
beat 60

turtle1 $ repeat 4 (forward left)
`;

export async function openFirstDance(): Promise<void> {
  const document = await workspace.openTextDocument({ language: "improv", content: FIRST_DANCE });
  await window.showTextDocument(document);
}

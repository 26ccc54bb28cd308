// The versions in use, for bug reports.

import { env, ExtensionContext, version } from "vscode";
import { showInformation } from "./messages";
import { Server } from "./server";

export async function showVersions(context: ExtensionContext, { info, path }: Server): Promise<void> {
  const { version: extension } = context.extension.packageJSON as { version: string };
  const server = info ? `${info.name} ${info.version} (${path})` : "no language server";
  const versions = `Extension ${extension}, ${server}, VS Code ${version}`;
  if (await showInformation(versions, "Copy")) await env.clipboard.writeText(versions);
}

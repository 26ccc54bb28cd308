// Prints each word of a program and the scope that VS Code's own tokenizer gives it, as JSON.
// node colors.mjs VSCODE GRAMMAR PROGRAM

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [vscode, grammarFile, programFile] = process.argv.slice(2);
const require = createRequire(`${vscode}/package.json`);
const oniguruma = require("vscode-oniguruma");
const { INITIAL, Registry, parseRawGrammar } = require("vscode-textmate");

await oniguruma.loadWASM(readFileSync(require.resolve("vscode-oniguruma").replace("main.js", "onig.wasm")));
const registry = new Registry({
  onigLib: Promise.resolve({
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  }),
  loadGrammar: async () => parseRawGrammar(readFileSync(grammarFile, "utf8"), grammarFile),
});
const grammar = await registry.loadGrammar("source.improv");

const found = [];
let stack = INITIAL;
for (const line of readFileSync(programFile, "utf8").trimEnd().split("\n")) {
  const { tokens, ruleStack } = grammar.tokenizeLine(line, stack);
  stack = ruleStack;
  for (const word of line.matchAll(/\S+/g)) {
    const token = tokens.find(({ startIndex, endIndex }) => startIndex <= word.index && word.index < endIndex);
    found.push([word[0], token.scopes.at(-1)]);
  }
}
console.log(JSON.stringify(found));

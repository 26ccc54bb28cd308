#!/bin/sh
# build.sh FILE.so: compile the grammar for an editor. Needs the tree-sitter CLI, Node.js, and a C compiler.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$(dirname "$1")"
library=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
work=$(mktemp -d) # keeps the generated files out of the repository
trap 'rm -rf "$work"' EXIT
cp -R "$here/grammar.js" "$here/words.json" "$here/src" "$work"
cd "$work"
tree-sitter generate --abi 14 2>generate.log || { cat generate.log >&2; exit 1; } # the newest that Helix 25.01 and Neovim 0.10 read
"${CC:-cc}" -O2 -shared -fPIC -Isrc -o "$library" src/parser.c src/scanner.c

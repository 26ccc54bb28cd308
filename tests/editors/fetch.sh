#!/bin/bash
# fetch.sh [nvim-0.10 | nvim-0.12 | helix | emacs | tree-sitter | code-server]... : get editors newer than
# Debian 12's into .cache/, beside the system's; all of them where none is named. Those of Debian bring their own
# libraries: this needs no root, but apt and patchelf (Debian has a package).
# code-server, VS Code from npm, needs node 20, ripgrep, g++ and make.
set -euo pipefail
cd "$(dirname "$0")/../.."
PATH=$PATH:$PWD/.venv/bin # where a person may have installed patchelf

# shellcheck disable=SC2016 # apt's own variable
# Debian's archive as this machine names it: by origin once apt has lists, else the first that is no security archive.
mirror=$({ apt-get indextargets --format '$(SITE)' 'Origin: Debian'
  apt-get indextargets --format '$(SITE)' --no-release-info; } |
  awk '!/security/ && !found++')

apt=$(mktemp -d) # what apt knows and brings, by suite
trap 'rm -rf "$apt"' EXIT

# unpack SUITE PACKAGE FOLDER PROGRAM
unpack() {
  command -v patchelf >/dev/null || { echo "patchelf is needed: apt-get install patchelf" >&2; exit 1; }
  local suite=$1 package=$2 root=$PWD/.cache/$3 work=$apt/$1 deb file new=
  [ -d "$work" ] || new=yes
  mkdir -p "$root"/usr/{bin,sbin,lib,lib64} "$work"/{lists,archives,debs}/partial "$work"/{sources.list.d,preferences.d}
  : >"$work/status" # as if nothing were installed: every library comes along, libc too
  cat >"$work/sources.list.d/suite.sources" <<-END
	Types: deb
	URIs: $mirror
	Suites: $suite
	Components: main
	Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
	END
  local get=(apt-get -qq -o Dir::Etc="$work" -o Dir::State="$work" -o Dir::State::lists="$work/lists"
    -o Dir::State::status="$work/status" -o Dir::Cache="$work" -o Dir::Cache::archives="$work/debs"
    -o Debug::NoLocking=1 -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none)
  [ -z "$new" ] || "${get[@]}" update
  "${get[@]}" -y --download-only --no-install-recommends install "$package" >/dev/null
  for file in bin sbin lib lib64; do ln -sfn "usr/$file" "$root/$file"; done
  for deb in "$work"/debs/*.deb; do
    dpkg-deb --fsys-tarfile "$deb" | tar -x -C "$root" --keep-directory-symlink --no-same-owner
  done
  # The editor itself runs with the libraries that came along, not with the system's older ones.
  file=$(realpath "$root/usr/bin/$4")
  patchelf --set-interpreter "$root$(patchelf --print-interpreter "$file")" --force-rpath \
    --set-rpath "$root/usr/lib/$(uname -m)-linux-gnu:$root/usr/lib" "$file"
  rm "$work"/debs/*.deb
  "$root/usr/bin/$4" --version | head -n 1
}


# code-server's install scripts would download binaries; what they need is built here, or is the system's.
code_server() {
  mkdir -p .cache/code-server && (
    cd .cache/code-server
    npm_config_nodedir=$(dirname "$(dirname "$(realpath "$(command -v node)")")") # its headers
    export npm_config_nodedir npm_config_jobs=max npm_config_yes=true npm_config_loglevel=error
    npm install --ignore-scripts --omit=dev code-server@4.100.3
    cd node_modules/code-server/lib/vscode
    npm install --ignore-scripts --omit=dev
    npm rebuild native-watchdog @vscode/spdlog node-pty
    mkdir -p node_modules/@vscode/ripgrep/bin
    ln -sf "$(command -v rg)" node_modules/@vscode/ripgrep/bin/rg
    ln -sfn node_modules node_modules.asar
    cd ../../../.. && npm rebuild argon2 --build-from-source
  )
}

# Emacs looks for its files where Debian has them; a script beside it tells where they are here.
emacs() {
  unpack trixie emacs-nox emacs emacs-nox
  cat >.cache/emacs/usr/bin/emacs <<-'END'
	#!/bin/bash
	usr=$(realpath "$0") && usr=${usr%/bin/emacs}
	share=("$usr"/share/emacs/[0-9]*) libexec=("$usr"/libexec/emacs/*/*)
	export EMACSLOADPATH=$share/lisp EMACSDATA=$share/etc EMACSDOC=$share/etc EMACSPATH=$libexec
	exec "$usr/bin/emacs-nox" --dump-file="$(echo "$libexec"/*.pdmp)" "$@"
	END
  chmod +x .cache/emacs/usr/bin/emacs
}

(($#)) || set -- nvim-0.10 nvim-0.12 helix emacs tree-sitter code-server
for editor in "$@"; do
  case $editor in
    nvim-0.10) unpack trixie neovim "$editor" nvim ;;
    nvim-0.12) unpack forky neovim "$editor" nvim ;;
    helix) unpack forky hx "$editor" hx ;;
    tree-sitter) unpack trixie tree-sitter-cli "$editor" tree-sitter ;;
    emacs) emacs ;;
    code-server) code_server ;;
    *) echo "unknown editor $editor: choose nvim-0.10, nvim-0.12, helix, emacs, tree-sitter or code-server" >&2; exit 1 ;;
  esac
done

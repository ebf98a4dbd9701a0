#!/bin/sh
# Installs baudbot for the user who runs this:
#   sh install.sh --from URL-OR-FOLDER [--to FOLDER]
# --from is where the files of a release are: archives, and SHA256SUMS, by which they are checked.
# --to is where bin/ and share/ go (default: ~/.local). Nothing else is changed. Needs tar, gzip, sha256sum, and for URLs curl or wget.
set -eu

fail() {
  echo "install.sh: $*" >&2
  exit 1
}

from=
to=${HOME:?is not set}/.local
while [ $# -gt 0 ]; do
  case $1 in
    --from) from=${2:?names no place} && shift 2 ;;
    --to) to=${2:?names no folder} && shift 2 ;;
    *)
      sed -n '2,6s/^# \{0,1\}//p' "$0"
      exit 2
      ;;
  esac
done
[ -n "$from" ] || fail "--from is missing: the URL or the folder that the files of the release are in"

case $(uname -s) in
  Linux) ;;
  *) fail "this is $(uname -s); the programs of a release are for Linux, also in WSL; elsewhere there is the page that needs no installation" ;;
esac
case $(uname -m) in
  x86_64 | amd64) target=x86_64-unknown-linux-musl ;;
  aarch64 | arm64) target=aarch64-unknown-linux-musl ;;
  *) fail "there is no program for $(uname -m); build it: cargo install --locked --path cli --features full" ;;
esac

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM

fetch() { # NAME
  case $from in
    http://* | https://*)
      if command -v curl >/dev/null; then
        curl --fail --silent --show-error --location --output "$work/$1" "${from%/}/$1" || fail "cannot get ${from%/}/$1"
      elif command -v wget >/dev/null; then
        wget --quiet --output-document="$work/$1" "${from%/}/$1" || fail "cannot get ${from%/}/$1"
      else
        fail "needs curl or wget"
      fi
      ;;
    *) cp "$from/$1" "$work/$1" 2>/dev/null || fail "there is no $from/$1" ;;
  esac
}

fetch SHA256SUMS
archive=$(sed -n "s/^[0-9a-f]*  \(baudbot-.*-$target\.tar\.gz\)\$/\1/p" "$work/SHA256SUMS")
[ -n "$archive" ] || fail "$from has no archive for $target"
fetch "$archive"
grep -F "  $archive" "$work/SHA256SUMS" >"$work/sum"
(cd "$work" && sha256sum --check --status sum 2>/dev/null || sha256sum -c -s sum) ||
  fail "$archive is not what SHA256SUMS says: it is damaged, or somebody has changed it"
tar -C "$work" -xzf "$work/$archive"
tree=$work/${archive%.tar.gz}
mkdir -p "$to/bin" "$to/share/man/man1" "$to/share/bash-completion/completions" "$to/share/zsh/site-functions" \
  "$to/share/fish/vendor_completions.d"
# Into place at once, so that a program that runs is not written into.
cp "$tree/baudbot" "$to/bin/.baudbot.new"
mv "$to/bin/.baudbot.new" "$to/bin/baudbot"
cp "$tree"/man/man1/*.1 "$to/share/man/man1/"
cp "$tree/completions/baudbot.bash" "$to/share/bash-completion/completions/baudbot"
cp "$tree/completions/_baudbot" "$to/share/zsh/site-functions/"
cp "$tree/completions/baudbot.fish" "$to/share/fish/vendor_completions.d/"
echo "$("$to/bin/baudbot" --version) is in $to/bin"
case :$PATH: in
  *:"$to/bin":*) echo "try: baudbot" ;;
  *) echo "try: $to/bin/baudbot   (to call it baudbot, add $to/bin to your PATH)" ;;
esac

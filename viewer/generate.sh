#!/usr/bin/env bash
# Makes src/gen from ../proto, with the buf of ../tools, which is got if it is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
buf=../tools/node_modules/.bin/buf
[ -x "$buf" ] || npm install --prefix ../tools --no-save --no-audit --no-fund --loglevel=error
"$buf" generate ../proto --template buf.gen.yaml

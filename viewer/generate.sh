#!/usr/bin/env bash
# Makes src/gen from ../proto, with the buf of ../xtask/tools, which is got if it is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
buf=../xtask/tools/node_modules/.bin/buf
[ -x "$buf" ] || npm install --prefix ../xtask/tools --no-save --no-audit --no-fund --loglevel=error
"$buf" generate ../proto --template buf.gen.yaml

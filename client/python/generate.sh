#!/usr/bin/env bash
# Makes Python stubs from the contract, proto/baudbot/v1/*.proto, in client/python/generated/.
# Needs grpcio-tools (see requirements.txt). PYTHON names another interpreter than python3.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
proto=$here/../../proto
python=${PYTHON:-python3}

"$python" -c 'import grpc_tools' 2>/dev/null || {
  echo "generate.sh: $python has no grpcio-tools; run: $python -m pip install -r $here/requirements.txt" >&2
  exit 1
}
rm -rf "$here/generated"
mkdir "$here/generated"
"$python" -m grpc_tools.protoc --proto_path="$proto" \
  --python_out="$here/generated" --pyi_out="$here/generated" --grpc_python_out="$here/generated" \
  "$proto"/baudbot/v1/*.proto
echo "stubs are in client/python/generated"

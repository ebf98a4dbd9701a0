#!/usr/bin/env bash
# Makes Python stubs from baudbot's contract in generated/. PYTHON names another interpreter than python3.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
rm -rf generated
mkdir generated
"${PYTHON:-python3}" -m grpc_tools.protoc --descriptor_set_in=baudbot.binpb \
  --python_out=generated --pyi_out=generated --grpc_python_out=generated {protos}
echo "stubs are in generated"

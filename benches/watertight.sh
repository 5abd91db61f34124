#!/usr/bin/env bash
# Shoots many rays (10^9, or as many as the argument says) at closed meshes; any that passes between triangles fails it.
set -euo pipefail
cd "$(dirname "$0")/.."
RAYBOMB_RAYS=${1:-1e9} cargo test --locked --release --test watertight -- --nocapture

#!/usr/bin/env bash
# Installs what the tests need beside Python on Debian and Ubuntu; does nothing when it is there already.
set -euo pipefail

command -v systemd-analyze >/dev/null && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
fi
"${as_root[@]}" apt-get update
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends systemd

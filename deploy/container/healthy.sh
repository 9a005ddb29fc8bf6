#!/bin/bash
# Tells Docker whether this container is healthy: the server is ready. A worker has no port: it ends when it
# cannot work, and the server knows which workers it has heard of (`divemesh workers`).
set -euo pipefail

tr '\0' '\n' </proc/1/cmdline | grep -qx serve || exit 0
exec 3<>"/dev/tcp/127.0.0.1/${DIVEMESH_HEALTH_PORT:-8080}"
printf 'GET /healthz/ready HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' >&3
answer=$(tr -d '\r' <&3)
echo "${answer##*$'\n'}"
[[ $answer == "HTTP/1.1 200 "* ]]

#!/bin/bash
# Installs, builds, and shows the whole way: a dive goes in over the network, a worker reconstructs
# it, the artifacts come back, the metrics are printed.
#   deploy/demo.sh [--keep] [--preset NAME] [DIVE]
# DIVE: a folder or archive of your own; without it a dive along a sunken barge is rendered.
# --keep leaves the server up and prints an address that opens the page signed in.
set -euo pipefail

keep=false preset=standard dive=
while (($#)); do
    case $1 in
        --keep) keep=true ;;
        --preset) preset=${2:?--preset needs a name} && shift ;;
        -h | --help) sed -n '2,/^set /{s/^# \{0,1\}//p}' "$0" && exit 0 ;;
        -*) echo "demo: unknown option $1" >&2 && exit 2 ;;
        *) dive=$(realpath -e "$1") ;;
    esac
    shift
done
cd "$(dirname "$0")/.."

deploy/install.sh
cmake --preset release --log-level=WARNING >/dev/null
cmake --build --preset release --target divemesh

divemesh=$PWD/build/release/divemesh
demo=$PWD/build/demo
if [[ -z $dive ]]; then
    dive=$demo/barge
    if [[ ! -f $dive/complete ]]; then
        echo "demo: rendering a dive along a barge"
        rm -rf "$dive"
        mkdir -p "$demo"
        "$divemesh" simulate --scene barge --length-m 3 --out "$dive"
        touch "$dive/complete"
    fi
fi

data=$demo/data
rm -rf "$data" "$demo/result" "$demo/server.out"
mkdir -p "$data"
export DIVEMESH_TOKEN
DIVEMESH_TOKEN=$("$divemesh" token create --data "$data" --name demo --scope admin 2>/dev/null)

"$divemesh" serve --data "$data" --listen 127.0.0.1:0 --workers 1 >"$demo/server.out" 2>"$demo/server.log" &
server=$!
stop_server() {
    kill "$server" 2>/dev/null && wait "$server" || true
}
trap stop_server EXIT

address=
for ((i = 0; i < 300; i++)); do
    address=$(sed -n 's/^listening on \(http:[^ ]*\).*/\1/p' "$demo/server.out" 2>/dev/null || true)
    [[ -n $address ]] && break
    kill -0 "$server" 2>/dev/null || break
    sleep 0.1
done
if [[ -z $address ]]; then
    cat "$demo/server.log" >&2
    echo "demo: the server did not start" >&2
    exit 1
fi

"$divemesh" upload "$dive" --server "$address" --preset "$preset" --wait --download "$demo/result"

echo
echo "demo: the results are in $demo/result:"
(cd "$demo/result" && ls -sh -I keyframes)
if $keep; then
    trap - EXIT
    disown "$server"
    echo "demo: open $("$divemesh" token sign-in --data "$data" --server "$address" 2>/dev/null)"
    echo "demo: (signs a browser in once, within 15 minutes)"
    echo "demo: the server is up at $address (pid $server; stop it with: kill $server)"
    echo "demo: export DIVEMESH_SERVER=$address DIVEMESH_TOKEN=$DIVEMESH_TOKEN"
fi

#!/bin/bash
# What runs in the containers, without a container: secrets come from files, the program takes the place of the
# script, health is the server's. Ends with 77 where this machine allows no namespace to be PID 1 in.
#   tests/deploy/check_container_scripts.sh SOURCE PROGRAM
set -euo pipefail

scripts=$1/deploy/container program=$2
folder=$(mktemp -d "${TMPDIR:-/tmp}/divemesh-container.XXXXXX")
trap 'rm -rf "$folder"' EXIT
faults=0
fault() {
    echo "check_container_scripts: $1" >&2
    faults=$((faults + 1))
}

for script in "$scripts"/*.sh; do
    [[ -x $script ]] || fault "$script cannot be run"
    "$(head -1 "$script" | cut -c3-)" -n "$script" || fault "$script is no script"
done

# A divemesh that says how it was started.
mkdir "$folder/bin"
# shellcheck disable=SC2016 # these are its variables
printf '#!/bin/bash\necho "$$ $* $PGPASSWORD ${PGPASSWORD_FILE:-no file} ${DIVEMESH_CATALOG:-no catalog}"\n' >"$folder/bin/divemesh"
chmod +x "$folder/bin/divemesh"
printf 'a secret\n' >"$folder/secret"
start() { PATH=$folder/bin:$PATH "$@"; }
# shellcheck disable=SC2016 # for the inner shell
said=$(start env PGPASSWORD_FILE="$folder/secret" bash -c 'echo $$; exec "$0" serve --data x' "$scripts/entrypoint.sh")
[[ $said == "${said%%$'\n'*}"$'\n'"${said%%$'\n'*} serve --data x a secret no file no catalog" ]] || fault "the entrypoint makes of it: $said"
said=$(start env PGPASSWORD_FILE="$folder/missing" "$scripts/entrypoint.sh" serve 2>&1) && fault "the entrypoint goes on without a secret"
[[ $said == *"cannot read $folder/missing"* ]] || fault "a missing secret is reported as: $said"

"$scripts/make_secrets.sh" "$folder/secrets" >/dev/null
before=$(cat "$folder"/secrets/*)
"$scripts/make_secrets.sh" "$folder/secrets" >/dev/null
[[ $(cat "$folder"/secrets/*) == "$before" ]] || fault "make_secrets.sh replaces secrets"
[[ $(stat -c %a "$folder/secrets") == 700 ]] || fault "others can enter the folder of the secrets"
[[ $(sort -u <(cd "$folder/secrets" && for each in *; do cat "$each" && echo; done) | grep -cE '^[0-9a-f]{48}$') == 3 ]] ||
    fault "the secrets are not three random ones"

namespace=(unshare --pid --fork --mount-proc --kill-child)
((EUID == 0)) || namespace+=(--user --map-root-user)
"${namespace[@]}" true 2>/dev/null || {
    echo "check_container_scripts: left out: health, because this machine allows no namespaces"
    exit $((faults == 0 ? 77 : 1))
}
# The words after the script are those of process 1, as `divemesh serve` would have them.
# shellcheck disable=SC2016 # for the inner shell
"${namespace[@]}" bash -c '
    set -eu
    ! "$2/healthy.sh" 2>/dev/null || { echo "without a server it is healthy"; exit 1; }
    start() {
        rm -f "$3/server.out"
        "$1" serve --data "$3/data" --listen 127.0.0.1:0 --workers 0 --no-auth --min-free "$4" >"$3/server.out" 2>"$3/server.log" &
        server=$!
        for ((i = 0; i < 100; i++)); do ! grep -qs "listening on" "$3/server.out" || break; sleep 0.1; done
        export DIVEMESH_HEALTH_PORT=$(sed -n "s/^listening on .*:\([0-9]*\).*/\1/p" "$3/server.out")
    }
    start "$1" "$2" "$3" 1000000G
    ! "$2/healthy.sh" >/dev/null || { echo "a server without space is healthy"; exit 1; }
    kill -TERM $server
    wait $server
    start "$1" "$2" "$3" 1M
    [[ $("$2/healthy.sh") == *\"ready\"* ]] || { echo "a server that is ready is not healthy"; exit 1; }
    kill -STOP $server
    ! timeout 2 "$2/healthy.sh" || { echo "a server that does not answer is healthy"; exit 1; }
    kill -CONT $server
    kill -TERM $server
    wait $server || { echo "the server does not stop on SIGTERM"; exit 1; }' \
    init "$program" "$scripts" "$folder" serve || fault "health of a server"
# shellcheck disable=SC2016
"${namespace[@]}" bash -c '"$1/healthy.sh" && [[ $2 == worker ]]' init "$scripts" worker || fault "health of a worker"
((faults == 0))

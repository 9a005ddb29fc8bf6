#!/bin/bash
# Becomes `divemesh ARGUMENTS...`. Secrets may be in files: for NAME_FILE=/run/secrets/... it sets NAME to what
# the file holds. The children that read recordings get none of these variables.
set -euo pipefail

for name in DIVEMESH_CATALOG DIVEMESH_TOKEN PGPASSWORD AWS_ACCESS_KEY_ID AWS_SECRET_ACCESS_KEY; do
    source=${name}_FILE
    file=${!source:-}
    [[ -n $file ]] || continue
    [[ -r $file ]] || {
        echo "divemesh: cannot read $file: mount the secret there so that uid $(id -u) can read it, or unset $source" >&2
        exit 2
    }
    export "$name=$(<"$file")"
    unset "$source"
done
exec divemesh "$@"

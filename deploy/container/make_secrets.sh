#!/bin/bash
# Makes the secrets of compose.yaml, at random, where none are yet.
#   deploy/container/make_secrets.sh [FOLDER]      (default: deploy/container/secrets)
# Only its owner can enter the folder; in the containers each user can read the files that it is given.
set -euo pipefail

case ${1:-} in
    -h | --help) sed -n '2,/^set /{/^set /!s/^# \{0,1\}//p}' "$0" && exit 0 ;;
    -*) echo "make_secrets: unknown option $1" >&2 && exit 2 ;;
esac
folder=${1:-$(dirname "$(realpath "$0")")/secrets}

install -d -m 0700 "$folder"
for name in postgresql_password s3_access_key s3_secret_key; do
    [[ -s $folder/$name ]] || head -c 24 /dev/urandom | od -An -tx1 | tr -d ' \n' >"$folder/$name"
    chmod 0444 "$folder/$name"
done
echo "make_secrets: they are in $folder; keep a copy in a safe place"

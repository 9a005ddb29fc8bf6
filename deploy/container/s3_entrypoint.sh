#!/bin/sh
# Becomes the Versity gateway, with the keys that are in files.
set -eu

ROOT_ACCESS_KEY_ID=$(cat "$S3_ACCESS_KEY_FILE")
ROOT_SECRET_ACCESS_KEY=$(cat "$S3_SECRET_KEY_FILE")
export ROOT_ACCESS_KEY_ID ROOT_SECRET_ACCESS_KEY
exec /usr/local/bin/versitygw "$@"

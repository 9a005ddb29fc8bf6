#!/bin/bash
# Makes a fresh Debian 12 with nothing but git, clones this repository into it, and runs there what
# the README tells a newcomer to run: deploy/demo.sh and deploy/test.sh.
#   deploy/clean_root.sh [COMMAND...]
# COMMAND: a line for the shell in the clone, instead of these two.
# What is not committed is left out, and so is the shared test data. Needs root or sudo, mmdebstrap
# and about 20 GB in TMPDIR; all of it is removed at the end. Packages come from this machine's own
# Debian sources, by its proxies.
# DIVEMESH_CLEAN_CCACHE: a folder that is the compiler's cache in there.
set -euo pipefail

case ${1:-} in
    -h | --help) sed -n '2,/^set /{/^set /!s/^# \{0,1\}//p}' "$0" && exit 0 ;;
    -*) echo "clean_root: unknown option $1" >&2 && exit 2 ;;
esac
commands=("$@")
((${#commands[@]})) || commands=(deploy/demo.sh deploy/test.sh)

# What a command in there needs to reach the registries as this machine does.
passed_variables=(http_proxy https_proxy no_proxy HTTP_PROXY HTTPS_PROXY NO_PROXY npm_config_registry)

if ((EUID != 0)); then
    command -v sudo >/dev/null || {
        echo "clean_root: run it as root, or install sudo" >&2
        exit 1
    }
    kept=$(IFS=,; echo "${passed_variables[*]},TMPDIR,DIVEMESH_CLEAN_CCACHE")
    exec sudo --preserve-env="$kept" "$(realpath "$0")" "${commands[@]}"
fi
command -v mmdebstrap >/dev/null || {
    echo "clean_root: mmdebstrap is not there; install it (apt-get install mmdebstrap)" >&2
    exit 1
}
# All mounts are made in a namespace of our own, by its first process: whatever happens, they and every
# process in there end with it, and the trap can remove nothing that is bound.
if [[ -z ${CLEAN_ROOT:-} ]]; then
    CLEAN_ROOT=$(mktemp -d "${TMPDIR:-/tmp}/divemesh-clean-root.XXXXXX")
    export CLEAN_ROOT
    inside=
    # shellcheck disable=SC2317 # the trap calls it
    clean_up() {
        [[ -z $inside ]] || kill -KILL "$inside" 2>/dev/null || true # unshare heeds no other signal
        rm -rf --one-file-system "$CLEAN_ROOT"
    }
    trap clean_up EXIT
    trap 'exit 130' INT TERM HUP
    unshare --mount --pid --fork --kill-child --mount-proc "$(realpath "$0")" "${commands[@]}" &
    inside=$!
    wait "$inside"
    exit
fi

repository=$(realpath "$(dirname "$0")/..")
root=$CLEAN_ROOT/root
clone=/home/divemesh
# shellcheck source=debian_root.sh
source "$repository/deploy/debian_root.sh"

# localhost, the name server, and the certificates that this machine's owner added to Debian's.
own_certificates=/usr/local/share/ca-certificates
has_own_certificates() { compgen -G "$own_certificates/*.crt" >/dev/null; }
copy_network_settings() {
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
    has_own_certificates || return 0
    mkdir -p "$root$own_certificates"
    cp -L "$own_certificates"/*.crt "$root$own_certificates/"
}

mount_into_root() {
    mount -t proc proc "$root/proc"
    mount --rbind /dev "$root/dev"
    mount --rbind /sys "$root/sys"
    [[ -n ${DIVEMESH_CLEAN_CCACHE:-} ]] || return 0
    mkdir -p "$root/root/.cache/ccache"
    mount --bind "$DIVEMESH_CLEAN_CCACHE" "$root/root/.cache/ccache"
}

clone_repository() {
    [[ -z $(git -C "$repository" status --porcelain) ]] ||
        echo "clean_root: what is not committed is left out"
    git clone --quiet --no-hardlinks "$repository" "$root$clone"
}

run_in_root() {
    local environment=(HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8)
    local name
    for name in "${passed_variables[@]}"; do
        [[ -z ${!name:-} ]] || environment+=("$name=${!name}")
    done
    ! has_own_certificates || environment+=(NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt)
    local command
    for command in "${commands[@]}"; do
        echo "clean_root: $command"
        env -i "${environment[@]}" chroot "$root" bash -c "cd $clone && $command"
    done
}

make_debian_root "$CLEAN_ROOT" git
copy_network_settings
mount_into_root
clone_repository
run_in_root
echo "clean_root: all of it passed"

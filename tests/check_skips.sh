#!/bin/bash
# Fails when a test was skipped that tests/allowed_skips.txt does not let be skipped on this machine,
# or when a line of that list names no test.
#   tests/check_skips.sh RESULTS.xml...    (what `ctest --output-junit` wrote of all tests)
set -euo pipefail
(($#)) || {
    echo "usage: tests/check_skips.sh RESULTS.xml..." >&2
    exit 2
}
folder=$(dirname "$(realpath "$0")")
list=$folder/allowed_skips.txt

no_shared_data() { [[ ! -d ${DIVEMESH_SHARED:-$folder/../../shared} ]]; }
no_mount() { ((EUID != 0)) || ! unshare --mount mount -t tmpfs tmpfs /tmp 2>/dev/null; }
no_user_namespace() { ! unshare --user --mount true 2>/dev/null; }
no_colmap() { ! command -v colmap >/dev/null; }
no_chromium() { ! command -v chromium >/dev/null; }
no_gdal() { ! command -v gdalinfo >/dev/null; }
no_postgresql() { ! compgen -G '/usr/lib/postgresql/*/bin/postgres' >/dev/null; }
no_ceph() { ! command -v ceph-osd >/dev/null || ! command -v radosgw >/dev/null; }
no_nginx() { [[ ! -x /usr/sbin/nginx ]]; }
no_caddy() { [[ ! -x /usr/bin/caddy ]]; }
no_avx2() { ! grep -qw avx2 /proc/cpuinfo; }

# "status name" of every test.
tests=$(sed -nE 's|.*<testcase name="([^"]*)" .*status="([a-z]+)".*|\2 \1|p' "$@")
# Disabled or left out by its own word; what could not be started fails ctest.
skipped=$(sed -nE 's/^(notrun|disabled) //p' <<<"$tests" | sort -u)

bad=0
complain() {
    echo "check_skips: $1" >&2
    bad=1
}
allowed=()
while read -r condition test reason; do
    [[ -z $condition || $condition == \#* ]] && continue
    [[ -n $reason ]] || complain "$list: $test has no reason"
    expression="[./]$test(/[^/]*)?\$"
    grep -qE "$expression" <<<"$tests" || complain "$list: no test is called $test"
    case $condition in
        no_shared_data | no_mount | no_user_namespace | no_colmap | no_chromium | no_gdal | no_avx2 | no_postgresql | no_ceph | no_nginx | no_caddy) ;;
        *) complain "$list: there is no condition $condition" && continue ;;
    esac
    ! "$condition" || allowed+=(-e "$expression")
done <"$list"

# With no line in force every skipped test is one too many.
refused=$(grep -vE "${allowed[@]:--e^\$}" <<<"$skipped" || true)
while read -r test; do
    [[ -z $test ]] || complain "$test was skipped, and $list has no line for it that holds here"
done <<<"$refused"
((bad == 0)) || exit 1
echo "check_skips: $(wc -w <<<"$skipped") tests skipped, each for a reason on the list"

#!/bin/bash
# Installs the packages into a fresh Debian 12 that runs systemd, and does there what docs/installing.md says:
# the demo, a dive through the services in their sandboxes, an upgrade, a purge.
#   deploy/test_package.sh [FOLDER]
# FOLDER: has the packages (default: build/release/packages, made by deploy/package.sh).
# Needs root, mmdebstrap, a Debian mirror, and about 3 GB in TMPDIR; all of it is removed at the end. Where
# a Debian cannot be made or run here, it says so and ends with 77.
# DIVEMESH_DEBIAN_TAR: a tar of such a Debian with systemd-sysv, instead of the mirror's.
set -euo pipefail

case ${1:-} in
    -h | --help) sed -n '2,/^set /{/^set /!s/^# \{0,1\}//p}' "$0" && exit 0 ;;
    -*) echo "test_package: unknown option $1" >&2 && exit 2 ;;
esac
leave_out() {
    echo "test_package: left out: $1" >&2
    exit 77
}
fail() {
    echo "test_package: FAILED: $1" >&2
    exit 1
}
say() { echo "test_package: $1"; }

repository=$(realpath "$(dirname "$0")/..")
packages=$(realpath "${1:-$repository/build/release/packages}")
# shellcheck source=debian_root.sh
source "$repository/deploy/debian_root.sh"
compgen -G "$packages/divemesh_*.deb" >/dev/null || fail "there are no packages in $packages: run deploy/package.sh"
((EUID == 0)) || leave_out "only root can install packages into another Debian"
command -v mmdebstrap >/dev/null || leave_out "there is no mmdebstrap (apt-get install mmdebstrap)"

folder=$(mktemp -d "${TMPDIR:-/tmp}/divemesh-test-package.XXXXXX")
root=$folder/root
cgroup='' booted='' init=''
clean_up() {
    [[ -z $booted ]] || kill -KILL "$booted" 2>/dev/null || true # unshare heeds no other signal
    [[ -z $booted ]] || wait "$booted" 2>/dev/null || true
    local i
    for ((i = 0; i < 50; i++)); do # until the last process has gone
        [[ -n $cgroup && -d $cgroup ]] || break
        find "$cgroup" -depth -type d -exec rmdir {} \; 2>/dev/null || true
        sleep 0.1
    done
    rm -rf --one-file-system "$folder"
}
trap clean_up EXIT
trap 'exit 130' INT TERM HUP

make_root() {
    if [[ -n ${DIVEMESH_DEBIAN_TAR:-} ]]; then
        mkdir "$root"
        tar -xf "$DIVEMESH_DEBIAN_TAR" -C "$root"
    else
        make_debian_root "$folder" systemd-sysv || leave_out "no Debian 12 could be made here: is there a mirror?"
    fi
    cp -L /etc/resolv.conf "$root/etc/"
    mkdir "$root/root/packages"
    cp "$packages"/divemesh*.deb "$root/root/packages/"
}

# With the machine's network; what is booted has none of it, so that no port is in the way.
download_dependencies() {
    chroot "$root" apt-get update -q >/dev/null || leave_out "the mirror cannot be reached"
    chroot "$root" bash -c 'apt-get install -q -y --download-only /root/packages/*.deb' >"$folder/download.log" 2>&1 ||
        { cat "$folder/download.log" >&2 && fail "apt finds not all that the packages need"; }
}

# Runs in namespaces of its own and becomes their systemd.
# shellcheck disable=SC2016 # for the inner shell
boot_script='set -e
root=$1
mount --make-rprivate /
mount --bind "$root" "$root"
mount -t proc proc "$root/proc"
mount -t sysfs -o ro sysfs "$root/sys"
mount -t cgroup2 cgroup2 "$root/sys/fs/cgroup"
mount -t tmpfs tmpfs "$root/run"
mount -t tmpfs tmpfs "$root/tmp"
mount -t tmpfs -o mode=755 tmpfs "$root/dev"
for device in null zero full random urandom tty; do
    touch "$root/dev/$device"
    mount --bind "/dev/$device" "$root/dev/$device"
done
mkdir "$root/dev/pts" "$root/dev/shm"
mount -t devpts -o newinstance,ptmxmode=0666 devpts "$root/dev/pts"
mount -t tmpfs tmpfs "$root/dev/shm"
ln -s pts/ptmx "$root/dev/ptmx"
ln -s /proc/self/fd "$root/dev/fd"
cd "$root"
mkdir .host
pivot_root . .host
umount -l /.host
rmdir /.host
exec env -i container=divemesh PATH=/usr/sbin:/usr/bin:/sbin:/bin /lib/systemd/systemd'

boot() {
    local cgroups=/sys/fs/cgroup/unified
    [[ -d $cgroups ]] || cgroups=/sys/fs/cgroup
    cgroup=$cgroups/$(basename "$folder")
    mkdir "$cgroup" 2>/dev/null || leave_out "no control group can be made here"
    (
        echo "$BASHPID" >"$cgroup/cgroup.procs"
        exec unshare --mount --pid --cgroup --uts --ipc --net --fork --kill-child bash -c "$boot_script" boot "$root"
    ) >"$folder/boot.log" 2>&1 </dev/null &
    booted=$!
    local i
    for ((i = 0; i < 300; i++)); do
        kill -0 "$booted" 2>/dev/null || { cat "$folder/boot.log" >&2 && leave_out "systemd cannot run in namespaces here"; }
        init=$(pgrep -P "$booted" -x systemd || true)
        if [[ -n $init ]] && in_root systemctl is-system-running 2>/dev/null | grep -qE 'running|degraded'; then
            return
        fi
        sleep 0.2
    done
    fail "systemd does not come up"
}

in_root() {
    nsenter -t "$init" -a --root --wd env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
        DEBIAN_FRONTEND=noninteractive "$@"
}
# As the administrator of the server.
# shellcheck disable=SC2016 # for the inner shell
server_divemesh() {
    in_root bash -c 'DIVEMESH_TOKEN=$(cat /var/lib/divemesh/admin.token) exec divemesh "$@"' divemesh "$@"
}
install_packages() {
    in_root bash -c "apt-get install -q -y $1/*.deb" >"$folder/install.log" 2>&1 ||
        { tail -n 30 "$folder/install.log" >&2 && fail "the packages cannot be installed"; }
}
wait_for() { # wait_for SECONDS WHAT COMMAND...
    local seconds=$1 what=$2 i
    shift 2
    for ((i = 0; i < seconds * 5; i++)); do
        ! "$@" >/dev/null 2>&1 || return 0
        sleep 0.2
    done
    in_root journalctl --no-pager -n 40 >&2
    fail "$what"
}
server_answers() { server_divemesh dives; }

# Says how long a command takes, and how much of it is processor time: other work on this machine adds only
# to the first.
timed() { # timed WHAT COMMAND...
    local what=$1 times
    shift
    { TIMEFORMAT='%0R s, of processors %0U + %0S s' && time "$@" 2>&3; } 3>&2 2>"$folder/times"
    times=$(cat "$folder/times")
    say "$what: $times"
}
demo() {
    in_root bash -c 'cd /root && divemesh demo --no-keep' >"$folder/demo.log" 2>&1 ||
        { cat "$folder/demo.log" >&2 && fail "the demo fails"; }
}
check_demo() {
    local start=$SECONDS
    timed "apt install, without downloads" install_packages /root/packages
    [[ $(in_root divemesh --version) == [0-9]* ]] || fail "the program does not run"
    timed "divemesh demo" demo
    in_root test -s /root/divemesh-demo/result/mesh.glb || fail "the demo leaves no mesh.glb"
    say "$((SECONDS - start)) s from apt install to mesh.glb, load $(cut -d' ' -f1 /proc/loadavg) on $(nproc) cores"
}

check_services() {
    local unit
    for unit in divemesh-server divemesh-worker; do
        in_root systemctl is-enabled --quiet $unit || fail "$unit is not enabled"
        in_root systemd-analyze verify $unit.service || fail "systemd finds faults in $unit.service"
        say "$unit: $(in_root systemd-analyze security --no-pager $unit.service | sed -n 's/^.*Overall exposure level for [^:]*: \(.*\)$/exposure \1/p')"
    done
    wait_for 30 "the server does not answer" server_answers
    wait_for 30 "the worker does not run" in_root systemctl is-active divemesh-worker
}

# A dive through the services, whose worker is stopped in the middle of it.
check_dive() {
    local job
    server_divemesh upload /root/divemesh-demo/barge --preset fast >"$folder/upload.out" 2>"$folder/upload.log" ||
        { cat "$folder/upload.log" >&2 && fail "the server takes no dive"; }
    job=$(sed -n 's/^job //p' "$folder/upload.out")
    wait_for 60 "the job does not start" job_is "$job" running
    local start=$SECONDS
    in_root systemctl stop divemesh-worker
    say "the worker stopped within $((SECONDS - start)) s in the middle of a job"
    job_is "$job" queued || fail "the job of a stopped worker is not queued again"
    in_root systemctl start divemesh-worker
    wait_for 300 "the job does not succeed" job_is "$job" succeeded
    in_root journalctl --no-pager -u divemesh-worker -o cat >"$folder/worker.log"
    ! grep network_kept "$folder/worker.log" || fail "attempts are not cut off from the network"
    server_divemesh download "$job" mesh.glb --out /root/downloaded 2>/dev/null
    in_root test -s /root/downloaded/mesh.glb || fail "there is no mesh to download"
}
job_is() { server_divemesh jobs "$1" --json | grep -q "\"state\": \"$2\""; }

# Makes the packages of a next version of what is installed.
make_next_version() {
    local package next=$root/root/next
    mkdir "$next"
    for package in "$packages"/divemesh*.deb; do
        dpkg-deb -R "$package" "$folder/next"
        sed -i -E 's/^Version: .*/Version: 99.0/; s/divemesh \(= [^)]*\)/divemesh (= 99.0)/' "$folder/next/DEBIAN/control"
        dpkg-deb --root-owner-group -Zgzip -z1 -b "$folder/next" "$next" >/dev/null
        rm -r "$folder/next"
    done
}

check_upgrade() {
    local dives
    dives=$(server_divemesh dives --json)
    in_root sh -c 'echo "# a setting of the user" >>/etc/divemesh/server.toml'
    in_root systemctl disable --quiet divemesh-worker
    make_next_version
    install_packages /root/next
    in_root dpkg-query -W -f='${Version}\n' divemesh-server | grep -qx 99.0 || fail "the next version is not installed"
    wait_for 30 "the server does not answer after the upgrade" server_answers
    [[ $(server_divemesh dives --json) == "$dives" ]] || fail "the upgrade changes the dives"
    in_root grep -q "a setting of the user" /etc/divemesh/server.toml || fail "the upgrade loses the user's settings"
    ! in_root systemctl is-enabled --quiet divemesh-worker || fail "the upgrade enables a service that the user disabled"
    say "upgraded: dives and settings are as before"
}

check_purge() {
    in_root apt-get purge -q -y divemesh-server divemesh-worker divemesh >"$folder/purge.log" 2>&1 ||
        { cat "$folder/purge.log" >&2 && fail "the packages cannot be purged"; }
    grep -q 'stay in /var/lib/divemesh' "$folder/purge.log" || fail "a purge does not say where the dives are"
    in_root test -s /var/lib/divemesh/catalog.db || fail "a purge deletes the dives"
    ! in_root test -e /etc/divemesh || fail "a purge leaves /etc/divemesh"
    ! in_root systemctl is-active --quiet divemesh-server || fail "a purged server runs"
    say "purged: the dives stay"
}

make_root
download_dependencies
boot
check_demo
check_services
check_dive
check_upgrade
check_purge
say "all of it passed"

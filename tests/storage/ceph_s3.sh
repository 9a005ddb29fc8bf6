#!/bin/bash
# Runs an object store for tests on loopback until it is told to end: a Ceph of one monitor, one disk
# and its RADOS Gateway, with their data in FOLDER. Says "ready" when it takes requests.
#   tests/storage/ceph_s3.sh FOLDER GATEWAY_PORT MONITOR_PORT ACCESS_KEY SECRET_KEY [GIBIBYTES]
set -euo pipefail

folder=$1 gateway_port=$2 monitor_port=$3 access_key=$4 secret_key=$5 gibibytes=${6:-4}
mkdir -p "$folder"/{monitor,disk,gateway,run}
cluster=$(cat /proc/sys/kernel/random/uuid)
disk=$(cat /proc/sys/kernel/random/uuid)
export CEPH_CONF=$folder/ceph.conf
cat >"$CEPH_CONF" <<CONFIG
[global]
fsid = $cluster
mon_host = v2:127.0.0.1:$monitor_port
mon_initial_members = a
public_addr = 127.0.0.1
keyring = $folder/keyring
run_dir = $folder/run
admin_socket = $folder/run/\$cluster-\$name.asok
log_file = $folder/\$name.log
mon_data = $folder/monitor
osd_data = $folder/disk
osd_pool_default_size = 1
osd_pool_default_min_size = 1
osd_pool_default_pg_num = 8
osd_pool_default_pgp_num = 8
osd_pool_default_pg_autoscale_mode = off
osd_crush_chooseleaf_type = 0
osd_memory_target = 939524096
mon_allow_pool_size_one = true
mon_max_pg_per_osd = 1000
mon_data_avail_warn = 1
mon_data_avail_crit = 1
bluestore_block_size = $((gibibytes << 30))
[osd]
keyring = $folder/disk/keyring
CONFIG

daemons=()
# Ends with this script, even if that is killed.
daemon() {
    setpriv --pdeathsig KILL "$@" </dev/null >>"$folder/daemons.log" 2>&1 &
    daemons+=($!)
}
end() {
    trap - EXIT
    kill "${daemons[@]}" 2>/dev/null || true
    wait "${daemons[@]}" 2>/dev/null || true
}
trap end EXIT
trap 'exit 0' TERM INT

ceph-authtool --create-keyring "$folder/keyring" --gen-key -n client.admin --cap mon 'allow *' --cap osd 'allow *' --cap mgr 'allow *' >/dev/null
ceph-authtool --create-keyring "$folder/monitor.keyring" --gen-key -n mon. --cap mon 'allow *' >/dev/null
ceph-authtool "$folder/monitor.keyring" --import-keyring "$folder/keyring" >/dev/null
monmaptool --create --clobber --fsid "$cluster" --addv a "v2:127.0.0.1:$monitor_port" "$folder/map" >/dev/null
ceph-mon --mkfs -i a --monmap "$folder/map" --keyring "$folder/monitor.keyring" >>"$folder/daemons.log" 2>&1
daemon ceph-mon -f -i a
key=$(ceph-authtool --gen-print-key)
echo "{\"cephx_secret\": \"$key\"}" | ceph --connect-timeout 30 osd new "$disk" -i - >/dev/null
ceph-authtool --create-keyring "$folder/disk/keyring" --name osd.0 --add-key "$key" >/dev/null
ceph-osd -i 0 --mkfs --osd-uuid "$disk" >>"$folder/daemons.log" 2>&1
daemon ceph-osd -f -i 0
daemon radosgw -f -n client.admin --keyring "$folder/keyring" --rgw_frontends="beast endpoint=127.0.0.1:$gateway_port" --rgw_data="$folder/gateway"
until (: >"/dev/tcp/127.0.0.1/$gateway_port") 2>/dev/null; do
    kill -0 "${daemons[@]}"
    sleep 0.2
done
radosgw-admin user create --uid=divemesh --display-name=divemesh --access-key="$access_key" --secret-key="$secret_key" >>"$folder/daemons.log" 2>&1
echo ready
wait

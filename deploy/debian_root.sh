# Makes a fresh Debian 12 in a folder. Sourced by the scripts that need one; they run as root.
# shellcheck shell=bash

# "deb URI SUITE main" of this machine's sources of Debian 12; other people's packages (a newer Node)
# are what such a root is to be without.
debian_sources() {
    # shellcheck disable=SC2016 # these are apt's variables
    apt-get indextargets --format '$(ORIGIN) $(RELEASE) $(COMPONENT) $(REPO_URI)' 'Created-By: Packages' |
        sed -nE 's/^(Debian)? (bookworm(-updates|-security)?) main (.*)$/deb \4 \2 main/p' | sort -u
}

apt_settings() {
    apt-config dump | grep -E '^Acquire::(https?(::[^:]+)*::(Proxy|Verify-Peer|Verify-Host|CaInfo)|Check-(Date|Valid-Until)) ' || true
}

# make_debian_root FOLDER PACKAGE...: into FOLDER/root, from this machine's sources, by its proxies.
make_debian_root() {
    local folder=$1 sources packages
    shift
    packages=$(IFS=,; echo "$*")
    sources=$(debian_sources)
    apt_settings >"$folder/apt.conf"
    echo "Debian 12 and $packages from ${sources:-deb.debian.org}"
    printf '%s\n' "$sources" >"$folder/sources.list"
    mmdebstrap --quiet --variant=minbase --include="$packages" --aptopt="$folder/apt.conf" \
        bookworm "$folder/root" ${sources:+"$folder/sources.list"}
}

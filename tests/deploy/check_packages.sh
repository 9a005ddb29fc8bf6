#!/bin/bash
# Makes the packages of a build folder and compares them with what they should hold.
#   tests/deploy/check_packages.sh BUILD_FOLDER
set -euo pipefail

build=$1
folder=$(mktemp -d "${TMPDIR:-/tmp}/divemesh-packages.XXXXXX")
trap 'rm -rf "$folder"' EXIT
faults=0
fault() {
    echo "check_packages: $1" >&2
    faults=$((faults + 1))
}

said=$(cd "$build" && cpack -B "$folder/packages" 2>&1) || { echo "$said" >&2 && exit 1; }

for package in divemesh divemesh-server divemesh-worker; do
    dpkg-deb -R "$(compgen -G "$folder/packages/${package}_*.deb")" "$folder/$package"
done

field() { sed -n "s/^$2: //p" "$folder/$1/DEBIAN/control"; }
conffiles() { cat "$folder/$1/DEBIAN/conffiles" 2>/dev/null || true; }
files() { (cd "$folder/$1" && find . -type f ! -path './DEBIAN/*' | sort); }

expect_files() { # PACKAGE FILE...: all of it
    local package=$1 difference
    shift
    difference=$(diff <(printf '%s\n' "$@" | sort) <(files "$package")) || fault "$package holds other files:"$'\n'"$difference"
}
expect_some() { # PACKAGE FILE...: among others
    local package=$1 file
    shift
    for file in "$@"; do
        grep -qxF "$file" <<<"$(files "$package")" || fault "$package lacks $file"
    done
}

expect_some divemesh ./usr/bin/divemesh ./usr/share/man/man1/divemesh.1.gz ./usr/share/doc/divemesh/README.md \
    ./usr/share/doc/divemesh/docs/installing.md ./usr/share/doc/divemesh/deploy/proxy/nginx.conf \
    ./usr/share/doc/divemesh/copyright
[[ -z $(conffiles divemesh) ]] || fault "divemesh has conffiles"
# What a worker cannot be without; the versions are those that the program was linked with.
for library in libc6 libopencv-core406 libsqlite3-0 libsoci-sqlite3-4.0 libsoci-postgresql4.0 libpq5 libssl3 libseccomp2; do
    grep -q "\b$library\b" <<<"$(field divemesh Depends)" || fault "divemesh does not depend on $library"
done
! grep -q -- '-dev\b' <<<"$(field divemesh Depends)" || fault "divemesh depends on what only a build needs"

for service in server worker; do
    package=divemesh-$service
    expect_files "$package" "./etc/divemesh/$service.toml" "./usr/lib/systemd/system/$package.service" \
        "./usr/lib/sysusers.d/$package.conf" "./usr/share/doc/$package/"{copyright,changelog.gz}
    [[ $(conffiles "$package") == "/etc/divemesh/$service.toml" ]] || fault "$package: conffiles are $(conffiles "$package")"
    grep -qF "divemesh (= $(field divemesh Version))" <<<"$(field "$package" Depends)" ||
        fault "$package goes with other versions of divemesh"
    for script in postinst prerm postrm; do
        sh -n "$folder/$package/DEBIAN/$script" || fault "$package: $script is no script"
        ! grep -q '@' "$folder/$package/DEBIAN/$script" || fault "$package: $script is not filled in"
        ! grep -qE '^[^"]*\brm\b' "$folder/$package/DEBIAN/$script" || fault "$package: $script removes files"
    done
done

# As installed: the units are right, and the program takes their configuration.
root=$folder/root
mkdir "$root"
for package in divemesh divemesh-server divemesh-worker; do
    cp -a "$folder/$package"/[a-z]* "$root/"
done
odd=$(find "$root"/* ! -perm -444 -o -type d ! -perm 755 -o -perm /022)
[[ -z $odd ]] || fault "other rights than they should have: $odd"
mkdir -p "$root/bin"
cp /bin/sh "$root/bin/"
cp /lib/systemd/system/*.target "$root/usr/lib/systemd/system/"
said=$(systemd-analyze verify --man=no --root="$root" divemesh-server.service divemesh-worker.service 2>&1 || true)
[[ -z $said ]] || fault "systemd on the units: $said"
systemd-sysusers --root="$root" 2>/dev/null || fault "systemd-sysusers fails"
grep -q '^divemesh:x:[0-9]*:[0-9]*:.*:/var/lib/divemesh:' "$root/etc/passwd" || fault "there is no user divemesh"
"$root/usr/bin/divemesh" --config "$root/etc/divemesh/server.toml" serve --data "$folder" --check-config ||
    fault "the server does not take its configuration"

((faults == 0))

# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Clean Debian systems in folders, shared by sdk/dist/build, tests/package/dist.sh and tests/elsewhere/run; sourced, not run.
# A command in a chroot has mounts of its own, which end with it: none is left behind, whatever ends it.
#
# BINNACLE_CHROOTS   the folder for what is kept: minimal systems as tarballs, ccache. build/chroots of the project
# BINNACLE_MIRROR    the mirror; else the one that this Debian uses, else deb.debian.org

chroot_root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
chroot_kept=$(realpath -m -- "${BINNACLE_CHROOTS:-$chroot_root/build/chroots}")

# chroot_missing [SUITE]: prints why there can be no chroot; nothing if there can.
chroot_missing() {
  if [ "$(id -u)" != 0 ]; then
    echo "only root can make a chroot"
  elif ! command -v debootstrap >/dev/null; then
    echo "no debootstrap (Debian package debootstrap)"
  elif ! unshare --mount --pid --fork true 2>/dev/null; then
    echo "no mount namespaces here (unshare --mount)"
  elif [ $# -gt 0 ] && ! wget -q -T 20 --spider "$(chroot_mirror)/dists/$1/Release" 2>/dev/null; then
    echo "no mirror of Debian $1 at $(chroot_mirror)"
  fi
}

chroot_mirror() {
  local found
  found=$(sed -nE 's,^(URIs:|deb( \[[^]]*\])?) +(https?://[^ ]+/debian)/?( .*)?$,\3,p' \
    /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null | head -n 1 || true)
  echo "${BINNACLE_MIRROR:-${found:-http://deb.debian.org/debian}}"
}

# in_chroot FOLDER [--bind OUTSIDE:INSIDE]… COMMAND…: its exit status is the command's.
in_chroot() {
  # shellcheck disable=SC2016  # expanded by the inner shell
  unshare --mount --propagation private --pid --fork --kill-child bash -euc '
    folder=$1 && shift
    mount -t proc proc "$folder/proc"
    # Open MPI 5 looks for the processors there.
    mount --rbind -o ro /sys "$folder/sys" 2>/dev/null || true
    mount -t tmpfs -o mode=1777 tmpfs "$folder/dev/shm"
    mount -t devpts -o newinstance,ptmxmode=0666 devpts "$folder/dev/pts" 2>/dev/null || true
    while [ "$1" = --bind ]; do
      mkdir -p "$folder${2#*:}"
      mount --bind "${2%%:*}" "$folder${2#*:}"
      shift 2
    done
    exec chroot "$folder" env -i HOME=/opt/home PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
      LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive ${http_proxy:+http_proxy="$http_proxy"} "$@"' in_chroot "$@"
}

# chroot_install FOLDER PACKAGE…
chroot_install() {
  local folder=$1
  shift
  in_chroot "$folder" apt-get -q -o Acquire::Retries=3 update &&
    in_chroot "$folder" apt-get -q -o Acquire::Retries=3 -o Dpkg::Options::=--force-unsafe-io install -y --no-install-recommends "$@" &&
    in_chroot "$folder" apt-get clean
}

chroot_make() {
  local folder=$1 suite=$2
  shift 2
  if [ $# -eq 0 ]; then
    debootstrap --variant=minbase "$suite" "$folder" "$(chroot_mirror)" || return 1
    # No package starts a daemon.
    printf '#!/bin/sh\nexit 101\n' >"$folder/usr/sbin/policy-rc.d" && chmod 755 "$folder/usr/sbin/policy-rc.d"
  else
    tar -C "$folder" -xpf "$(chroot_base "$suite")" --numeric-owner && chroot_install "$folder" "$@"
  fi
}

# chroot_base SUITE [PACKAGE…]: prints the tarball of a minimal Debian with these packages; the first time it is made.
chroot_base() {
  local name=$1 folder
  [ $# -eq 1 ] || name=$1-$(printf '%s\n' "${@:2}" | sort | sha256sum | cut -c1-12)
  mkdir -p "$chroot_kept"
  (
    flock 9
    [ ! -e "$chroot_kept/$name.tar" ] || exit 0
    echo "binnacle: making a Debian $1${2:+ with $(($# - 1)) packages} (log: $chroot_kept/$name.log)" >&2
    folder=$(mktemp -d "$chroot_kept/$name.XXXXXX")
    chmod 755 "$folder"
    if chroot_make "$folder" "$@" >"$chroot_kept/$name.log" 2>&1 9>&- &&
      tar -C "$folder" --one-file-system --numeric-owner -cpf "$chroot_kept/$name.tar.part" .; then
      mv "$chroot_kept/$name.tar.part" "$chroot_kept/$name.tar"
    else
      tail -n 20 "$chroot_kept/$name.log" >&2
      echo "binnacle: no Debian $1 could be made (log: $chroot_kept/$name.log)" >&2
    fi
    chroot_remove "$folder" 9>&- &  # it has many files, and nobody waits for that
    [ -e "$chroot_kept/$name.tar" ]
  ) 9>"$chroot_kept/$name.lock" >&2 || return 1
  echo "$chroot_kept/$name.tar"
}

# chroot_new SUITE [PACKAGE…]: prints the folder of a new one, for chroot_remove.
chroot_new() {
  local tarball folder
  tarball=$(chroot_base "$@") || return 1
  folder=$(mktemp -d "$chroot_kept/$1-used.XXXXXX")
  chmod 755 "$folder"
  tar -C "$folder" --numeric-owner -xpf "$tarball" && mkdir -p "$folder/opt/home" || return 1
  echo "$folder"
}

# chroot_remove FOLDER: never beyond it, nor through a mount.
chroot_remove() {
  [ -n "$1" ] && [ "${1#"$chroot_kept"/}" != "$1" ] || return 1
  ! grep -qF " $1/" /proc/mounts || { echo "binnacle: $1 has mounts, and is left as it is" >&2 && return 1; }
  rm -rf --one-file-system -- "$1"
}

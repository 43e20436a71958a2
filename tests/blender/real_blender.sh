#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Whole Blenders for the tests: Debian's packages, each suite in a tree of its own, entered through bubblewrap.
#
#   real_blender.sh setup SUITE         make the tree (1.3 GB) unless it stands; trixie has Blender 4.3, sid 5.2
#   real_blender.sh run   SUITE CMD...  run a command in it, in the same folder, without a display
#   real_blender.sh gui   SUITE CMD...  the same under Xvfb, with OpenGL by software
#
# ZRAKA_BLENDERS  where the trees stand; ~/.cache/zraka when not set
# BLENDER_HOME    the command's home folder, and so Blender's preferences; else the tree's own
# Needs root on a Debian. /tmp, the current folder and BLENDER_HOME are shared with the tree; processes are not.
set -euo pipefail

base=${ZRAKA_BLENDERS:-$HOME/.cache/zraka}

# Debian's Blender depends on no Python package, yet its scripts import these; blender.org's builds bring their own.
packages=blender,python3-numpy,python3-requests,python3-cattr,python3-zstandard,python3-openimageio
packages+=,xvfb,libgl1-mesa-dri,libegl1,xdotool,imagemagick

fail() { echo "real_blender: $*" >&2; exit 1; }

stands() {  # Is the tree complete, of these packages, and does its Blender start?
    [ "$(cat "$tree/.packages" 2>/dev/null)" = "$packages" ] && chroot "$tree" blender -b --version >/dev/null 2>&1
}

host_needs() {
    dpkg-query --show "$@" >/dev/null 2>&1 && return
    apt-get -qq -o DPkg::Lock::Timeout=300 update
    DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o DPkg::Lock::Timeout=300 install --no-install-recommends "$@" >/dev/null
}

setup() {
    [ "$(id -u)" = 0 ] || fail "only root can set up $suite"
    command -v apt-get >/dev/null && command -v dpkg-query >/dev/null || fail "only a Debian can set up $suite"
    mkdir -p "$base"
    exec 9>"$tree.lock"
    flock 9  # Two may ask at once.
    ! stands || return 0
    host_needs bubblewrap mmdebstrap debian-archive-keyring
    local mirror codename
    codename=$(. /etc/os-release; echo "$VERSION_CODENAME")
    mirror=$(apt-get indextargets --format '$(RELEASE) $(REPO_URI)' | sed -n "s/^$codename //p" | sort -u | head -n 1)
    [ -n "$mirror" ] || fail "apt knows no mirror of $codename"
    echo "real_blender: setting up $suite in $tree (some minutes, once)" >&2
    rm -rf "$tree" "$tree.new"
    # A mirror may be older than the week for which its lists call themselves valid.
    mmdebstrap --quiet --mode=root --format=directory --variant=apt --include="$packages" \
        --aptopt='Acquire::Check-Valid-Until "false"' \
        --aptopt='Acquire::Retries "3"' --aptopt='Acquire::Languages "none"' --aptopt='Apt::Install-Recommends "false"' \
        --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-exclude=/usr/share/man/*' \
        --dpkgopt='path-exclude=/usr/share/locale/*' --dpkgopt='force-unsafe-io' \
        "$suite" "$tree.new" "$mirror" >&2 || fail "$suite cannot be installed; sid sometimes cannot for days"
    ln -sfn ../proc/self/mounts "$tree.new/etc/mtab"  # else Blender complains at each start
    mkdir -p "$tree.new/var/cache/shaders"
    echo "$packages" >"$tree.new/.packages"
    mv "$tree.new" "$tree"
    stands || fail "Blender of $suite does not start"
}

enter() {  # enter [more arguments of bwrap] -- CMD...
    [ -e "$tree/.packages" ] || fail "$suite is not set up"
    local home=${BLENDER_HOME:-/root} args=() folder name
    for folder in "$PWD" "${BLENDER_HOME:-}"; do
        [[ -z $folder || $folder = /tmp || $folder = /tmp/* ]] || args+=(--bind "$folder" "$folder")
    done
    for name in DISPLAY WAYLAND_DISPLAY XAUTHORITY PYTHONHOME PYTHONPATH VIRTUAL_ENV LD_LIBRARY_PATH LD_PRELOAD; do
        args+=(--unsetenv "$name")
    done
    exec bwrap --bind "$tree" / --dev-bind /dev /dev --proc /proc --ro-bind /sys /sys --tmpfs /run --bind /tmp /tmp \
        --unshare-pid --unshare-net --die-with-parent "${args[@]}" --chdir "$PWD" \
        --setenv HOME "$home" --setenv PATH /usr/bin:/bin --setenv LC_ALL C.UTF-8 \
        --dir /run/user --setenv XDG_RUNTIME_DIR /run/user \
        --setenv LIBGL_ALWAYS_SOFTWARE 1 --setenv MESA_SHADER_CACHE_DIR /var/cache/shaders "$@"
}

# X names its locks by process ids, which mean nothing between trees: the display has this script's id as its number.
# shellcheck disable=SC2016
in_window='
    socket=/tmp/.X11-unix/X${DISPLAY#:}
    Xvfb "$DISPLAY" -screen 0 1280x800x24 +extension GLX -noreset -nolisten tcp >/run/xvfb.log 2>&1 & x=$!
    for _ in {1..400}; do [ -S "$socket" ] && break; sleep 0.05; done
    [ -S "$socket" ] || { cat /run/xvfb.log >&2; exit 97; }
    status=0; "$@" || status=$?
    kill $x; wait $x; rm -f "$socket" "/tmp/.X${DISPLAY#:}-lock"
    exit $status'

[ $# -ge 2 ] || { sed -n '3,12s/^# \{0,1\}//p' "$0"; exit 2; }
command=$1 suite=$2
shift 2
[[ $suite =~ ^[a-z]+$ ]] || fail "unknown suite $suite"
tree=$base/blender-$suite
case $command in
    setup) setup ;;
    run) enter -- "$@" ;;
    gui) enter --setenv DISPLAY ":$((1000 + $$ % 50000))" -- /bin/bash -c "$in_window" gui "$@" ;;
    *) fail "unknown command $command" ;;
esac

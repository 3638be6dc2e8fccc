#!/usr/bin/env bash
# Installs the packages that cpack makes into a bare Debian 12 and uses them there: program, scene, Python module, CMake example.
#   tools/check_packages.sh [BUILD] [WORK]      default: build/release, and a folder in /tmp that is removed at the end
# A WORK that is given is kept, and its bare system is used again. Needs root and debootstrap (or DEBOOTSTRAP, its path); is skipped
# without. About 1.5 GB and some minutes; BRIM_MIRROR names another mirror of Debian.
set -euo pipefail

build=$(realpath "${1:-build/release}")
debootstrap=${DEBOOTSTRAP:-$(command -v debootstrap || true)}
say() { printf '== %s\n' "$*"; }
skip() { echo "skipped: $*"; exit 0; }
fail() { echo "check_packages: $*" >&2; exit 1; }

[[ -n $debootstrap ]] || skip "debootstrap is not installed"
((EUID == 0)) || skip "a bare system is made by root alone"
[[ -f $build/CPackConfig.cmake ]] || fail "$build is no build folder; build first: ./dev build"

work=${2:-}
if [[ -z $work ]]; then
  work=$(mktemp -d /tmp/brim_packages.XXXXXX)
  trap 'umount "$work/root/proc" 2>/dev/null || true; rm -rf "$work"' EXIT
else
  mkdir -p "$work"
  work=$(realpath "$work")
  trap 'umount "$work/root/proc" 2>/dev/null || true' EXIT
fi
root=$work/root

say "packages of $build"
rm -rf "$build/packages"
(cd "$work" && cpack --config "$build/CPackConfig.cmake" >"$work/cpack.log" 2>&1) || { tail -20 "$work/cpack.log" >&2; fail "cpack failed"; }
deb=$(ls "$build"/packages/*.deb) archive=$(ls "$build"/packages/*.tar.gz)
dpkg-deb -f "$deb" Depends

if [[ ! -x $root/usr/bin/apt-get ]]; then
  say "bare Debian 12"
  "$debootstrap" --variant=minbase bookworm "$root" "${BRIM_MIRROR:-http://deb.debian.org/debian}" >"$work/debootstrap.log" 2>&1 ||
    { tail -20 "$work/debootstrap.log" >&2; fail "debootstrap failed"; }
fi
mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
cp /etc/resolv.conf "$root/etc/resolv.conf"
inside() { env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive chroot "$root" "$@"; }
get() { inside apt-get install -q -y --no-install-recommends "$@" >>"$work/apt.log" 2>&1 || { tail -20 "$work/apt.log" >&2; fail "cannot install $*"; }; }

inside apt-get update -q >"$work/apt.log" 2>&1
cp "$deb" "$root/tmp/brim.deb"
say "the .deb with what it depends on, and nothing else"
get /tmp/brim.deb
inside brim --version
inside brim run /usr/share/brim/scenes/bounce.json --check --quiet --force -o /tmp/bounce
inside brim info /tmp/bounce | head -3
inside brim validate /usr/share/brim/scenes/drape.json
inside test -s /usr/share/man/man1/brim.1 -a -s /usr/share/bash-completion/completions/brim

say "the Python module"
get python3-numpy
inside python3 -c '
import brim
world = brim.World(voxel_size=0.05)
world.add("obstacle", name="floor", shape=brim.plane())
ball = world.add("rigid", shape=brim.sphere(0.2), transform={"position": (0, 0, 0.3)})
world.run(frames=30).all()
assert abs(ball.q[2] - 0.2) < 0.02, ball.q
print("brim", brim.__version__, "from Python: the ball lies at", round(float(ball.q[2]), 3), "m")'

say "a project of its own, by CMake and what the .deb suggests"
mapfile -t suggested < <(dpkg-deb -f "$deb" Suggests | tr ',' '\n' | tr -d ' ')
get g++ cmake make "${suggested[@]}"
inside cmake -S /usr/share/brim/examples/cpp_project -B /tmp/drop >"$work/cmake.log" 2>&1 || { tail -20 "$work/cmake.log" >&2; fail "the example is not configured"; }
inside cmake --build /tmp/drop >>"$work/cmake.log" 2>&1 || { tail -20 "$work/cmake.log" >&2; fail "the example is not built"; }
inside /tmp/drop/drop

say "the .tar.gz, beside the same libraries, with the .deb taken off"
inside apt-get remove -q -y brim >>"$work/apt.log" 2>&1
rm -rf "$root/opt/brim" && mkdir -p "$root/opt/brim"
tar -xzf "$archive" -C "$root/opt/brim" --strip-components=1
program=$(cd "$root" && find opt/brim -path '*/bin/brim' | head -1)
[[ -n $program ]] || fail "no bin/brim in $archive"
inside "/$program" --version
inside "/$program" run "/$(dirname "$(dirname "$program")")/share/brim/scenes/bounce.json" --check --quiet --force -o /tmp/bounce2
module=$(cd "$root" && find opt/brim -path '*/brim/_core*.so' | head -1)
inside env PYTHONPATH="/$(dirname "$(dirname "$module")")" python3 -c 'import brim; print("brim", brim.__version__, "from", brim.__file__)'
say "all of it works on a bare Debian 12"

#!/usr/bin/env bash
# run-in-vm.sh - run a host program against the real Linux V4L2 API, without a camera.
#
# Boots Debian's own kernel under QEMU (software emulation, no KVM needed) with a throw-away
# initramfs, loads the kernel's virtual camera driver `vivid` as /dev/video0, runs PROGRAM
# with its shared libraries copied from this machine, and exits with PROGRAM's exit status.
# Nothing is installed and no root rights are needed (apart from reading the files you name).
#
# Exit status:  PROGRAM's own (128+N if signal N killed it);
#               124  the VM ran past --timeout;
#               125  this script or the VM failed (reason on stderr).
set -euo pipefail

ME=run-in-vm
SELF_DIR=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() {
  cat <<'USAGE'
usage: run-in-vm.sh [options] [--] PROGRAM [ARGS...]

  --timeout SEC      wall-clock limit for the whole VM (default 300)
  --ctrl NAME=VALUE  set a control on /dev/video0 before PROGRAM starts (repeatable; v4l2-ctl names)
  --during SCRIPT    shell text run in the VM in parallel with PROGRAM. Helpers there:
                       vctl NAME=VALUE   v4l2-ctl -d /dev/video0 -c NAME=VALUE
                       unplug | replug   unbind / bind the driver: the node really goes away and comes back
  --in DIR           host directory, read-only at /in in the VM      (9p)
  --out DIR          host directory, writable at /out in the VM      (9p)
  --copy FILE        also copy this host file (and its libraries, if it is a program); repeatable
  --env NAME=VALUE   environment variable for PROGRAM (repeatable)
  --vivid PARAMS     vivid module parameters (default below)
  --module FILE.ko   extra module to load after vivid; 'FILE.ko PARAMS' is allowed (repeatable)
  --modules NAMES    load these modules of the Debian kernel instead of vivid ('none' for no driver)
  --cpus N           virtual CPUs (default 2)        --mem MB   memory (default 512)
  --console          show the kernel console on stderr
  --times            report where the time went on stderr
  --fetch-only       fill the cache (kernel, busybox) and stop

environment:
  VIVID_VM_CACHE        cache directory (default: cache/ beside this script)
  VIVID_VM_KERNEL_PKG   Debian kernel package (default linux-image-amd64; the -cloud- kernels have no vivid)
  VIVID_VM_KERNEL_DEB   use this kernel .deb file instead of apt-get download
  VIVID_VM_ACCEL        tcg (default) or kvm. kvm is opt-in: a /dev/kvm that opens may still not run a stock kernel
USAGE
}

say()  { printf '%s: %s\n' "$ME" "$*" >&2; }
die()  { say "$*"; exit 125; }
now()  { date +%s.%N; }

# ---------------------------------------------------------------- options
TIMEOUT=300 CPUS=2 MEM=512 IN_DIR='' OUT_DIR='' DURING='' CONSOLE=0 TIMES=0 FETCH_ONLY=0
MODULES=vivid
# Two capture nodes with one webcam input each: video0 through the single-planar interface, video1 through the other.
# input_types: two bits an input, 0 = webcam, 1 = TV, 2 = S-Video, 3 = HDMI.  node_types bit 0 = video capture.
VIVID_PARAMS='n_devs=2 node_types=0x1,0x1 num_inputs=1,1 input_types=0x0,0x0 vid_cap_nr=0,1 multiplanar=1,2'
CTRLS=() COPIES=() ENVS=() EXTRA_MODULES=()

need_arg() { [ $# -ge 2 ] || die "option $1 needs a value"; }
while [ $# -gt 0 ]; do
  case $1 in
    --timeout) need_arg "$@"; TIMEOUT=$2; shift 2 ;;
    --ctrl)    need_arg "$@"; CTRLS+=("$2"); shift 2 ;;
    --during)  need_arg "$@"; DURING=$2; shift 2 ;;
    --in)      need_arg "$@"; IN_DIR=$2; shift 2 ;;
    --out)     need_arg "$@"; OUT_DIR=$2; shift 2 ;;
    --copy)    need_arg "$@"; COPIES+=("$2"); shift 2 ;;
    --env)     need_arg "$@"; ENVS+=("$2"); shift 2 ;;
    --vivid)   need_arg "$@"; VIVID_PARAMS=$2; shift 2 ;;
    --module)  need_arg "$@"; EXTRA_MODULES+=("$2"); shift 2 ;;
    --modules) need_arg "$@"; MODULES=$2; shift 2 ;;
    --cpus)    need_arg "$@"; CPUS=$2; shift 2 ;;
    --mem)     need_arg "$@"; MEM=$2; shift 2 ;;
    --console) CONSOLE=1; shift ;;
    --times)   TIMES=1; shift ;;
    --fetch-only) FETCH_ONLY=1; shift ;;
    -h|--help) usage; exit 0 ;;
    --) shift; break ;;
    -*) usage >&2; die "unknown option $1" ;;
    *)  break ;;
  esac
done
[ $# -gt 0 ] || [ $FETCH_ONLY = 1 ] || { usage >&2; die 'no PROGRAM given'; }

# ---------------------------------------------------------------- what must be there
command -v qemu-system-x86_64 >/dev/null ||
  die 'qemu-system-x86_64 not found. Install it:  apt-get install --no-install-recommends qemu-system-x86'
command -v dpkg-deb >/dev/null || die 'dpkg-deb not found: this script needs Debian or a derivative'
[ -z "$IN_DIR" ]  || [ -d "$IN_DIR" ]  || die "--in: no directory $IN_DIR"
[ -z "$OUT_DIR" ] || mkdir -p "$OUT_DIR" || die "--out: cannot make $OUT_DIR"
if [ ${#CTRLS[@]} -gt 0 ] && ! command -v v4l2-ctl >/dev/null; then
  die '--ctrl needs v4l2-ctl. Install it:  apt-get install --no-install-recommends v4l-utils'
fi

# ---------------------------------------------------------------- cache: kernel, modules, busybox
CACHE=${VIVID_VM_CACHE:-$SELF_DIR/cache}
# Every module that can be asked for by name (their dependencies are found in the files themselves).
KEEP_MODULES='vivid uvcvideo vhci_hcd cuse
              virtio_pci virtio_console 9p 9pnet_virtio'

apt_download() {   # PACKAGE -> one .deb in the current directory
  apt-get -q -o APT::Sandbox::User=root download "$1" >apt.log 2>&1 || {
    cat apt.log >&2
    die "apt-get download $1 failed (run 'apt-get update' first?). Packages needed: qemu-system-x86 (installed);
    linux-image-amd64's kernel image and busybox-static (only downloaded); v4l-utils (installed, optional)."
  }
}

ko_field() { tr '\0' '\n' <"$2" | sed -n "s/^$1=//p"; }   # FIELD FILE.ko, from its .modinfo section

KERNEL_DEB=''
if [ -n "${VIVID_VM_KERNEL_DEB:-}" ]; then
  [ -f "$VIVID_VM_KERNEL_DEB" ] || die "VIVID_VM_KERNEL_DEB: no file $VIVID_VM_KERNEL_DEB"
  KERNEL_DEB=$(realpath "$VIVID_VM_KERNEL_DEB")
fi

fill_cache() (   # a subshell: cd, traps and temporary files stay in here
  mkdir -p "$CACHE" && cd "$CACHE" || die "cannot make cache directory $CACHE"
  exec 9>lock; flock 9                       # two runs at once fill it once
  [ ! -e ready ] || exit 0
  rm -rf tmp modules && mkdir tmp && cd tmp
  if [ -n "$KERNEL_DEB" ]; then
    cp "$KERNEL_DEB" kernel.deb || die 'cannot copy the kernel .deb'
  else
    pkg=${VIVID_VM_KERNEL_PKG:-linux-image-amd64}
    # linux-image-amd64 is a meta package: take the image it depends on.
    real=$(apt-cache depends "$pkg" 2>/dev/null | sed -n 's/^ *Depends: \(linux-image-[0-9].*\)$/\1/p' | head -n1)
    say "downloading ${real:-$pkg} (about 70 MB, once)"
    apt_download "${real:-$pkg}"
    mv linux-image-*.deb kernel.deb
  fi
  # (set -e is off in here, because of the || after the call: every step says what it needs)
  dpkg-deb -x kernel.deb k || die 'the kernel package does not unpack'
  cp k/boot/vmlinuz-* ../vmlinuz || die 'no vmlinuz in the kernel package'
  # Flat copy of the wanted modules and, in turn, of everything they depend on.
  mkdir -p ../modules
  todo=$KEEP_MODULES
  while [ -n "${todo// /}" ]; do
    next=''
    for m in $todo; do
      [ ! -e "../modules/$m.ko" ] || continue
      f=$(find k/lib/modules -name "$m.ko*" -o -name "${m//_/-}.ko*" | head -n1)
      if [ -z "$f" ]; then
        [ "$m" != vivid ] || die "this kernel package has no vivid module (the 'cloud' kernels are built without media support)"
        continue                              # built in, or an optional one
      fi
      case $f in
        *.xz)  xz  -dc "$f" >"../modules/$m.ko" ;;
        *.zst) zstd -qdc "$f" >"../modules/$m.ko" ;;
        *)     cp "$f" "../modules/$m.ko" ;;
      esac
      next+=" $(ko_field depends "../modules/$m.ko" | tr ',-' ' _')"
    done
    todo=$next
  done
  basename "$(echo k/lib/modules/*)" >../kernel-release
  apt_download busybox-static
  dpkg-deb -x busybox-static_*.deb b || die 'busybox-static does not unpack'
  cp "$(find b -type f -path '*bin/busybox')" ../busybox || die 'no busybox in busybox-static'
  cd .. && rm -rf tmp && touch ready
)

T_START=$(now)
[ -e "$CACHE/ready" ] || fill_cache || exit 125
[ $FETCH_ONLY = 0 ] || { say "cache ready: $CACHE (kernel $(cat "$CACHE/kernel-release"))"; exit 0; }

# ---------------------------------------------------------------- the initramfs
WORK=$(mktemp -d "${TMPDIR:-/tmp}/$ME.XXXXXX")
QEMU_PID=''
cleanup() {
  [ -z "$QEMU_PID" ] || kill "$QEMU_PID" 2>/dev/null || true
  rm -rf "$WORK"
}
trap cleanup EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

ROOT=$WORK/root
mkdir -p "$ROOT"/{dev,proc,sys,tmp,in,out,etc,root,modules,usr/{bin,sbin,lib,lib64}}
ln -s usr/bin "$ROOT/bin"; ln -s usr/sbin "$ROOT/sbin"; ln -s usr/lib "$ROOT/lib"; ln -s usr/lib64 "$ROOT/lib64"
cp "$CACHE/busybox" "$ROOT/usr/bin/busybox"
echo 'root:x:0:0:root:/root:/bin/sh' >"$ROOT/etc/passwd"
echo 'root:x:0:'                     >"$ROOT/etc/group"

# copy_in FILE: the file at its own path, with its shared libraries (or a script's interpreter).
copy_in() {
  local file=$1 lib interp
  [ -f "$file" ] || die "no file $file"
  [ -e "$ROOT$file" ] && return
  mkdir -p "$ROOT$(dirname "$file")"
  cp -L "$file" "$ROOT$file"
  case $(head -c2 "$file" | tr -d '\0') in
    '#!')
      interp=$(head -n1 "$file" | sed 's/^#! *//; s/ .*//')
      case $interp in */sh|*/env) ;; *) copy_in "$interp" ;; esac   # those two come from busybox
      return ;;
  esac
  [ "$(head -c4 "$file" | tail -c3)" = ELF ] || return 0
  while IFS= read -r lib; do
    case $lib in
      *'not found'*) die "$file: missing library: $lib" ;;
      *'=> /'*) lib=${lib#*=> }; lib=${lib%% (*} ;;
      *' (0x'*) lib=${lib%% (*}; lib=${lib#"${lib%%[![:space:]]*}"} ;;
      *) continue ;;
    esac
    case $lib in /*) ;; *) continue ;; esac      # linux-vdso has no file
    [ -e "$ROOT$lib" ] || { mkdir -p "$ROOT$(dirname "$lib")"; cp -L "$lib" "$ROOT$lib"; }
  done < <(ldd "$file" 2>/dev/null || true)
}

PROGRAM=$(type -P -- "$1") || die "no such program on this machine, or not executable: $1"
PROGRAM=$(realpath -s -- "$PROGRAM")
shift
copy_in "$PROGRAM"
for f in "${COPIES[@]}"; do copy_in "$(realpath -s -- "$f")"; done
if V4L2_CTL=$(command -v v4l2-ctl); then copy_in "$V4L2_CTL"; fi

# Modules in load order: a module's dependencies first.
LOAD=()
add_module() {
  local m=${1//-/_} d
  case " ${LOAD[*]-} " in *" $m "*) return ;; esac
  [ -e "$CACHE/modules/$m.ko" ] || return 0       # built into the kernel
  for d in $(ko_field depends "$CACHE/modules/$m.ko" | tr ',' ' '); do add_module "$d"; done
  LOAD+=("$m")
  cp "$CACHE/modules/$m.ko" "$ROOT/modules/"
}
add_module virtio_pci; add_module virtio_console
if [ -n "$IN_DIR$OUT_DIR" ]; then add_module 9pnet_virtio; add_module 9p; fi
if [ "$MODULES" != none ]; then
  for m in $MODULES; do
    [ -e "$CACHE/modules/$m.ko" ] || die "no module $m in $CACHE/modules"
    add_module "$m"
  done
fi
for m in "${LOAD[@]}"; do
  case $m in
    vivid) echo "insmod /modules/vivid.ko $VIVID_PARAMS" ;;
    *)     echo "insmod /modules/$m.ko" ;;
  esac
done >"$ROOT/modules/load.sh"
for m in "${EXTRA_MODULES[@]}"; do
  f=${m%% *}; [ -f "$f" ] || die "--module: no file $f"
  for d in $(ko_field depends "$f" | tr ',' ' '); do
    n=${#LOAD[@]}; add_module "$d"
    for x in "${LOAD[@]:n}"; do echo "insmod /modules/$x.ko"; done
  done
  cp "$f" "$ROOT/modules/"
  echo "insmod /modules/$(basename "$f") $([ "$f" = "$m" ] || echo "${m#* }")"
done >>"$ROOT/modules/load.sh"

quote() { printf "'%s' " "${1//\'/\'\\\'\'}"; }   # for any POSIX shell
{
  for e in "${ENVS[@]}"; do printf 'export '; quote "$e"; echo; done
  echo 'cd /tmp'
  printf 'exec '; for a in "$PROGRAM" "$@"; do quote "$a"; done; echo
} >"$ROOT/program.sh"
for c in "${CTRLS[@]}"; do printf 'v4l2-ctl -d /dev/video0 -c '; quote "$c"; echo '|| exit 1'; done >"$ROOT/controls.sh"
[ -z "$DURING" ] || printf '%s\n' "$DURING" >"$ROOT/during.sh"

helper() { cat >"$ROOT/usr/bin/$1"; chmod 755 "$ROOT/usr/bin/$1"; }
helper vctl   <<'S'
#!/bin/sh
exec v4l2-ctl -d /dev/video0 -c "$1"
S
helper unplug <<'S'
#!/bin/sh
echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind
S
helper replug <<'S'
#!/bin/sh
echo vivid.0 >/sys/bus/platform/drivers/vivid/bind
S

cat >"$ROOT/init" <<'INIT'
#!/bin/busybox sh
# PID 1 of the VM. Ports to the host: vport0p1 stdout, vport0p2 stderr, vport0p3 status.
/bin/busybox mkdir -p /dev /proc /sys
/bin/busybox mount -t devtmpfs dev /dev
/bin/busybox --install -s /usr/bin
mount -t proc proc /proc
mount -t sysfs sys /sys
mkdir -p /dev/shm /run
mount -t tmpfs shm /dev/shm
ln -sf /proc/self/fd /dev/fd; ln -sf fd/0 /dev/stdin; ln -sf fd/1 /dev/stdout; ln -sf fd/2 /dev/stderr
ip link set lo up 2>/dev/null
export PATH=/usr/bin:/usr/sbin HOME=/root TERM=dumb LC_ALL=C.UTF-8
stop() { sync; reboot -f; }
fail() { echo "VM-SETUP-FAILED: $*"; stop; sleep 60; }
up() { cut -d' ' -f1 /proc/uptime; }
t_init=$(up)

while read -r line; do $line || fail "$line"; done </modules/load.sh
t_modules=$(up)

i=0; while [ ! -e /dev/vport0p3 ] && [ $i -lt 100 ]; do sleep 0.05; i=$((i+1)); done
exec 9>/dev/vport0p3 || fail 'no virtio-serial ports'
for tag in in out; do
  grep -qw "$tag" /sys/bus/virtio/drivers/9pnet_virtio/*/mount_tag 2>/dev/null || continue
  ro=''; [ $tag = in ] && ro=,ro
  mount -t 9p -o trans=virtio,version=9p2000.L,msize=524288$ro $tag /$tag || fail "mount /$tag"
done
sh /controls.sh >/tmp/.controls 2>&1 || fail "controls: $(cat /tmp/.controls)"

# The program writes into pipes, as it would under any CI; cat carries them to the host.
mkfifo /tmp/.out /tmp/.err
cat /tmp/.out >/dev/vport0p1 & cat1=$!
cat /tmp/.err >/dev/vport0p2 & cat2=$!
exec 3>/tmp/.out 4>/tmp/.err
[ -e /during.sh ] && { sh /during.sh >&3 2>&4 </dev/null 9>&- & }
t_start=$(up)
sh /program.sh >&3 2>&4 </dev/null 3>&- 4>&- 9>&-
status=$?
t_end=$(up)
exec 3>&- 4>&-
i=0; while kill -0 $cat1 2>/dev/null || kill -0 $cat2 2>/dev/null; do    # until the output has drained
  i=$((i+1)); [ $i -gt 40 ] && break; sleep 0.05
done
sync
echo "status=$status init=$t_init modules=$t_modules start=$t_start end=$t_end" >&9
stop
INIT
chmod 755 "$ROOT/init"

(cd "$ROOT" && find . | "$CACHE/busybox" cpio -o -H newc 2>/dev/null) >"$WORK/initramfs.cpio"
T_BUILT=$(now)

# ---------------------------------------------------------------- boot
case ${VIVID_VM_ACCEL:-tcg} in
  tcg) ACCEL=(-accel tcg,thread=multi -cpu "${VIVID_VM_CPU:-max}") ;;
  kvm) ACCEL=(-accel kvm -cpu host) ;;
  *)   die "VIVID_VM_ACCEL must be tcg or kvm" ;;
esac
SHARES=()
[ -z "$IN_DIR" ]  || SHARES+=(-virtfs "local,path=$(realpath "$IN_DIR"),mount_tag=in,security_model=none,readonly=on")
[ -z "$OUT_DIR" ] || SHARES+=(-virtfs "local,path=$(realpath "$OUT_DIR"),mount_tag=out,security_model=none")
QUIET=quiet; [ $CONSOLE = 0 ] || QUIET=

mkfifo "$WORK/out" "$WORK/err"
cat "$WORK/out" & CAT1=$!
cat "$WORK/err" >&2 & CAT2=$!
exec 5>"$WORK/out" 6>"$WORK/err"

timeout -k 5 "$TIMEOUT" qemu-system-x86_64 \
  -M q35 "${ACCEL[@]}" -smp "$CPUS" -m "$MEM" \
  -nodefaults -no-user-config -display none -no-reboot \
  -kernel "$CACHE/vmlinuz" -initrd "$WORK/initramfs.cpio" \
  -append "console=ttyS0 $QUIET panic=-1 reboot=t no5lvl no_timer_check mitigations=off tsc=reliable ${VIVID_VM_APPEND:-}" \
  -serial "file:$WORK/console.log" \
  -device virtio-serial-pci \
  -add-fd fd=5,set=5 -chardev file,id=out,path=/dev/fdset/5,append=on -device virtserialport,chardev=out,nr=1 \
  -add-fd fd=6,set=6 -chardev file,id=err,path=/dev/fdset/6,append=on -device virtserialport,chardev=err,nr=2 \
  -chardev "file,id=status,path=$WORK/status" -device virtserialport,chardev=status,nr=3 \
  "${SHARES[@]}" >"$WORK/qemu.log" 2>&1 </dev/null &
QEMU_PID=$!
QRC=0; wait "$QEMU_PID" || QRC=$?
QEMU_PID=''
exec 5>&- 6>&-
wait "$CAT1" "$CAT2" || true
T_END=$(now)

# ---------------------------------------------------------------- the verdict
[ $CONSOLE = 0 ] || sed 's/\r$//; s/^/[console] /' "$WORK/console.log" >&2 || true
[ -z "${VIVID_VM_KEEP_LOG:-}" ] || cp "$WORK/console.log" "$VIVID_VM_KEEP_LOG"
# A kernel bug that PROGRAM provoked must not go unseen.
grep -aE 'BUG:|WARNING:|Oops|Call Trace|Kernel panic|Out of memory' "$WORK/console.log" | sed "s/^/$ME: kernel: /" >&2 || true

if [ -s "$WORK/status" ]; then
  STATUS=$(sed -n 's/.*status=\([0-9]*\) .*/\1/p' "$WORK/status")
  if [ $TIMES = 1 ]; then
    awk -v a="$T_START" -v b="$T_BUILT" -v e="$T_END" -v sz="$(stat -c %s "$WORK/initramfs.cpio")" \
        '{ for (i = 1; i <= NF; i++) { split($i, kv, "="); v[kv[1]] = kv[2] } }
         END { printf "run-in-vm: initramfs %.1f MB built in %.2f s; in the VM: init at %.2f s, modules %.2f s, setup %.2f s, program %.2f s; whole run %.2f s\n",
               sz/1e6, b-a, v["init"], v["modules"]-v["init"], v["start"]-v["modules"], v["end"]-v["start"], e-a }' "$WORK/status" >&2
  fi
  exit "$STATUS"
fi
if [ $QRC = 124 ] || [ $QRC = 137 ]; then
  say "the VM was stopped after $TIMEOUT s (--timeout)"
  tail -n 5 "$WORK/console.log" 2>/dev/null | sed "s/^/$ME: console: /" >&2 || true
  exit 124
fi
sed "s/^/$ME: qemu: /" "$WORK/qemu.log" >&2 || true
tail -n 15 "$WORK/console.log" 2>/dev/null | sed "s/^/$ME: console: /" >&2 || true
die "the VM ended without reporting a status (qemu exit $QRC)"

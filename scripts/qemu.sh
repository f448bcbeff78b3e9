#!/bin/sh
# SPDX-License-Identifier: MIT
#
# qemu.sh TARGET ELF WORD...: runs an image on an emulated board; the words are its command line, by semihosting.
# QEMU_EXTRA holds more options of QEMU; QEMU_SERIAL=stdio: the board's UART is our standard input and output;
# QEMU_SECONDS: how long it may run, 0 for ever. Exit status: the image's own, or 124 after a minute. 77: no QEMU for it.
set -euf
target=$1
elf=$2
shift 2
case $target in
cortex-m4) qemu="qemu-system-arm -M mps2-an386" ;;
cortex-m7) qemu="qemu-system-arm -M mps2-an500" ;;
cortex-m33) qemu="qemu-system-arm -M mps2-an505" ;;
rv32) qemu="qemu-system-riscv32 -M virt -bios none" ;;
*) echo "qemu.sh: no board for the target $target" >&2; exit 2 ;;
esac
command -v "${qemu%% *}" >/dev/null 2>&1 || { echo "qemu.sh: ${qemu%% *} is not installed" >&2; exit 77; }
words="arg=$(basename "$elf" .elf)"
for word in "$@"; do words="$words,arg=$word"; done
# shellcheck disable=SC2086 # commands with their options
[ "${QEMU_SERIAL:-none}" = stdio ] || exec </dev/null
exec timeout -k 2 "${QEMU_SECONDS:-60}" $qemu -display none -monitor none -serial "${QEMU_SERIAL:-none}" ${QEMU_EXTRA:-} \
    -semihosting-config "enable=on,target=native,$words" -kernel "$elf"

#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# loop.sh NAME SCENE TARGET: the scene's servo on a microcontroller, in a closed loop with the simulated device over
# LCM: recorded, compared with the host's servo bit for bit, drawn. Called by `make loop` from the project's root when
# all is built. LINE=pipes (QEMU, semihosted), uart (QEMU's UART), or a serial port with BAUD. SECONDS_=how long;
# LOCKSTEP=1: the device's clock waits for the servo. DEVICE_OPTIONS: more options of haptable-device (--at X,Y,Z ...).
# Results: $BUILD/NAME/loop/.
set -eu

BUILD=${BUILD:-build}
name=$1 scene=$2 target=$3
folder=$BUILD/$name/loop
images=$BUILD/$name/firmware/$target
log=$folder/session.lcmlog
. scripts/session.sh
. scripts/own.sh

# quoted WORD: for a shell.
quoted() { printf "'%s'" "$(printf '%s' "$1" | sed "s/'/'\\\\''/g")"; }

# bridge OPTION...: in the background, until the device has been silent for a second.
bridge() {
    "$BUILD/bin/haptable-bridge" "$BUILD/$name" "$@" --csv "$folder/bridge.csv" --until-silent 1 --json --quiet \
        >"$folder/bridge.json" &
    bridge=$!
    children="$children $bridge"
}

start_bridge() {
    case $LINE in
    pipes)
        rm -f "$folder/to" "$folder/from"
        mkfifo "$folder/to" "$folder/from"
        QEMU_SECONDS=0 sh scripts/qemu.sh "$target" "$images/loop.elf" "$folder/to" "$folder/from" &
        children="$children $!"
        bridge --pipes "$folder/to" "$folder/from"
        ;;
    uart) bridge --run "env QEMU_SERIAL=stdio QEMU_SECONDS=0 sh scripts/qemu.sh $target $(quoted "$images/uart.elf")" ;;
    *) bridge --port "$LINE" --baud "$BAUD" ;;
    esac
}

run_loop() {
    start_logger "$log" "$folder/logger.txt"
    start_bridge
    lockstep=""
    [ "${LOCKSTEP:-0}" = 0 ] || lockstep=--lockstep
    # shellcheck disable=SC2086 # options with their values
    "$BUILD/bin/haptable-device" --path poke,drag,circle --seconds "$SECONDS_" $lockstep ${DEVICE_OPTIONS:-} \
        --csv "$folder/device.csv" --quiet --json -- "$scene" >"$folder/device.json"
    wait "$bridge"
    stop_logger "$log" "$folder/logger.txt"
}

# The positions that the target got, through the host's servo: the same forces. A state that the next one overtook in
# real time was a tick of the target that the record does not have: then there is nothing to compare.
compare() {
    overtaken=$(value lost_answers "$folder/bridge.json")
    if [ "$overtaken" -ne 0 ]; then
        same="not compared: $overtaken states were overtaken in real time (LOCKSTEP=1 compares)"
        return
    fi
    cut -d, -f2-4 "$folder/bridge.csv" >"$folder/path.csv"
    if ! "$BUILD/$name/servo" --quiet --replay "$folder/path.csv" --out "$folder/host.csv" \
        --tables "$(value tables_hash "$folder/bridge.json" | tr -d '"')"; then
        same="not compared with those of the host's servo"
        return
    fi
    # Without the first column: in real time a tick may be missing, and its number with it.
    for record in bridge host; do cut -d, -f2- "$folder/$record.csv" >"$folder/$record.bits"; done
    if cmp -s "$folder/bridge.bits" "$folder/host.bits"; then
        same="those of the host's servo, bit for bit"
    else
        same="not those of the host's servo: compare $folder/bridge.csv and host.csv"
    fi
    rm -f "$folder/bridge.bits" "$folder/host.bits"
}

report() {
    json=$folder/bridge.json
    echo "The scene $name, its servo on $target ($LINE):"
    echo "  ticks              $(value ticks "$json") of the device's $(value ticks "$folder/device.json")"
    echo "  with contact       $(value contact_ticks "$json")"
    echo "  asked again        $(value resent_frames "$json"), overtaken $(value lost_answers "$json"), bytes of garbage $(value skipped_bytes "$json")"
    printf '  on the line, mean  %.0f us, 99.9 %% %.0f us\n' "$(value round_trip_mean_us "$json")" "$(value round_trip_p999_us "$json")"
    printf '  largest force      %.3f N\n' "$(value largest_force_n "$json")"
    echo "  forces             $same"
    echo "  log                $log"
    echo "  pictures           $folder/pictures/"
}

if [ "${4:-}" = --inside ]; then
    run_loop
    exit 0
fi
for program in bridge device view; do
    [ -x "$BUILD/bin/haptable-$program" ] || { echo "loop: $BUILD/bin/haptable-$program is missing: make loop" >&2 && exit 1; }
done
own "$folder" loop
rm -rf "$folder"
own "$folder" loop
sh scripts/loopback.sh sh "$0" "$name" "$scene" "$target" --inside
compare
"$BUILD/bin/haptable-view" "$BUILD/$name" --quiet --log "$log" --every 100 -o "$folder/pictures"
report

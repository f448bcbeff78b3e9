# SPDX-License-Identifier: GPL-2.0-or-later
#
# What scripts that run a session over LCM share: `. scripts/session.sh`. Add "$!" to $children for everything started in the
# background: nothing of it outlives the script, however that ends.

children=""
stop_children() {
    for child in $children; do kill "$child" 2>/dev/null || true; done
    # lcm-logger does not hear a signal that comes before its loop runs. Its sleep outlives us: no pipe of ours is its.
    { sleep 2 && for child in $children; do kill -9 "$child" || true; done; } >/dev/null 2>&1 &
    killer=$!
    for child in $children; do wait "$child" || true; done
    kill "$killer" 2>/dev/null || true
    children=""
}
trap stop_children EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# LCM's own group and port, as the programs choose by themselves.
LCM_DEFAULT_URL=${LCM_DEFAULT_URL:-udpm://239.255.76.67:7667?ttl=0}
export LCM_DEFAULT_URL

# value KEY FILE: a number of a program's --json summary.
value() { sed -n "s/^ *\"$1\": \([^,]*\),*\$/\1/p" "$2"; }

# start_logger LOG COMPLAINTS, stop_logger LOG COMPLAINTS: the session's LCM log.
start_logger() {
    lcm-logger -q -f --lcm-url="$LCM_DEFAULT_URL" "$1" 2>"$2" &
    logger=$!
    children="$children $logger"
}
stop_logger() {
    kill "$logger"
    wait "$logger" || true # ended by our signal
    [ -s "$1" ] || { echo "lcm-logger wrote no log, it says: $(cat "$2")" >&2; exit 1; }
}

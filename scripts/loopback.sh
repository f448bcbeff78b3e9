#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
#
# loopback.sh CMD...: runs a command where LCM's UDP multicast works without a network, and without touching the
# network of this machine. Exit status: the command's; 77 where LCM cannot work at all (tests skip on 77).
set -u

[ $# -gt 0 ] || { echo "loopback.sh: say which command to run: loopback.sh CMD..." >&2; exit 2; }
group=239.255.76.67

# 1. Multicast goes over lo already (an administrator has set the route, or we run inside ourselves): just run.
ip route get "$group" 2>/dev/null | grep -q 'dev lo ' && exec "$@"

# 2. A network namespace of our own: its lo alone is up, and every multicast goes there. Root keeps its rights, for
#    real-time priority (no -r); other users become root inside, where the kernel lets them (user namespaces).
inside='ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$@"'
for unshare in "unshare -n" "unshare -rn"; do
    # shellcheck disable=SC2086 # the command and its option
    $unshare sh -c "${inside%exec*}exit 0" 2>/dev/null && exec $unshare sh -c "$inside" sh "$@"
done

# 3. Some other interface takes multicast: with ttl=0 in the URL no message leaves this machine.
ip route get "$group" >/dev/null 2>&1 && exec "$@"

echo "loopback.sh: LCM cannot work here: no multicast route, and no right to make a network namespace." \
    "As root run: ip link set lo up; ip route add 224.0.0.0/4 dev lo" >&2
exit 77

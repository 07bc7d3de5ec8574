# Run by systemd in a container, see scripts/dev/systemd-proof. Each line says what holds, or FAILED.
set -u
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
db=/var/lib/ballbard/ballbard.db

# check WORDS COMMAND...
check() {
  local words=$1 said
  shift
  if said=$("$@" 2>&1); then echo "ok      $words"; else echo "FAILED  $words: $said"; fi
}
# within SECONDS COMMAND...: until it succeeds
within() {
  local end=$((SECONDS + $1))
  shift
  until "$@" >/dev/null 2>&1; do
    [ "$SECONDS" -lt "$end" ] || { "$@"; echo "not within the time"; systemctl status --no-pager ballbard | head -n 5; return 1; }
    sleep 0.2
  done
}
show() { systemctl show -p "$1" --value ballbard; }
is() { [ "$(show "$1")" = "$2" ] || { echo "$1 is '$(show "$1")', not '$2'"; return 1; }; }
status_says() { show StatusText | grep -q -- "$1"; }
runs() { ballbar list --json --db "$db" | grep -c '"started_us"'; }
has_runs() { [ "$(runs)" -eq "$1" ] || { echo "$(runs) runs"; return 1; }; }
refused() { show StatusText | sed -n 's/.* \([0-9]*\) refused.*/\1/p'; }
refused_is() { [ "$(refused)" = "$1" ]; }
exposure_at_most() {
  local said
  said=$(systemd-analyze security ballbard --no-pager | tail -n 1)
  echo "$said" | grep -oE '[0-9]+\.[0-9]+' | awk -v most="$1" '{ exit !($1 <= most) }' || { echo "$said"; return 1; }
}
reload_refused() {
  cp /etc/ballbard/ballbard.toml /tmp/good.toml
  echo 'no_such_key = 1' >>/etc/ballbard/ballbard.toml
  systemctl reload ballbard
  within 7 status_says "unknown key" && is ActiveState active
  local code=$?
  cp /tmp/good.toml /etc/ballbard/ballbard.toml
  systemctl reload ballbard
  return $code
}
# datagrams HOW TO [BYTES]: five LCM messages on BALLBAR that hold no reading but so many bytes, else 8
datagrams() {
  $1 python3 -c "
import socket, struct
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
for i in range(5): s.sendto(struct.pack('>II', 0x4c433032, i) + b'BALLBAR\0' + b'x' * ${3:-8}, ('$2', 7667))"
}
# wire HERE THERE NAMESPACE NET: a wire to a host that is a network namespace; we are NET.1, it is NET.2
wire() {
  ip netns add "$3"
  ip link add "$1" type veth peer name "$2" netns "$3"
  ip addr add "$4.1/24" dev "$1"
  ip link set "$1" up
  ip -n "$3" addr add "$4.2/24" dev "$2"
  ip -n "$3" link set "$2" up
}
# allows ADDRESSES: the unit's IP filter lets them in, until it is called without any; the counters begin anew
allows() {
  mkdir -p /run/systemd/system/ballbard.service.d
  printf '[Service]\nIPAddressAllow=%s\n' "$1" >/run/systemd/system/ballbard.service.d/cell.conf
  [ -n "$1" ] || rm -r /run/systemd/system/ballbard.service.d
  systemctl daemon-reload
  systemctl restart ballbard
  within 20 status_says "^listening"
}

ip link set lo up
check "installs without a multicast route, and waits for one" dpkg -i /out/old.deb
check "is active and enabled" systemctl is-active --quiet ballbard
check "starts with the system" systemctl is-enabled --quiet ballbard
check "has its user" id ballbard
check "the route for one host" systemctl enable --now --quiet ballbard-loopback
check "listens as soon as there is a network" within 20 status_says "^listening"

# A robot, rules of one's own, and figures for a collector.
sed -n '/^\[\[robot\]\]/,$p' /usr/share/ballbard/robots/lrmate200ic.toml |
  sed 's|^urdf = .*|urdf = "/usr/share/ballbard/robots/lrmate200ic.urdf"|' >>/etc/ballbard/ballbard.toml
sed -i 's|^\[rules\]|[metrics]\npath = "/var/lib/ballbard/ballbard.prom"\n\n[rules]|' /etc/ballbard/ballbard.toml
shipped=$(ls /usr/share/ballbard/rules/*.lua | grep -vc '_test[.]lua$')
touch /etc/ballbard/rules.d/straightness_high.lua
check "configuration is good" ballbar config check
check "rules are good" ballbar rules check
check "reloads" systemctl reload ballbard
check "an empty file of one's own switches a shipped rule off" within 7 status_says " $((shipped - 1)) rules"
check "a wrong configuration is said, the running one stays" reload_refused
check "a recording arrives by multicast" lcm-logplayer -s 30 /out/demo.lcm
check "its 16 runs are stored" within 20 has_runs 16
check "as who is in the group, and may only read" su -s /bin/bash -c "ballbar list --db $db" -g ballbard nobody
check "metrics are written" within 20 grep -q '^ballbard_runs_stored_total 16' /var/lib/ballbard/ballbard.prom
check "a backup while it runs" ballbar db backup /tmp/backup.db
check "the database is sound" ballbar db check

restarts=$(show NRestarts)
kill -SEGV "$(show MainPID)"
check "is started again after SIGSEGV" within 10 is NRestarts $((restarts + 1))
check "and listens" within 20 status_says "^listening"
check "nothing is lost" has_runs 16

mkdir -p /run/systemd/system/ballbard.service.d
printf '[Service]\nWatchdogSec=3\nTimeoutAbortSec=3\n' >/run/systemd/system/ballbard.service.d/quick.conf
systemctl daemon-reload
systemctl restart ballbard
restarts=$(show NRestarts)
kill -STOP "$(show MainPID)"
check "the watchdog ends a service that hangs, and it is started again" within 20 is NRestarts $((restarts + 1))
check "it was the watchdog" sh -c "journalctl -u ballbard --no-pager | grep -q 'Watchdog timeout'"
rm -r /run/systemd/system/ballbard.service.d
systemctl daemon-reload
systemctl restart ballbard
check "listens" within 20 status_says "^listening"

# A second host on a wire of its own.
wire near wire far 10.9.9
check "no message was refused yet" within 7 refused_is 0
check "sends from this host" datagrams "" 127.0.0.1
check "which is heard" within 12 refused_is 5
check "sends from afar" datagrams "ip netns exec far" 10.9.9.1
sleep 6
check "which the IP filter keeps out" refused_is 5
allows 10.9.9.0/24
datagrams "ip netns exec far" 10.9.9.1
check "unless its subnet is allowed" within 12 refused_is 5

# The firewall of docs/RELIABILITY.md; the unit lets everybody in, so that the firewall alone decides.
sed -n '/^    table inet ballbard {/,/^    }/p' /out/RELIABILITY.md >/tmp/ballbard.nft
wire cell0 wire0 cell 192.168.77
allows any
check "the firewall of RELIABILITY.md is taken" nft -f /tmp/ballbard.nft
check "and is one" sh -c "nft list table inet ballbard | grep -q 'hook input'"
datagrams "ip netns exec far" 10.9.9.1
datagrams "ip netns exec cell" 192.168.77.1 4
datagrams "ip netns exec cell" 192.168.77.1
check "it lets the cell's instruments through" within 12 refused_is 5
datagrams "" 127.0.0.1
check "and this host" within 12 refused_is 10
sleep 6
check "but neither strangers nor what is too short" refused_is 10
nft delete table inet ballbard
datagrams "ip netns exec far" 10.9.9.1
datagrams "ip netns exec cell" 192.168.77.1 4
check "which come in without it" within 12 refused_is 20
allows ""
check "exposure is at most 1.3" exposure_at_most 1.3
check "its memory has a limit" is MemoryMax 536870912

check "stops" systemctl stop ballbard
check "cleanly" is Result success
check "can be read while it is stopped" su -s /bin/bash -c "ballbar list --db $db" -g ballbard nobody

# The database of the first version, as its ballbard wrote it.
rm "$db" "$db"-wal "$db"-shm
sqlite3 "$db" </out/version1.sql
chown ballbard: "$db"
chmod 640 "$db"
check "a database of version 1 is there" [ "$(sqlite3 -readonly "$db" 'PRAGMA user_version')" = 1 ]
check "upgrades" dpkg -i /out/new.deb
systemctl start ballbard
check "runs" within 20 status_says "^listening"
check "keeps the configuration that people wrote" grep -q lrmate-1 /etc/ballbard/ballbard.toml
check "brings the database up to date" sh -c "[ $(sqlite3 -readonly "$db" 'PRAGMA user_version') -ge 4 ]"
check "with its runs" has_runs 3
check "and it is sound" ballbar db check

check "a purge" dpkg -P ballbard
check "keeps the data" [ -s "$db" ]
check "and the rules that people wrote" [ -e /etc/ballbard/rules.d/straightness_high.lua ]
check "but no configuration" [ ! -e /etc/ballbard/ballbard.toml ]
check "is installed again, with the data" dpkg -i /out/new.deb
check "which are there" has_runs 3
check "a purge of everything" env BALLBARD_PURGE_DATA=yes dpkg -P ballbard
check "deletes the data" [ ! -e /var/lib/ballbard ]
echo "all done in $SECONDS s"

#!/usr/bin/env bash
# `lightbox submit` on a real Slurm: one controller and three nodes, all on this machine and on
# loopback, in a folder that goes away.
#
#     tests/slurm/run.sh            kills a node in mid-run, and compares the picture
#     tests/slurm/run.sh scaling    prints the tables of docs/slurm.md
#
# Needs Debian's slurm-wlm and munge, installed but not started, and the release build of lightbox.
set -euo pipefail
cd "$(dirname "$0")/../.."

say() { printf '%s\n' "$*" >&2; }
die() { say "error: $*"; exit 1; }

lightbox=$(realpath "${CARGO_TARGET_DIR:-target}/release/lightbox")
[ -x "$lightbox" ] || die "$lightbox is not there; run: cargo build --release"
for program in munged slurmctld slurmd sbatch; do
    command -v "$program" > /dev/null || die "$program is not there; run: apt-get install slurm-wlm munge"
done

home=$(mktemp -d)
chmod 755 "$home" # munged asks for it.
export SLURM_CONF=$home/slurm.conf

# Every process that runs under our configuration: daemons, steps and jobs, and no others.
ours() { { grep -lszxF "SLURM_CONF=$SLURM_CONF" /proc/[0-9]*/environ || true; } | cut -d/ -f3; }

tear_down() {
    local status=$? pid
    trap - EXIT
    if [ "$status" != 0 ]; then
        say "--- what the logs say"
        tail -n 15 "$home"/*.log "$home"/shared/*.slices/logs/*.log >&2 || true
    fi
    for pid in $(ours); do kill -KILL "$pid" 2> /dev/null || true; done
    rm -rf "$home" || { sleep 1; rm -rf "$home"; } # Once more: the killed may be at their last file.
    exit "$status"
}
trap tear_down EXIT
trap 'exit 130' INT TERM

# --- The cluster. Each node says that it has one processor, whatever the machine has.
port=$((20000 + $$ % 20000))
mkdir "$home/munge" "$home/state" "$home/shared"
cat > "$SLURM_CONF" << END
ClusterName=lightbox
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=$port
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
# A slice goes on elsewhere when the credential of its first start has run out.
AuthInfo=socket=$home/munge/socket,cred_expire=5
StateSaveLocation=$home/state
SlurmdSpoolDir=$home/spool-%n
SlurmctldPidFile=$home/slurmctld.pid
SlurmdPidFile=$home/%n.pid
SlurmctldLogFile=$home/slurmctld.log
SlurmdLogFile=$home/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
TaskProlog=$home/prolog
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=2,bf_interval=2
SlurmdTimeout=6
ReturnToService=2
NodeName=n1 NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1
NodeName=n2 NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1
NodeName=n3 NodeAddr=127.0.0.1 Port=$((port + 3)) CPUs=1
PartitionName=all Nodes=n[1-3] Default=YES State=UP
END
# Mixed nodes: what a node's prolog exports, its jobs have; n3 takes the best of the machine.
cat > "$home/prolog" << 'END'
#!/bin/sh
case $SLURMD_NODENAME in
    n1) kernel=portable ;;
    n2) kernel=avx2 ;;
    *) exit ;;
esac
echo "export LIGHTBOX_KERNEL=$kernel"
echo "print kernel $kernel"
END
chmod +x "$home/prolog"
(umask 077 && head -c 128 /dev/urandom > "$home/munge.key")
munged --key-file="$home/munge.key" --socket="$home/munge/socket" --pid-file="$home/munge/pid" \
    --log-file="$home/munged.log" --seed-file="$home/munge/seed"
slurmctld -i
for node in n1 n2 n3; do slurmd -N "$node"; done

# until_true SECONDS COMMAND...: waits until it holds.
until_true() {
    local end=$((SECONDS + $1))
    shift
    until "$@" 2> /dev/null; do
        [ "$SECONDS" -lt "$end" ] || die "waited in vain for: $*"
        sleep 0.2
    done
}
idle() { [ "$(sinfo -h -N -t idle -o %N | sort -u | wc -l)" = 3 ]; }
gone() { [ -z "$(squeue -h -j "$1")" ]; }
until_true 60 idle

# submit OUT ARGUMENTS...: sets $array and $merge to the jobs.
submit() {
    local report
    report=$("$lightbox" submit "${@:2}" -o "$1")
    say "$report"
    array=$(sed -n 's/^render *job \([0-9]*\):.*/\1/p' <<< "$report")
    merge=$(sed -n 's/^merge *job \([0-9]*\):.*/\1/p' <<< "$report")
}

# --- The test.
killed_node() {
    local out="$home/shared/a picture.exr" node=n3 slice part job pid
    local -a scene=(glass-sphere --size 256x256 --spp 192)
    "$lightbox" render "${scene[@]}" -o "$home/local.exr"
    submit "$out" "${scene[@]}" --slices 6 --every 0.5

    running() { slice=$(squeue -h -j "$array" -w "$node" -t R -o %K) && [ -n "$slice" ]; }
    until_true 60 running
    part=${out%.exr}.slices/parts/$slice.part
    # Something to go on from: the part's head tells which samples every pixel has.
    held() { [[ $(grep -am1 '^samples = ' "$part") =~ \[\[([0-9]+),\ ([0-9]+)\] ]] && ((BASH_REMATCH[2] - BASH_REMATCH[1] >= 4)); }
    until_true 60 held
    # The node is lost with all that runs on it: its daemon, the step, the render.
    job=$({ grep -lszxF "SLURMD_NODENAME=$node" $(ours | sed 's|.*|/proc/&/environ|') || true; } | cut -d/ -f3)
    [ -n "$job" ] || die "nothing runs on $node"
    pid="$(cat "$home/$node.pid") $(ps -o ppid= -p "${job//$'\n'/,}" | sort -u) $job"
    kill -KILL $pid
    say "killed: $node, in the middle of slice $slice"

    until_true 600 gone "$array"
    until_true 60 gone "$merge"
    local log=${out%.exr}.slices/logs
    tail -n 4 "$log"/*.log >&2
    grep -q "^slice $slice on $node\$" "$log/$slice.log" || die "slice $slice was not on $node"
    grep -q "^slice $slice on n[12]\$" "$log/$slice.log" || die "slice $slice was not requeued"
    grep -q "of them before" "$log/$slice.log" || die "slice $slice did not go on from where it was"
    for kernel in portable avx2; do
        grep -q "^kernel $kernel\$" "$log"/*.log || die "no slice was rendered by $kernel"
    done
    cmp "$out" "$home/local.exr" || die "the picture is not that of one run"

    # Once more, with a part cut short: its slice fails, and the merge ends too instead of waiting for ever.
    rm "$out"
    truncate -s -1 "$part"
    submit "$out" "${scene[@]}" --slices 6 --every 0.5
    until_true 120 gone "$array"
    until_true 120 gone "$merge"
    [ ! -e "$out" ] || die "a part cut short was merged"
    # Without it, the same words render its slice, and nothing else.
    rm "$part"
    submit "$out" "${scene[@]}" --slices 6 --every 0.5
    until_true 600 gone "$array"
    until_true 60 gone "$merge"
    cmp "$out" "$home/local.exr" || die "the picture is not that of one run"
    say "ok: $node killed, slice $slice requeued, three kinds of node, the file of one run"
}

# --- The figures.
now() { echo "${EPOCHREALTIME/,/.}"; }

scaling() {
    local slices out begun ended
    local -a scene=(glass-sphere --size 256x256 --spp 96)
    echo "slices  submission to picture, s  rendering, s: sum  longest"
    for slices in 1 2 3 6; do
        out=$home/shared/$slices.exr
        begun=$(now)
        submit "$out" "${scene[@]}" --slices "$slices" 2> /dev/null
        until_true 900 gone "$array"
        until_true 60 gone "$merge"
        ended=$(now)
        cmp "$out" "$home/shared/1.exr" || die "the picture is not that of one slice"
        sed -n 's/.* spp in \([0-9.]*\) s .*/\1/p' "${out%.exr}".slices/logs/[0-9]*.log | awk \
            -v slices="$slices" -v begun="$begun" -v ended="$ended" \
            '{ sum += $1; if ($1 > most) most = $1 }
            END { printf "%6d  %24.1f  %17.1f  %7.1f\n", slices, ended - begun, sum, most }'
    done
    overhead
}

# median_of COMMAND...: seconds of the median of nine runs, and of its processor time.
median_of() {
    local i
    for i in 1 2 3 4 5 6 7 8 9; do
        TIMEFORMAT='%R %U %S'
        { time "$@" > /dev/null 2>&1; } 2>&1
    done | awk '{ print $1, $2 + $3 }' | sort -n | sed -n 5p
}

overhead() {
    local part=$home/one.part parts n
    local -a slice=(glass-sphere --size 256x256 --part -o "$part" --threads 1)
    echo "step: wall, processor (s; median of nine)"
    echo "start of the program: $(median_of "$lightbox" --version)"
    echo "start, load, 1 sample, part: $(median_of "$lightbox" render "${slice[@]}" --samples 0..1)"
    "$lightbox" render "${slice[@]}" --samples 0..1 --json |
        sed 's/.*"seconds":\([^,]*\),"load_seconds":\([^,]*\),"build_seconds":\([^,]*\),.*/of that: tracing \1, load \2, build \3/'
    echo "bytes of a part: $(stat -c %s "$part")"
    for n in 1 6 24; do
        parts=()
        for ((i = 0; i < n; i++)); do
            parts+=("$home/$i.part")
            "$lightbox" render glass-sphere --size 256x256 --part --samples "$i..$((i + 1))" -o "$home/$i.part" > /dev/null
        done
        echo "merge of $n: $(median_of "$lightbox" merge "${parts[@]}" -o "$home/merged.exr")"
    done
}

case ${1:-} in
    '') killed_node ;;
    scaling) scaling ;;
    *) die "unknown: $1; without a word, the test; with \"scaling\", the figures" ;;
esac

# shell_fixture.sh: for test scripts: a folder of their own, expectations, processes that are gone at the end.
# Sourced. Needs GARLAND_BIN (programs) and GARLAND_TESTS (this folder's parent).
set -u
: "${GARLAND_BIN:?the folder of the programs}" "${GARLAND_TESTS:?the folder of the tests}"
export GARLAND_BIN GARLAND_TESTS
unset GARLAND_MASTER
PATH=$GARLAND_BIN:$PATH
scenes=$GARLAND_TESTS/scenes
[ -w /dev/shm ] && export TMPDIR=/dev/shm
folder=$(mktemp -d) || exit 1
mkdir "$folder/tmp"
export TMPDIR=$folder/tmp
cd "$folder" || exit 1
failures=0
checks=0

leave() {
    local pid
    for pid in $(jobs -p); do
        kill -KILL "$pid" 2>/dev/null
    done
    wait 2>/dev/null
    cd /
    rm -rf "$folder"
}
trap leave EXIT

fail() {
    failures=$((failures + 1))
    printf 'FAILED: %s\n' "$*"
}

# check NAME COMMAND...: the command succeeds.
check() {
    local name=$1
    shift
    checks=$((checks + 1))
    "$@" || fail "$name"
}

# expect STATUS TEXT COMMAND...: exit status, and a text (extended regular expression) in what it prints.
expect() {
    local status=$1 text=$2 got
    shift 2
    checks=$((checks + 1))
    "$@" >out 2>err </dev/null
    got=$?
    [ "$got" = "$status" ] || fail "$*: exit status $got, expected $status: $(cat out err)"
    [ -z "$text" ] || cat out err | grep -Eq -- "$text" || fail "$*: no \"$text\" in: $(cat out err)"
}

# job NAME MUTATIONS_PER_PIXEL [SEED [SCENE [MORE FIELDS]]]: writes NAME.json with outputs NAME.exr, NAME.png and NAME.report.json.
job() {
    cat >"$1.json" <<JOB
{"scene": "${4:-$scenes/diffuse.pbrt}", "film": {"width": 32, "height": 24}, "algorithm": "mmlt", "max_path_length": 5,
 "seed": "${3:-1}", "stop": {"mutations_per_pixel": $2},
 "output": {"image": "$1.exr", "preview": "$1.png", "report": "$1.report.json"}${5:-}}
JOB
}

# same_pixels A B: the same bits in R, G and B.
same_pixels() {
    local a b
    a=$("$GARLAND_BIN/tests/pixel_digest" "$1") && b=$("$GARLAND_BIN/tests/pixel_digest" "$2") && [ "$a" = "$b" ]
}

# await SECONDS COMMAND...: until it succeeds.
await() {
    local end=$(($(date +%s) + $1))
    shift
    until "$@" >/dev/null 2>&1; do
        [ "$(date +%s)" -lt "$end" ] || return 1
        sleep 0.05
    done
}

# start_master [OPTIONS]: $master is its process id, $address where it listens; state in ./state.
start_master() {
    : >master.out
    garland-master --listen "ipc://$folder/socket" --state "$folder/state" --quiet "$@" >master.out 2>>master.err &
    master=$!
    address=ipc://$folder/socket
    await 20 grep -q '^listening on' master.out || fail "the master is not ready: $(cat master.err)"
}

# start_worker: $worker is its process id.
start_worker() {
    garland-worker --master "$address" --threads 1 --cache "$folder/cache" --quiet 2>>worker.err &
    worker=$!
}

# stop PID SIGNAL: and waits for its end.
stop() {
    kill -"$2" "$1" 2>/dev/null
    wait "$1" 2>/dev/null
}

# Processes whose command line names this test's folder, besides this script itself.
left_running() {
    local entry
    for entry in /proc/[0-9]*; do
        if tr '\0' ' ' 2>/dev/null <"$entry/cmdline" | grep -q "garland-[mw].*$folder"; then
            echo "${entry#/proc/}"
        fi
    done
}

finish() {
    if [ "$failures" -gt 0 ]; then
        echo "$failures of $checks checks failed"
        exit 1
    fi
    echo "$checks checks passed"
    exit 0
}

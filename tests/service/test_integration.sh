#!/bin/bash
# Whole renders with separate processes: the image is the same, bit for bit, for one worker or more, with workers that die,
# join late or leave, and with a master that is killed and started again.
. "${GARLAND_TESTS:?}/service/shell_fixture.sh"

# The yardstick: one worker, nothing goes wrong.
job one 5000
expect 0 'mutations per pixel' garland render one.json --workers 1
reference=$folder/one.exr

# ---- workers ----
for workers in 2 3; do
    sed "s|one\\.|w$workers.|g" one.json >"w$workers.json"
    expect 0 '' garland render "w$workers.json" --workers "$workers"
    check "$workers workers give the bits of one" same_pixels "$reference" "w$workers.exr"
done

fetch_and_compare() { # NAME JOB
    expect 0 'one.exr' garland fetch "$2" --master "$address" --wait --out "$1"
    check "$1: the bits of one worker" same_pixels "$reference" "$1/one.exr"
}

submit() { # sets $id
    id=$(garland submit one.json --master "$address" 2>>err)
    [[ $id =~ ^[0-9]+$ ]] || fail "submit printed \"$id\""
}

units_in() {
    garland status "$1" --master "$address" --json | sed -n 's/.*"units_in":[[:space:]]*\([0-9]*\).*/\1/p'
}

has_units() { # JOB AT_LEAST
    local units
    units=$(units_in "$1")
    [ "${units:-0}" -ge "$2" ]
}

is_state() { # JOB STATE
    garland status "$1" --master "$address" --json | grep -q "\"state\":[[:space:]]*\"$2\""
}

# ---- a master of our own: workers killed again and again ----
start_master --lease 1
submit
for ((i = 0; i < 20; i++)); do
    start_worker
    sleep "0.$(printf %03d $((RANDOM % 250)))"
    stop "$worker" KILL
done
start_worker
survivor=$worker
fetch_and_compare killed "$id"

# ---- a worker joins half way, another leaves politely ----
submit
await 20 has_units "$id" 8 || fail 'the first worker does nothing'
start_worker
sleep 0.1
stop "$survivor" TERM
fetch_and_compare joined "$id"
stop "$worker" TERM

# ---- the master is killed in the middle, twice, and once asked to end; the workers stay ----
submit
start_worker
stay=$worker
for signal in KILL TERM KILL; do
    sleep 0.15
    stop "$master" "$signal"
    start_master --lease 1
done
fetch_and_compare restarted "$id"
check 'the worker stayed through it all' kill -0 "$stay"

# ---- two jobs at a time, one of them cancelled; a finished job outlives a restart ----
submit
first=$id
submit
second=$id
expect 0 '' garland cancel "$second" --master "$address"
await 20 is_state "$second" cancelled || fail 'the job is not cancelled'
expect 1 'cancelled' garland fetch "$second" --master "$address" --out second
fetch_and_compare beside "$first"
stop "$master" KILL
start_master --lease 1
fetch_and_compare afterwards "$first"
expect 0 "$second" garland status --master "$address"
expect 1 'another master' garland-master --listen "ipc://$folder/other" --state "$folder/state"
expect 1 'there is no job' garland fetch 12345 --master "$address"
stop "$master" TERM
stop "$stay" TERM

# ---- render: interrupted, with a dying worker, with a folder that vanishes ----
children() { # of a process, by program name; without a look at every process of the machine, which takes its time
    local child
    for child in $(cat "/proc/$1/task/"*/children 2>/dev/null); do
        if grep -q "^$2" "/proc/$child/comm" 2>/dev/null; then
            echo "$child"
        fi
    done
}
has_child() {
    [ -n "$(children "$1" "$2")" ]
}

job long 1e7
for signal in INT TERM; do
    garland render long.json --workers 2 >out 2>err &
    render=$!
    await 20 has_child "$render" garland-worker || fail 'no workers'
    sleep 0.3
    kill -"$signal" "$render"
    wait "$render"
    check "render ends with 1 after SIG$signal" test $? = 1
    check "SIG$signal leaves no processes" test -z "$(left_running)"
    check "SIG$signal leaves no files" test -z "$(ls -A "$TMPDIR")"
done

sed 's|one\.|dying.|g' one.json >dying.json
garland render dying.json --workers 2 >out 2>err &
render=$!
await 20 has_child "$render" garland-worker || fail 'no workers'
sleep 0.1
victim=$(children "$render" garland-worker | head -n 1)
[ -n "$victim" ] && kill -KILL "$victim"
wait "$render"
check 'render survives the death of a worker' test $? = 0
check 'and gives the same bits' same_pixels "$reference" dying.exr

mkdir vanishing
garland render one.json --workers 2 --out vanishing >out 2>err &
render=$!
await 20 has_child "$render" garland-worker || fail 'no workers'
rm -rf vanishing
wait "$render"
check 'a folder that vanished is a failure' test $? = 1
kept=$(sed -n 's/.*kept in \(.*\)$/\1/p' err)
check 'and the image is kept where it says' same_pixels "$reference" "$kept/image.exr"
rm -rf "$TMPDIR"/garland-*

check 'no temporary files' test -z "$(ls -A "$TMPDIR")"
check 'no processes' test -z "$(left_running)"
finish

#!/bin/bash
# The rule `seconds`, with a master and worker processes over TCP: a render ends when it was told to. Never before; after it by
# half a second at most where the workers have a processor each. On a busy machine they do not: units take longer by as much
# as the workers got less, and so much later may the end be. How much they got is in the report: processor seconds over wall
# seconds, of all workers.
. "${GARLAND_TESTS:?}/service/shell_fixture.sh"
workers=2

start_master --listen 'tcp://127.0.0.1:*'
address=$(sed -n 's/^listening on \(tcp:[^ ]*\).*/\1/p' master.out | head -n 1)
check 'the master tells its port' test -n "$address"
for ((i = 0; i < workers; i++)); do
    start_worker
done

number() { # NAME FILE: the first member of that name
    sed -n "s/.*\"$1\":[[:space:]]*\\([0-9.e+-]*\\).*/\\1/p" "$2" | head -n 1
}

in_time() { # ASKED REPORT
    awk -v asked="$1" -v workers="$workers" -v wall="$(number wall_seconds "$2")" \
        -v pilot="$(number pilot_cpu_seconds "$2")" -v render="$(number render_cpu_seconds "$2")" 'BEGIN {
        share = (pilot + render) / (workers * wall)
        room = share >= 0.9 ? 0.5 : 0.5 * 0.9 / share
        printf "asked for %g s, it took %g s; workers had %.0f %% of a processor each: %.2f s late, at most %.2f s\n",
               asked, wall, 100 * share, wall - asked, room
        exit !(wall >= asked && share > 0 && wall - asked <= room)
    }'
}

# Of a large image the time is short for everything: a pilot, features, a first pass over it.
while read -r seconds width height; do
    cat >timed.json <<JOB
{"scene": "$scenes/diffuse.pbrt", "film": {"width": $width, "height": $height}, "algorithm": "auto", "max_path_length": 6,
 "stop": {"seconds": $seconds}, "output": {"image": "timed.exr", "report": "timed.report.json"}}
JOB
    id=$(garland submit timed.json --master "$address" 2>>err)
    mkdir -p "got$seconds"
    expect 0 'timed.exr' garland fetch "$id" --master "$address" --wait --out "got$seconds"
    check "$seconds seconds end the render" grep -q '"stopped_by":[[:space:]]*"seconds"' "got$seconds/timed.report.json"
    check "$seconds seconds are kept" in_time "$seconds" "got$seconds/timed.report.json"
done <<CASES
2.5 96 96
3 1920 1080
CASES
finish

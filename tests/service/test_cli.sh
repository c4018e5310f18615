#!/bin/bash
# The command line as scripts rely on it: exit status and words for wrong usage, bad jobs, bad files; nothing left behind.
. "${GARLAND_TESTS:?}/service/shell_fixture.sh"

# ---- usage ----
for command in render plan pack submit status fetch cancel compare report bench; do
    expect 0 "usage: garland $command" garland "$command" --help
    expect 2 "garland $command --help" garland "$command" --nonsense
done
expect 0 'usage: garland' garland --help
expect 0 '^garland [0-9]' garland --version
expect 0 '^garland-master [0-9]' garland-master --version
expect 0 '^garland-worker [0-9]' garland-worker --version
expect 0 '--listen ADDR' garland-master --help
expect 0 '--master ADDR' garland-worker --help
expect 2 'usage: garland' garland
expect 2 'unknown command "rendr"; did you mean render' garland rendr
expect 2 'did you mean --workers' garland render --worker 3 x.json
expect 2 'expected a number from 1' garland render --workers 0 x.json
expect 2 'expected a number from 1' garland render --workers 3x x.json
expect 2 'value is missing' garland render x.json --workers
expect 2 'argument is missing' garland render
expect 2 'unexpected argument "b"' garland render a b
expect 2 '-o FILE is missing' garland pack scene.pbrt
expect 2 '--master ADDR is missing' garland status
expect 2 "no job's number" garland status 12x --master ipc:///nowhere
expect 2 "no job's number" garland fetch 0 --master ipc:///nowhere
expect 2 'expected tcp://host:port' garland status --master somewhere
expect 2 '--state DIR is missing' garland-master --listen ipc:///nowhere
expect 2 '--listen ADDR is missing' garland-master --state s
expect 2 '--help' garland-master --listen ipc:///nowhere --state s --lease never
expect 1 'no master answers at ipc:///nowhere' garland status --master ipc:///nowhere

# ---- jobs ----
bad_job() { # TEXT EXPECTED
    printf '%s' "$1" >bad.json
    expect 1 "$2" garland render bad.json
}
expect 1 'missing\.json' garland render missing.json
bad_job '{"scene": "a.pbrt"' 'bad\.json.*line'
bad_job '{"scene": "a.pbrt", "sceen": 1}' 'sceen'
bad_job '{"scene": "a.pbrt", "film": {"width": "wide"}}' 'film\.width'
bad_job '{"scene": "a.pbrt", "film": {"width": -1}}' 'film\.width'
bad_job '{"scene": "a.pbrt", "algorithm": "magic"}' 'algorithm'
bad_job '{"scene": 5}' 'scene'
bad_job '{}' 'scene'
bad_job '[]' 'bad\.json'
bad_job '' 'bad\.json'
bad_job '{"scene": "nowhere.pbrt"}' 'nowhere\.pbrt does not exist'
bad_job '{"scene": "a.pbrt", "scene": "b.pbrt"}' 'scene'
job nofolder 1
sed -i 's|"nofolder.exr"|"not/there/o.exr"|' nofolder.json
expect 1 'output\.image: the folder not/there' garland render nofolder.json

# ---- scenes ----
printf 'WorldBegin\nShape "sphere"\nNonsense 1 2 3\n' >broken.pbrt
job broken 1 1 "$folder/broken.pbrt"
expect 1 'broken\.pbrt:3' garland render broken.json
expect 1 'broken\.pbrt:3' garland pack broken.pbrt -o broken.bundle
check 'a failed pack leaves no file' test ! -e broken.bundle
printf 'LookAt 0 0 5 0 0 0 0 1 0\nCamera "perspective"\nWorldBegin\nShape "sphere"\n' >dark.pbrt
job dark 1 1 "$folder/dark.pbrt"
expect 1 'light' garland render dark.json

expect 0 '^[0-9a-f]{64}$' garland pack "$scenes/diffuse.pbrt" -o scene.bundle
expect 0 'triangles.*materials.*lights' garland pack "$scenes/diffuse.pbrt" -o again.bundle
check 'packing is repeatable' cmp -s scene.bundle again.bundle
size=$(stat -c %s scene.bundle)
for cut in 0 1 63 64 1000 $((size / 2)) $((size - 33)) $((size - 1)); do
    head -c "$cut" scene.bundle >cut.bundle
    job cut 1 1 "$folder/cut.bundle"
    expect 1 'cut\.bundle' garland render cut.json
done
for at in 9 100 $((size / 3)) $((size / 2)) $((size - 5)); do
    cp scene.bundle flipped.bundle
    byte=$(od -An -tu1 -j "$at" -N 1 scene.bundle)
    printf "\\x$(printf %02x $((byte ^ 16)))" | dd of=flipped.bundle bs=1 seek="$at" conv=notrunc status=none
    job flipped 1 1 "$folder/flipped.bundle"
    expect 1 'flipped\.bundle' garland render flipped.json
done

# ---- a render, and where its outputs go ----
job good 4
expect 0 'mutations per pixel' garland render good.json --workers 1
check 'outputs are in the current folder' test -s good.exr -a -s good.png -a -s good.report.json
expect 0 'elsewhere/good.exr' garland render good.json --workers 1 --out elsewhere
check 'outputs are in --out' test -s elsewhere/good.exr -a -s elsewhere/good.png -a -s elsewhere/good.report.json
check 'the same job gives the same pixels' same_pixels good.exr elsewhere/good.exr
sed 's|"seed": "1"|"seed": "2"|; s|good\.|other.|g' good.json >other.json
expect 0 '' garland render other.json --workers 1 --quiet
check '--quiet prints nothing' test ! -s out
same_pixels good.exr other.exr && fail 'another seed gives other pixels'
job bundled 4 1 "$folder/scene.bundle"
expect 0 '' garland render bundled.json --workers 1
check 'a bundle gives what its scene gives' same_pixels good.exr bundled.exr

# ---- report ----
expect 0 '' garland report good.report.json --image good.png -o good.html --csv tables
check 'the page holds its picture' grep -q 'src="data:image/png;base64,iVBOR' good.html
check 'the tables are there' test -s tables/history.csv -a -s tables/lengths.csv -a -s tables/moves.csv
expect 0 '' garland report good.report.json --image good.exr -o good.html
expect 1 'good\.exr' garland report good.exr -o no.html
expect 1 'missing\.json' garland report missing.json -o no.html
expect 2 'one of -o' garland report good.report.json
check 'no page of what is no report' test ! -e no.html

# ---- plan ----
expect 0 'Algorithm: mmlt, 32 x 24 pixels' garland plan good.json --workers 1 --seconds 1
rm -rf planned && mkdir planned
sed 's|good\.|planned/good.|g' good.json >planned.json
expect 0 'Cost on 100 workers' garland plan planned.json --workers 1 --seconds 1 --for 100
expect 0 '"effects":' garland plan planned.json --workers 1 --seconds 1 --json
check 'a plan writes no outputs' test -z "$(ls -A planned)"
expect 1 'missing\.json' garland plan missing.json
expect 2 'expected a number from 1' garland plan good.json --for 0

# ---- compare ----
expect 0 'error +0 ' garland compare good.exr bundled.exr
expect 0 '"relmse":' garland compare good.exr other.exr --json
expect 0 'relMSE' garland compare good.exr other.exr --reference2 bundled.exr --heatmap heat.png
check 'the heat map is a PNG' grep -aq PNG heat.png
expect 1 'missing\.exr' garland compare good.exr missing.exr
expect 1 'good\.png' garland compare good.exr good.png
sed 's|"width": 32|"width": 31|; s|good\.|small.|g' good.json >small.json
expect 0 '' garland render small.json --workers 1
expect 1 '31' garland compare good.exr small.exr
mkdir left right
cp good.exr left/a.exr; cp other.exr left/b.exr; cp good.exr left/alone.exr
cp good.exr right/a.exr; cp good.exr right/b.exr; cp good.exr right/waiting.exr
expect 0 '^median ' garland compare left right --csv pairs.csv --heatmaps heat
check 'a row for each pair' test "$(wc -l <pairs.csv)" = 3
check 'a heat map for each pair' test "$(ls heat)" = "$(printf 'a.png\nb.png')"
expect 0 'without a reference: left/alone.exr' garland compare left right
expect 0 'without an image: right/waiting.exr' garland compare left right
expect 0 '"images_without_reference":' garland compare left right --json
cp small.exr right/b.exr
expect 1 '1 of 2 pairs could not be compared' garland compare left right
expect 2 'two images or two folders' garland compare left right/a.exr
expect 2 'go with folders' garland compare good.exr other.exr --csv pairs.csv
expect 2 'go with two images' garland compare left right --heatmap heat.png
mkdir none
expect 1 'no .exr or .pfm image of one name' garland compare left none

# ---- bench ----
cat >bench.json <<END
{"scenes": [{"name": "diffuse", "scene": "$GARLAND_TESTS/scenes/diffuse.pbrt", "film": {"width": 12, "height": 12},
             "max_path_length": 3}],
 "variants": [{"name": "first", "algorithm": "bdpt"}, {"name": "second", "algorithm": "mmlt"}],
 "budgets": {"mutations_per_pixel": [4, 16]}, "seeds": 2, "workers": 2,
 "reference": {"algorithm": "bdpt", "seconds": 0.05}}
END
expect 0 '^second ' garland bench bench.json --out b
check 'all results are written' test -s b/bench.txt -a -s b/bench.json -a -s b/bench.csv -a -s b/bench.svg
rm b/runs/diffuse-second-1.json
expect 0 '3 of 4 runs are there' garland bench bench.json --out b
sed 's|\[4, 16\]|[16, 4]|' bench.json >wrong.json
expect 1 'wrong.json: budgets.mutations_per_pixel.1.: expected a number' garland bench wrong.json --out b
sed 's|\[4, 16\]|[1e6]|; s|mutations_per_pixel|seconds|' bench.json >long.json
garland bench long.json --out c --quiet 2>err & bench=$!
await 30 test -d c/references
kill -INT $bench
wait $bench
check 'an interrupt ends a bench with status 1' test $? = 1
check 'and is told' grep -q 'interrupted' err

# ---- nothing left ----
check 'no temporary files' test -z "$(ls -A "$TMPDIR")"
check 'no processes' test -z "$(left_running)"
finish

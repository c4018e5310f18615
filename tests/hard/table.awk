# Rows of docs/hard-cases.md from the cases (first file) and the figures that the tests recorded (second file).
BEGIN { FS = "\t" }
FNR == 1 { file++ }
file == 1 { order[++cases] = $1; title[$1] = $2; wrong[$1] = $3; done[$1] = $4; next }
{
    count[$1, $2] += $3
    # what is counted adds up; what is a size is the largest
    if ($2 ~ /^(refused|edges|lost|leaks)$/)
        worst[$1, $2] += $4
    else if (!(($1, $2) in worst) || $4 > worst[$1, $2])
        worst[$1, $2] = $4
}
function has(figure) { return (c, figure) in count }
function add(text) { cell = cell (cell == "" ? "" : "; ") text }
END {
    print "| case | what could go wrong | what is done | measured |"
    print "|---|---|---|---|"
    for (i = 1; i <= cases; i++) {
        c = order[i]
        cell = ""
        if (has("refused"))
            add(sprintf("nothing non-finite in %.2g evaluations%s", count[c, "refused"],
                        worst[c, "refused"] > 0 ? ", " worst[c, "refused"] " refused" : ""))
        if (has("energy"))
            add(sprintf("energy within %.1f errors of the closed form", worst[c, "energy"]))
        if (has("off"))
            add(sprintf("the mean within %.1g", worst[c, "off"]))
        if (has("target"))
            add(sprintf("invariance of %d paths to %.1g%s", count[c, "target"], worst[c, "target"],
                        worst[c, "edges"] > 0 ? ", " worst[c, "edges"] " outside their condition" : ""))
        if (has("lost"))
            add(sprintf("%d of %d round trips lost, C to %.1g", worst[c, "lost"], count[c, "lost"], worst[c, "change"]))
        if (has("agree"))
            add(sprintf("algorithms agree: largest abs(t) %.1f", worst[c, "agree"]))
        if (has("leaks"))
            add(sprintf("%d of %d segments leave a closed room", worst[c, "leaks"], count[c, "leaks"]))
        if (has("double"))
            add(sprintf("%d cases, off by %.2f of what is allowed at most", count[c, "double"], worst[c, "double"]))
        if (cell == "") {
            print "no figure of the case \"" c "\" was recorded" >"/dev/stderr"
            failed = 1
        }
        printf "| %s | %s | %s | %s |\n", title[c], wrong[c], done[c], cell
    }
    exit failed
}

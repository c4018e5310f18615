# For the scripts of this folder: tables into documents. Each stands between "<!-- NAME -->" and "<!-- end -->".

replace() { # DOCUMENT NAME FILE: the contents of FILE
    awk -v begin="<!-- $2 -->" -v file="$3" '
        $0 == begin { print; print "```"; while ((getline line < file) > 0) print line; print "```"; inside = 1; next }
        $0 == "<!-- end -->" { inside = 0 }
        !inside { print }' "$1" >"$1.new"
    mv "$1.new" "$1"
}

machine() { # when, what and on which machine
    echo "$(date -u +%F), commit $(git -C "$root" rev-parse --short HEAD 2>/dev/null || echo unknown)," \
        "$(nproc) cores, $(sed -n 's/^model name\s*: //p' /proc/cpuinfo | head -n 1)," \
        "$(sed -n 's/^cpu family\s*: /family /p' /proc/cpuinfo | head -n 1)" \
        "$(sed -n 's/^model\s*: /model /p' /proc/cpuinfo | head -n 1), $(cc --version | head -n 1)"
}

# SPDX-License-Identifier: Apache-2.0
# Sourced by the scripts beside it: places, messages, and which made data is still good.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/im2fit
jobs=$(nproc)
export CMAKE_BUILD_PARALLEL_LEVEL=$jobs CTEST_PARALLEL_LEVEL=$jobs
# Paths relative to the checkout: another clone then finds what this one compiled.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1
use_ccache() {
  if command -v ccache >/dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_C_COMPILER_LAUNCHER=ccache; fi
}
use_ccache
# deps GROUP...: installs packages. On a fresh machine ccache is among them, and the first build should fill it.
deps() { "$root/scripts/deps" "$@" && use_ccache; }

# when_free COMMAND...: starts it in the background once fewer than $jobs are running there.
when_free() {
  while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n || true; done
  "$@" &
}

say() { printf '\n== %s\n' "$*" >&2; }
die() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }

# A digest of every source that shapes trained data: when it changes, trackers and indexes are made anew.
# IM2FIT_KEEP_DATA=1 keeps what is there while one works on code that does not change the numbers.
data_digest() {
  (cd "$root" && find core kernels perception body index lab apps/im2fit-lab -name '*.cpp' -o -name '*.h' | LC_ALL=C sort |
    xargs cat | sha256sum | cut -c1-16)
}

# made FILE WORDS...: true when FILE was made by this code with these words. mark FILE WORDS... says so.
made() {
  local file=$1; shift
  [ -s "$file" ] || return 1
  [ "${IM2FIT_KEEP_DATA:-0}" = 1 ] && return 0
  [ "$(cat "$file.made" 2>/dev/null)" = "$digest $*" ]
}
mark() { local file=$1; shift; printf '%s %s\n' "$digest" "$*" > "$file.made"; }

# prepare LAB DIRECTORY SUBJECTS TRAINING_IMAGES LEVEL_TREES: body data, tracker and index into DIRECTORY, each made
# once.
prepare() {
  local lab=$1 directory=$2 subjects=$3 images=$4 trees=$5
  digest=$(data_digest)
  mkdir -p "$directory"
  export IM2FIT_BODY=$cache/body.i2b IM2FIT_TRACKER=$directory/tracker.i2t IM2FIT_INDEX=$directory/index.i2f
  if ! made "$IM2FIT_BODY" body; then
    say "body data"
    "$lab" fetch --out "$IM2FIT_BODY"
    mark "$IM2FIT_BODY" body
  fi
  if ! made "$IM2FIT_TRACKER" "tracker $images $trees"; then
    say "tracker from $images renders"
    "$lab" train --images "$images" --level-trees "$trees" --out "$IM2FIT_TRACKER"
    mark "$IM2FIT_TRACKER" "tracker $images $trees"
  fi
  if ! made "$IM2FIT_INDEX" "index $subjects $images $trees"; then
    say "index of $subjects models"
    "$lab" index --subjects "$subjects" --out "$IM2FIT_INDEX"
    mark "$IM2FIT_INDEX" "index $subjects $images $trees"
  fi
}

# What tests need: numbers that are right in kind, made in a few minutes.
small_subjects=1500 small_images=4000 small_trees=250
prepare_small() { prepare "$1" "$cache/small" $small_subjects $small_images $small_trees; }

# closing_line FILE...: "N passed, N failed" over the ctest outputs given.
closing_line() {
  awk '/tests passed, .* tests? failed out of/ { failed += $4; total += $9 }
       END { printf "%d passed, %d failed\n", total - failed, failed }' "$@"
}

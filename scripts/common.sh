# SPDX-License-Identifier: Apache-2.0
# Sourced by the scripts beside it: places, messages, and which made data is still good.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cache=${XDG_CACHE_HOME:-$HOME/.cache}/im2fit
jobs=$(nproc)
export CMAKE_BUILD_PARALLEL_LEVEL=$jobs CTEST_PARALLEL_LEVEL=$jobs
# Paths relative to the checkout: another clone then finds what this one compiled.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1
# The compiler says which headers it read: ccache need not run the preprocessor first, an eighth of an empty cache's build.
export CCACHE_DEPEND=1
# In whatever language warnings are: scripts/package, which sets LC_ALL, then finds what preset dev compiled.
export CCACHE_SLOPPINESS=locale
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
# skipped WHY: ends a script that cannot do its work here. Where nothing may be skipped, as in .ci/run, that is a failure.
skipped() {
  echo "skipped: $(basename "$0"): $*" >&2
  [ -z "${IM2FIT_NO_SKIPS:-}" ] || exit 1
  exit 0
}
die() { printf '%s: %s\n' "$(basename "$0")" "$*" >&2; exit 1; }

# fingerprint LAB WHAT: `im2fit-lab fingerprint`, remembered for each build of the program.
fingerprint() {
  local lab=$1 what=$2 known
  known=$cache/fingerprints/$(cat "$lab" "$IM2FIT_BODY" | sha256sum | cut -c1-24)-$what
  [ "$what" != index ] || known+=-$(sha256sum "$IM2FIT_TRACKER" | cut -c1-12)
  if [ ! -s "$known" ]; then
    mkdir -p "$cache/fingerprints"
    "$lab" fingerprint "$what" --body "$IM2FIT_BODY" --tracker "$IM2FIT_TRACKER" > "$known.new" || return 1
    mv "$known.new" "$known"
  fi
  cat "$known"
}

# made FILE KEY: FILE is there and was made with this key. mark FILE KEY says so. IM2FIT_KEEP_DATA=1 keeps what is there
# whatever made it.
made() { [ -s "$1" ] && { [ "${IM2FIT_KEEP_DATA:-0}" = 1 ] || [ "$(cat "$1.made" 2>/dev/null)" = "$2" ]; }; }
mark() { printf '%s\n' "$2" > "$1.made"; }

# shape_digest LAB: of the body data, without what only pictures show; remembered for each file.
shape_digest() {
  local lab=$1 known
  known=$cache/fingerprints/$(sha256sum "$IM2FIT_BODY" | cut -c1-24)-shape
  if [ ! -s "$known" ]; then
    mkdir -p "$cache/fingerprints"
    "$lab" fingerprint shape --body "$IM2FIT_BODY" | sha256sum | cut -c1-16 > "$known.new" || return 1
    mv "$known.new" "$known"
  fi
  cat "$known"
}

# prepare LAB DIRECTORY SUBJECTS TRAINING_IMAGES LEVEL_TREES: body data, tracker and index into DIRECTORY, each made
# once and made again when its key changes: the file before it, the settings here, and the program's fingerprint, which
# a change of arithmetic changes and a comment does not.
prepare() {
  local lab=$1 directory=$2 subjects=$3 images=$4 trees=$5 key print shape
  mkdir -p "$directory"
  export IM2FIT_BODY=$cache/body.i2b IM2FIT_TRACKER=$directory/tracker.i2t IM2FIT_INDEX=$directory/index.i2f
  # The trial needs a body: one that cannot be read is no longer good.
  if [ ! -s "$IM2FIT_BODY" ] || ! key=$(fingerprint "$lab" body) || ! made "$IM2FIT_BODY" "$key"; then
    say "body data"
    # npm's copy by name: what tests and published figures rest on is from it, and upstream's has other bytes.
    "$lab" fetch --source npm --out "$IM2FIT_BODY"
    key=$(fingerprint "$lab" body)
    mark "$IM2FIT_BODY" "$key"
  fi
  # An assignment of its own: a trial that fails ends the script, where it would vanish inside a longer text.
  print=$(fingerprint "$lab" tracker)
  shape=$(shape_digest "$lab")
  key="$print, $images renders, $trees trees, body $shape"
  if ! made "$IM2FIT_TRACKER" "$key"; then
    say "tracker from $images renders"
    "$lab" train --images "$images" --level-trees "$trees" --out "$IM2FIT_TRACKER"
    mark "$IM2FIT_TRACKER" "$key"
  fi
  print=$(fingerprint "$lab" index)
  key="$print, $subjects subjects, tracker $(sha256sum "$IM2FIT_TRACKER" | cut -c1-16)"
  if ! made "$IM2FIT_INDEX" "$key"; then
    say "index of $subjects models"
    "$lab" index --subjects "$subjects" --out "$IM2FIT_INDEX"
    mark "$IM2FIT_INDEX" "$key"
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

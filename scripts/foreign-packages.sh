# SPDX-License-Identifier: Apache-2.0
# Sourced: Debian packages of another architecture, downloaded by a private apt configuration. This machine's own
# package database is neither read nor changed, and no root is needed.

# foreign_apt ARCH DIRECTORY: makes the configuration in DIRECTORY and fetches the package lists; what the other
# functions download lies in DIRECTORY/archives. False, with apt's last words on stderr, when the mirror cannot be had.
foreign_apt() {
  local arch=$1 work=$2 release mirror
  mkdir -p "$work"/{lists/partial,archives/partial,etc/preferences.d}
  : > "$work/status"
  release=$(. /etc/os-release && echo "$VERSION_CODENAME")
  # This machine's mirrors serve the foreign architecture too; where none is configured, Debian's own.
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 2>/dev/null | grep -v security | head -n 1)
  echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] ${mirror:-http://deb.debian.org/debian} $release main" > "$work/sources.list"
  cat > "$work/apt.conf" <<CONF
APT::Architecture "$arch";
APT::Architectures { "$arch"; };
Dir::State "$work";
Dir::State::status "$work/status";
Dir::State::lists "$work/lists";
Dir::Cache "$work";
Dir::Cache::archives "$work/archives";
Dir::Etc::sourcelist "$work/sources.list";
Dir::Etc::sourceparts "-";
Dir::Etc::preferencesparts "$work/etc/preferences.d";
APT::Install-Recommends "false";
APT::Sandbox::User "";
Debug::NoLocking "true";
CONF
  foreign_run "$work" apt-get -qq update
}

# foreign_with_dependencies DIRECTORY PACKAGE...: the packages and all they depend on.
foreign_with_dependencies() {
  local work=$1; shift
  foreign_run "$work" apt-get -qq -y --download-only install "$@"
}

# foreign_alone DIRECTORY PACKAGE...: the packages and nothing else.
foreign_alone() {
  local work=$1; shift
  (cd "$work/archives" && foreign_run "$work" apt-get -qq download "$@")
}

# foreign_depends DIRECTORY PACKAGE: the first package it depends on.
foreign_depends() {
  APT_CONFIG=$1/apt.conf apt-cache show "$2" | sed -n 's/^Depends: \([^ ,]*\).*/\1/p' | head -n 1
}

# foreign_libraries TRIPLE SYSROOT PROGRAM IMAGE: what it needs from the sysroot, into the image where its loader looks.
foreign_libraries() {
  local triple=$1 sysroot=$2 program=$3 image=$4 name file into
  for name in $("$triple-objdump" -p "$program" | awk '$1 == "NEEDED" { print $2 }'); do
    case $name in ld-linux*) into=$image/lib ;; *) into=$image/lib/$triple ;; esac
    [ ! -e "$into/$name" ] || continue
    file=$(find -L "$sysroot/lib" "$sysroot/usr/lib/$triple" -maxdepth 2 -name "$name" | head -n 1)
    [ -n "$file" ] || { echo "$name, which $(basename "$program") needs, is not in $sysroot" >&2; return 1; }
    mkdir -p "$into"
    cp -L "$file" "$into/$name"
    foreign_libraries "$triple" "$sysroot" "$file" "$image" || return 1
  done
}

foreign_run() {
  local work=$1; shift
  APT_CONFIG=$work/apt.conf "$@" >"$work/log" 2>&1 || { tail -n 5 "$work/log" >&2; return 1; }
}

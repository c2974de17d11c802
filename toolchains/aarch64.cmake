# SPDX-License-Identifier: Apache-2.0
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(im2fit_triple aarch64-linux-gnu)
set(im2fit_sysroot_name aarch64)
set(im2fit_emulator qemu-aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/sysroot.cmake)

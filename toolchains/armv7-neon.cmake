# SPDX-License-Identifier: Apache-2.0
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_CXX_COMPILER arm-linux-gnueabihf-g++)
set(CMAKE_C_COMPILER arm-linux-gnueabihf-gcc)
set(im2fit_triple arm-linux-gnueabihf)
set(im2fit_sysroot_name armv7-neon)
set(im2fit_emulator qemu-arm)
# NEON is assumed: every ARMv7 tablet of the last ten years has it.
set(CMAKE_CXX_FLAGS_INIT "-march=armv7-a -mfpu=neon -mfloat-abi=hard")
include(${CMAKE_CURRENT_LIST_DIR}/sysroot.cmake)

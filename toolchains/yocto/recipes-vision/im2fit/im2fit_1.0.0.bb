# SPDX-License-Identifier: Apache-2.0
SUMMARY = "Body measurements from a depth camera"
DESCRIPTION = "Library, program and service that measure and dress a person before one depth camera, on the device."
SECTION = "multimedia"
LICENSE = "Apache-2.0"
LIC_FILES_CHKSUM = "file://LICENSE;md5=3b83ef96387f14655fc854ddc3c6bd57 file://NOTICE;md5=0d95f7a50e7b3dde568f50f76be8ff2e"

# Beside this recipe: git archive --prefix=im2fit-1.0.0/ -o im2fit-1.0.0.tar.gz HEAD
SRC_URI = "file://im2fit-${PV}.tar.gz"

# The layers openembedded-core and meta-oe.
DEPENDS = "bzip2 cli11 fmt libdeflate libpng libusb1 libzip lz4 nlohmann-json yaml-cpp zstd"

inherit cmake pkgconfig systemd

EXTRA_OECMAKE = " \
    -DIM2FIT_BUILD_LAB=OFF \
    -DIM2FIT_BUILD_TESTS=OFF \
    -DIM2FIT_SOURCES=folder,usb,v4l2 \
    -DCMAKE_COMPILE_WARNING_AS_ERROR=OFF \
"

# The page wants three.js as Debian packs it: build/ and examples/js/ of r111, in IM2FIT_THREE_DIR.
PACKAGECONFIG ??= ""
PACKAGECONFIG[page] = "-DIM2FIT_PAGE=ON,-DIM2FIT_PAGE=OFF,libmicrohttpd qrencode,libmicrohttpd"

PACKAGES =+ "${PN}-cameras ${PN}-tools ${PN}-daemon"
SYSTEMD_PACKAGES = "${PN}-daemon"
SYSTEMD_SERVICE:${PN}-daemon = "im2fitd.service"
# A vendor enables it once models are installed: docs/models.md.
SYSTEMD_AUTO_ENABLE = "disable"

FILES:${PN} = "${libdir}/libim2fit.so.* ${datadir}/im2fit"
FILES:${PN}-cameras = "${libdir}/libim2fit-cameras.so.*"
FILES:${PN}-tools = "${bindir}/im2fit ${libexecdir}/im2fit ${nonarch_base_libdir}/udev ${nonarch_libdir}/udev"
FILES:${PN}-daemon = "${bindir}/im2fitd ${sysconfdir}/im2fit ${systemd_system_unitdir}"
CONFFILES:${PN}-daemon = "${sysconfdir}/im2fit/im2fitd.yaml"
RDEPENDS:${PN}-daemon = "${PN}-tools"

# SPDX-License-Identifier: Apache-2.0
################################################################################
#
# im2fit
#
################################################################################

IM2FIT_VERSION = 1.0.0
# The checkout, or what git archive made of it: IM2FIT_OVERRIDE_SRCDIR in local.mk names another.
IM2FIT_SITE = $(BR2_EXTERNAL_IM2FIT_PATH)/../..
IM2FIT_SITE_METHOD = local
IM2FIT_LICENSE = Apache-2.0
IM2FIT_LICENSE_FILES = LICENSE NOTICE
IM2FIT_INSTALL_STAGING = YES
IM2FIT_DEPENDENCIES = bzip2 cli11 fmt json-for-modern-cpp libdeflate libpng libusb libzip lz4 yaml-cpp zstd

# The page wants three.js as Debian packs it, in IM2FIT_THREE_DIR, libmicrohttpd and libqrencode.
IM2FIT_CONF_OPTS = \
	-DIM2FIT_BUILD_LAB=OFF \
	-DIM2FIT_BUILD_TESTS=OFF \
	-DIM2FIT_SOURCES=folder,usb,v4l2 \
	-DIM2FIT_PAGE=OFF \
	-DCMAKE_COMPILE_WARNING_AS_ERROR=OFF

$(eval $(cmake-package))

// SPDX-License-Identifier: Apache-2.0
// What reading and writing by libpng share: it reports errors by longjmp, and everything it may jump over is plain
// data owned by the caller.
#pragma once

#include <png.h>

#include <csetjmp>
#include <cstring>

namespace im2fit::hal {

struct PngMessage {
  char text[128] = "";
};

// With a PngMessage as libpng's error pointer.
inline void on_png_error(png_structp png, png_const_charp message) {
  auto* place = static_cast<PngMessage*>(png_get_error_ptr(png));
  std::strncpy(place->text, message, sizeof place->text - 1);
  png_longjmp(png, 1);
}

inline void on_png_warning(png_structp, png_const_charp) {}

}  // namespace im2fit::hal

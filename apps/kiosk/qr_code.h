// SPDX-License-Identifier: Apache-2.0
// A text as a QR code (ISO/IEC 18004), for a page to draw.
#pragma once

#include <string>

#include "core/status.h"

namespace im2fit::apps {

struct QrCode {
  int side = 0;      // modules, without the margin of four that belongs around it
  std::string path;  // of an SVG <path>: the dark modules, a unit each, from 0, 0
};

// With error correction of level M: 15 % of it may be hidden by a reflection. Error: invalid_argument, the text is
// empty or longer than a code holds (2331 bytes).
Result<QrCode> qr_code(const std::string& text);

}  // namespace im2fit::apps

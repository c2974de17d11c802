// SPDX-License-Identifier: Apache-2.0
// What the person is asked to do, in words. The customer page (apps/kiosk/web/lang) holds the texts: one copy for the
// page and the C interface.
#pragma once

#include <array>

#include "body/tape.h"

namespace im2fit::c {

// One for each of body::kTapeLanguages: the texts of all guidance codes, in the order of their bits, each ended by a
// zero byte. One string a language: a table of pointers would cost a relocation for each text.
extern const std::array<const char*, body::kTapeLanguages.size()> kGuidanceTexts;

}  // namespace im2fit::c

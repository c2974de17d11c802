// SPDX-License-Identifier: Apache-2.0
// im2fit_guidance_text.
#include <cstddef>
#include <cstring>

#include "capi/guidance_texts.h"
#include "capi/include/im2fit/im2fit.h"

extern "C" const char* im2fit_guidance_text(int bit, const char* language) {
  if (bit < 0 || bit >= IM2FIT_GUIDANCE_COUNT || language == nullptr) return nullptr;
  for (std::size_t i = 0; i < im2fit::c::kGuidanceTexts.size(); ++i) {
    if (im2fit::body::kTapeLanguages[i] != language) continue;
    const char* text = im2fit::c::kGuidanceTexts[i];
    for (int before = 0; before < bit; ++before) text += std::strlen(text) + 1;
    return text;
  }
  return nullptr;
}

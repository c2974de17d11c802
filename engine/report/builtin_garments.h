// SPDX-License-Identifier: Apache-2.0
// The texts of data/garments/ and data/fabrics/.
#pragma once

#include <span>

namespace im2fit {

struct BuiltinText {
  const char* file;
  const char* text;
};
std::span<const BuiltinText> builtin_garment_texts();
extern const BuiltinText kBuiltinFabrics, kBuiltinCutLaw;

}  // namespace im2fit

// SPDX-License-Identifier: Apache-2.0
// The files of data/tape, data/garments and data/fabrics, for packs.
#pragma once

#include <span>

namespace im2fit::apps {

struct PackText {
  const char* file;  // "tape/points.yaml", as below data/
  const char* text;
};
// The tape's in the order in which they are read, then the others by name.
std::span<const PackText> pack_texts();

}  // namespace im2fit::apps

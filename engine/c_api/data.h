// SPDX-License-Identifier: Apache-2.0
// Files that a caller has in memory or inside another file (im2fit_data).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/status.h"
#include "engine/include/im2fit/im2fit.h"

namespace im2fit::c {

// `field` of the settings names it in errors: "settings.index_data". Errors: invalid_argument for a kind, address,
// size or offset that cannot be; io when the descriptor cannot be read; corrupt when it ends before.
Result<std::vector<std::byte>> bytes_of(const im2fit_data& data, const char* field);

std::string name_of(const im2fit_data& data, const char* path, const char* field);

// A file of the kind that T reads: body::BodyModel, index::Index.
template <class T>
Result<T> parsed(const im2fit_data& data, const char* field) {
  auto bytes = bytes_of(data, field);
  if (!bytes) return bytes.error();
  return T::parse(std::move(*bytes), name_of(data, nullptr, field));
}

}  // namespace im2fit::c

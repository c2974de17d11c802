// SPDX-License-Identifier: Apache-2.0
// The real body pack, where there is one, and the mesh of a body.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "body/model.h"

namespace im2fit::body {

inline std::string body_pack_path() {
  if (const char* path = std::getenv("IM2FIT_BODY")) return path;
  if (const char* cache = std::getenv("XDG_CACHE_HOME")) return std::string(cache) + "/im2fit/body.i2b";
  const char* home = std::getenv("HOME");
  return std::string(home != nullptr ? home : "") + "/.cache/im2fit/body.i2b";
}

// nullptr when there is no pack. A pack that does not load fails the tests that need it.
inline const BodyModel* real_body() {
  static const auto model = [] {
    auto loaded = BodyModel::load(body_pack_path());
    return loaded ? std::make_unique<BodyModel>(std::move(*loaded)) : nullptr;
  }();
  return model.get();
}

// The vertices of a body at rest.
inline std::vector<Vec3f> mesh_of(const BodyModel& model, const Params& params = {}) {
  std::vector<Vec3f> out(static_cast<std::size_t>(model.vertex_count()));
  model.morph(params, out);
  return out;
}

}  // namespace im2fit::body

#define IM2FIT_NEEDS_BODY()                                                                           \
  if (!std::filesystem::exists(im2fit::body::body_pack_path()))                                       \
    GTEST_SKIP() << "no body pack at " << im2fit::body::body_pack_path() << ": run im2fit-lab fetch"; \
  ASSERT_NE(im2fit::body::real_body(), nullptr) << im2fit::body::body_pack_path() << " does not load"

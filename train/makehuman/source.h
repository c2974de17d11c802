// SPDX-License-Identifier: Apache-2.0
// MakeHuman's data as both layouts hold it: base mesh, rig, weights, targets. One interface, two readers.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"

namespace im2fit::body::makehuman {

inline constexpr int kSourceVertexCount = 19158;
inline constexpr int kBodyFirstHelper = 13380;
inline constexpr double kMmPerDm = 100;

using TextureCorner = std::array<float, 2>;  // u, v from the lower left corner, 0..1

// A target in both layouts' words, without ".target": "torso/torso-vshape-incr" and "torso/torso-vshape-more".
struct TargetName {
  std::string upstream;
  std::string npm;
};

using Delta = std::array<std::int16_t, 3>;  // 1e-3 dm
using DenseTarget = std::vector<Delta>;     // one row a source vertex

struct Bone {
  std::string parent;  // "" for the root
  std::string head;    // names of joint lists
  std::string tail;
};

struct Rig {
  std::map<std::string, Bone> bones;
  std::map<std::string, std::vector<int>> joints;
};

class Source {
 public:
  virtual ~Source() = default;

  std::vector<std::array<double, 3>> base_dm;                              // kSourceVertexCount rows
  std::map<std::string, std::vector<std::array<std::int32_t, 4>>> groups;  // "body", "helper-tights", ...
  std::vector<TextureCorner> texture;                                      // "vt" of an .obj
  std::map<std::string, std::vector<std::array<std::int32_t, 4>>>
      corners;  // into `texture`; as `groups`, face by face
  Rig rig;
  std::vector<std::vector<std::pair<std::string, double>>> influences;  // per vertex: bone, weight (any sum)
  mutable std::vector<std::string> files_read;                          // so far, in any order; upstream's alone
  bool npm_bugs = false;  // knee cubes of the height targets move wrongly; one breast target moves the whole body

  // An empty target when the layout has no such file.
  virtual Result<DenseTarget> target(const TargetName& name) const = 0;
};

Result<std::unique_ptr<Source>> open_npm_package(const std::string& directory);
// `data` is the folder that holds 3dobjs/ and targets/.
Result<std::unique_ptr<Source>> open_upstream_checkout(const std::string& data);

// Both layouts write the rig alike: {"bones": {name: {parent, head, tail}}, "joints": {name: [vertices]}}.
Result<Rig> read_rig(const std::string& path);

}  // namespace im2fit::body::makehuman

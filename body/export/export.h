// SPDX-License-Identifier: Apache-2.0
// The avatar as files other programs read. Each is written atomically.
#pragma once

#include <string>

#include "base/status.h"
#include "body/model.h"
#include "body/skeleton.h"

namespace im2fit::body {

struct Avatar {
  const BodyModel* model = nullptr;
  Params params;
  Pose pose;  // how it stands in .obj and in the default pose of .glb
};
Status write_glb(const Avatar& avatar, const std::string& path);   // metres, +Y up, skinned, 19 joints
Status write_obj(const Avatar& avatar, const std::string& path);   // metres, posed
Status write_bvh(const Avatar& avatar, const std::string& path);   // centimetres, one frame: the pose
Status write_skel(const Avatar& avatar, const std::string& path);  // the fifteen joints, mm
// The paper's nine attributes, one "name value" a line (docs/formats.md).
Status write_attributes(const Avatar& avatar, const std::string& path);

}  // namespace im2fit::body

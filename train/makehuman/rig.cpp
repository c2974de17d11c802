// SPDX-License-Identifier: Apache-2.0
#include "formats/json_file.h"
#include "train/makehuman/source.h"

namespace im2fit::body::makehuman {

Result<Rig> read_rig(const std::string& path) {
  const auto json = read_json(path);
  if (!json) return json.error();
  const auto bad = [&](const std::string& why) { return Error{ErrorCode::corrupt, path + ": " + why}; };
  if (!json->is_object() || !json->contains("bones") || !json->contains("joints"))
    return bad("expected an object with 'bones' and 'joints'");
  Rig rig;
  for (const auto& [name, joint] : (*json)["joints"].items()) {
    auto& list = rig.joints[name];
    if (!joint.is_array()) return bad("joint '" + name + "' is not a list");
    for (const auto& v : joint) {
      if (!v.is_number_integer() || v.get<std::int64_t>() < 0 || v.get<std::int64_t>() >= kSourceVertexCount)
        return bad("joint '" + name + "' lists a vertex outside 0.." + std::to_string(kSourceVertexCount - 1));
      list.push_back(v.get<int>());
    }
  }
  for (const auto& [name, bone] : (*json)["bones"].items()) {
    if (!bone.is_object()) return bad("bone '" + name + "' is not an object");
    Bone b;
    if (const auto p = bone.find("parent"); p != bone.end() && p->is_string()) b.parent = p->get<std::string>();
    b.head = bone.value("head", "");
    b.tail = bone.value("tail", "");
    if (!rig.joints.contains(b.head) || !rig.joints.contains(b.tail))
      return bad("bone '" + name + "' ends at a joint that is not listed");
    rig.bones[name] = b;
  }
  return rig;
}

}  // namespace im2fit::body::makehuman

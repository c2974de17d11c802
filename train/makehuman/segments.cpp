// SPDX-License-Identifier: Apache-2.0
#include "train/makehuman/segments.h"

#include <algorithm>
#include <map>

namespace im2fit::body::makehuman {

const std::array<std::string_view, kSegmentCount> kSegmentHeads = {"upperleg01.L:head+upperleg01.R:head",
                                                                   "spine05:head",
                                                                   "spine03:head",
                                                                   "neck01:head",
                                                                   "head:head",
                                                                   "clavicle.L:head",
                                                                   "upperarm01.L:head",
                                                                   "lowerarm01.L:head",
                                                                   "wrist.L:head",
                                                                   "clavicle.R:head",
                                                                   "upperarm01.R:head",
                                                                   "lowerarm01.R:head",
                                                                   "wrist.R:head",
                                                                   "upperleg01.L:head",
                                                                   "lowerleg01.L:head",
                                                                   "foot.L:head",
                                                                   "upperleg01.R:head",
                                                                   "lowerleg01.R:head",
                                                                   "foot.R:head"};
const std::array<std::string_view, kSegmentCount> kSegmentTails = {
    "spine05:head",      "spine03:head",      "neck01:head",        "head:head",          "head:tail",
    "upperarm01.L:head", "lowerarm01.L:head", "wrist.L:head",       "metacarpal3.L:tail", "upperarm01.R:head",
    "lowerarm01.R:head", "wrist.R:head",      "metacarpal3.R:tail", "lowerleg01.L:head",  "foot.L:head",
    "foot.L:tail",       "lowerleg01.R:head", "foot.R:head",        "foot.R:tail"};
const std::array<std::string_view, kJointCount> kOpenNiJoints = {
    "head:head+head:tail", "neck01:head",       "spine03:head",       "upperarm01.L:head",  "upperarm01.R:head",
    "lowerarm01.L:head",   "lowerarm01.R:head", "metacarpal3.L:tail", "metacarpal3.R:tail", "upperleg01.L:head",
    "upperleg01.R:head",   "lowerleg01.L:head", "lowerleg01.R:head",  "foot.L:head",        "foot.R:head"};

namespace {

constexpr int kFirstCubeVertex = 13606;
constexpr int kLastCubeVertex = 14597;

// The segment a bone of MakeHuman's 163 belongs to; bones not named here follow their parent.
struct BoneSegment {
  std::string_view bone;  // without ".L" / ".R"
  Segment segment;        // the left one of a pair
};
constexpr BoneSegment kBoneSegments[] = {
    {"root", Segment::pelvis},
    {"pelvis", Segment::pelvis},
    {"spine05", Segment::abdomen},
    {"spine04", Segment::abdomen},
    {"spine03", Segment::chest},
    {"neck01", Segment::neck},
    {"head", Segment::head},
    {"clavicle", Segment::left_shoulder},
    {"upperarm01", Segment::left_upper_arm},
    {"lowerarm01", Segment::left_lower_arm},
    {"wrist", Segment::left_hand},
    {"upperleg01", Segment::left_upper_leg},
    {"lowerleg01", Segment::left_lower_leg},
    {"foot", Segment::left_foot},
};

Segment right_of(Segment s) {
  if (s >= Segment::left_shoulder && s <= Segment::left_hand)
    return static_cast<Segment>(index_of(s) - index_of(Segment::left_shoulder) + index_of(Segment::right_shoulder));
  if (s >= Segment::left_upper_leg && s <= Segment::left_foot)
    return static_cast<Segment>(index_of(s) - index_of(Segment::left_upper_leg) + index_of(Segment::right_upper_leg));
  return s;
}

// False for a bone whose chain of parents ends without meeting a segment.
bool segment_of_bone(const Rig& rig, std::string bone, Segment& out) {
  for (int depth = 0; depth < 64; ++depth) {
    const bool sided = bone.ends_with(".L") || bone.ends_with(".R");
    const std::string_view stem = sided ? std::string_view(bone).substr(0, bone.size() - 2) : std::string_view(bone);
    for (const BoneSegment& b : kBoneSegments)
      if (b.bone == stem) {
        out = bone.ends_with(".R") ? right_of(b.segment) : b.segment;
        return true;
      }
    const auto it = rig.bones.find(bone);
    if (it == rig.bones.end()) return false;
    bone = it->second.parent;
  }
  return false;
}

void set_rigid(std::vector<SegmentWeights>& weights, int v, std::size_t segment) {
  weights[index_of(v)] = {};
  weights[index_of(v)][segment] = 1;
}

// A joint cube moves with one segment. A segment's head cube moves with that segment, about its own mean: then
// skinned joints and posed bones are the same points.
Status make_joint_cubes_rigid(const Rig& rig, std::vector<SegmentWeights>& weights) {
  for (int first = kFirstCubeVertex; first <= kLastCubeVertex; first += kCubeSize) {
    SegmentWeights sum{};
    for (int v = first; v < first + kCubeSize; ++v)
      for (std::size_t s = 0; s < sum.size(); ++s) sum[s] += weights[index_of(v)][s];
    const auto best = static_cast<std::size_t>(std::max_element(sum.begin(), sum.end()) - sum.begin());
    for (int v = first; v < first + kCubeSize; ++v) set_rigid(weights, v, best);
  }
  for (std::size_t s = 0; s < kSegmentCount; ++s) {
    for (const auto& joints : {kSegmentTails[s], kSegmentHeads[s]}) {
      const auto list = joint_vertices(rig, joints);
      if (!list) return list.error();
      for (const int v : *list)
        if (v >= kFirstCubeVertex) set_rigid(weights, v, s);
    }
  }
  return Ok{};
}

}  // namespace

Result<std::vector<int>> joint_vertices(const Rig& rig, std::string_view text) {
  std::vector<int> out;
  while (!text.empty()) {
    const auto plus = text.find('+');
    const auto part = text.substr(0, plus);
    text = plus == std::string_view::npos ? std::string_view() : text.substr(plus + 1);
    const auto colon = part.find(':');
    const auto bone = rig.bones.find(std::string(part.substr(0, colon)));
    if (bone == rig.bones.end())
      return Error{ErrorCode::corrupt, "rig: no bone '" + std::string(part.substr(0, colon)) + "'"};
    const auto& joint = part.substr(colon + 1) == "head" ? bone->second.head : bone->second.tail;
    const auto& list = rig.joints.at(joint);
    out.insert(out.end(), list.begin(), list.end());
  }
  return out;
}

Result<std::vector<SegmentWeights>> segment_weights(const Source& source) {
  std::vector<SegmentWeights> weights(kSourceVertexCount, SegmentWeights{});
  std::map<std::string, Segment> segments;
  for (std::size_t v = 0; v < source.influences.size(); ++v)
    for (const auto& [bone, weight] : source.influences[v]) {
      if (!segments.contains(bone) && !segment_of_bone(source.rig, bone, segments[bone]))
        return Error{ErrorCode::corrupt, "skin weights: bone '" + bone + "' is not in the rig"};
      weights[v][index_of(segments[bone])] += weight;
    }
  const Status rigid = make_joint_cubes_rigid(source.rig, weights);
  if (!rigid) return rigid.error();
  return weights;
}

SkinRecord heaviest_four(const SegmentWeights& weights) {
  std::array<std::size_t, kSegmentCount> order{};
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return weights[a] > weights[b]; });
  const double sum = weights[order[0]] + weights[order[1]] + weights[order[2]] + weights[order[3]];
  SkinRecord record;
  if (!(sum > 0)) {
    record.weight[0] = 1;
    return record;
  }
  float rest = 1;
  for (std::size_t i = 3; i > 0; --i) {
    record.segment[i] = weights[order[i]] > 0 ? static_cast<std::uint8_t>(order[i]) : std::uint8_t{0};
    record.weight[i] = static_cast<float>(weights[order[i]] / sum);
    rest -= record.weight[i];
  }
  record.segment[0] = static_cast<std::uint8_t>(order[0]);
  record.weight[0] = rest;
  return record;
}

}  // namespace im2fit::body::makehuman

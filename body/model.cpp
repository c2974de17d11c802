// SPDX-License-Identifier: Apache-2.0
#include "body/model.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "body/model_data.h"
#include "body/shape_space.h"
#include "core/container.h"

namespace im2fit::body {

const std::array<std::int8_t, kSegmentCount> kSegmentParent = {-1, 0,  1,  2, 3,  2,  5, 6,  7, 2,
                                                               9,  10, 11, 0, 13, 14, 0, 16, 17};
const std::array<std::string_view, kSegmentCount> kSegmentNames = {
    "pelvis",          "abdomen",         "chest",           "neck",           "head",
    "left_shoulder",   "left_upper_arm",  "left_lower_arm",  "left_hand",      "right_shoulder",
    "right_upper_arm", "right_lower_arm", "right_hand",      "left_upper_leg", "left_lower_leg",
    "left_foot",       "right_upper_leg", "right_lower_leg", "right_foot"};

namespace {

constexpr bool is_arm(std::uint8_t segment) {
  const auto s = static_cast<Segment>(segment);
  return (s >= Segment::left_upper_arm && s <= Segment::left_hand) ||
         (s >= Segment::right_upper_arm && s <= Segment::right_hand);
}

// Checks every index of the file once, so that nothing later reads past an end however the file was made.
class Validator {
 public:
  Validator(const BodyModel::Data& data, const std::string& what) : d_(data), what_(what) {}

  Status check() const {
    const auto count = static_cast<std::int64_t>(d_.base.size());
    if (count < kBodyVertexCount || count > 0xFFFF)
      return bad("base",
                 std::to_string(count) + " vertices, expected " + std::to_string(kBodyVertexCount) + " to 65535");
    if (d_.skin.size() != d_.base.size()) return bad("skin", "not one record a vertex");
    // A coordinate is 0 or no smaller than kernels/blend may take for 0 somewhere.
    const auto sane = [](float c) { return c == 0 || (std::fabs(c) > 1e-18F && std::fabs(c) < 1e5F); };
    for (const Vec3f& v : d_.base)
      if (!sane(v.x) || !sane(v.y) || !sane(v.z)) return bad("base", "a vertex is not a finite position");
    if (!quads_within(d_.quads, kBodyVertexCount)) return bad("quads", "vertex index out of range");
    if (!quads_within(d_.tights_quads, count)) return bad("tights_quads", "vertex index out of range");
    if (!quads_within(d_.skirt_quads, count)) return bad("skirt_quads", "vertex index out of range");
    if (!targets_ok()) return bad("targets", "run out of range");
    if (!runs_ok()) return bad("runs", "vertex or delta out of range");
    if (!macros_ok()) return bad("macros", "target or factor out of range");
    if (!modifiers_ok()) return bad("modifiers", "target out of range");
    if (!skin_ok()) return bad("skin", "segment or weight out of range");
    if (!lists_ok()) return bad("lists", "list empty or vertex out of range");
    for (const std::int32_t v : d_.landmarks)
      if (v < 0 || v >= kBodyVertexCount) return bad("landmarks", "vertex out of range");
    return Ok{};
  }

 private:
  Error bad(const char* section, const std::string& why) const {
    return {ErrorCode::corrupt, what_ + ": section '" + section + "': " + why};
  }
  static bool quads_within(std::span<const std::array<std::int32_t, 4>> quads, std::int64_t count) {
    return std::all_of(quads.begin(), quads.end(), [&](const auto& q) {
      return std::all_of(q.begin(), q.end(), [&](std::int32_t v) { return v >= 0 && v < count; });
    });
  }
  bool targets_ok() const {
    return d_.targets.size() <= kTargetCountMax &&
           std::all_of(d_.targets.begin(), d_.targets.end(),
                       [&](const auto& t) { return std::uint64_t{t.first_run} + t.run_count <= d_.runs.size(); });
  }
  bool runs_ok() const {
    return std::all_of(d_.runs.begin(), d_.runs.end(), [&](const RunRecord& r) {
      return std::size_t{r.first_vertex} + r.vertex_count <= d_.base.size() &&
             (std::uint64_t{r.first_delta} + r.vertex_count) * 3 <= d_.deltas.size();
    });
  }
  bool macros_ok() const {
    return std::all_of(d_.macros.begin(), d_.macros.end(), [&](const MacroRecord& m) {
      return m.target < d_.targets.size() && std::all_of(m.factors.begin(), m.factors.end(), [](std::uint8_t f) {
               return f == kNoFactor || f < kFactorCount;
             });
    });
  }
  bool modifiers_ok() const {
    const auto ok = [&](std::int16_t t) { return t >= -1 && t < static_cast<std::int64_t>(d_.targets.size()); };
    return std::all_of(d_.modifiers.begin(), d_.modifiers.end(), [&](const ModifierRecord& m) {
      return ok(m.low[0]) && ok(m.low[1]) && ok(m.high[0]) && ok(m.high[1]);
    });
  }
  bool skin_ok() const {
    return std::all_of(d_.skin.begin(), d_.skin.end(), [&](const SkinRecord& s) {
      for (std::size_t i = 0; i < 4; ++i)
        if (s.segment[i] >= kSegmentCount || !(s.weight[i] >= 0 && s.weight[i] <= 1)) return false;
      return true;
    });
  }
  bool lists_ok() const {
    for (const ListRecord& l : d_.lists)
      if (l.count == 0 || std::uint64_t{l.first} + l.count > d_.list_vertices.size()) return false;
    return std::all_of(d_.list_vertices.begin(), d_.list_vertices.end(),
                       [&](std::int32_t v) { return v >= 0 && v < static_cast<std::int64_t>(d_.base.size()); });
  }

  const BodyModel::Data& d_;
  const std::string& what_;
};

std::vector<std::string> split_lines(std::span<const std::byte> text) {
  std::vector<std::string> lines;
  std::string line;
  for (const std::byte b : text) {
    if (b == std::byte{'\n'}) {
      lines.push_back(std::move(line));
      line.clear();
    } else {
      line += static_cast<char>(b);
    }
  }
  return lines;
}

template <class T>
bool take(const ContainerReader& reader, const char* name, std::span<const T>& out, Error& error,
          std::size_t count = SIZE_MAX) {
  auto section = reader.array<T>(name, count);
  if (!section) {
    error = section.error();
    return false;
  }
  out = *section;
  return true;
}

Status read_sections(std::span<const std::byte> bytes, const std::string& what, BodyModel::Data& d) {
  const auto reader = ContainerReader::parse(bytes, kBodyMagic, kBodyVersion, what);
  if (!reader) return reader.error();
  Error error;
  if (!take(*reader, "base", d.base, error) || !take(*reader, "quads", d.quads, error) ||
      !take(*reader, "tights_quads", d.tights_quads, error) || !take(*reader, "skirt_quads", d.skirt_quads, error) ||
      !take(*reader, "targets", d.targets, error) || !take(*reader, "runs", d.runs, error) ||
      !take(*reader, "deltas", d.deltas, error) || !take(*reader, "macros", d.macros, error) ||
      !take(*reader, "modifiers", d.modifiers, error) || !take(*reader, "skin", d.skin, error) ||
      !take(*reader, "lists", d.lists, error, kListCount) ||
      !take(*reader, "list_vertices", d.list_vertices, error) ||
      !take(*reader, "landmarks", d.landmarks, error, kLandmarkCount))
    return error;
  const auto names = reader->section("modifier_names");
  if (!names) return names.error();
  d.modifier_names = split_lines(*names);
  if (d.modifier_names.size() != d.modifiers.size() || d.modifiers.size() > kModifierCountMax)
    return Error{ErrorCode::corrupt, what + ": section 'modifier_names' has " +
                                         std::to_string(d.modifier_names.size()) + " lines, 'modifiers' has " +
                                         std::to_string(d.modifiers.size()) + " records"};
  if (const Status valid = Validator(d, what).check(); !valid) return valid.error();
  auto look = read_look(*reader, d.base.size(), d.quads.size(), what);
  if (!look) return look.error();
  d.look = *look;
  auto space = read_shape_space(*reader, what);
  if (!space) return space.error();
  d.shape_space = std::move(*space);
  const auto starts = read_start_bodies(*reader, d.modifiers.size(), what);
  if (!starts) return starts.error();
  d.starts = *starts;
  return Ok{};
}

void derive(BodyModel::Data& d) {
  d.triangles.reserve(d.quads.size() * 2);
  for (const auto& q : d.quads) {
    d.triangles.push_back({q[0], q[1], q[2]});
    d.triangles.push_back({q[0], q[2], q[3]});
  }
  for (const TargetRecord& t : d.targets) {
    std::uint32_t count = t.run_count;
    while (count > 0 && d.runs[t.first_run + count - 1].first_vertex >= kBodyVertexCount) --count;
    d.body_run_count.push_back(count);
  }
  std::vector<float> arm_weights(d.skin.size());
  for (std::size_t v = 0; v < arm_weights.size(); ++v)
    for (std::size_t i = 0; i < 4; ++i) arm_weights[v] += is_arm(d.skin[v].segment[i]) ? d.skin[v].weight[i] : 0;
  const auto arm_weight = [&](std::int32_t v) { return arm_weights[static_cast<std::size_t>(v)]; };
  d.triangle_is_arm.reserve(d.triangles.size());
  for (const auto& t : d.triangles)
    d.triangle_is_arm.push_back(arm_weight(t[0]) + arm_weight(t[1]) + arm_weight(t[2]) >= 1.5F ? 1 : 0);
}

// A NaN becomes the low end: a slider never poisons a mesh.
float limited(float v, float low, float high) {
  return v > low ? (v < high ? v : high) : low;
}

// A slider 0..1 as the weights of its min, average and max targets.
struct Tri {
  float min, average, max;
  explicit Tri(float slider) {
    const float v = limited(slider, 0, 1);
    max = v > 0.5F ? 2 * v - 1 : 0;
    min = v < 0.5F ? 1 - 2 * v : 0;
    average = 1 - max - min;
  }
};

// Below 25 MakeHuman blends in the child, whose stature is a child's: adults of 18 to 25 are its 25.
float old_share(float age_years) {
  return (limited(age_years, 25, 90) - 25) / 65;
}

std::array<float, kFactorCount> factor_values(const Params& p) {
  const float gender = limited(p.gender, 0, 1);
  const float old = old_share(p.age_years);
  const Tri muscle(p.muscle), weight(p.weight), height(p.height), proportions(p.proportions), cup(p.cup),
      firmness(p.firmness);
  std::array<float, 3> race{};
  for (std::size_t i = 0; i < 3; ++i) race[i] = limited(p.race[i], 0, 1e6F);
  const float race_sum = race[0] + race[1] + race[2];
  for (float& r : race) r = race_sum > 0 ? r / race_sum : 1.0F / 3;
  return {gender,           1 - gender,      1 - old,         old,        race[0],        race[1],    race[2],
          muscle.min,       muscle.average,  muscle.max,      weight.min, weight.average, weight.max, height.min,
          height.max,       proportions.min, proportions.max, cup.min,    cup.average,    cup.max,    firmness.min,
          firmness.average, firmness.max};
}

using TargetWeights = std::array<float, kTargetCountMax>;

void add_macros(const BodyModel::Data& d, const Params& p, TargetWeights& weights) {
  const auto factors = factor_values(p);
  for (const MacroRecord& m : d.macros) {
    float product = 1;
    for (const std::uint8_t f : m.factors) {
      if (f == kNoFactor) break;
      product *= factors[f];
    }
    weights[m.target] += product;
  }
}

void add_modifiers(const BodyModel::Data& d, const Params& p, TargetWeights& weights) {
  const std::size_t count = std::min(p.modifiers.size(), d.modifiers.size());
  for (std::size_t i = 0; i < count; ++i) {
    const float v = p.modifiers[i];
    if (!(v != 0) || v != v) continue;
    const float strength = limited(v < 0 ? -v : v, 0, kModifierLimit);
    for (const std::int16_t t : v < 0 ? d.modifiers[i].low : d.modifiers[i].high)
      if (t >= 0) weights[static_cast<std::size_t>(t)] += strength;
  }
}

void weigh_targets(const BodyModel::Data& d, const Params& p, TargetWeights& weights) {
  std::fill_n(weights.begin(), d.targets.size(), 0.0F);
  add_macros(d, p, weights);
  add_modifiers(d, p, weights);
}

float scale_of(float weight) {
  const float scale = weight * kDeltaUnitMm;
  return weight != 0 && !(std::fabs(scale) < kBlendScaleMin) ? scale : 0;
}

void add_target(const BodyModel::Data& d, std::size_t target, std::uint32_t run_count,
                std::span<const BlendInto> into) {
  if (into.empty()) return;
  blend(d.runs.data() + d.targets[target].first_run, static_cast<int>(run_count), d.deltas.data(), into.data(),
        static_cast<int>(into.size()));
}

}  // namespace

BodyModel::BodyModel() : data_(std::make_unique<Data>()) {}
BodyModel::BodyModel(BodyModel&&) noexcept = default;
BodyModel& BodyModel::operator=(BodyModel&&) noexcept = default;
BodyModel::~BodyModel() = default;

Result<BodyModel> BodyModel::load(const std::string& path) {
  auto file = MappedFile::open(path);
  if (!file) return file.error();
  BodyModel model;
  model.data_->mapped = std::move(*file);
  const Status status = read_sections(model.data_->mapped.bytes(), path, *model.data_);
  if (!status) return status.error();
  derive(*model.data_);
  return model;
}

Result<BodyModel> BodyModel::parse(std::vector<std::byte> bytes, const std::string& what) {
  BodyModel model;
  model.data_->owned = std::move(bytes);
  const Status status = read_sections(model.data_->owned, what, *model.data_);
  if (!status) return status.error();
  derive(*model.data_);
  return model;
}

const ShapeSpace& BodyModel::shape_space() const {
  return data_->shape_space;
}

const StartBodies& BodyModel::start_bodies() const {
  return data_->starts;
}

int BodyModel::vertex_count() const {
  return static_cast<int>(data_->base.size());
}
int BodyModel::body_vertex_count() const {
  return kBodyVertexCount;
}
std::span<const std::array<std::int32_t, 4>> BodyModel::body_quads() const {
  return data_->quads;
}
std::span<const std::array<std::int32_t, 3>> BodyModel::body_triangles() const {
  return data_->triangles;
}
std::span<const std::string> BodyModel::modifier_names() const {
  return data_->modifier_names;
}

int BodyModel::modifier_index(std::string_view name) const {
  const auto& names = data_->modifier_names;
  const auto it = std::find(names.begin(), names.end(), name);
  return it == names.end() ? -1 : static_cast<int>(it - names.begin());
}

void BodyModel::morph(const Params& params, std::span<Vec3f> out) const {
  const Data& d = *data_;
  assert(out.size() == d.base.size());
  TargetWeights weights;
  weigh_targets(d, params, weights);
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  std::memcpy(out.data(), d.base.data(), d.base.size_bytes());
  for (std::size_t t = 0; t < d.targets.size(); ++t) {
    const BlendInto into = {scale_of(weights[t]), &out[0].x};
    if (into.scale != 0) add_target(d, t, d.targets[t].run_count, {&into, 1});
  }
  if (!params.warp.is_none()) apply_warp(*this, params.warp, out);
}

// A run may cross from the body into the helpers, which therefore need places that hold numbers. The meshes that a
// target moves are moved together: its deltas come from far.
void BodyModel::move_bodies(std::span<const BodyMove> moves) const {
  const Data& d = *data_;
  assert(!moves.empty() && moves.size() <= kBodyMovesMax);
  std::array<TargetWeights, kBodyMovesMax> weights;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    weigh_targets(d, *moves[i].to, weights[i]);
    if (moves[i].from == nullptr) {
      std::memcpy(moves[i].out.data(), d.base.data(), d.base.size_bytes());
      continue;
    }
    TargetWeights before;
    weigh_targets(d, *moves[i].from, before);
    for (std::size_t t = 0; t < d.targets.size(); ++t) weights[i][t] = (weights[i][t] - before[t]) * moves[i].share;
  }
  for (std::size_t t = 0; t < d.targets.size(); ++t) {
    std::array<BlendInto, kBodyMovesMax> into;
    std::size_t count = 0;
    for (std::size_t i = 0; i < moves.size(); ++i)
      if (const float scale = scale_of(weights[i][t]); scale != 0) into[count++] = {scale, &moves[i].out[0].x};
    add_target(d, t, d.body_run_count[t], std::span(into).first(count));
  }
}

Vec3f mean_of_list(const BodyModel::Data& data, std::size_t list, std::span<const Vec3f> vertices) {
  const ListRecord& l = data.lists[list];
  Vec3f sum;
  for (const std::int32_t v : data.list_vertices.subspan(l.first, l.count))
    sum = sum + vertices[static_cast<std::size_t>(v)];
  return sum * (1.0F / static_cast<float>(l.count));
}

}  // namespace im2fit::body

// SPDX-License-Identifier: Apache-2.0
#include "index/format.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/container.h"

namespace im2fit::index {
namespace {

constexpr float kMagnitudeMax = 1e9F;  // of any stored number: products of four of them stay finite in double

// Collects the first error, so that the section list reads as a list.
class SectionReader {
 public:
  SectionReader(const ContainerReader& container, const std::string& what) : container_(container), what_(what) {}
  template <class T>
  std::span<const T> take(const char* name, std::size_t count) {
    if (error_) return {};
    auto values = container_.array<T>(name, count);
    if (!values) {
      fail(values.error());
      return {};
    }
    if constexpr (std::is_floating_point_v<T>) {
      for (const T v : *values)
        if (!(std::abs(v) <= kMagnitudeMax)) fail(name, "holds a number that is not finite or beyond 1e9");
    }
    return *values;
  }
  // Checked page by page as it is read.
  template <class T>
  std::span<const T> take_paged(const char* name, std::size_t count, PagedBytes& pages) {
    if (error_) return {};
    auto found = container_.paged(name);
    if (!found) {
      fail(found.error());
      return {};
    }
    pages = *found;
    const auto bytes = pages.bytes();
    if (bytes.size() != count * sizeof(T)) {
      fail(name, "has " + std::to_string(bytes.size()) + " bytes, expected " + std::to_string(count * sizeof(T)));
      return {};
    }
    return {reinterpret_cast<const T*>(bytes.data()), count};
  }
  template <class T>
  T record(const char* name) {
    T out{};
    const auto bytes = take<std::byte>(name, sizeof(T));
    if (!error_) std::memcpy(static_cast<void*>(&out), bytes.data(), sizeof(T));
    return out;
  }
  // `why` becomes a string in failing only: millions of values are checked.
  void require(bool holds, const char* name, const char* why) {
    if (!holds) fail(name, why);
  }
  bool failed() const { return error_; }
  const Error& error() const { return first_; }

 private:
  void fail(const char* name, const std::string& why) {
    fail({ErrorCode::corrupt, what_ + ": section '" + name + "' " + why + "; build the index again"});
  }
  void fail(Error e) {
    if (!error_) first_ = std::move(e);
    error_ = true;
  }
  const ContainerReader& container_;
  const std::string& what_;
  Error first_;
  bool error_ = false;
};

bool within(double value, double low, double high) {
  return value >= low && value <= high;
}  // false for NaN

bool possible(const NoiseModel& n) {
  return std::all_of(n.share.begin(), n.share.end(), [](double s) { return within(s, 0, 1e9); }) &&
         n.share[0] + n.share[1] > 1e-9;
}

void check_meta(SectionReader& in, const MetaRecord& m) {
  in.require(within(m.feature_size, 1, kFeatureMax), "meta", "has an impossible feature size");
  in.require(within(m.target_count, kTargetMin, kTargetMax), "meta", "has an impossible number of targets");
  in.require(within(m.dimensions, 1, kDimensionMax), "meta", "has an impossible number of dimensions");
  in.require(within(m.entry_count, 1, kEntryMax), "meta", "has an impossible number of entries");
  in.require(m.subject_count <= m.entry_count && m.densified_count <= m.entry_count, "meta",
             "has an impossible number of people");
  in.require(within(m.leaf_count, 1, m.entry_count), "meta", "has an impossible number of leaves");
  in.require(within(m.group_count, 1, kGroupMax), "meta", "has an impossible number of groups");
  in.require(m.local_method <= 2 && m.quadratic <= 1 && m.interval_kind <= 1, "meta", "names an unknown method");
  in.require(within(m.neighbour_count, 1, kNeighbourMax), "meta", "has an impossible number of neighbours");
  in.require(within(m.grid_unit, 1e-9, 1e9), "meta", "has an impossible grid unit");
  in.require(within(m.intercept_penalty, 0, 1e9) && within(m.slope_penalty, 0, 1e9), "meta",
             "has an impossible penalty");
  in.require(possible(m.noise), "meta", "has an impossible noise model");
  in.require(m.reserved == 0, "meta", "has a reserved field that is not 0");
}

CodeTree take_tree(SectionReader& in, const MetaRecord& m) {
  CodeTree tree;
  tree.point_count = m.entry_count;
  tree.dimension_count = static_cast<int>(m.dimensions);
  const auto steps = in.take<std::int32_t>("code.step", kDimensionMax);
  tree.blocks =
      in.take_paged<std::int8_t>("code", code_block_bytes(tree.point_count, tree.dimension_count), tree.pages);
  tree.leaf_first = in.take<std::uint32_t>("leaf", std::size_t{m.leaf_count} + 1);
  tree.leaf_boxes = in.take<std::int16_t>("leaf.box", box_values(m.leaf_count, tree.dimension_count));
  if (in.failed()) return tree;
  tree.group_boxes = in.take<std::int16_t>("group.box", box_values(tree.group_count(), tree.dimension_count));
  if (in.failed()) return tree;
  for (std::size_t d = 0; d < steps.size(); ++d) {
    in.require(steps[d] >= 0 && steps[d] <= kStepMax && (steps[d] == 0 || d < m.dimensions), "code.step",
               "holds a step out of range");
    tree.steps[d] = steps[d];
  }
  in.require(tree.leaf_first.front() == 0 && tree.leaf_first.back() == m.entry_count, "leaf",
             "does not cover the entries");
  for (std::size_t l = 0; l < m.leaf_count; ++l)
    in.require(tree.leaf_first[l] < tree.leaf_first[l + 1], "leaf", "is not rising");
  for (const auto boxes : {tree.leaf_boxes, tree.group_boxes}) {
    bool in_range = true;
    for (const std::int16_t edge : boxes) in_range &= edge >= -kCoordinateMax && edge <= kCoordinateMax;
    in.require(in_range, "leaf.box", "holds an edge out of range");
  }
  return tree;
}

void check_probabilities(SectionReader& in, std::span<const float> table, const char* name) {
  float last = 0;
  for (const float p : table) {
    in.require(p >= last && p <= 1, name, "is not a rising table of probabilities");
    last = p;
  }
}

void check_intervals(SectionReader& in, std::span<const float> interval, std::span<const float> spread,
                     const char* name) {
  for (std::size_t m = 0; m < kMeasurementCount && !in.failed(); ++m) {
    in.require(interval[2 * m] <= interval[2 * m + 1], name, "is turned round");
    in.require(spread[m] >= 0, name, "has a negative spread");
  }
}

void check_weights(SectionReader& in, std::span<const std::int16_t> weights, const char* name) {
  in.require(std::find(weights.begin(), weights.end(), std::int16_t{-32768}) == weights.end(), name,
             "holds a weight out of range");
}

void check_fit(SectionReader& in, const FitLayout& fit, const char* name) {
  in.require(
      within(fit.shapes, 1, kFitMax) && fit.patches <= kFitMax && fit.limbs <= kFitMax && fit.size() <= kFitMax, name,
      "has an impossible fit");
}

// `name` makes the name of a section of its part's.
template <class Name>
ValueMapContents take_map(SectionReader& in, const Name& name, std::size_t values, std::size_t targets) {
  ValueMapContents c;
  c.mean = in.take<std::uint16_t>(name("mean").c_str(), values);
  c.scale = in.take<std::uint16_t>(name("scale").c_str(), values);
  c.weights = in.take<std::int16_t>(name("weights").c_str(), targets * values);
  c.unit = in.take<float>(name("unit").c_str(), targets);
  c.bias = in.take<float>(name("bias").c_str(), targets);
  if (in.failed()) return c;
  in.require(std::all_of(c.mean.begin(), c.mean.end(), [](auto m) { return std::abs(float_of_upper(m)) <= 1e9F; }),
             name("mean").c_str(), "holds a mean out of range");
  in.require(std::all_of(c.scale.begin(), c.scale.end(),
                         [](auto s) { return s == 0 || (float_of_upper(s) >= 1e-30F && float_of_upper(s) <= 1e9F); }),
             name("scale").c_str(), "holds an impossible scale");
  check_weights(in, c.weights, name("weights").c_str());
  return c;
}

ClothingContents take_clothing(SectionReader& in, Refinement view, const MetaRecord& m) {
  const auto name = [&](const char* part) { return clothing_section_of(view, part); };
  ClothingContents c;
  c.record = in.record<ClothingRecord>(name("about").c_str());
  check_fit(in, c.record.fit, name("about").c_str());
  in.require(within(c.record.right_share, 0, 1), name("about").c_str(), "has an impossible share");
  if (in.failed()) return c;
  c.map = take_map(in, name, refined_size(view, m.feature_size, c.record.fit), 1);
  c.table = in.take<float>(name("table").c_str(), kScoreTableSize);
  if (in.failed()) return c;
  check_probabilities(in, c.table, name("table").c_str());
  return c;
}

RefinementContents take_refinement(SectionReader& in, Refinement kind, const MetaRecord& m) {
  const auto name = [&](const char* part) { return section_of(kind, part); };
  RefinementContents c;
  c.record = in.record<RefinementRecord>(name("about").c_str());
  const FitLayout& fit = c.record.fit;
  check_fit(in, fit, name("about").c_str());
  in.require(c.record.interval_kind <= 1, name("about").c_str(), "names an unknown method");
  for (const float share : c.record.share) in.require(within(share, 0, 1), name("about").c_str(), "mixes impossibly");
  in.require(possible(c.record.noise), name("about").c_str(), "has an impossible noise model");
  in.require(c.record.reserved == 0, name("about").c_str(), "has a reserved field that is not 0");
  if (in.failed()) return c;
  c.map = take_map(in, name, refined_size(kind, m.feature_size, fit), kTargetMin);
  c.interval = in.take<float>(name("interval").c_str(), 2 * kMeasurementCount);
  c.spread_floor = in.take<float>(name("spread").c_str(), kMeasurementCount);
  c.sex_table = in.take<float>(name("sex").c_str(), kScoreTableSize);
  if (in.failed()) return c;
  check_intervals(in, c.interval, c.spread_floor, name("interval").c_str());
  check_probabilities(in, c.sex_table, name("sex").c_str());
  return c;
}

void check_values(SectionReader& in, const Contents& c) {
  // Below that (standardise() in index/regression.h) no feature varies.
  for (const float s : c.feature_scale)
    in.require(s == 0 || s >= 1e-30F, "feature.scale", "holds an impossible scale");
  for (const float s : c.target_scale) in.require(s >= 0, "target.scale", "holds a negative scale");
  for (const float s : c.residual_scale) in.require(s >= 0, "residual.scale", "holds a negative scale");
  check_weights(in, c.ridge, "ridge");
  check_intervals(in, c.interval, c.spread_floor, "interval");
  check_probabilities(in, c.sex_table, "sex.table");
  for (const GroupRecord& g : c.groups) {
    in.require(g.first <= c.meta.feature_size && g.count <= c.meta.feature_size - g.first, "groups",
               "names features that do not exist");
    in.require(std::isfinite(g.weight) && std::isfinite(g.error_without), "groups", "holds a number not finite");
  }
}

}  // namespace

LocalData Contents::local_data() const {
  return {&tree, residual, residual_scale, error_map, static_cast<int>(meta.target_count)};
}

Surface Contents::surface() const {
  return {projection, inverse_spread, meta.quadratic != 0 ? quadratic : std::span<const float>{},
          static_cast<int>(meta.target_count), static_cast<int>(meta.dimensions)};
}

std::uint32_t Contents::person_of(std::uint32_t entry) const {
  std::uint32_t number = 0;
  for (std::size_t i = person_bytes; i-- > 0;) number = number << 8 | person[entry * person_bytes + i];
  return number;
}

Position Contents::code_place(std::uint32_t entry) const {
  Position out{};
  for (std::size_t d = 0; d < meta.dimensions; ++d) out[d] = meta.grid_unit * (tree.code(entry, d) * tree.steps[d]);
  return out;
}

Position Contents::error_of(std::uint32_t entry) const {
  Position out{};
  const auto dimensions = static_cast<int>(meta.dimensions);
  for (int d = 0; d < dimensions; ++d)
    out[static_cast<std::size_t>(d)] = static_cast<double>(residual_scale[static_cast<std::size_t>(d)]) *
                                       residual_steps(residual, dimensions, entry, d);
  return out;
}

MeasurementValues Contents::measurements_of_entry(std::uint32_t entry) const {
  Position place = code_place(entry);
  const Position shift = surface().shift_of(surface().targets_at(place)), error = error_of(entry);
  for (std::size_t d = 0; d < meta.dimensions; ++d) place[d] += shift[d] + error[d];
  MeasurementValues out{};
  for (std::size_t m = 0; m < out.size(); ++m) {
    double sum = 0;
    for (std::size_t d = 0; d < meta.dimensions; ++d)
      sum += static_cast<double>(place_map[m * meta.dimensions + d]) * place[d];
    out[m] = static_cast<float>(static_cast<double>(target_mean[m]) + static_cast<double>(target_scale[m]) * sum);
  }
  return out;
}

float probability_at(std::span<const float> table, double score) {
  const double last = static_cast<double>(kScoreTableSize - 1);
  const double place = std::clamp((score + kScoreMax) / (2 * kScoreMax) * last, 0.0, last);
  const auto cell = std::min(static_cast<std::size_t>(place), kScoreTableSize - 2);
  const double part = place - static_cast<double>(cell);
  const auto low = static_cast<double>(table[cell]);
  const auto high = static_cast<double>(table[cell + 1]);
  return static_cast<float>(low + part * (high - low));
}

Result<Contents> parse_contents(std::span<const std::byte> bytes, const std::string& what) {
  auto container = ContainerReader::parse(bytes, kMagic, kVersion, what);
  if (!container) return container.error();
  SectionReader in(*container, what);
  Contents c;
  c.meta = in.record<MetaRecord>("meta");
  if (in.failed()) return in.error();
  check_meta(in, c.meta);
  if (in.failed()) return in.error();
  const MetaRecord& m = c.meta;
  const std::size_t features = m.feature_size;
  const std::size_t targets = m.target_count;
  const std::size_t entries = m.entry_count;
  const auto terms = static_cast<std::size_t>(quadratic_term_count(static_cast<int>(m.dimensions)));
  const auto report = in.take<float>("report", sizeof(ReportRecord) / sizeof(float));
  if (!in.failed()) std::memcpy(static_cast<void*>(&c.report), report.data(), sizeof c.report);
  c.groups = in.take<GroupRecord>("groups", m.group_count);
  c.feature_mean = in.take<float>("feature.mean", features);
  c.feature_scale = in.take<float>("feature.scale", features);
  c.ridge = in.take<std::int16_t>("ridge", targets * features);
  c.ridge_unit = in.take<float>("ridge.unit", targets);
  c.ridge_bias = in.take<float>("ridge.bias", targets);
  c.target_mean = in.take<float>("target.mean", targets);
  c.target_scale = in.take<float>("target.scale", targets);
  c.projection = in.take<float>("projection", m.dimensions * targets);
  c.inverse_spread = in.take<float>("code.spread", m.dimensions);
  c.quadratic = in.take<float>("quadratic", targets * terms);
  c.tree = take_tree(in, m);
  c.residual = in.take_paged<std::uint8_t>("residual", entries * residual_bytes(static_cast<int>(m.dimensions)),
                                           c.residual_pages);
  c.residual_scale = in.take<float>("residual.scale", m.dimensions);
  c.error_map = in.take<float>("error.map", targets * m.dimensions);
  c.place_map = in.take<float>("place.map", targets * m.dimensions);
  if (const auto numbers = container->paged("person"))
    for (const std::size_t bytes : {2, 3})
      if (numbers->bytes().size() == bytes * entries) c.person_bytes = bytes;
  c.person = in.take_paged<std::uint8_t>("person", c.person_bytes * entries, c.person_pages);
  c.age = in.take_paged<std::uint8_t>("age", entries, c.age_pages);
  c.interval = in.take<float>("interval", 2 * kMeasurementCount);
  c.spread_floor = in.take<float>("spread.floor", kMeasurementCount);
  c.sex_table = in.take<float>("sex.table", kScoreTableSize);
  if (in.failed()) return in.error();
  check_values(in, c);
  for (const Refinement kind : kRefinements)
    if (container->section(section_of(kind, "about")))
      c.refinements[static_cast<std::size_t>(kind)] = take_refinement(in, kind, m);
  for (std::size_t v = 0; v < kClothingViews.size(); ++v)
    if (container->section(clothing_section_of(kClothingViews[v], "about")))
      c.clothing[v] = take_clothing(in, kClothingViews[v], m);
  const auto provenance = container->section("provenance");
  if (!provenance) return provenance.error();
  in.require(provenance->size() <= kProvenanceMax, "provenance", "is too long");
  if (in.failed()) return in.error();
  c.provenance = {reinterpret_cast<const char*>(provenance->data()), provenance->size()};
  return c;
}

}  // namespace im2fit::index

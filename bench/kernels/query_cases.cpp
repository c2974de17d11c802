// SPDX-License-Identifier: Apache-2.0
// What an index query does, at the shipped sizes: the whole feature, 16 targets, 12 dimensions, 20,000 points.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bench/kernels/cases.h"
#include "core/rng.h"
#include "index/regression.h"
#include "kernels/code_bounds/code_bounds.h"
#include "kernels/code_distance/code_distance.h"
#include "perception/observe/observe.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {
namespace {

constexpr int kFeatures = kFeatureSize, kTargets = 16, kDimensions = 12, kPoints = 20000, kBoxes = 640;

}  // namespace

void add_standardise_cases(Cases& cases) {
  struct Data {
    std::vector<float> feature, mean, scale;
    std::vector<std::int16_t> out = std::vector<std::int16_t>(kFeatures);
  };
  const auto data = std::make_shared<Data>();
  Rng rng(2);
  for (int i = 0; i < kFeatures; ++i) {
    data->mean.push_back(static_cast<float>(rng.uniform(0, 100)));
    data->scale.push_back(static_cast<float>(rng.uniform(0.01, 1)));
    data->feature.push_back(data->mean.back() + static_cast<float>(rng.normal(0, 2)) / data->scale.back());
  }
  const std::string name = "standardise/" + std::to_string(kFeatures);
  const Floor floor = {kFeatures / 8.0 * 3 / 2 / 2500, "three loads of 8 values, two loads a cycle"};
  add_plain(cases, name, kFeatures, "value", floor, [data] {
    index::standardise(data->feature.data(), data->mean.data(), data->scale.data(), kFeatures, data->out.data());
    keep(data->out[0]);
  });
}

void add_project_cases(Cases& cases) {
  constexpr int kStride = index::row_stride(kFeatures);
  struct Data {
    std::vector<std::int16_t> feature = std::vector<std::int16_t>(kStride);
    std::vector<std::int16_t> weights = std::vector<std::int16_t>(std::size_t{kStride} * kTargets);
  };
  const auto data = std::make_shared<Data>();
  Rng rng(3);
  for (std::int16_t& v : data->feature) v = static_cast<std::int16_t>(rng.index(40961) - 20480);
  for (std::int16_t& v : data->weights) v = static_cast<std::int16_t>(rng.index(65535) - 32767);
  constexpr double kProducts = double{kStride} * kTargets;
  const std::string name = "project/" + std::to_string(kFeatures) + "x16";
  const Floor floor = {kProducts / 16 * 6 / 3 / 2500,
                       "16 products take a load, a multiplication and four operations to add exactly; three a cycle"};
  add_plain(cases, name, kProducts, "product", floor, [data] {
    std::int64_t out[kTargets];
    index::multiply_rows(data->feature.data(), data->weights.data(), kStride, kTargets, out);
    keep(out[0]);
  });
}

namespace {

// All points, as a scan without a tree would. A query of 50,000 entries scans a tenth of them, a leaf at a time.
void add_distance(Cases& cases) {
  constexpr int kBlocks = kPoints / kCodeBlock;
  struct Data {
    std::vector<std::int8_t> blocks = std::vector<std::int8_t>(std::size_t{kPoints} * kDimensions);
    std::vector<std::int32_t> out = std::vector<std::int32_t>(kPoints), least = std::vector<std::int32_t>(kBlocks);
  };
  const auto data = std::make_shared<Data>();
  Rng rng(4);
  for (std::int8_t& c : data->blocks) c = static_cast<std::int8_t>(rng.index(256) - 128);
  std::array<std::int32_t, kDimensions> steps{}, place{};
  for (std::int32_t& s : steps) s = 5 + rng.index(kCodeStepMax - 4);
  for (std::int32_t& p : place) p = rng.index(8000) - 4000;
  const CodeQuery query(steps.data(), place.data(), kDimensions);
  const Floor floor = {
      kBlocks * (kDimensions / 2.0 * 16 + 12) / 3 / 2500,
      "16 points: 16 operations a pair of dimensions, 12 to store and find the least; three a cycle"};
  add_variants(cases, "code_distance/20000x12", kCodeDistanceWithRef, kPoints, "point", floor, true,
               [&](auto* function) {
                 return [data, query, function] {
                   function(data->blocks.data(), kBlocks, query, data->out.data(), data->least.data());
                   keep(data->out[0]);
                 };
               });
}

void add_bounds(Cases& cases) {
  constexpr int kBlocks = kBoxes / kBoxBlock;
  struct Data {
    std::vector<std::int16_t> blocks = std::vector<std::int16_t>(std::size_t{kBoxes} * 2 * kDimensions);
    std::vector<std::int32_t> out = std::vector<std::int32_t>(kBoxes);
  };
  const auto data = std::make_shared<Data>();
  Rng rng(5);
  for (std::size_t i = 0; i < data->blocks.size(); ++i)
    data->blocks[i] = static_cast<std::int16_t>(i / kBoxBlock % 2 == 0 ? rng.index(1 << 13) - (1 << 12)
                                                                       : data->blocks[i - kBoxBlock] + 2000);
  std::array<std::int16_t, kDimensions> place{};
  for (std::int16_t& p : place) p = static_cast<std::int16_t>(rng.index(1 << 13) - (1 << 12));
  const Floor floor = {kBlocks * kDimensions * 13.0 / 3 / 2500, "16 boxes: 13 operations a dimension, three a cycle"};
  add_variants(cases, "code_bounds/640x12", kCodeBoundsWithRef, kBoxes, "box", floor, true, [&](auto* function) {
    return [data, place, function] {
      function(data->blocks.data(), kBlocks, place.data(), kDimensions, data->out.data());
      keep(data->out[0]);
    };
  });
}

}  // namespace

void add_code_cases(Cases& cases) {
  add_distance(cases);
  add_bounds(cases);
}

// The 512 neighbours of a query, 32 rows at a time as index/regression does it.
void add_gram_cases(Cases& cases) {
  using index::kGramWidth;
  constexpr int kRows = 512, kChunk = 32;
  struct Data {
    std::vector<double> rows = std::vector<double>(kRows * kGramWidth), weights = std::vector<double>(kRows);
  };
  const auto data = std::make_shared<Data>();
  Rng rng(8);
  for (std::size_t i = 0; i < data->rows.size(); ++i)
    data->rows[i] = i % kGramWidth < kDimensions ? rng.uniform(-1, 1) : 0.0;
  for (double& w : data->weights) w = rng.uniform();
  constexpr double kVectors = 4 + 4 * (1 + 2 + 3);  // of four sums: those of the columns, then rows of 4, 8, 12
  const Floor floor = {kRows * kVectors * 2 / 2 / 2500, "28 multiplications and additions a row, two a cycle"};
  add_plain(cases, "gram/512x12", kRows, "row", floor, [data] {
    double sums[kGramWidth] = {}, products[kGramWidth * kGramWidth] = {};
    for (int first = 0; first < kRows; first += kChunk)
      index::add_gram(data->rows.data() + first * kGramWidth, data->weights.data() + first, kChunk, kDimensions, sums,
                      products);
    keep(sums[0]);
    keep(products[0]);
  });
}

}  // namespace im2fit::bench

// SPDX-License-Identifier: Apache-2.0
#include "body/params_vector.h"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace im2fit::body {
std::vector<float> pack_params(const Params& params, std::size_t modifier_count) {
  std::vector<float> values = {params.gender,  params.age_years,   params.muscle, params.weight,
                               params.height,  params.proportions, params.cup,    params.firmness,
                               params.race[0], params.race[1],     params.race[2]};
  values.resize(params_vector_size(modifier_count), 0.0F);
  const std::size_t given = std::min(modifier_count, params.modifiers.size());
  std::copy_n(params.modifiers.begin(), given, values.begin() + kMacroParamCount);
  std::copy(params.warp.values.begin(), params.warp.values.end(), values.end() - kWarpCount);
  return values;
}

Params unpack_params(std::span<const float> row) {
  assert(row.size() >= params_vector_size(0));
  Params p;
  float* const macros[] = {&p.gender, &p.age_years, &p.muscle,  &p.weight,  &p.height, &p.proportions,
                           &p.cup,    &p.firmness,  &p.race[0], &p.race[1], &p.race[2]};
  static_assert(std::size(macros) == kMacroParamCount);
  for (std::size_t i = 0; i < kMacroParamCount; ++i) *macros[i] = row[i];
  p.modifiers.assign(row.begin() + kMacroParamCount, row.end() - kWarpCount);
  std::copy(row.end() - kWarpCount, row.end(), p.warp.values.begin());
  return p;
}

}  // namespace im2fit::body

// SPDX-License-Identifier: Apache-2.0
#include "body/params_vector.h"

#include <algorithm>

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

}  // namespace im2fit::body

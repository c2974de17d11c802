// SPDX-License-Identifier: Apache-2.0
#include "body/params_vector.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace im2fit::body {
namespace {

constexpr float kAgeMin = 18;
constexpr float kAgeMax = 90;

float unit(float value) {
  return std::clamp(value, 0.0F, 1.0F);
}

}  // namespace

std::vector<float> pack_params(const Params& params, std::size_t modifier_count) {
  std::vector<float> values = {params.gender,  params.age_years,   params.muscle, params.weight,
                               params.height,  params.proportions, params.cup,    params.firmness,
                               params.race[0], params.race[1],     params.race[2]};
  values.resize(params_vector_size(modifier_count), 0.0F);
  const std::size_t given = std::min(modifier_count, params.modifiers.size());
  std::copy_n(params.modifiers.begin(), given, values.begin() + kMacroParamCount);
  return values;
}

Result<Params> unpack_params(std::span<const float> values, std::size_t modifier_count) {
  if (values.size() != params_vector_size(modifier_count))
    return Error{ErrorCode::corrupt, "body parameters have " + std::to_string(values.size()) +
                                         " values, this body file needs " +
                                         std::to_string(params_vector_size(modifier_count)) +
                                         ": the index was built with another body file"};
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      return Error{ErrorCode::corrupt, "body parameter " + std::to_string(i) + " is not a finite number"};
  Params params;
  params.gender = unit(values[0]);
  params.age_years = std::clamp(values[1], kAgeMin, kAgeMax);
  params.muscle = unit(values[2]);
  params.weight = unit(values[3]);
  params.height = unit(values[4]);
  params.proportions = unit(values[5]);
  params.cup = unit(values[6]);
  params.firmness = unit(values[7]);
  const float african = unit(values[8]);
  const float asian = unit(values[9]);
  const float caucasian = unit(values[10]);
  const float sum = african + asian + caucasian;
  if (sum > 0) params.race = {african / sum, asian / sum, caucasian / sum};
  params.modifiers.assign(values.begin() + kMacroParamCount, values.end());
  return params;
}

}  // namespace im2fit::body

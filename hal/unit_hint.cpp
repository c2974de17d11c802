// SPDX-License-Identifier: Apache-2.0
// Of depth_diagnosis.h what programs alone call: a file of its own, so that the device library does not hold it.
#include "hal/depth_diagnosis.h"

namespace im2fit::hal {
namespace {

std::string number(float value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

DepthDiagnosis read_in_unit(DepthDiagnosis diagnosis, double unit_mm) {
  constexpr std::string_view kOption = "--unit ";
  const std::size_t at = diagnosis.text.find(kOption);
  if (unit_mm == 1 || !(diagnosis.unit_mm > 0) || at == std::string::npos) return diagnosis;
  diagnosis.unit_mm *= static_cast<float>(unit_mm);
  diagnosis.text = "read in units of " + number(static_cast<float>(unit_mm)) + " mm, the " +
                   diagnosis.text.substr(0, at) + std::string(kOption) + number(diagnosis.unit_mm);
  return diagnosis;
}

}  // namespace im2fit::hal

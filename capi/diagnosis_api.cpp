// SPDX-License-Identifier: Apache-2.0
// im2fit_diagnose.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <string_view>

#include "capi/call.h"
#include "engine/diagnosis.h"

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;
using im2fit::hal::DiagnosisCode;

static_assert(IM2FIT_DIAGNOSIS_UNIT == static_cast<int>(DiagnosisCode::unit));
static_assert(IM2FIT_DIAGNOSIS_FIELD_OF_VIEW == static_cast<int>(DiagnosisCode::field_of_view));
static_assert(IM2FIT_DIAGNOSIS_FIELD_OF_VIEW + 1 == im2fit::hal::kDiagnosisNames.size());

im2fit_diagnosis to_c(const im2fit::hal::DepthDiagnosis& found) {
  im2fit_diagnosis out{};
  out.code = static_cast<std::int32_t>(found.code);
  out.rotate_deg = found.rotate_deg;
  out.unit_mm = found.unit_mm;
  const std::size_t length = std::min(found.text.size(), sizeof out.text - 1);
  std::memcpy(out.text, found.text.data(), length);
  return out;
}

}  // namespace

extern "C" {

int im2fit_diagnose(im2fit_handle* handle, const uint16_t* depth_mm, int32_t width, int32_t height, size_t stride,
                    im2fit_diagnosis* diagnosis, size_t struct_size) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (depth_mm == nullptr || diagnosis == nullptr)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  depth_mm == nullptr ? "the frame is NULL" : "the place for the diagnosis is NULL");
    const im2fit::Intrinsics& k = h.origin.intrinsics;
    if (width != k.width || height != k.height)
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  "the frame is " + std::to_string(width) + "x" + std::to_string(height) + ", the settings say " +
                      std::to_string(k.width) + "x" + std::to_string(k.height));
    if (stride != 0 && (stride < static_cast<std::size_t>(width) || stride > 1U << 24))
      return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT,
                  "the stride is less than the width (it counts values, not bytes)");
    const im2fit::DepthView depth(depth_mm, width, height, stride == 0 ? width : static_cast<int>(stride));
    const im2fit::JointModel* model = h.data.tracker != nullptr ? &h.data.tracker->model() : nullptr;
    const im2fit_diagnosis found = to_c(im2fit::diagnose(depth, k, model));
    std::memcpy(diagnosis, &found, std::min(struct_size, sizeof found));
    if (struct_size > sizeof found)
      std::memset(reinterpret_cast<char*>(diagnosis) + sizeof found, 0, struct_size - sizeof found);
    return static_cast<int>(IM2FIT_OK);
  });
}

const char* im2fit_diagnosis_name(int code) {
  if (code < 0 || code >= static_cast<int>(im2fit::hal::kDiagnosisNames.size())) return nullptr;
  return im2fit::hal::kDiagnosisNames[static_cast<std::size_t>(code)].data();
}

}  // extern "C"

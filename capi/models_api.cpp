// SPDX-License-Identifier: Apache-2.0
// im2fit_get_models: what a handle was opened with.
#include <algorithm>
#include <cstddef>
#include <cstring>

#include "capi/call.h"

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;
using im2fit::index::Refinement;

static_assert(sizeof(im2fit_models) >= offsetof(im2fit_models, site_corrected) + sizeof(std::int32_t));

bool has(const im2fit::index::Info& info, Refinement kind) {
  return info.refined[static_cast<std::size_t>(kind)].sample_count > 0;
}

im2fit_models models_of(const im2fit::MeasuringData& data) {
  im2fit_models models{};
  models.made_by = "";
  if (data.tracker != nullptr) models.tracker_key = data.tracker->model().key();
  if (data.index != nullptr) {
    const im2fit::index::Info& info = data.index->info();
    const bool shapes = data.fits_shapes();
    models.made_by = info.provenance.c_str();
    models.people = info.subject_count;
    models.captures = info.entry_count;
    models.answers_shape = shapes ? 1 : 0;
    models.answers_turned = shapes && has(info, Refinement::turned) ? 1 : 0;
    models.answers_clothed = shapes && data.index->knows_clothed() ? 1 : 0;
  }
  models.has_body = data.body_model != nullptr ? 1 : 0;
  models.site_corrected = data.site != nullptr ? 1 : 0;
  return models;
}

}  // namespace

extern "C" int im2fit_get_models(im2fit_handle* handle, im2fit_models* models, size_t struct_size) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (models == nullptr) return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the models is NULL");
    const im2fit_models known = models_of(h.data);
    std::memcpy(models, &known, std::min(struct_size, sizeof known));
    if (struct_size > sizeof known)
      std::memset(reinterpret_cast<char*>(models) + sizeof known, 0, struct_size - sizeof known);
    return static_cast<int>(IM2FIT_OK);
  });
}

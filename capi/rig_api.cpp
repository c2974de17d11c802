// SPDX-License-Identifier: Apache-2.0
// im2fit_live_rig: the avatar moves as the person does.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include "body/model.h"
#include "capi/call.h"
#include "capi/person.h"
#if IM2FIT_HAVE_RESULT
#include "body/export/figure.h"
#include "body/export/motion.h"
#endif

namespace {

using im2fit::c::fail;
using im2fit::c::guarded;

static_assert(IM2FIT_RIG_NODE_COUNT == im2fit::body::kSegmentCount);
static_assert(sizeof(im2fit_rig) == offsetof(im2fit_rig, joints_inferred) + sizeof(std::uint32_t));

#if IM2FIT_HAVE_RESULT

bool finite(const im2fit::JointSet& joints) {
  return std::all_of(joints.position_mm.begin(), joints.position_mm.end(),
                     [](im2fit::Vec3f p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); });
}

im2fit::Status make_skeleton(im2fit_handle& h, const im2fit::AnsweredBody& body) {
  const auto figure = im2fit::body::make_figure({h.data.body_model.get(), body.params, body.pose});
  if (!figure) return figure.error();
  h.skeleton = {figure->skeleton, figure->floor_rest};
  return im2fit::Ok{};
}

im2fit_rig to_c(const im2fit::body::RigPose& pose, const im2fit::EngineResult& now) {
  im2fit_rig rig{};
  rig.root_m[0] = pose.root_m.x;
  rig.root_m[1] = pose.root_m.y;
  rig.root_m[2] = pose.root_m.z;
  for (std::size_t s = 0; s < pose.rotation.size(); ++s)
    std::copy(pose.rotation[s].begin(), pose.rotation[s].end(), rig.rotations[s]);
  rig.user_id = now.user;
  rig.joints_inferred = now.joints_inferred;
  return rig;
}

#endif

}  // namespace

extern "C" {

int im2fit_live_rig(im2fit_handle* handle, im2fit_rig* rig, size_t struct_size) {
  return guarded(handle, [&](im2fit_handle& h) {
    if (rig == nullptr) return fail(&h, IM2FIT_ERROR_INVALID_ARGUMENT, "the place for the rig is NULL");
#if IM2FIT_HAVE_RESULT
    if (h.data.body_model == nullptr) return im2fit::c::no_body(h);
    return im2fit::c::with_person(h, [&](const im2fit::PersonMeasurement& person) {
      if (!h.skeleton)
        if (const auto made = make_skeleton(h, *person.body); !made) return fail(&h, made.error());
      const im2fit::EngineResult now = h.engine->result();
      if (!now.has_joints || !finite(now.display_joints))
        return fail(&h, IM2FIT_ERROR_NOT_FOUND, "no person is followed in the latest frame");
      const im2fit_rig known = to_c(im2fit::body::rig_of_joints(h.skeleton->rest, h.skeleton->floor_mm,
                                                                im2fit::to_mesh_axes(now.display_joints, now.floor)),
                                    now);
      std::memcpy(rig, &known, std::min(struct_size, sizeof known));
      if (struct_size > sizeof known)
        std::memset(reinterpret_cast<char*>(rig) + sizeof known, 0, struct_size - sizeof known);
      return static_cast<int>(IM2FIT_OK);
    });
#else
    static_cast<void>(struct_size);
    return im2fit::c::without_result(h);
#endif
  });
}

const char* im2fit_rig_node_name(int node) {
  return node >= 0 && node < IM2FIT_RIG_NODE_COUNT
             ? im2fit::body::kSegmentNames[static_cast<std::size_t>(node)].data()  // literals, ended by a zero byte
             : nullptr;
}

int im2fit_rig_node_parent(int node) {
  return node >= 0 && node < IM2FIT_RIG_NODE_COUNT ? im2fit::body::kSegmentParent[static_cast<std::size_t>(node)]
                                                   : -1;
}

}  // extern "C"

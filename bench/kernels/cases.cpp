// SPDX-License-Identifier: Apache-2.0
#include "bench/kernels/cases.h"

namespace im2fit::bench {

void add_fpfh_cases(Cases& cases);
void add_normals_cases(Cases& cases);
void add_gram_cases(Cases& cases);
void add_joints_cases(Cases& cases);
void add_blend_cases(Cases& cases);
void add_skin_cases(Cases& cases);
void add_standardise_cases(Cases& cases);
void add_project_cases(Cases& cases);
void add_code_cases(Cases& cases);
void add_sample_cases(Cases& cases);
void add_silhouette_cases(Cases& cases);
void add_membership_cases(Cases& cases);
void add_fuse_cases(Cases& cases);
void add_segment_cases(Cases& cases);
void add_unpack11_cases(Cases& cases);
void add_undistort_cases(Cases& cases);
void add_contour_cases(Cases& cases);
void add_height_cases(Cases& cases);
void add_section_cases(Cases& cases);
void add_moments_cases(Cases& cases);
void add_geodesic_cases(Cases& cases);

namespace {

struct Topic {
  const char* name;  // what its cases' names begin with
  void (*add)(Cases& cases);
};
// One line a topic, so that several people can add theirs.
constexpr Topic kTopics[] = {
    {"fpfh", add_fpfh_cases},
    {"normals", add_normals_cases},
    {"gram", add_gram_cases},
    {"joints", add_joints_cases},
    {"blend", add_blend_cases},
    {"skin", add_skin_cases},
    {"standardise", add_standardise_cases},
    {"project", add_project_cases},
    {"code", add_code_cases},
    {"sample", add_sample_cases},
    {"silhouette", add_silhouette_cases},
    {"membership", add_membership_cases},
    {"fuse", add_fuse_cases},
    {"segment", add_segment_cases},
    {"unpack11", add_unpack11_cases},
    {"undistort", add_undistort_cases},
    {"contour", add_contour_cases},
    {"height", add_height_cases},
    {"section", add_section_cases},
    {"moments", add_moments_cases},
    {"geodesic", add_geodesic_cases},
};

constexpr CaseList kLists[] = {
    {"kernels", kernel_cases},
    {"frame", frame_cases},
    {"growth", growth_cases},
#ifdef IM2FIT_BENCH_CLOTH
    {"cloth", cloth_cases},
#endif
};

}  // namespace

const CaseList* case_list(std::string_view name) {
  for (const CaseList& list : kLists) {
    if (list.name == name) return &list;
  }
  return nullptr;
}

std::string case_list_names() {
  std::string names;
  for (const CaseList& list : kLists) names += (names.empty() ? "" : ", ") + std::string(list.name);
  return names;
}

Cases kernel_cases(std::string_view only) {
  Cases cases;
  for (const Topic& topic : kTopics) {
    if (only.empty() || only.starts_with(topic.name)) topic.add(cases);
  }
  // A case whose file goes by another name.
  return cases.empty() && !only.empty() ? kernel_cases({}) : cases;
}

}  // namespace im2fit::bench

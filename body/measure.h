// SPDX-License-Identifier: Apache-2.0
// Measurements of a mesh by the definitions of DESIGN section 3: the truth of every evaluation.
#pragma once

#include <span>
#include <vector>

#include "body/model.h"
#include "kernels/core/measurement.h"

namespace im2fit::body {

// Morphs, poses relaxed (arm spread by girth) and measures. Weight from the rest pose's volume.
// Density 1010..985 kg/m^3 falls with body mass index: see density_kg_m3.
MeasurementValues measure_person(const BodyModel& model, const Params& params);
// The same on an already morphed rest mesh.
MeasurementValues measure_rest_mesh(const BodyModel& model, std::span<const Vec3f> rest_vertices, float gender);

// Closed-mesh volume (signed tetrahedra), litres.
double volume_litres(const BodyModel& model, std::span<const Vec3f> vertices);
double density_kg_m3(double stature_mm, double volume_l);
double stature_mm(const BodyModel& model, std::span<const Vec3f> vertices);

// The level sections behind the girths (mesh axes, mm), for drawing: hull polygons in order.
struct Section {
  Measurement id;
  std::vector<Vec3f> hull;
};
std::vector<Section> girth_sections(const BodyModel& model, std::span<const Vec3f> relaxed_vertices, float gender);

// Sets params.height and params.weight (then the fatness strength of facts/makehuman.md) so that the rest mesh has
// this stature and mass. False when out of reach (params then hold the nearest).
bool solve_stature_and_weight(const BodyModel& model, Params& params, double stature_mm, double weight_kg);

}  // namespace im2fit::body

// SPDX-License-Identifier: Apache-2.0
// Measurements of a mesh by the definitions of ISO 8559-1 (core/measurement.h): the truth of every evaluation.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "body/model.h"
#include "body/skeleton.h"
#include "core/measurement.h"

namespace im2fit::body {

// Morphs, poses relaxed (arm spread by girth) and measures. Weight from the rest pose's volume.
// Density 1025..1000 kg/m^3 falls with body mass index: see density_kg_m3.
MeasurementValues measure_person(const BodyModel& model, const Params& params);
// The same on an already morphed rest mesh.
MeasurementValues measure_rest_mesh(const BodyModel& model, std::span<const Vec3f> rest_vertices, float gender);

// A section behind a girth (mesh axes, mm): its hull, a polygon in order.
struct Section {
  Measurement id;
  std::vector<Vec3f> hull;
};

// The same, many times: no allocation after construction. Not shareable between threads; the model must outlive it.
class Measurer {
 public:
  explicit Measurer(const BodyModel& model);
  Measurer(Measurer&&) noexcept;
  Measurer& operator=(Measurer&&) noexcept;
  ~Measurer();
  MeasurementValues measure(const Params& params);
  MeasurementValues measure_rest_mesh(std::span<const Vec3f> rest_vertices, float gender);
  // Of the mesh measured last: its values, its bones as they rest, all vertices and the bones in the relaxed pose,
  // and the sections of the five girths.
  const MeasurementValues& values() const;
  const Skeleton& rest_bones() const;
  std::span<const Vec3f> posed() const;
  // All vertices at rest, of the last measure(); measure_rest_mesh() leaves them.
  std::span<const Vec3f> rest() const;
  const PosedSkeleton& bones() const;
  std::span<const Section> sections() const;
  // Of the same mesh: how much chest, waist and hip girth grow with the height they are taken at, mm a mm, from 20 mm
  // below to 20 mm above.
  struct Slopes {
    double chest = 0, waist = 0, hip = 0;
  };
  Slopes girth_slopes() const;
  // The chest girth of the mesh measured last, `rest_vertices`, with the arms so far off the body, taken so much
  // higher than at the nipples. posed() has the arms there afterwards.
  double chest_girth_mm(std::span<const Vec3f> rest_vertices, float arms_off_deg, float raised_mm);

 private:
  struct Work;
  const BodyModel* model_;
  std::unique_ptr<Work> work_;
};

// Closed-mesh volume (signed tetrahedra), litres.
double volume_litres(const BodyModel& model, std::span<const Vec3f> vertices);
// So that bodies with the dimensions of ANSUR II's people weigh what those do (docs/makehuman.md).
inline constexpr double kLeanDensityKgM3 = 1025;
inline constexpr double kObeseDensityKgM3 = 1000;
inline constexpr double kLeanIndex = 18;  // litres per square metre of stature; density falls linearly between these
inline constexpr double kObeseIndex = 42;
double density_kg_m3(double stature_mm, double volume_l);
double stature_mm(const BodyModel& model, std::span<const Vec3f> vertices);
// From the crotch to the floor, of a mesh that stands.
float inside_leg_mm(const BodyModel& model, std::span<const Vec3f> vertices);

// The smallest section square to the neck's axis, of a posed mesh.
double neck_girth_mm(const BodyModel& model, std::span<const Vec3f> posed_vertices);

// Arm abduction of the relaxed pose for this build: 10 (slim) to 22 degrees (obese).
float relaxed_spread_deg(const BodyModel& model, std::span<const Vec3f> rest_vertices);

// Of a posed mesh, as Measurer::sections().
std::vector<Section> girth_sections(const BodyModel& model, std::span<const Vec3f> relaxed_vertices, float gender);

}  // namespace im2fit::body

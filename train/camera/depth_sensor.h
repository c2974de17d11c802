// SPDX-License-Identifier: Apache-2.0
// What a depth sensor makes of an ideal view. Two kinds: structured light (Kinect for Xbox 360) and time of flight
// (after Kinect v2 and Azure Kinect).
//
// Structured light. Everything happens in disparity, where the sensor works: raw = A - C/z with one raw unit = one
// step of the 11-bit output (2.894e-6/mm in 1/z: 11.6 mm at 2 m, Khoshelham 2012).
//  - Axial noise: Nguyen 2012, sigma = 1.2 + 1.9 (z - 0.4)^2 mm, plus 0.1/sqrt(z) t^2/(pi/2 - t)^2 mm at incidence
//    t (z in m). The published spread was measured on the quantised output, so the quantiser's own variance
//    (1/12 step^2) is taken off before it is added again by rounding. Half of the variance is shared by patches of
//    4 px (at 640 wide): the sensor matches windows, so neighbouring pixels err together.
//  - Lateral noise: within 2 px of a depth step the value of a displaced pixel is delivered, sd 0.8 + 0.035
//    t/(pi/2 - t) px at 640 wide.
//  - Shadow: no data where the projector, 75 mm along +u, is hidden by something nearer.
//  - Holes: grazing surfaces, far surfaces, single pixels, small blobs, dark hair in patches.
//
// Time of flight. No disparity steps, no projector's shadow, millimetres from 0.4 to 5 m.
//  - Axial noise: sigma = 2.0 + 0.3 z^2 + 0.1 z^1.5 t^2/(pi/2 - t)^2 mm (z in m): growth with distance and incidence
//    in the form Fankhauser 2015 ("Kinect v2 for mobile robot navigation: evaluation and modeling") fitted to
//    Kinect v2; the base of 2 mm stands for its 1.5 - 0.5 z, since cloth and skin answer less than a white target.
//    Stays below Azure Kinect's stated 17 mm random error. A quarter of the variance is shared by patches.
//  - Flying pixels: beside a depth step, 45 % of the pixels see both surfaces and deliver a depth up to halfway
//    between, even over the mixture; 15 % are given up as invalid.
//  - Multipath: light from the other wall lengthens the light path in the room's concave corners: up to +20 mm in the
//  corner,
//    fading within about 100 mm at 2.5 m.
//  - Holes: grazing surfaces (from 70 degrees), dark hair in patches, single pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/rng.h"
#include "core/sensor_kind.h"
#include "train/render/raster.h"
#include "train/render/raw_row.h"

namespace im2fit::lab {

inline constexpr float kKinectFocalPx = 575.8F;  // depth camera, 640 px wide (not 525: that is registered depth)
inline constexpr float kProjectorBaselineMm = 75;
inline constexpr float kMixedMm = 50;  // flying pixels further than this off their surface belong to no person
inline constexpr int kPatchMaxPx = 4;  // side of a noise patch at 640 wide; 2 at 320
inline constexpr double kRawStepPerMm = 0.1042 / 4 / 9000;  // of 1/z: pixel 0.1042 mm, zero plane 1200 mm, 7.5 cm

struct SensorOptions {
  bool noise = true;     // axial and lateral; false: exact depth rounded to mm (or to the raw step, see quantise)
  bool quantise = true;  // 11-bit raw steps; structured light only
  bool shadow = true;
  bool holes = true;
  float range_min_mm = 500;  // nearer or farther: no data
  float range_max_mm = 5000;
  float depth_scale = 1;   // a device's own scale error: delivered = true * depth_scale (up to +-0.3 % is usual)
  int box_margin_px = -1;  // >= 0: only the person's box and this margin are made, the rest of the frame is 0
  SensorKind kind = SensorKind::structured_light;

  bool operator==(const SensorOptions&) const = default;
};
SensorOptions kinect_sensor();
SensorOptions tof_sensor();
SensorOptions exact_sensor();  // no noise, no quantisation, no range limits

// z in mm of a raw 11-bit value, unrounded; raw < kRawInfinity.
double raw_to_mm(int raw);
// Nguyen's axial spread, mm, at z mm and incidence cosine 0..1 (capped at 87 degrees).
double axial_sigma_mm(double z_mm, double cosine);
// Time of flight's axial spread, same units and cap.
double tof_sigma_mm(double z_mm, double cosine);

// Not shareable between threads. No allocation after construction.
class DepthSensor {
 public:
  DepthSensor(const SensorOptions& options, const Intrinsics& intrinsics);
  // Becomes DepthSensor(options, the same intrinsics); cheap when only the depth scale differs.
  void change(const SensorOptions& options);

  // Shadow and edges of the view's rows box.v0 .. v1 (whole rows: a shadow's cause may lie outside the box).
  void prepare(const CleanView& view, const PixelBox& box);
  // One frame of the prepared view, pixels of `box` only: depends on seed, frame and the view, not on the box.
  // `person` (same size, may be null): 255 - who where the pixel is a person's (label_of), 127 - who where it is but
  // the depth delivered is a mixture, more than kMixedMm off the surface; else 0.
  void expose(const CleanView& view, const PixelBox& box, std::uint64_t seed, std::uint64_t frame, DepthImage out,
              std::uint8_t* person);

 private:
  struct Tables {
    std::vector<float> sigma_raw;           // by raw: axial spread head-on, raw units
    std::vector<float> graze_raw;           // by raw: raw units per mm sqrt(m) of grazing noise
    std::vector<float> graze;               // by cosine byte: 0.1 t^2/(pi/2 - t)^2
    std::vector<float> lateral_px;          // by cosine byte
    std::vector<std::uint16_t> mm;          // by raw, 0 out of range, and of kRawCount
    std::vector<std::int32_t> lost_by_raw;  // chance of no data, of 65536
    std::vector<std::int32_t> lost_by_cosine;
  };
  struct Sample {
    float inverse_depth = 0;
    std::uint8_t cosine = 0;
    std::uint8_t label = 0;
    bool mixed = false;  // by more than kMixedMm
  };
  void shadow_rows(const CleanView& view, int v0, int v1);
  void edge_rows(const CleanView& view, int v0, int v1);
  void bias_rows(const CleanView& view, int v0, int v1);
  void make_buffers();
  void make_tables();
  void scale_depth(float depth_scale);
  // A row of the current frame: pixels u0 .. u1 of row v; `row` seeds its draws.
  struct RowOfFrame {
    int v, u0, u1;
    std::uint64_t row, seed, frame;
  };
  bool in_steps() const { return options_.quantise && options_.kind == SensorKind::structured_light; }
  void expect_rows(const CleanView& view, int v0, int v1);
  static void lattice_row(std::uint64_t seed, std::uint64_t frame, int cell, std::vector<float>& out);
  void patch_row(std::uint64_t seed, std::uint64_t frame, int v);
  void expose_steps(const CleanView& view, const RowOfFrame& where, std::uint16_t* pixels, std::uint8_t* person);
  void expose_smooth(const CleanView& view, const RowOfFrame& where, std::uint16_t* pixels, std::uint8_t* person);
  void displace(const CleanView& view, const RowOfFrame& where);
  std::size_t displaced(const CleanView& view, int u, int v, std::uint64_t bits) const;
  Sample flying(const CleanView& view, int u, int v, std::uint64_t bits) const;
  std::uint16_t deliver(const Sample& sample, float noise, std::int32_t chance) const;
  bool hair_lost(std::uint64_t seed, std::uint64_t frame, int u, int v) const;
  void punch_blobs(const PixelBox& box, std::uint64_t seed, std::uint64_t frame, DepthImage out,
                   std::uint8_t* person) const;

  SensorOptions options_;
  Intrinsics k_;
  int patch_px_;       // side of a noise patch
  float pixel_scale_;  // width of a 640-wide camera's pixel in ours
  Tables tables_;
  std::vector<float> source_;       // inverse depth after the shadow, or with multipath
  std::vector<std::uint8_t> edge_;  // 1 within 2 px of a depth step
  std::vector<std::uint8_t> step_;
  // Patch noise: two rows of the lattice and what lies between them, row of the frame.
  std::vector<float> lattice_low_, lattice_row_low_, lattice_row_high_, patch_;
  int lattice_cell_ = -1;  // whose rows those are, of the current frame
  // In steps: what noise does not change, by pixel.
  std::vector<float> exact_, sigma_;
  std::vector<std::int32_t> lost_, step_row_;
  // A row's pixels beside a depth step.
  struct Beside {
    std::size_t count = 0;
    std::vector<std::int32_t> u, from;  // column; the pixel whose value it delivers
    std::vector<std::uint64_t> bits;    // its draw
    std::vector<float> sigma;           // of its displacement, px
  };
  Beside beside_;
  RawRowFunction* raw_row_ = fastest_raw_row();
};

// What depth_sensor.cpp and depth_sensor_frame.cpp share.
// 1/z = (7.5 - m)/9000, m = ((raw - 800)/4 - 0.375) 0.1042: the formula of the device's own driver.
inline constexpr double kRawAtInfinity = 7.5 / 0.1042 * 4 + 800 + 1.5;
inline constexpr float kRawPerInverseMm = static_cast<float>(1 / kRawStepPerMm);
inline constexpr float kDepthStep = 0.02F;  // relative: a jump of 40 mm at 2 m is an edge
inline constexpr int kEdgeReachPx = 2;

}  // namespace im2fit::lab

// SPDX-License-Identifier: Apache-2.0
#include "perception/profile/row_scan.h"

#include <algorithm>
#include <cstdlib>

namespace im2fit::profile {
namespace {

// The first set bit from `from` on of words first(0), first(1), ...; `end` where there is none before it.
template <class WordAt>
int next_bit(WordAt word_at, int from, int end) {
  for (int word = from / 64; 64 * word < end; ++word) {
    std::uint64_t bits = word_at(word);
    if (word == from / 64) bits &= ~std::uint64_t{0} << (from % 64);
    if (bits != 0) return std::min(end, 64 * word + __builtin_ctzll(bits));
  }
  return end;
}

template <std::size_t kCount>
Line<kCount> line_of(const PersonFrame& frame, const std::array<Vec3f, kCount>& joints) {
  Line<kCount> line;
  for (std::size_t i = 0; i < kCount; ++i) {
    line.height_mm[i] = frame.height(joints[i]);
    line.side_mm[i] = frame.side(joints[i]);
  }
  return line;
}

}  // namespace

void Scene::set_axes() {
  using enum Joint;
  height = {k, frame.up, frame.camera_height_mm};
  side = {k, frame.right, -dot(frame.right, frame.origin_mm)};
  toward = {k, frame.toward, -dot(frame.toward, frame.origin_mm)};
  spine = line_of<3>(frame, {joint(NE), joint(TO), (joint(LH) + joint(RH)) * 0.5F});
  left_arm = line_of<3>(frame, {joint(LS), joint(LE), joint(LA)});
  right_arm = line_of<3>(frame, {joint(RS), joint(RE), joint(RA)});
  left_leg = line_of<3>(frame, {joint(LH), joint(LK), joint(LF)});
  right_leg = line_of<3>(frame, {joint(RH), joint(RK), joint(RF)});
  head = line_of<2>(frame, {joint(HE), joint(NE)});
}

void find_runs(const Scene& s, int v, const std::uint64_t* seen, const std::uint64_t* steps, Row& row) {
  row.v = v;
  row.depth = s.depth.row(v);
  row.mask = s.mask.row(v);
  row.width = s.mask.width;
  row.height = s.height.row(v);
  row.side = s.side.row(v);
  row.toward = s.toward.row(v);
  row.run_count = 0;
  const auto pixels = [&](int word) { return seen[word]; };
  const auto breaks = [&](int word) { return ~seen[word] | steps[word]; };
  for (int begin = next_bit(pixels, 0, row.width); begin < row.width;) {
    const int end = next_bit(breaks, begin + 1, row.width) - 1;
    Run* last = row.run_count > 0 ? &row.runs[static_cast<std::size_t>(row.run_count - 1)] : nullptr;
    // A step between neighbours is found again here: it does not join them.
    if (last != nullptr && begin - last->end <= kGapPx + 1 &&
        std::abs(row.depth[begin] - row.depth[last->end]) < kContourStepQ4) {
      last->end = end;
    } else {
      if (row.run_count == static_cast<int>(row.runs.size())) break;
      row.runs[static_cast<std::size_t>(row.run_count++)] = {begin, end};
    }
    begin = next_bit(pixels, end + 1, row.width);
  }
  for (int i = 0; i < row.run_count; ++i) {
    Run& run = row.runs[static_cast<std::size_t>(i)];
    run.begin_side_mm = row.side.at(static_cast<float>(run.begin) - 0.5F, row.z(run.begin));
    run.end_side_mm = row.side.at(static_cast<float>(run.end) + 0.5F, row.z(run.end));
  }
}

float z_near(const Row& row, int u) {
  for (int d = 0; d <= kGapPx; ++d) {
    if (u - d >= 0 && row.z(u - d) > 0) return row.z(u - d);
    if (u + d < row.width && row.z(u + d) > 0) return row.z(u + d);
  }
  return 0;
}

float side_of_edge(const Row& row, float u_edge, int u_inside) {
  return row.side.at(u_edge, z_near(row, u_inside));
}

const Run* run_at(const Row& row, float side) {
  const Run* best = nullptr;
  float best_gap = 60.0F;  // farther than this from every run: there is none
  for (int i = 0; i < row.run_count; ++i) {
    const Run& r = row.runs[static_cast<std::size_t>(i)];
    const float gap = side < r.begin_side_mm ? r.begin_side_mm - side
                      : side > r.end_side_mm ? side - r.end_side_mm
                                             : 0.0F;
    if (gap < best_gap) {
      best_gap = gap;
      best = &r;
    }
  }
  return best;
}

float relief_at(const Row& row, float u, const Run& run) {
  const int c = static_cast<int>(u + 0.5F);
  float sum = 0;
  int n = 0;
  for (int x = std::max(run.begin, c - 2); x <= std::min(run.end, c + 2); ++x) {
    const float z = row.z(x);
    if (z <= 0) continue;
    sum += row.toward.at(static_cast<float>(x), z);
    ++n;
  }
  return n > 0 ? sum / static_cast<float>(n) : kNaN;
}

// The column depends on the depth there, so it is looked up twice.
float relief_at_side(const Row& row, float side, float z_mm, const Run& run) {
  const auto clamped = [&](float u) {
    return std::clamp(u, static_cast<float>(run.begin), static_cast<float>(run.end));
  };
  const float u = clamped(row.side.column(side, z_mm));
  const float z = z_near(row, static_cast<int>(u + 0.5F));
  return relief_at(row, z > 0 ? clamped(row.side.column(side, z)) : u, run);
}

}  // namespace im2fit::profile

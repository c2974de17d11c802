// SPDX-License-Identifier: Apache-2.0
// Four pairs at a time: the arithmetic of fpfh_lane.h in its order.
//
// AArch64 does all of it. ARMv7's NEON has no division, no square root, and takes denormals for zeros. There the two
// lengths are approximated (two Newton steps: 22 bits), bins are read off with a margin, and a pair within the margin
// of an edge is left aside for the scalar unit: the same bins again. Clouds with coordinates so small that a denormal
// could decide anything go to portable as a whole.
#include <arm_neon.h>

#include "kernels/fpfh/fpfh_blocks.h"
#include "kernels/fpfh/fpfh_constants.h"

namespace im2fit {
namespace {

using fpfh_detail::kCountBytes;
using fpfh_detail::kIncrements;
using fpfh_detail::kNoPair;
using fpfh_detail::PairTask;

constexpr int kLanes = 4;
constexpr int kBlocksUntilOverflow = fpfh_detail::kLanesUntilOverflow / kLanes;

struct Source {
  float32x4_t x, y, z, nx, ny, nz;
};

float32x4_t dot(float32x4_t ax, float32x4_t ay, float32x4_t az, float32x4_t bx, float32x4_t by, float32x4_t bz) {
  return vaddq_f32(vaddq_f32(vmulq_f32(ax, bx), vmulq_f32(ay, by)), vmulq_f32(az, bz));
}

uint32x4_t greater(float32x4_t a, float32x4_t b) {
#ifdef __aarch64__
  return vcgtq_f32(a, b);
#else
  uint32x4_t out;  // GCC 12 would compare lane by lane in the scalar unit, for the sake of denormals
  asm("vcgt.f32 %q0, %q1, %q2" : "=w"(out) : "w"(a), "w"(b));
  return out;
#endif
}

bool any(uint32x4_t lanes) {
#ifdef __aarch64__
  return vmaxvq_u32(lanes) != 0;
#else
  const uint32x2_t both = vorr_u32(vget_low_u32(lanes), vget_high_u32(lanes));
  return vget_lane_u64(vreinterpret_u64_u32(both), 0) != 0;
#endif
}

// The line and the normals of four pairs, in terms of fpfh_lane.h.
struct Terms {
  float32x4_t d2, c, triple, size1, size2, source, target, s;
};

Terms terms_of(const Source& p, float32x4_t dx, float32x4_t dy, float32x4_t dz, float32x4_t d2, float32x4_t mx,
               float32x4_t my, float32x4_t mz) {
  Terms t;
  t.d2 = d2;
  const float32x4_t along1 = dot(p.nx, p.ny, p.nz, dx, dy, dz);
  const float32x4_t along2 = dot(mx, my, mz, dx, dy, dz);
  t.c = dot(p.nx, p.ny, p.nz, mx, my, mz);
  const float32x4_t vx = vsubq_f32(vmulq_f32(dy, p.nz), vmulq_f32(dz, p.ny));
  const float32x4_t vy = vsubq_f32(vmulq_f32(dz, p.nx), vmulq_f32(dx, p.nz));
  const float32x4_t vz = vsubq_f32(vmulq_f32(dx, p.ny), vmulq_f32(dy, p.nx));
  t.triple = dot(vx, vy, vz, mx, my, mz);
  t.size1 = vabsq_f32(along1);
  t.size2 = vabsq_f32(along2);
  const uint32x4_t swap = greater(t.size2, t.size1);
  t.source = vbslq_f32(swap, vnegq_f32(along2), along1);
  t.target = vbslq_f32(swap, vnegq_f32(along1), along2);
  t.s = vsubq_f32(d2, vmulq_f32(t.source, t.source));
  return t;
}

// kVectorConstants.lanes, to be multiplied by lane.
struct Constants {
  float32x4_t a, b, c;
};
Constants load_constants() {
  const float* lanes = fpfh_detail::kVectorConstants.lanes;
  return {vld1q_f32(lanes), vld1q_f32(lanes + 4), vld1q_f32(lanes + 8)};
}
template <int kIndex>
float32x4_t times(float32x4_t v, const Constants& k) {
  const float32x4_t of = kIndex < 4 ? k.a : kIndex < 8 ? k.b : k.c;
#ifdef __aarch64__
  return vmulq_laneq_f32(v, of, kIndex % 4);
#else
  return vmulq_lane_f32(v, kIndex % 4 < 2 ? vget_low_f32(of) : vget_high_f32(of), kIndex % 2);
#endif
}
constexpr int kParallel = 11;

struct Pairs {
  int32x4_t codes;
  uint32x4_t sound;  // lanes whose code holds
};

#ifdef __aarch64__

constexpr int kTie = 10;

// 11 (f + 1) / 2 as an integer in 0..10; NaN gives 0.
int32x4_t clamped(float32x4_t f) {
  const float32x4_t half = vdupq_n_f32(5.5F);
  const float32x4_t position = vaddq_f32(vmulq_f32(f, half), half);
  return vcvtq_s32_f32(vminnmq_f32(vmaxnmq_f32(position, vdupq_n_f32(0.0F)), vdupq_n_f32(10.0F)));
}

Pairs pairs_of(const Terms& t, const Constants& k) {
  const float32x4_t v_length = vsqrtq_f32(vmaxnmq_f32(t.s, vdupq_n_f32(0.0F)));
  const float32x4_t d_length = vsqrtq_f32(t.d2);
  const float32x4_t inverse = vdivq_f32(vdupq_n_f32(1.0F), vmulq_f32(v_length, d_length));
  const int32x4_t b2 = clamped(vmulq_f32(vmulq_f32(t.triple, d_length), inverse));
  const int32x4_t b3 = clamped(vmulq_f32(vmulq_f32(t.source, v_length), inverse));
  const float32x4_t wt = vsubq_f32(t.target, vmulq_f32(t.source, t.c));
  const float32x4_t across = vabsq_f32(wt), cl = vmulq_f32(t.c, v_length);
  // Minus the number of edges passed. a - b > 0 where a > b: floats underflow gradually.
  uint32x4_t passed = greater(times<0>(across, k), times<5>(cl, k));
  passed = vaddq_u32(passed, greater(times<1>(across, k), times<6>(cl, k)));
  passed = vaddq_u32(passed, greater(times<2>(across, k), times<7>(cl, k)));
  passed = vaddq_u32(passed, greater(times<3>(across, k), times<8>(cl, k)));
  passed = vaddq_u32(passed, greater(times<4>(across, k), times<9>(cl, k)));
  const uint32x4_t below = vcltzq_f32(wt);
  // b1 = 5 + passed, or 5 - passed where w.target is below zero.
  const int32x4_t minus = vreinterpretq_s32_u32(vsubq_u32(veorq_u32(passed, below), below));
  Pairs out;
  const uint32x4_t apart = greater(vabdq_f32(t.size1, t.size2), times<kTie>(d_length, k));
  out.sound = vandq_u32(apart, greater(t.s, times<kParallel>(t.d2, k)));
  constexpr int kStride = kFpfhBins * kFpfhBins;
  const int32x4_t places =
      vmlsq_n_s32(vmlaq_n_s32(vaddq_s32(b3, vdupq_n_s32(5 * kStride)), b2, kFpfhBins), minus, kStride);
  out.codes = vshlq_n_s32(places, 5);
  return out;
}

constexpr bool denormals_could_decide(const OrganisedCloud&) {
  return false;
}

#else

// Margins: the approximated roots are within 1e-6 of themselves, portable's own rounding within as much; bins' edges
// are kept clear of by ten times that and more.
constexpr float kEdgeMargin = 2e-5F;      // of the sizes compared at f1's edges
constexpr float kPositionMargin = 4e-4F;  // of positions 0..11
constexpr float kTieMargin = 1e-3F;       // of the tie
// Clouds pass denormals_could_decide: coordinates are zero or at least 1e-8 m, so their differences are zero or at
// least 2^-24 of that, and products of two and three stay above 1e-35 unless sums cancel to less than these bounds.
constexpr float kTinySquared = 1e-18F;
constexpr float kTinyAcross = 1e-24F;

float32x4_t inverse_root(float32x4_t a) {
  float32x4_t r = vrsqrteq_f32(a);
  r = vmulq_f32(r, vrsqrtsq_f32(vmulq_f32(a, r), r));
  r = vmulq_f32(r, vrsqrtsq_f32(vmulq_f32(a, r), r));
  return r;
}

// As above; lanes too near an edge leave `sound`.
int32x4_t clamped(float32x4_t f, uint32x4_t& sound) {
  const float32x4_t half = vdupq_n_f32(5.5F);
  const float32x4_t position = vmaxq_f32(vaddq_f32(vmulq_f32(f, half), half), vdupq_n_f32(0.0F));
  const int32x4_t bin = vcvtq_s32_f32(position);
  const float32x4_t from_middle = vsubq_f32(vsubq_f32(position, vcvtq_f32_s32(bin)), vdupq_n_f32(0.5F));
  sound = vandq_u32(sound, vcaltq_f32(from_middle, vdupq_n_f32(0.5F - kPositionMargin)));
  return vminq_s32(bin, vdupq_n_s32(kFpfhBins - 1));
}

Pairs pairs_of(const Terms& t, const Constants& k) {
  Pairs out;
  out.sound = greater(t.d2, vdupq_n_f32(kTinySquared));
  out.sound = vandq_u32(out.sound, greater(t.s, times<kParallel>(t.d2, k)));
  const float32x4_t inverse_v = inverse_root(t.s), inverse_d = inverse_root(t.d2);
  const float32x4_t v_length = vmulq_f32(t.s, inverse_v), d_length = vmulq_f32(t.d2, inverse_d);
  const float32x4_t apart = vabdq_f32(t.size1, t.size2);
  out.sound =
      vandq_u32(out.sound, greater(apart, vmulq_n_f32(d_length, fpfh_detail::kNearTie * (1.0F + kTieMargin))));
  const int32x4_t b2 = clamped(vmulq_f32(t.triple, inverse_v), out.sound);
  const int32x4_t b3 = clamped(vmulq_f32(t.source, inverse_d), out.sound);
  const float32x4_t wt = vsubq_f32(t.target, vmulq_f32(t.source, t.c));
  const float32x4_t across = vabsq_f32(wt), cl = vmulq_f32(t.c, v_length);
  out.sound = vandq_u32(out.sound, greater(across, vdupq_n_f32(kTinyAcross)));
  const float32x4_t margin = vmulq_n_f32(vaddq_f32(across, vabsq_f32(cl)), kEdgeMargin);
  uint32x4_t passed = vdupq_n_u32(0);
  const auto edge = [&](float32x4_t along_cosine, float32x4_t along_sine) {
    const float32x4_t over = vsubq_f32(along_cosine, along_sine);
    passed = vaddq_u32(passed, greater(over, vdupq_n_f32(0.0F)));
    out.sound = vandq_u32(out.sound, vcagtq_f32(over, margin));
  };
  edge(times<0>(across, k), times<5>(cl, k));
  edge(times<1>(across, k), times<6>(cl, k));
  edge(times<2>(across, k), times<7>(cl, k));
  edge(times<3>(across, k), times<8>(cl, k));
  edge(times<4>(across, k), times<9>(cl, k));
  const uint32x4_t below = greater(vdupq_n_f32(0.0F), wt);
  const int32x4_t minus = vreinterpretq_s32_u32(vsubq_u32(veorq_u32(passed, below), below));
  constexpr int kStride = kFpfhBins * kFpfhBins;
  const int32x4_t places =
      vmlsq_n_s32(vmlaq_n_s32(vaddq_s32(b3, vdupq_n_s32(5 * kStride)), b2, kFpfhBins), minus, kStride);
  out.codes = vshlq_n_s32(places, 5);
  return out;
}

bool denormals_could_decide(const OrganisedCloud& cloud) {
  const int count = cloud.intrinsics.width * cloud.intrinsics.height;
  const uint32x4_t one = vdupq_n_u32(1);
  uint32x4_t tiny = vdupq_n_u32(0);
  const auto look = [&](const float* values, float least) {
    int i = 0;
    for (; i + 4 <= count; i += 4) {
      // As integers, because the comparison of floats would take the tiniest for zero: 0 < |bits| < bits of `least`.
      const uint32x4_t bits = vshlq_n_u32(vreinterpretq_u32_f32(vld1q_f32(values + i)), 1);
      const uint32x4_t bound = vshlq_n_u32(vreinterpretq_u32_f32(vdupq_n_f32(least)), 1);
      tiny = vorrq_u32(tiny, vcltq_u32(vsubq_u32(bits, one), vsubq_u32(bound, one)));
    }
    for (; i < count; ++i) {
      const float size = values[i] < 0.0F ? -values[i] : values[i];
      if (size > 0.0F && size < least) tiny = one;
    }
  };
  for (const float* values : {cloud.x, cloud.y, cloud.z}) look(values, 1e-5F);  // mm
  for (const float* values : {cloud.nx, cloud.ny, cloud.nz}) look(values, 1e-9F);
  return any(tiny);
}

#endif

void add_bytes(uint8x16_t bytes, std::int32_t* counts) {
  alignas(16) std::uint8_t values[16];
  vst1q_u8(values, bytes);
  for (int b = 0; b < 16; ++b) counts[b] += values[b];
}

// Adds one pair to its candidate's bytes and to the source's.
inline void count_pair(std::uint32_t code, std::uint8_t* bytes, uint8x16_t& own_low, uint8x16_t& own_high) {
  const std::uint8_t* entry = kIncrements.bytes + code;
#ifdef __aarch64__
  const uint8x16x2_t one = vld1q_u8_x2(entry);
#else
  const uint8x16x2_t one = {{vld1q_u8(entry), vld1q_u8(entry + 16)}};
#endif
  own_low = vaddq_u8(own_low, one.val[0]);
  own_high = vaddq_u8(own_high, one.val[1]);
  vst1q_u8(bytes, vaddq_u8(vld1q_u8(bytes), one.val[0]));
  vst1q_u8(bytes + 16, vaddq_u8(vld1q_u8(bytes + 16), one.val[1]));
}

struct Lanes {
  std::uint32_t marked[kLanes];
};
Lanes spread(uint32x4_t lanes) {
  Lanes out;
  vst1q_u32(out.marked, lanes);
  return out;
}

// Returns the new length of the list.
int leave_aside(std::int32_t* list, int count, int j, uint32x4_t lanes) {
  const Lanes aside = spread(lanes);
  for (int t = 0; t < kLanes; ++t) {
    list[count] = j + t;
    count += aside.marked[t] != 0 ? 1 : 0;
  }
  return count;
}

// Lanes within the radius that someone needs.
uint32x4_t lanes_inside(const PairTask& task, int j, float32x4_t d2, float32x4_t radius_squared) {
  const uint32x4_t inside = greater(radius_squared, d2);
  if (task.source_needed) return inside;
  const std::uint8_t* needed = task.needed + j;
  const std::uint32_t wanted[kLanes] = {needed[0], needed[1], needed[2], needed[3]};
  return vandq_u32(inside, vcgtq_u32(vld1q_u32(wanted), vdupq_n_u32(0)));
}

// Adds four pairs to their candidates' bytes and to the source's.
void count_codes(uint32x4_t codes, std::uint8_t* bytes, uint8x16_t& own_low, uint8x16_t& own_high) {
  count_pair(vgetq_lane_u32(codes, 0), bytes, own_low, own_high);
  count_pair(vgetq_lane_u32(codes, 1), bytes + kCountBytes, own_low, own_high);
  count_pair(vgetq_lane_u32(codes, 2), bytes + 2 * kCountBytes, own_low, own_high);
  count_pair(vgetq_lane_u32(codes, 3), bytes + 3 * kCountBytes, own_low, own_high);
}

#ifdef __aarch64__
// The source has a normal, the candidates of some lanes have none. Returns those lanes.
uint32x4_t count_blank_candidates(std::int32_t* own, std::int32_t* others, uint32x4_t lanes, const float* nx,
                                  const Source& p, float32x4_t dx, float32x4_t dy, float32x4_t dz, float32x4_t d2) {
  const float32x4_t m = vld1q_f32(nx);
  const uint32x4_t blank = vandq_u32(vbicq_u32(lanes, vceqq_f32(m, m)), vcgtzq_f32(d2));
  std::int32_t f3[kLanes];
  vst1q_s32(f3, clamped(vdivq_f32(dot(p.nx, p.ny, p.nz, dx, dy, dz), vsqrtq_f32(d2))));
  const Lanes counted = spread(blank);
  for (int t = 0; t < kLanes; ++t) {
    if (counted.marked[t] == 0) continue;
    std::int32_t* other = others + t * kFpfhSize;
    ++own[0], ++own[kFpfhBins], ++own[2 * kFpfhBins + f3[t]];
    ++other[0], ++other[kFpfhBins], ++other[2 * kFpfhBins];
  }
  return blank;
}
#else
// f3 needs a division: the scalar unit's.
uint32x4_t count_blank_candidates(std::int32_t*, std::int32_t*, uint32x4_t, const float*, const Source&, float32x4_t,
                                  float32x4_t, float32x4_t, float32x4_t) {
  return vdupq_n_u32(0);
}
#endif

// Bytes are written that may be anyone's: what a loop needs of the task is copied first, or it would be read again.
void count_pairs(PairTask& shared_task) {
  PairTask task = shared_task;
  const Constants constants = load_constants();
  const float32x4_t radius_squared = vdupq_n_f32(task.radius_squared);
  const int i = task.source;
  const Source p = {vdupq_n_f32(task.x[i]),  vdupq_n_f32(task.y[i]),  vdupq_n_f32(task.z[i]),
                    vdupq_n_f32(task.nx[i]), vdupq_n_f32(task.ny[i]), vdupq_n_f32(task.nz[i])};
  std::int32_t* const own_counts = task.counts + static_cast<long>(i) * kFpfhSize;
  uint8x16_t own_low = vdupq_n_u8(0), own_high = vdupq_n_u8(0);
  int blocks = 0;
  for (int r = 0; r < task.range_count; ++r) {
    const int end = task.ranges[2 * r + 1];
    for (int j = task.ranges[2 * r]; j < end; j += kLanes) {
      const float32x4_t dx = vsubq_f32(vld1q_f32(task.x + j), p.x);
      const float32x4_t dy = vsubq_f32(vld1q_f32(task.y + j), p.y);
      const float32x4_t dz = vsubq_f32(vld1q_f32(task.z + j), p.z);
      const float32x4_t d2 = dot(dx, dy, dz, dx, dy, dz);
      const uint32x4_t inside = lanes_inside(task, j, d2, radius_squared);
      if (!any(inside)) continue;
      const Pairs pairs = pairs_of(
          terms_of(p, dx, dy, dz, d2, vld1q_f32(task.nx + j), vld1q_f32(task.ny + j), vld1q_f32(task.nz + j)),
          constants);
      // A missing normal is NaN, which is not sound.
      const uint32x4_t unsound = vbicq_u32(inside, pairs.sound);
      if (any(unsound)) {
        const uint32x4_t blank = count_blank_candidates(own_counts, task.counts + static_cast<long>(j) * kFpfhSize,
                                                        unsound, task.nx + j, p, dx, dy, dz, d2);
        task.aside_count = leave_aside(task.aside_list, task.aside_count, j, vbicq_u32(unsound, blank));
      }
      const uint32x4_t codes =
          vbslq_u32(vandq_u32(inside, pairs.sound), vreinterpretq_u32_s32(pairs.codes), vdupq_n_u32(kNoPair));
      count_codes(codes, task.count_bytes + static_cast<long>(j) * kCountBytes, own_low, own_high);
      if (++blocks == kBlocksUntilOverflow) {
        add_bytes(own_low, own_counts);
        add_bytes(own_high, own_counts + 16);
        own_low = own_high = vdupq_n_u8(0);
        blocks = 0;
      }
    }
  }
  add_bytes(own_low, own_counts);
  add_bytes(own_high, own_counts + 16);
  shared_task.aside_count = task.aside_count;
}

// Few points have no normal: their pairs are left to the scalar unit.
void count_blank_pairs(PairTask& shared_task) {
  PairTask task = shared_task;
  const float32x4_t radius_squared = vdupq_n_f32(task.radius_squared);
  const int i = task.source;
  for (int r = 0; r < task.range_count; ++r) {
    const int end = task.ranges[2 * r + 1];
    for (int j = task.ranges[2 * r]; j < end; j += kLanes) {
      const float32x4_t dx = vsubq_f32(vld1q_f32(task.x + j), vdupq_n_f32(task.x[i]));
      const float32x4_t dy = vsubq_f32(vld1q_f32(task.y + j), vdupq_n_f32(task.y[i]));
      const float32x4_t dz = vsubq_f32(vld1q_f32(task.z + j), vdupq_n_f32(task.z[i]));
      const uint32x4_t inside = lanes_inside(task, j, dot(dx, dy, dz, dx, dy, dz), radius_squared);
      if (any(inside)) task.aside_count = leave_aside(task.aside_list, task.aside_count, j, inside);
    }
  }
  shared_task.aside_count = task.aside_count;
}

}  // namespace

void fpfh_neon(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
               std::span<float> out) {
  if (denormals_could_decide(cloud)) {
    fpfh_portable(cloud, keypoints, radius_mm, work, out);
    return;
  }
  fpfh_detail::fpfh_in_blocks(cloud, keypoints, radius_mm, work, out, {count_pairs, count_blank_pairs});
}

}  // namespace im2fit

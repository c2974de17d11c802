// SPDX-License-Identifier: Apache-2.0
#include "kernels/section/section.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/kernels/ray_picture.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

constexpr std::int32_t kSlopeOne = 1 << FormSlope::kFractionBits;

// The cuts must outlive the scan.
SectionScan scan_of(const test::RayPicture& p, const std::vector<SectionCut>& cuts) {
  return {p.depths(),     p.masks(),         p.columns0.data(), p.rows0.data(), p.columns1.data(),
          p.rows1.data(), p.columns2.data(), p.rows2.data(),    cuts.data(),    static_cast<int>(cuts.size())};
}

struct Lists {
  int capacity;
  checkasm::Buffer<SectionPoint> points;
  checkasm::Buffer<int> counts;
  Lists(const SectionScan& scan, int capacity_, checkasm::Guard guard)
      : capacity(capacity_),
        points(static_cast<std::size_t>(scan.cut_count * (capacity_ + kSectionSlack)), guard),
        counts(static_cast<std::size_t>(scan.cut_count), guard) {}
  const SectionPoint* list(int cut) const { return points.data() + cut * (capacity + kSectionSlack); }
};

// Returns how many points there were.
int compare_tiers(const SectionScan& scan, int capacity, checkasm::Trial& trial) {
  const checkasm::Guard guard = trial.next_end();
  Lists want(scan, capacity, guard);
  section_portable(scan, want.points.data(), capacity, want.counts.data());
  checkasm::each_simd(kSectionKernels, [&](const auto& variant) {
    Lists got(scan, capacity, guard);
    variant.function(scan, got.points.data(), capacity, got.counts.data());
    checkasm::expect_same_bits(want.counts, got.counts);
    if (testing::Test::HasFailure()) return;
    for (int cut = 0; cut < scan.cut_count; ++cut) {
      for (int i = 0; i < want.counts[static_cast<std::size_t>(cut)]; ++i) {
        ASSERT_EQ(want.list(cut)[i].x, got.list(cut)[i].x) << "cut " << cut << ", point " << i;
        ASSERT_EQ(want.list(cut)[i].y, got.list(cut)[i].y) << "cut " << cut << ", point " << i;
      }
    }
  });
  int total = 0;
  for (const int count : want.counts.span()) total += count;
  return total;
}

TEST(Section, TiersAgree) {
  checkasm::Trial trial;
  int total = 0;
  for (const int width : checkasm::odd_sizes(80)) {
    IM2FIT_CHECK_PARAMETERS(trial, width);
    const test::RayPicture p(width, 6, kSlopeOne / 12, 28000, 34000, trial);
    std::vector<SectionCut> cuts(1 + trial.rng().index(kSectionCountMax));
    for (SectionCut& cut : cuts)
      cut = {trial.biased(-100000, 100000), trial.biased(-300000, 300000), trial.biased(-300000, 300000)};
    total += compare_tiers(scan_of(p, cuts), 6 * width, trial);
    // Lists that end in the midst of eight pixels.
    compare_tiers(scan_of(p, cuts), static_cast<int>(trial.rng().index(12)), trial);
    if (HasFailure()) return;
  }
  EXPECT_GT(total, 1000);
}

// The largest tables, depths and centres the contract allows; and points and centres about the coordinates' limits.
TEST(Section, TiersAgreeAtTheExtremes) {
  checkasm::Trial trial;
  int total = 0;
  for (int turn = 0; turn < 60; ++turn) {
    IM2FIT_CHECK_PARAMETERS(trial, turn);
    const test::RayPicture wild(37, 3, kSlopeOne / 8 * 23, 1, 65535, trial);
    const std::int32_t far = kFormOffsetMax / 2;
    compare_tiers(scan_of(wild, {{trial.biased(-far, far), trial.biased(-far, far), trial.biased(-far, far)}}), 111,
                  trial);
    // All depths 2048 mm, slopes to +-2^-4: along, x, y within 128 mm of 0; centres 512 mm off in x and y.
    const test::RayPicture tight(64, 3, kSlopeOne / 32, 32768, 32768, trial);
    const std::int32_t limit = 512 << 10;
    total +=
        compare_tiers(scan_of(tight, {{0, turn % 2 == 0 ? limit : -limit, trial.biased(-90000, 90000)},
                                      {0, trial.biased(-90000, 90000), turn % 3 == 0 ? limit : -limit},
                                      {trial.biased(-kSectionOffMax, kSectionOffMax), limit - 60000, limit - 60000}}),
                      192, trial);
    if (HasFailure()) return;
  }
  EXPECT_GT(total, 1000);
}

// The corner of the square, just inside the wedge: the largest squares compared. 99 off^2 < 16 (x^2 + y^2) with
// |x| = |y| = 4095 holds up to |off| = 2328 of 1/32 mm.
TEST(Section, LargestSquares) {
  for (const int off : {2328, 2329, -2328, -2329}) {
    const std::uint16_t depth = 16 * 1024;  // z = 2^20 raw: a slope of 2^8 is 1/1024 mm
    const std::uint8_t mask = 255;
    const std::int32_t along = off * 32 * 256, corner = 4095 * 128 * 256, zero = 0;
    const SectionCut cut = {0, 0, 0};
    const std::int32_t other = -corner;
    const SectionScan scan = {{&depth, 1, 1}, {&mask, 1, 1}, &along, &zero, &corner, &zero, &other, &zero, &cut, 1};
    for (const auto& variant : kSectionWithRef) {
      if (!tier_available(variant.tier)) continue;
      std::vector<SectionPoint> points(1 + kSectionSlack);
      int count = -1;
      variant.function(scan, points.data(), 1, &count);
      ASSERT_EQ(count, std::abs(off) == 2328 ? 1 : 0) << variant.name << ' ' << off;
      if (count == 0) continue;
      EXPECT_EQ(points[0].x, 4095);
      EXPECT_EQ(points[0].y, -4095);
    }
  }
}

// An upright round column before a level camera, cut square: every point of the section lies on the circle.
class Column {
 public:
  static constexpr double kRadius = 150, kDistance = 2000;
  Column() : rays_(kWidth, kHeight), along_(kWidth, kHeight), x_(kWidth, kHeight), y_(kWidth, kHeight) {
    rays_.set({kWidth, kHeight, 300, 300, 119.5F, 89.5F});
    along_.set(rays_, {0, 1, 0});
    x_.set(rays_, {-1, 0, 0});
    y_.set(rays_, {0, 0, 1});
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const double tx = (u - 119.5) / 300, a = 1 + tx * tx;
        const double root = kDistance * kDistance - a * (kDistance * kDistance - kRadius * kRadius);
        const double z = root > 0 ? (kDistance - std::sqrt(root)) / a : 0;
        depth_.push_back(static_cast<std::uint16_t>(std::lround(z * 16)));
        mask_.push_back(root > 0 ? 255 : 0);
        // Within a tenth of the distance from the centre (0, height_mm, kDistance), with 0.3 mm to spare either way.
        const double off = std::fabs((v - 89.5) / 300 * z - kCutMm);
        const double distance = std::sqrt(off * off + kRadius * kRadius);
        if (root > 0 && 10 * off < distance - 0.3) ++surely_in_;
        if (root > 0 && 10 * off < distance + 0.3) ++perhaps_in_;
      }
    }
  }
  SectionScan scan() const {
    return {{depth_.data(), kWidth, kHeight},
            {mask_.data(), kWidth, kHeight},
            along_.columns(),
            along_.rows(),
            x_.columns(),
            x_.rows(),
            y_.columns(),
            y_.rows(),
            &cut_,
            1};
  }
  int surely_in() const { return surely_in_; }
  int perhaps_in() const { return perhaps_in_; }

 private:
  static constexpr int kWidth = 240, kHeight = 180;
  static constexpr double kCutMm = 120;
  RayTable rays_;
  RayForm along_, x_, y_;
  SectionCut cut_ = {form_offset(kCutMm), 0, form_offset(kDistance)};
  std::vector<std::uint16_t> depth_;
  std::vector<std::uint8_t> mask_;
  int surely_in_ = 0, perhaps_in_ = 0;
};

TEST(Section, PointsOfAColumnLieOnItsCircle) {
  const Column column;
  ASSERT_GT(column.surely_in(), 100);
  for (const auto& variant : kSectionWithRef) {
    if (!tier_available(variant.tier)) continue;
    std::vector<SectionPoint> points(5000 + kSectionSlack);
    int count = 0;
    variant.function(column.scan(), points.data(), 5000, &count);
    EXPECT_GE(count, column.surely_in()) << variant.name;
    EXPECT_LE(count, column.perhaps_in()) << variant.name;
    for (int i = 0; i < count; ++i) {
      const SectionPoint p = points[static_cast<std::size_t>(i)];
      // Depth to 1/32 mm, coordinates to 1/16 mm. Near the silhouette the depth's rounding moves the point along the
      // ray, which is the circle's tangent there.
      EXPECT_NEAR(std::hypot(p.x / 8.0, p.y / 8.0), Column::kRadius, 0.13) << variant.name << ' ' << i;
      EXPECT_LT(p.y, 0);
    }
  }
}

// ref works in double on the same tables: lists differ by border points only.
TEST(Section, PortableAgreesWithRef) {
  checkasm::Trial trial;
  const test::RayPicture p(160, 40, kSlopeOne / 12, 28000, 34000, trial);
  const std::vector<SectionCut> cuts = {{10000, -50000, 1000000}, {-60000, 30000, 2000000}};
  const SectionScan scan = scan_of(p, cuts);
  Lists ref(scan, 6400, checkasm::Guard::after), got(scan, 6400, checkasm::Guard::after);
  section_ref(scan, ref.points.data(), 6400, ref.counts.data());
  section_portable(scan, got.points.data(), 6400, got.counts.data());
  for (int cut = 0; cut < 2; ++cut) {
    const int in_ref = ref.counts[static_cast<std::size_t>(cut)], in_got = got.counts[static_cast<std::size_t>(cut)];
    EXPECT_NEAR(in_got, in_ref, 2 + 0.03 * in_ref);
    // Each of ours has one of ref's within one unit, a few border points apart.
    int missing = 0;
    for (int i = 0; i < in_got; ++i) {
      const SectionPoint a = got.list(cut)[i];
      missing += std::none_of(ref.list(cut), ref.list(cut) + in_ref,
                              [a](SectionPoint b) { return std::abs(a.x - b.x) <= 1 && std::abs(a.y - b.y) <= 1; });
    }
    EXPECT_LE(missing, 2 + 0.03 * in_got);
  }
}

}  // namespace
}  // namespace im2fit

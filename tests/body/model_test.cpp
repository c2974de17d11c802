// SPDX-License-Identifier: Apache-2.0
#include "body/model.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <new>

#include "allocations.h"
#include "body/measure.h"
#include "body/model_data.h"
#include "body/skeleton.h"
#include "body_pack.h"
#include "core/container.h"
#include "core/rng.h"
#include "fake_shape_space.h"

namespace {
std::size_t allocation_count = 0;
}

std::size_t im2fit::body::allocations_so_far() {
  return allocation_count;
}

// Not inlined: GCC would warn of malloc and delete meeting in one function.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocation_count;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocation_count;
  return std::malloc(size > 0 ? size : 1);
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace im2fit::body {
namespace {

Params person(float gender, float height) {
  Params p;
  p.gender = gender;
  p.height = height;
  return p;
}

TEST(RealBody, StatureAtTheEndsAndMiddleOfTheHeightSlider) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  // docs/makehuman.md: 136.4 / 173.0 / 245.4 cm for men, 122.3 / 159.0 / 231.2 cm for women.
  const std::array<std::array<double, 3>, 2> expected = {{{1223, 1590, 2312}, {1364, 1730, 2454}}};
  for (std::size_t g = 0; g < 2; ++g)
    for (std::size_t h = 0; h < 3; ++h)
      EXPECT_NEAR(stature_mm(model, mesh_of(model, person(static_cast<float>(g), static_cast<float>(h) / 2))),
                  expected[g][h], 1);
}

TEST(RealBody, StatureDoesNotDependOnAgesBrokenHeightTargets) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  for (const float age : {25.0F, 57.0F, 90.0F})
    for (const float muscle : {0.0F, 1.0F})
      for (const float weight : {0.0F, 1.0F}) {
        Params low = person(1, 0), high = person(1, 1);
        low.age_years = high.age_years = age;
        low.muscle = high.muscle = muscle;
        low.weight = high.weight = weight;
        const auto a = mesh_of(model, low), b = mesh_of(model, high);
        // The same head lift for all: how far the crown moves from the lowest to the highest slider.
        EXPECT_NEAR(stature_mm(model, b) - stature_mm(model, a), 2454 - 1364, 2.5) << age << muscle << weight;
      }
}

TEST(RealBody, BaseIsMirrorSymmetric) {
  IM2FIT_NEEDS_BODY();
  const auto base = real_body()->data().base.first(kBodyVertexCount);
  std::map<std::array<long, 3>, int> cells;
  const auto key = [](float x, float y, float z) {
    return std::array<long, 3>{std::lround(x * 20), std::lround(y * 20), std::lround(z * 20)};
  };
  for (const Vec3f& v : base) ++cells[key(v.x, v.y, v.z)];
  int lonely = 0;
  for (const Vec3f& v : base) {
    bool found = false;
    for (int d = 0; d < 27 && !found; ++d) {
      auto k = key(-v.x, v.y, v.z);
      k[0] += d % 3 - 1;
      k[1] += d / 3 % 3 - 1;
      k[2] += d / 9 - 1;
      found = cells.contains(k);
    }
    lonely += found ? 0 : 1;
  }
  EXPECT_EQ(lonely, 0);
}

TEST(RealBody, MeshIsAClosedConsistentlyOrientedManifold) {
  IM2FIT_NEEDS_BODY();
  std::map<std::pair<int, int>, int> edges;
  for (const auto& t : real_body()->body_triangles())
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first})) << edge.first << "-" << edge.second;
  }
}

// Area of the level section from the oriented crossings (Green's theorem), summed over slices.
double sliced_litres(const BodyModel& model, std::span<const Vec3f> v, double step_mm) {
  double litres = 0;
  float low = 1e9F, high = -1e9F;
  for (const Vec3f& p : v.first(kBodyVertexCount)) {
    low = std::min(low, p.y);
    high = std::max(high, p.y);
  }
  for (double y = static_cast<double>(low) + step_mm / 2; y < static_cast<double>(high); y += step_mm) {
    double area = 0;
    for (const auto& t : model.body_triangles()) {
      std::array<std::array<double, 2>, 2> ends{};
      int found = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3f a = v[static_cast<std::size_t>(t[i])], b = v[static_cast<std::size_t>(t[(i + 1) % 3])];
        const bool up = static_cast<double>(a.y) < y && static_cast<double>(b.y) >= y;
        const bool down = static_cast<double>(a.y) >= y && static_cast<double>(b.y) < y;
        if (!up && !down) continue;
        const double s = (y - static_cast<double>(a.y)) / (static_cast<double>(b.y) - static_cast<double>(a.y));
        // An outward triangle is crossed from its rising edge to its falling one, clockwise seen from above.
        ends[up ? 0 : 1] = {static_cast<double>(a.x) + s * (static_cast<double>(b.x) - static_cast<double>(a.x)),
                            static_cast<double>(a.z) + s * (static_cast<double>(b.z) - static_cast<double>(a.z))};
        ++found;
      }
      if (found == 2) area += 0.5 * (ends[0][0] * ends[1][1] - ends[1][0] * ends[0][1]);
    }
    litres += std::fabs(area) * step_mm * 1e-6;
  }
  return litres;
}

TEST(RealBody, VolumeMatchesTheSumOfItsSlices) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params p = person(0.2F, 0.6F);
  p.weight = 0.8F;
  p.age_years = 60;
  const auto mesh = mesh_of(model, p);
  const double litres = volume_litres(model, mesh);
  EXPECT_NEAR(litres, sliced_litres(model, mesh, 2), 0.001 * litres);
}

TEST(RealBody, SlidersOutOfRangeOrNotANumberGiveAFiniteBody) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Params p;
  p.gender = p.muscle = p.height = p.age_years = nan;
  p.weight = 7;
  p.race = {nan, -1, 0};
  p.modifiers = {nan, 1e9F, -1e9F};
  for (const Vec3f& v : mesh_of(model, p)) ASSERT_LT(norm(v), 5000.0F);
}

TEST(RealBody, MovesBetweenTwoPeopleAreTheDifferencesOfTheirMeshes) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params a = person(1, 0.4F), b = person(1, 0.7F);
  b.weight = 0.8F;
  b.modifiers.assign(model.modifier_names().size(), 0.0F);
  b.modifiers[3] = -0.5F;
  const auto from = mesh_of(model, a), to = mesh_of(model, b);
  // The mesh of one; from it half of the step, begun at zero; the whole step, begun at the other's mesh.
  std::vector<Vec3f> mesh(from.size()), half(from.size()), whole = from;
  const std::array<BodyModel::BodyMove, BodyModel::kBodyMovesMax> moves = {
      {{nullptr, &b, 1, mesh}, {&a, &b, 0.5F, half}, {&a, &b, 1, whole}}};
  model.move_bodies(moves);
  float moved_mm = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model.body_vertex_count()); ++i) {
    ASSERT_TRUE(std::memcmp(&mesh[i], &to[i], sizeof(Vec3f)) == 0) << i;
    ASSERT_LT(norm(half[i] - (to[i] - from[i]) * 0.5F), 2e-3F) << i;
    ASSERT_LT(norm(whole[i] - to[i]), 2e-3F) << i;
    moved_mm = std::max(moved_mm, norm(to[i] - from[i]));
  }
  EXPECT_GT(moved_mm, 100);
}

TEST(RealBody, MorphAndSkinDoNotAllocate) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params p = person(0.4F, 0.55F);
  p.modifiers.assign(model.modifier_names().size(), 0.1F);
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count())), posed(rest.size());
  const std::size_t before = allocation_count;
  model.morph(p, rest);
  const Skeleton skeleton = rest_skeleton(model, rest);
  const Pose pose = psi_pose(skeleton);
  skin(model, rest, skeleton, pose, posed);
  const JointSet joints = joints_of(model, posed);
  const Pose again = pose_from_joints(skeleton, joints);
  skin(model, rest, skeleton, again, posed);
  EXPECT_EQ(allocation_count, before);
}

class BodyFile : public testing::Test {
 protected:
  static const std::vector<std::byte>& good() {
    static const std::vector<std::byte> bytes = fake_body_file();
    return bytes;
  }
  static std::string error_of(std::vector<std::byte> bytes) {
    const auto model = BodyModel::parse(std::move(bytes), "people.i2b");
    return model ? "" : model.error().message;
  }
  // The good file with one section changed, its checksum right.
  template <class Change>
  static std::vector<std::byte> with(const std::string& name, Change change) {
    const auto reader = ContainerReader::parse(good(), kBodyMagic, kBodyVersion, "good");
    ContainerWriter writer(kBodyMagic, kBodyVersion);
    for (const auto& [key, entry] : reader->entries()) {
      const auto section = *reader->section(key);
      std::vector<std::byte> bytes(section.begin(), section.end());
      if (key == name) change(bytes);
      writer.add(key, std::move(bytes));
    }
    return writer.finish();
  }
  template <class T>
  static void put(std::vector<std::byte>& bytes, std::size_t at, T value) {
    ASSERT_LE(at + sizeof value, bytes.size());
    std::memcpy(bytes.data() + at, &value, sizeof value);
  }
};

TEST_F(BodyFile, LoadsAsPacked) {
  EXPECT_EQ(error_of(good()), "");
}

TEST_F(BodyFile, TruncatedForeignAndEmptyFilesAreRefused) {
  EXPECT_NE(error_of({}).find("people.i2b"), std::string::npos);
  for (const std::size_t size : {std::size_t{31}, std::size_t{500}, good().size() / 2, good().size() - 1})
    EXPECT_NE(error_of({good().begin(), good().begin() + static_cast<std::ptrdiff_t>(size)}).find("truncated"),
              std::string::npos)
        << size;
  auto foreign = good();
  foreign[0] = std::byte{'Z'};
  EXPECT_NE(error_of(foreign).find("I2BD"), std::string::npos);
  EXPECT_FALSE(BodyModel::load("/nonexistent/body.i2b"));
}

TEST_F(BodyFile, AFlippedByteNamesItsSection) {
  const auto reader = ContainerReader::parse(good(), kBodyMagic, kBodyVersion, "good");
  ASSERT_TRUE(reader);
  for (const auto& [name, entry] : reader->entries()) {
    if (entry.size == 0) continue;
    auto bad = good();
    bad[entry.offset + entry.size / 2] ^= std::byte{0x40};
    EXPECT_NE(error_of(bad).find("'" + name + "'"), std::string::npos) << name;
  }
}

TEST_F(BodyFile, IndicesOutOfRangeAreRefusedEvenWithARightChecksum) {
  const auto expect_named = [&](const std::string& name, auto change) {
    EXPECT_NE(error_of(with(name, change)).find("'" + name + "'"), std::string::npos) << name;
  };
  expect_named("base", [](auto& b) { put(b, 8, std::numeric_limits<float>::infinity()); });
  expect_named("base", [](auto& b) { b.resize(12 * 100); });
  expect_named("quads", [](auto& b) { put(b, 4, std::int32_t{-1}); });
  expect_named("tights_quads", [](auto& b) { put(b, 0, std::int32_t{1 << 20}); });
  expect_named("targets", [](auto& b) { put(b, 4, std::uint32_t{1 << 30}); });
  expect_named("runs", [](auto& b) { put(b, 0, std::uint32_t{0xFFFFFFFF}); });
  expect_named("runs", [](auto& b) { put(b, 6, std::uint16_t{0xFFFF}); });
  expect_named("macros", [](auto& b) { put(b, 0, std::uint16_t{0xFFFF}); });
  expect_named("macros", [](auto& b) { put(b, 2, std::uint8_t{99}); });
  expect_named("skin", [](auto& b) { put(b, 0, std::uint8_t{19}); });
  expect_named("skin", [](auto& b) { put(b, 4, std::numeric_limits<float>::quiet_NaN()); });
  expect_named("lists", [](auto& b) { put(b, 4, std::uint32_t{0}); });
  expect_named("lists", [](auto& b) { put(b, 0, std::uint32_t{1 << 30}); });
  expect_named("landmarks", [](auto& b) { put(b, 0, std::int32_t{kBodyVertexCount}); });
  expect_named("look_corners", [](auto& b) { b.resize(b.size() - 16); });
  expect_named("look_man", [](auto& b) { put(b, 0, std::uint32_t{0}); });
  expect_named("look_man", [](auto& b) { b.resize(20); });
  expect_named("look_woman", [](auto& b) { put(b, 16, std::uint32_t{0x00100000}); });  // 4096 pixels, big-endian
  expect_named("look_woman", [](auto& b) { put(b, 20, std::uint32_t{0x20000000}); });  // not square
  expect_named("look_eyes", [](auto& b) { put(b, 0, std::int32_t{-1}); });
  expect_named("look_eyes", [](auto& b) { put(b, 40, std::int32_t{1 << 20}); });
  expect_named("look_eyes", [](auto& b) { put(b, 148, std::int32_t{1 << 20}); });
  expect_named("look_eyes", [](auto& b) { put(b, 152, std::numeric_limits<float>::quiet_NaN()); });
  expect_named("look_eyes", [](auto& b) { put(b, 156, 1.5F); });
  expect_named("look_eyes", [](auto& b) { b.resize(b.size() / 2); });
  expect_named("look_hair", [](auto& b) {
    b.resize(16);
    put(b, 0, static_cast<std::uint16_t>(kBodyVertexCount));
  });
  expect_named("look_hair", [](auto& b) { b.assign(32, std::byte{0}); });  // one vertex twice
  expect_named("look_hair", [](auto& b) { b.resize(15); });
  expect_named("shape_about", [](auto& b) { put(b, 0, std::uint32_t{99}); });
  expect_named("shape_about", [](auto& b) { put(b, 0, std::uint32_t{10001}); });
  expect_named("shape_about", [](auto& b) { put(b, 4, std::uint32_t{0}); });
  expect_named("shape_about", [](auto& b) { put(b, 4, std::uint32_t{65}); });
  expect_named("shape_about", [](auto& b) { b.clear(); });
  expect_named("shape_scales", [](auto& b) { put(b, 4, std::numeric_limits<float>::quiet_NaN()); });
  expect_named("shape_scales", [](auto& b) { put(b, 0, -0.01F); });
  expect_named("shape_scales", [](auto& b) { put(b, 8, 3.0F); });
  expect_named("shape_points", [](auto& b) { b.erase(b.end() - 2, b.end()); });
  expect_named("shape_skin", [](auto& b) { put(b, 0, std::uint8_t{19}); });
  expect_named("shape_skin", [](auto& b) { put(b, 4, 0.5F); });
  expect_named("shape_skin", [](auto& b) { b.resize(b.size() + 20); });
  expect_named("shape_bones", [](auto& b) { put(b, 4, std::numeric_limits<float>::infinity()); });
  expect_named("modifier_names", [](auto& b) { b.push_back(std::byte{'\n'}); });
}

TEST_F(BodyFile, ShapeSpaceIsReadWithinHalfAStep) {
  const ShapeSpace wanted = fake_shape_space();
  const auto model = BodyModel::parse(good(), "good");
  ASSERT_TRUE(model);
  const ShapeSpace& found = model->shape_space();
  ASSERT_EQ(found.point_count, wanted.point_count);
  ASSERT_EQ(found.shape_count, wanted.shape_count);
  ASSERT_EQ(found.point_mean.size(), wanted.point_mean.size());
  ASSERT_EQ(found.point_basis.size(), wanted.point_basis.size());
  // Half a step of 32767 to the largest value, which the random space keeps below 900 and 40 mm.
  for (std::size_t i = 0; i < wanted.point_mean.size(); ++i)
    ASSERT_NEAR(found.point_mean[i], wanted.point_mean[i], 0.5F * 901 / 32767) << i;
  for (std::size_t i = 0; i < wanted.point_basis.size(); ++i)
    ASSERT_NEAR(found.point_basis[i], wanted.point_basis[i], 0.5F * 41 / 32767) << i;
  EXPECT_EQ(found.bone_mean, wanted.bone_mean);
  EXPECT_EQ(found.bone_basis, wanted.bone_basis);
  ASSERT_EQ(found.skin.size(), wanted.skin.size());
  EXPECT_EQ(std::memcmp(found.skin.data(), wanted.skin.data(), wanted.skin.size() * sizeof(SkinRecord)), 0);
}

TEST_F(BodyFile, WithoutAShapeSpaceLoadsWithAnEmptyOne) {
  const auto reader = ContainerReader::parse(good(), kBodyMagic, kBodyVersion, "good");
  ContainerWriter writer(kBodyMagic, kBodyVersion);
  for (const auto& [key, entry] : reader->entries()) {
    const auto section = *reader->section(key);
    if (!key.starts_with("shape_")) writer.add(key, {section.begin(), section.end()});
  }
  const auto model = BodyModel::parse(writer.finish(), "plain");
  ASSERT_TRUE(model);
  EXPECT_EQ(model->shape_space().point_count, 0U);
  EXPECT_EQ(model->shape_space().shape_count, 0U);
}

TEST_F(BodyFile, AShapeSpaceThatIsNoneIsNotWritten) {
  ShapeSpace space = fake_shape_space();
  space.point_basis.pop_back();
  EXPECT_FALSE(with_shape_space(good(), space));
  space = fake_shape_space();
  space.point_mean[7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(with_shape_space(good(), space));
  space = fake_shape_space();
  space.skin[5].weight = {0.5F, 0.2F, 0, 0};
  const auto refused = with_shape_space(good(), space);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("shape_skin"), std::string::npos);
}

}  // namespace
}  // namespace im2fit::body

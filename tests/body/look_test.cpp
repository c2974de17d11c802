// SPDX-License-Identifier: Apache-2.0
#include "body/look.h"

#include <gtest/gtest.h>

#include <cstring>

#include "body/model_data.h"
#include "body_pack.h"
#include "core/container.h"
#include "core/file.h"
#include "fake_shape_space.h"

namespace im2fit::body {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

std::vector<Params> different_people() {
  std::vector<Params> people(4);
  people[0].gender = 1;
  people[1].gender = 0;
  people[1].weight = 0.9F;
  people[1].muscle = 0.3F;
  people[2].gender = 1;
  people[2].age_years = 70;
  people[2].race = {1, 0, 0};
  people[3].gender = 0;
  people[3].race = {0, 1, 0};
  people[3].height = 0.3F;
  return people;
}

class Looks : public testing::Test {
 protected:
  void SetUp() override {
    IM2FIT_NEEDS_BODY();
    if (real_body()->data().look.empty())
      GTEST_SKIP() << body_pack_path() << " is older and has no look: run im2fit-lab fetch";
  }
  static const Look& look() { return real_body()->data().look; }
};

TEST_F(Looks, CopiesAtSeamsLieOnTheirVertexAndShareItsNormal) {
  const auto mesh = mesh_of(*real_body());
  const SkinPart part = skin_part(*real_body(), mesh);
  const auto body = at(kBodyVertexCount);
  ASSERT_GT(part.positions.size(), body) << "a skin cannot be laid flat without seams";
  ASSERT_LT(part.positions.size(), 16000U);
  ASSERT_EQ(part.texture.size(), part.positions.size());
  ASSERT_EQ(part.skin.size(), part.positions.size());
  for (std::size_t v = 0; v < part.positions.size(); ++v) {
    const std::size_t of = at(part.body_vertex[v]);
    ASSERT_TRUE(v >= body || of == v);
    ASSERT_EQ(std::memcmp(&part.positions[v], &mesh[of], sizeof(Vec3f)), 0) << v;
    ASSERT_EQ(std::memcmp(&part.normals[v], &part.normals[of], sizeof(Vec3f)), 0) << v;
    ASSERT_NEAR(norm(part.normals[v]), 1, 1e-5);
  }
  for (std::size_t q = 0; q < part.quads.size(); ++q)
    for (std::size_t k = 0; k < 4; ++k) {
      ASSERT_EQ(part.body_vertex[at(part.quads[q][k])], real_body()->body_quads()[q][k]);
      const TextureCoordinate is = part.texture[at(part.quads[q][k])];
      ASSERT_NEAR(is.u, look().corners[q][k].u / 65535.0F, 1e-6F);
      ASSERT_NEAR(is.v, look().corners[q][k].v / 65535.0F, 1e-6F);
    }
}

// Whether a ray from `from` towards +z meets the skin.
bool is_covered(std::span<const Vec3f> mesh, Vec3f from) {
  for (const auto& t : real_body()->body_triangles()) {
    const Vec3f a = mesh[at(t[0])] - from, b = mesh[at(t[1])] - from, c = mesh[at(t[2])] - from;
    const float bc = b.x * c.y - b.y * c.x, ca = c.x * a.y - c.y * a.x, ab = a.x * b.y - a.y * b.x;
    const float area = bc + ca + ab;
    if (area == 0 || bc / area < 0 || ca / area < 0 || ab / area < 0) continue;
    if ((bc * a.z + ca * b.z + ab * c.z) / area > 0) return true;
  }
  return false;
}

TEST_F(Looks, PupilsAreSeenAndLidsCoverTheRestOfTheEyes) {
  for (const Params& person : different_people()) {
    const auto mesh = mesh_of(*real_body(), person);
    const LookPart eyes = eyes_part(*real_body(), mesh);
    ASSERT_EQ(eyes.positions.size() % 2, 0U);
    const std::size_t half = eyes.positions.size() / 2, rays = 16;
    for (const std::size_t first : {std::size_t{0}, half}) {
      EXPECT_GT(eyes.normals[first].z, 0.95F) << "looks ahead";
      EXPECT_FALSE(is_covered(mesh, eyes.positions[first])) << "a lid before the pupil";
      std::size_t covered = 0;
      for (std::size_t i = half - 2 * rays; i < half; ++i)  // 56 and 75 degrees aside
        covered += is_covered(mesh, eyes.positions[first + i]) ? 1 : 0;
      EXPECT_GE(covered, 2 * rays - 3) << "the eye's side is not behind lids";
    }
    const float apart = eyes.positions[0].x - eyes.positions[half].x;
    EXPECT_GT(apart, 45) << "mm";
    EXPECT_LT(apart, 80) << "mm";
    for (std::size_t i = 0; i < eyes.positions.size(); ++i) ASSERT_NEAR(norm(eyes.normals[i]), 1, 1e-3);
  }
}

// Above the ears hair lies outside the skin of the scalp, and faces outwards.
TEST_F(Looks, HairCoversTheScalpOfEveryHead) {
  for (const Params& person : different_people()) {
    const auto mesh = mesh_of(*real_body(), person);
    const LookPart hair = hair_part(*real_body(), mesh, {}, look_of(person.gender));
    ASSERT_GT(hair.quads.size(), 200U);
    ASSERT_EQ(hair.texture.size(), hair.positions.size());
    const Skeleton skeleton = rest_skeleton(*real_body(), mesh);
    const auto head = at(static_cast<std::int32_t>(Segment::head));
    const Vec3f low = skeleton.head[head], crown = skeleton.tail[head];
    const Vec3f middle = low * 0.4F + crown * 0.6F;
    std::size_t outside = 0, above = 0;
    for (const HairRecord& record : look().hair) {
      if ((record.above >> static_cast<unsigned>(look_of(person.gender)) & 1U) == 0) continue;
      const Vec3f skin = mesh[record.vertex];
      if (skin.y < middle.y + 15) continue;  // the sides curl in to the ears and the neck
      ++above;
      const auto& o = record.offset[static_cast<std::size_t>(look_of(person.gender))];
      const Vec3f offset = {static_cast<float>(o[0]), static_cast<float>(o[1]), static_cast<float>(o[2])};
      outside += norm(skin + offset * kHairUnitMm - middle) > norm(skin - middle) ? 1 : 0;
    }
    ASSERT_GT(above, 60U);
    EXPECT_GT(outside, above * 9 / 10);
    std::size_t outwards = 0;
    for (std::size_t v = 0; v < hair.positions.size(); ++v)
      outwards += dot(hair.normals[v], hair.positions[v] - middle) > 0 ? 1 : 0;
    EXPECT_GT(outwards, hair.positions.size() * 9 / 10);
  }
}

TEST_F(Looks, HairTurnsWithTheHead) {
  const auto mesh = mesh_of(*real_body());
  const Mat3f turn = rotation_about({0, 1, 0}, 90);
  std::vector<Vec3f> turned;
  for (const Vec3f& v : mesh) turned.push_back(turn * v);
  const LookPart before = hair_part(*real_body(), mesh, {}, LookOf::woman);
  const LookPart after = hair_part(*real_body(), turned, turn, LookOf::woman);
  ASSERT_EQ(before.positions.size(), after.positions.size());
  for (std::size_t v = 0; v < before.positions.size(); ++v)
    ASSERT_LT(norm(turn * before.positions[v] - after.positions[v]), 0.01F);
}

// Nothing that is measured knows of the look: the same file without it is the same body, bit for bit.
TEST_F(Looks, AreNoPartOfTheBody) {
  const auto bytes = read_file(body_pack_path());
  ASSERT_TRUE(bytes);
  auto shape = shape_only(*bytes, "body");
  ASSERT_TRUE(shape);
  EXPECT_LT(shape->size(), bytes->size());
  const auto plain = BodyModel::parse(std::move(*shape), "plain");
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_TRUE(plain->data().look.empty());
  EXPECT_EQ(plain->shape_space().key, real_body()->shape_space().key);
  for (const Params& person : different_people()) {
    const auto a = mesh_of(*plain, person), b = mesh_of(*real_body(), person);
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3f)), 0);
  }
}

TEST(BodyWithoutALook, IsDrawnPlain) {
  const auto file = fake_body_file();
  auto shape = shape_only(file, "fake");
  ASSERT_TRUE(shape) << shape.error().message;
  const auto again = shape_only(*shape, "fake");
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, *shape) << "taking away nothing changes nothing";
  const auto model = BodyModel::parse(std::move(*shape), "fake");
  ASSERT_TRUE(model) << model.error().message;
  const auto mesh = mesh_of(*model);
  const SkinPart skin = skin_part(*model, mesh);
  EXPECT_EQ(skin.positions.size(), at(kBodyVertexCount));
  EXPECT_TRUE(skin.texture.empty());
  EXPECT_TRUE(eyes_part(*model, mesh).quads.empty());
  EXPECT_TRUE(hair_part(*model, mesh, {}, LookOf::man).quads.empty());
}

}  // namespace
}  // namespace im2fit::body

// SPDX-License-Identifier: Apache-2.0
// Eighty thousand damaged body files: each is refused, or gives meshes of finite numbers.
#include "tests/fuzz/damage.h"

#include <gtest/gtest.h>

#include "body_pack.h"
#include "fake_shape_space.h"
#include "tests/fuzz/body_use.h"

namespace im2fit::fuzz {
namespace {

const Bytes& sound_body() {
  static const Bytes bytes = body::fake_body_file();
  return bytes;
}

TEST(DamagedBody, AccidentsAreNoticedOrHarmless) {
  const Bytes& good = sound_body();
  const auto model = body::BodyModel::parse(good, "sound");
  ASSERT_TRUE(model);
  const std::vector<Vec3f> truth = mesh_of(*model);
  Rng rng(20263);
  for (int i = 0; i < trials(50000); ++i) {
    Bytes bytes = damaged(good, rng);
    const auto found = body::BodyModel::parse(std::move(bytes), "damaged");
    if (!found) continue;
    const std::vector<Vec3f> mesh = mesh_of(*found);
    ASSERT_EQ(std::memcmp(mesh.data(), truth.data(), truth.size() * sizeof(Vec3f)), 0) << "accident " << i;
    ASSERT_EQ(found->shape_space().point_mean, model->shape_space().point_mean) << "accident " << i;
    ASSERT_EQ(found->shape_space().point_basis, model->shape_space().point_basis) << "accident " << i;
    ASSERT_EQ(found->shape_space().bone_basis, model->shape_space().bone_basis) << "accident " << i;
  }
}

TEST(DamagedBody, AttacksAreRefusedOrGiveFiniteMeshes) {
  const Bytes& good = sound_body();
  Rng rng(20264);
  int accepted = 0;
  for (int i = 0; i < trials(20000); ++i) {
    Bytes bytes = damaged(good, rng);
    mend_checksums(bytes);
    const auto sane = use_body(std::move(bytes));
    if (!sane) continue;
    ++accepted;
    ASSERT_TRUE(*sane) << "attack " << i;
  }
  EXPECT_GT(accepted, trials(2000));  // else the checksums still refuse them
}

}  // namespace
}  // namespace im2fit::fuzz

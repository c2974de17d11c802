// SPDX-License-Identifier: Apache-2.0
// Segmenting and tracking a frame must not touch the heap: the device runs for days.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "perception/joints/tracker.h"
#include "perception/segment/segment.h"
#include "tests/perception/joints_model_builder.h"
#include "tests/perception/segment_scene.h"

namespace {
std::atomic<long> allocation_count{0};

void* counted(std::size_t size) {
  ++allocation_count;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
}  // namespace

void* operator new(std::size_t size) {
  return counted(size);
}
void* operator new[](std::size_t size) {
  return counted(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocation_count;
  return std::malloc(size > 0 ? size : 1);
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete[](void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  std::free(p);
}

namespace im2fit {
namespace {

TEST(SegmentAllocation, NoneAfterConstruction) {
  room_test::Scene scene;
  scene.wall_z = 3500;
  add(scene, room_test::person_at(0, 2600));
  const room_test::Picture person = render(scene, 0.5);
  scene.capsules.clear();
  const room_test::Picture empty = render(scene, 0.5);
  const auto bytes = test::constant_model(1, 1, 1, 1).bytes();
  const auto model = JointModel::parse(bytes, "model");
  ASSERT_TRUE(model);
  std::vector<std::uint8_t> mask(person.depth.size());
  Segmenter segmenter(scene.width, scene.height);
  PersonTracker people;
  JointTracker tracker(*model);
  const Intrinsics k = scene.intrinsics();
  bool found = false;
  JointSet joints;

  const long before = allocation_count;
  for (const room_test::Picture* p : {&person, &empty, &person, &person}) {
    const Person who = segmenter.run(p->view(), k, people, MaskImage(mask.data(), p->width, p->height));
    joints = tracker.track(p->view(), MaskView(mask.data(), p->width, p->height), k, who, found);
    found = who.found;
  }
  EXPECT_EQ(allocation_count - before, 0);
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace im2fit

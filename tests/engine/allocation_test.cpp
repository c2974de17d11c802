// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "allocations.h"
#include "fake_stages.h"

namespace {

std::atomic<bool> armed{false};
std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  if (armed.load(std::memory_order_relaxed)) allocations.fetch_add(1, std::memory_order_relaxed);
  if (size == 0) size = 1;
  void* p = alignment <= alignof(std::max_align_t)
                ? std::malloc(size)
                : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

}  // namespace

void* operator new(std::size_t size) {
  return counted(size, 0);
}
void* operator new[](std::size_t size) {
  return counted(size, 0);
}
void* operator new(std::size_t size, std::align_val_t a) {
  return counted(size, static_cast<std::size_t>(a));
}
void* operator new[](std::size_t size, std::align_val_t a) {
  return counted(size, static_cast<std::size_t>(a));
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
void operator delete(void* p, std::align_val_t) noexcept {
  std::free(p);
}
void operator delete[](void* p, std::align_val_t) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}

namespace im2fit::test {

void arm_allocation_count() {
  allocations = 0;
  armed = true;
}
long disarm_allocation_count() {
  armed = false;
  return allocations;
}

namespace {

TEST(Allocations, TheHookCounts) {
  arm_allocation_count();
  delete new int(3);
  EXPECT_EQ(disarm_allocation_count(), 1);
}

TEST(Allocations, NoneAfterStartOver300Frames) {
  for (const bool single : {false, true})
    for (const bool live : {false, true}) {
      FakeStages::Control control;
      EngineSettings settings = small_settings();
      settings.single_thread = single;
      settings.live = live;
      settings.frames_wanted = 290;
      auto engine = create_engine(settings, std::make_unique<FakeStages>(control));
      ASSERT_TRUE(engine);
      const FramePixels near(Shot{true, static_cast<GuidanceSet>(Guidance::too_near)});
      const FramePixels good(Shot{});
      hal::FrameInfo info;
      arm_allocation_count();
      for (int i = 0; i < 300; ++i) {
        info.sequence = static_cast<std::uint64_t>(i);
        info.host_ns = i + 1;
        const bool pushed = static_cast<bool>((*engine)->push(i < 10 ? near.view() : good.view(), info));
        if (!pushed) std::abort();
        if ((*engine)->result().frames_seen > 300) std::abort();
      }
      (*engine)->finish();
      const bool measured = (*engine)->result().measured;
      (*engine)->reset();
      EXPECT_EQ(disarm_allocation_count(), 0) << "single " << single << " live " << live;
      if (!live) {
        EXPECT_TRUE(measured);
      }
    }
}

}  // namespace
}  // namespace im2fit::test

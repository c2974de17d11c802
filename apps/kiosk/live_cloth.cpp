// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/live_cloth.h"

#include <sys/resource.h>

#include <span>
#include <utility>

#include "garment/drape/offset_wire.h"

namespace im2fit::apps {
namespace {

constexpr int kNice = 10;  // the camera's threads go first

}  // namespace

LiveCloth::LiveCloth(std::function<void(std::uint32_t)> moved)
    : moved_(std::move(moved)), thread_([this] { work(); }) {}

LiveCloth::~LiveCloth() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  news_.notify_all();
  thread_.join();
}

void LiveCloth::wear(const std::string& name, std::shared_ptr<body::MovingClothes> clothes) {
  const std::lock_guard lock(mutex_);
  if (clothes && clothes == clothes_) return;
  name_ = name;
  clothes_.swap(clothes);  // the ones before end with this call, or with the frame that is being simulated
  frame_.reset();
  fresh_ = false;
  asked_ = {};
}

void LiveCloth::follow(const body::Pose& pose) {
  {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || !is_wanted()) return;
    pose_ = pose;
    fresh_ = true;
  }
  news_.notify_one();
}

bool LiveCloth::is_wanted() const {
  return clothes_ && Clock::now() - asked_ < kLookedAt;
}

PageAnswer LiveCloth::ask(const std::string& name) {
  const std::lock_guard lock(mutex_);
  if (!clothes_ || name != name_) return {409, nullptr, "the person wears other clothes now"};
  asked_ = Clock::now();
  if (!frame_) return {202, nullptr, "no moving clothes yet; request it again"};
  return {200, frame_, ""};
}

std::shared_ptr<const PageFile> LiveCloth::told(body::MovingClothes& clothes) {
  clothes.find_offsets();
  std::vector<std::span<const Vec3f>> garments;
  for (std::size_t i = 0; i < clothes.size(); ++i) garments.push_back(clothes.offsets(i));
  return std::make_shared<const PageFile>(
      PageFile{"application/octet-stream", body::cloth_message(++number_, garments)});
}

void LiveCloth::work() {
  // Of this thread alone, on Linux; refused, it is as it was.
  (void)::setpriority(PRIO_PROCESS, 0, kNice);
  for (std::unique_lock lock(mutex_);;) {
    news_.wait(lock, [&] { return closing_ || (fresh_ && is_wanted()); });
    if (closing_) return;
    const auto clothes = clothes_;
    const body::Pose pose = pose_;
    fresh_ = false;
    lock.unlock();
    const auto began = Clock::now();
    clothes->frame(pose);
    const bool tells = Clock::now() - told_ >= kSendPeriod;
    auto frame = tells ? told(*clothes) : nullptr;
    const auto ended = Clock::now();
    lock.lock();
    if (tells && clothes == clothes_) {  // not for clothes replaced meanwhile
      frame_ = std::move(frame);
      told_ = ended;
      lock.unlock();
      moved_(number_);
      lock.lock();
    }
    news_.wait_until(lock, ended + kRestTimes * (ended - began), [&] { return closing_; });
  }
}

}  // namespace im2fit::apps

// SPDX-License-Identifier: Apache-2.0
// The clothes on the page, simulated on a thread of their own while a page shows them. The latest pose counts, and
// the thread that passes it never waits.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "apps/kiosk/board.h"
#include "garment/drape/moving_clothes.h"

namespace im2fit::apps {

// Any thread may call anything. One set of clothes moves at a time.
class LiveCloth {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kSendPeriod{90};  // every third frame of a camera of 30 Hz
  static constexpr std::chrono::seconds kLookedAt{3};          // after the last request of a page
  // A frame of cloth that takes so long waits for as many times that: the rest of the core is the camera's.
  static constexpr int kRestTimes = 2;

  // `moved`, on the thread of its own: there is a frame of this number.
  explicit LiveCloth(std::function<void(std::uint32_t number)> moved);
  ~LiveCloth();
  LiveCloth(const LiveCloth&) = delete;
  LiveCloth& operator=(const LiveCloth&) = delete;

  // From now on these clothes move, under this name; null: none. Frames of the clothes before are deleted.
  void wear(const std::string& name, std::shared_ptr<body::MovingClothes> clothes);
  // Does nothing where it would have to wait.
  void follow(const body::Pose& pose);
  // The latest frame, as body::cloth_message(). 202: no frame yet. 409: other clothes move. The simulation runs while
  // pages request frames.
  PageAnswer ask(const std::string& name);

 private:
  void work();
  bool is_wanted() const;  // holds mutex_
  std::shared_ptr<const PageFile> told(body::MovingClothes& clothes);

  const std::function<void(std::uint32_t)> moved_;
  std::mutex mutex_;
  std::condition_variable news_;
  bool closing_ = false;
  std::string name_;
  std::shared_ptr<body::MovingClothes> clothes_;
  body::Pose pose_;
  bool fresh_ = false;  // pose_ was not simulated yet
  Clock::time_point asked_{};
  std::shared_ptr<const PageFile> frame_;
  // Of the thread alone.
  std::uint32_t number_ = 0;
  Clock::time_point told_{};
  std::thread thread_;
};

}  // namespace im2fit::apps

// SPDX-License-Identifier: Apache-2.0
// A run in a browser: what the camera sees, what is needed, who was measured, and their body, which follows them.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "apps/common/events.h"
#include "apps/im2fit/page/avatar_animator.h"
#include "apps/im2fit/page/board.h"
#include "apps/im2fit/page/fitting_room.h"
#include "apps/im2fit/page/page_server.h"
#include "engine/engine.h"

namespace im2fit::apps {

// `see` on the engine's thread, the rest on one other. Nothing is drawn while no browser watches.
class LivePage {
 public:
  // `body_path`: the body file with which /tryon.glb is made; "": it is not. Errors: as PageServer::open().
  static Result<std::unique_ptr<LivePage>> open(const PageAddress& address, const std::string& body_path = "");
  const std::string& url() const { return server_->url(); }

  // Before the first frame.
  void begin(const Intrinsics& intrinsics, int frames_wanted);
  void see(const FrameSeen& frame);
  void publish(const Json& event);
  // Before its event.
  Status measured(const body::Avatar& avatar, std::span<const std::byte> glb);
  // Before its event, which says which person this is.
  void may_try_on(Customer customer) { customer_ = std::move(customer); }

 private:
  LivePage() = default;
  void draw(const FrameSeen& frame);
  void move(const FrameSeen& frame);

  Board board_;
  Intrinsics intrinsics_;
  std::mutex animator_mutex_;
  std::optional<AvatarAnimator> animator_;
  std::chrono::steady_clock::time_point drawn_{};
  std::uint64_t pictures_ = 0;
  Customer customer_;
  std::unique_ptr<FittingRoom> fitting_;
  std::unique_ptr<PageServer> server_;  // last: it refers to the board and the fitting room
};

}  // namespace im2fit::apps

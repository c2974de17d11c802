// SPDX-License-Identifier: Apache-2.0
// The person measured last, in the clothes a page asks for: dressed on a thread of its own, one drape at a time.
#pragma once

#include <condition_variable>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/kiosk/board.h"
#include "apps/kiosk/live_cloth.h"
#include "body/model.h"
#include "body/skeleton.h"
#include "core/status.h"
#include "person/garment_fit.h"

namespace im2fit::apps {

// Whom to dress.
struct Customer {
  std::string visit;  // the id their page names
  body::Params params;
  body::Pose pose;  // the avatar's default
  bool woman = false;
  std::vector<GarmentFit> fits;  // of each garment that may be tried
};

// Any thread may call anything. Holds up to kKept avatars. One avatar is being made and one waits at most: the one
// requested last.
class FittingRoom {
 public:
  static constexpr std::size_t kKept = 8;

  // `body_path`: loaded when first needed. `ready`, on the room's thread: a requested avatar has been made, or has
  // failed. `moved`, on another thread: the cloth has moved, to a frame of this number.
  FittingRoom(
      std::string body_path, std::function<void(const std::string& visit)> ready,
      std::function<void(std::uint32_t number)> moved = [](std::uint32_t) {});
  ~FittingRoom();  // waits for the avatar being made: some seconds
  FittingRoom(const FittingRoom&) = delete;
  FittingRoom& operator=(const FittingRoom&) = delete;

  // Both forget the customer before.
  void welcome(Customer customer);
  void forget();

  // The fields of a query, each once: `visit`, and either `top` and `top_size`, `bottom` and `bottom_size`, both or
  // none (bare); `colours=ease` for the ease map. 200: the avatar. 202: it is being made, call again after `ready`.
  // 400: invalid query. 404: no person is here, or another one. 500: it cannot be made.
  // The clothes of the last avatar returned are the ones that move.
  PageAnswer ask(std::span<const std::pair<std::string, std::string>> query);
  // For the same query: its cloth as LiveCloth::ask() returns it. 404 also for a bare body or one no longer kept.
  PageAnswer ask_cloth(std::span<const std::pair<std::string, std::string>> query);
  // The present pose of the dressed person. Does not wait.
  void follow(const body::Pose& pose) { live_.follow(pose); }

 private:
  struct Piece {
    std::string garment;
    float chest_mm = 0;  // the size is cut for
  };
  struct Wish {
    std::string name;
    std::vector<Piece> pieces;  // the lowest first
    bool ease = false;
  };
  struct Made {
    std::string name;
    PageAnswer answer;
    std::shared_ptr<body::MovingClothes> clothes;  // null: bare, or failed
  };
  Result<Wish> wish_of(std::span<const std::pair<std::string, std::string>> query) const;
  // nullopt: the wish is in `wish`. Else the answer to a query without a valid wish.
  std::optional<PageAnswer> read_wish(std::span<const std::pair<std::string, std::string>> query, Wish& wish) const;
  void work();
  Result<Made> make(const Customer& customer, const Wish& wish);

  const std::string body_path_;
  const std::function<void(const std::string&)> ready_;
  std::mutex mutex_;
  std::condition_variable news_;
  bool closing_ = false;
  std::optional<Customer> customer_;
  std::uint64_t visit_ = 0;  // whose avatars are kept
  std::optional<Wish> waiting_;
  std::string making_;                      // name of the wish; "": none
  std::list<Made> made_;                    // the latest used first
  std::unique_ptr<body::BodyModel> model_;  // written by the thread alone, before any clothes are made
  LiveCloth live_;
  std::thread thread_;
};

}  // namespace im2fit::apps

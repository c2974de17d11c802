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

#include "apps/im2fit/page/board.h"
#include "body/model.h"
#include "body/skeleton.h"
#include "core/status.h"
#include "engine/garment_fit.h"

namespace im2fit::apps {

// Whom to dress.
struct Customer {
  int person = 0;  // as events number them
  body::Params params;
  body::Pose pose;  // the avatar's default
  bool woman = false;
  std::vector<GarmentFit> fits;  // of each garment that may be tried
};

// Any thread may call anything. Holds at most kKept avatars; one is being made and one waits at most, the latest
// asked for.
class FittingRoom {
 public:
  static constexpr std::size_t kKept = 8;

  // `body_path`: loaded when first needed. `ready`, on the room's thread: something asked for has been made, or
  // failed.
  FittingRoom(std::string body_path, std::function<void(int person)> ready);
  ~FittingRoom();  // waits for what is being made: some seconds
  FittingRoom(const FittingRoom&) = delete;
  FittingRoom& operator=(const FittingRoom&) = delete;

  // Forgets whoever was here.
  void welcome(Customer customer);
  void forget();

  struct Answer {
    unsigned status = 200;                 // HTTP
    std::shared_ptr<const PageFile> file;  // with 200: a .glb
    std::string text;                      // else a line for people
  };
  // Of a query's fields, each once: `person`, and either `top` and `top_size`, `bottom` and `bottom_size`, both or
  // none (bare); `colours=ease` for the ease map. 200: there it is. 202: it is being made, ask again when `ready` was
  // called. 400: the query is none. 404: no person, or another one, is here. 500: it cannot be made.
  Answer ask(std::span<const std::pair<std::string, std::string>> query);

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
    Answer answer;
  };
  Result<Wish> wish_of(std::span<const std::pair<std::string, std::string>> query) const;
  void work();
  Result<std::string> make(const Customer& customer, const Wish& wish);

  const std::string body_path_;
  const std::function<void(int)> ready_;
  std::mutex mutex_;
  std::condition_variable news_;
  bool closing_ = false;
  std::optional<Customer> customer_;
  std::uint64_t visit_ = 0;  // whose avatars are kept
  std::optional<Wish> waiting_;
  std::string making_;                      // name of the wish; "": none
  std::list<Made> made_;                    // the latest used first
  std::unique_ptr<body::BodyModel> model_;  // of the thread alone
  std::thread thread_;
};

}  // namespace im2fit::apps

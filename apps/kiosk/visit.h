// SPDX-License-Identifier: Apache-2.0
// One person's visit to the page: consent, measurement, result, deletion. It has no clock and no thread of its own:
// the caller passes the time.
//
//   ASKING -> (FACTS ->) MEASURING -> RESULT -> (a new visit) ASKING
//
// FACTS: the person may report what they know of themselves, with VisitRules::ask_facts.
//
// A visit has an id that cannot be guessed. A page names it in every request (consent, touch, delete). A page that
// still shows the visit before can therefore neither consent for the next person nor delete that person's data.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace im2fit::apps {

enum class VisitState { asking, facts, measuring, result };
std::string_view name_of(VisitState state);  // "ASKING", "FACTS", "MEASURING", "RESULT"

// 32 hexadecimal digits of the system's random numbers.
std::string random_id();

struct VisitRules {
  bool ask = true;         // false: a visit begins with MEASURING
  bool ask_facts = false;  // true: FACTS follows consent
  // Without a touch the result goes: time to try on with a friend. So does FACTS.
  std::chrono::milliseconds result_max{120'000};
  // Without a person in view consent goes: enough to step back from the screen, too short for the next customer.
  std::chrono::milliseconds absent_max{30'000};
};

class Visit {
 public:
  using Time = std::chrono::steady_clock::time_point;
  Visit(const VisitRules& rules, Time now);

  const std::string& id() const { return id_; }
  std::uint64_t number() const { return number_; }  // from 1
  VisitState state() const { return state_; }

  // Each of these says whether the visit or its state is another now.
  bool consent(std::string_view id, Time now);  // only in ASKING
  bool facts_done(Time now);                    // only in FACTS: reported, or skipped
  bool measured(Time now);                      // only in MEASURING
  bool erase(std::string_view id, Time now);    // in any state
  bool next(Time now);                          // the next visit
  bool tick(Time now);                          // what time alone ends
  // A touch of the page, a person in view: they put the end off.
  bool touch(std::string_view id, Time now);  // whether `id` is this visit's
  void person_in_view(Time now);
  // Until tick() ends it; zero where time ends nothing.
  std::chrono::milliseconds left(Time now) const;

 private:
  void begin(Time now);
  std::chrono::milliseconds patience() const;

  VisitRules rules_;
  std::string id_;
  std::uint64_t number_ = 0;
  VisitState state_ = VisitState::asking;
  Time since_;  // the last touch or person
};

}  // namespace im2fit::apps

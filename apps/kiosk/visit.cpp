// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/visit.h"

#include <algorithm>
#include <random>

namespace im2fit::apps {

std::string_view name_of(VisitState state) {
  switch (state) {
    case VisitState::asking:
      return "ASKING";
    case VisitState::facts:
      return "FACTS";
    case VisitState::measuring:
      return "MEASURING";
    case VisitState::result:
      return "RESULT";
  }
  return "";
}

std::string random_id() {
  // libstdc++ takes these from the processor or from getentropy(): not to be foretold.
  std::random_device device;
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string id;
  for (int word = 0; word < 4; ++word)
    for (std::uint32_t bits = device(), digit = 0; digit < 8; ++digit, bits >>= 4U) id += kDigits[bits & 15U];
  return id;
}

Visit::Visit(const VisitRules& rules, Time now) : rules_(rules) {
  begin(now);
}

void Visit::begin(Time now) {
  id_ = random_id();
  ++number_;
  state_ = rules_.ask ? VisitState::asking : VisitState::measuring;
  since_ = now;
}

bool Visit::consent(std::string_view id, Time now) {
  if (id != id_ || state_ != VisitState::asking) return false;
  state_ = rules_.ask_facts ? VisitState::facts : VisitState::measuring;
  since_ = now;
  return true;
}

bool Visit::facts_done(Time now) {
  if (state_ != VisitState::facts) return false;
  state_ = VisitState::measuring;
  since_ = now;
  return true;
}

bool Visit::measured(Time now) {
  if (state_ != VisitState::measuring) return false;
  state_ = VisitState::result;
  since_ = now;
  return true;
}

bool Visit::next(Time now) {
  begin(now);
  return true;
}

bool Visit::erase(std::string_view id, Time now) {
  return id == id_ && next(now);
}

bool Visit::touch(std::string_view id, Time now) {
  if (id != id_) return false;
  since_ = now;
  return true;
}

void Visit::person_in_view(Time now) {
  if (state_ == VisitState::measuring) since_ = now;
}

std::chrono::milliseconds Visit::patience() const {
  if (state_ == VisitState::result || state_ == VisitState::facts) return rules_.result_max;
  // Without a question there is no consent that could outlive its person.
  return state_ == VisitState::measuring && rules_.ask ? rules_.absent_max : std::chrono::milliseconds(0);
}

std::chrono::milliseconds Visit::left(Time now) const {
  if (patience().count() == 0) return patience();
  const auto gone = std::chrono::duration_cast<std::chrono::milliseconds>(now - since_);
  return std::max(patience() - gone, std::chrono::milliseconds(1));
}

bool Visit::tick(Time now) {
  return patience().count() > 0 && now - since_ >= patience() && next(now);
}

}  // namespace im2fit::apps

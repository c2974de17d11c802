// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/hand_over.h"

#include <utility>

#include "apps/kiosk/operator_gate.h"
#include "apps/kiosk/visit.h"

namespace im2fit::apps {

std::string HandOver::offer(std::shared_ptr<const PageFile> result, Time now) {
  token_ = random_id();
  result_ = std::move(result);
  offered_ = now;
  return token_;
}

std::shared_ptr<const PageFile> HandOver::take(std::string_view token, Time now) {
  if (result_ && now - offered_ >= wait_max_) forget();
  if (!result_ || !same_secret(token_, token)) return nullptr;
  std::shared_ptr<const PageFile> given = result_;
  forget();
  return given;
}

void HandOver::forget() {
  token_.clear();
  result_.reset();
}

}  // namespace im2fit::apps

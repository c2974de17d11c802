// SPDX-License-Identifier: Apache-2.0
// Access to the operator's part of the page: a client needs the password (HTTP Basic, RFC 7617, user "operator")
// and, to change anything, the token, which no page of another site can read.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "core/status.h"

namespace im2fit::apps {

inline constexpr std::size_t kPasswordCharactersMin = 12;

// The first line of a file that its owner, and at most a group, may read. Errors: as read_file; others may read it;
// shorter than kPasswordCharactersMin, longer than 200, control characters.
Result<std::string> read_password(const std::string& path);

// For one thread.
class OperatorGate {
 public:
  using Time = std::chrono::steady_clock::time_point;
  enum class Answer { admitted, password_needed, too_many_tries };

  // "": no password, for a page that this machine alone can reach.
  explicit OperatorGate(const std::string& password);
  // Of a request's field Authorization. After five wrong ones in a second, all are refused until the second is over.
  Answer admit(std::optional<std::string_view> authorization, Time now);
  const std::string& token() const { return token_; }
  bool is_token(std::string_view given) const;

 private:
  std::string expected_;  // "Basic b3BlcmF0b3I6..."
  std::string token_;
  Time window_{};
  int wrong_ = 0;  // since `window_`
};

// The time does not depend on the secret: it shows only the length of `given`.
bool same_secret(std::string_view secret, std::string_view given);

}  // namespace im2fit::apps

// SPDX-License-Identifier: Apache-2.0
// Access to the operator's part of the page: who signs in with the password gets a session, which the browser keeps
// in a cookie, and that session's token, which no page of another site can read and which every change needs.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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
  static constexpr std::size_t kSessionsMax = 8;       // at once; the one that was idle longest makes room
  static constexpr std::chrono::minutes kIdleMax{30};  // a session ends without a request, and after kSessionMax
  static constexpr std::chrono::hours kSessionMax{12};
  // After kWrongMax wrong passwords from an address within kWrongWindow of each other, every answer to that address
  // comes after kSlowness, the right password's too: nobody is locked out, and guessing is slow on each connection,
  // because a client that does not wait learns nothing.
  static constexpr int kWrongMax = 5;
  static constexpr std::chrono::minutes kWrongWindow{1};
  static constexpr std::chrono::milliseconds kSlowness{1000};
  static constexpr std::size_t kAddressesMax = 1024;  // remembered; further ones are counted together

  // An empty password admits nobody.
  explicit OperatorGate(std::string password) : password_(std::move(password)) {}
  struct SignIn {
    std::string session;                // "": the password is wrong
    std::chrono::milliseconds wait{0};  // before the answer is sent
  };
  // `address` as text. Of IPv6 its network of 64 bits counts: a client has all addresses of that.
  SignIn sign_in(std::string_view password, const std::string& address, Time now);
  void sign_out(std::string_view session);
  // The session's token; "": it is none, or is over. `stays`: the request keeps it from being idle.
  std::string token_of(std::string_view session, bool stays, Time now);

 private:
  struct Session {
    std::string id, token;
    Time begun, used;
  };
  struct Wrong {
    int count = 0;
    Time last;
  };
  Wrong& wrong_of(const std::string& address, Time now);
  const std::string password_;
  std::vector<Session> sessions_;
  std::map<std::string, Wrong> wrong_;
};

// A page that nobody touches asks for these all the same: they keep no session from being idle.
bool asked_untouched(std::string_view path);

// The time does not depend on the secret: it shows only the length of `given`.
bool same_secret(std::string_view secret, std::string_view given);

}  // namespace im2fit::apps

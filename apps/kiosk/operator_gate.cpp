// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/operator_gate.h"

#include <arpa/inet.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "apps/kiosk/visit.h"
#include "core/file.h"
#include "core/text.h"

namespace im2fit::apps {
namespace {

constexpr std::size_t kPasswordBytesMax = 200;
// Its group may read it: systemd's credentials have an access list for their user, which shows as that.
constexpr mode_t kOthersMay = 027;

std::string network_of(const std::string& address) {
  std::array<unsigned char, 16> bytes{};
  if (::inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1 || address.rfind("::ffff:", 0) == 0) return address;
  std::fill(bytes.begin() + 8, bytes.end(), static_cast<unsigned char>(0));
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET6, bytes.data(), text.data(), text.size());
  return text.data();
}

}  // namespace

Result<std::string> read_password(const std::string& path) {
  struct stat about {};
  if (::stat(path.c_str(), &about) == 0 && (about.st_mode & kOthersMay) != 0)
    return Error{ErrorCode::invalid_argument, path + ": other users can read this password; run chmod 600"};
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes) return bytes.error();
  std::string password(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  password.resize(std::min(password.size(), password.find_first_of("\r\n")));
  if (character_count(password) < kPasswordCharactersMin || password.size() > kPasswordBytesMax)
    return Error{ErrorCode::invalid_argument, path + ": its first line is not a password of " +
                                                  std::to_string(kPasswordCharactersMin) + " characters or more"};
  if (printable(password) != password)
    return Error{ErrorCode::invalid_argument, path + ": the password has control characters"};
  return password;
}

OperatorGate::Wrong& OperatorGate::wrong_of(const std::string& address, Time now) {
  for (auto it = wrong_.begin(); it != wrong_.end();)
    it = now - it->second.last >= kWrongWindow ? wrong_.erase(it) : std::next(it);
  const std::string network = network_of(address);
  return wrong_[wrong_.size() < kAddressesMax || wrong_.count(network) > 0 ? network : "others"];
}

OperatorGate::SignIn OperatorGate::sign_in(std::string_view password, const std::string& address, Time now) {
  Wrong& wrong = wrong_of(address, now);
  SignIn answer;
  if (wrong.count >= kWrongMax) answer.wait = kSlowness;
  if (!same_secret(password_, password)) {
    wrong.count = std::min(wrong.count + 1, kWrongMax);
    wrong.last = now;
    return answer;
  }
  if (sessions_.size() >= kSessionsMax)
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(),
                                     [](const Session& a, const Session& b) { return a.used < b.used; }));
  sessions_.push_back({random_id(), random_id(), now, now});
  answer.session = sessions_.back().id;
  return answer;
}

void OperatorGate::sign_out(std::string_view session) {
  std::erase_if(sessions_, [&](const Session& one) { return same_secret(one.id, session); });
}

std::string OperatorGate::token_of(std::string_view session, bool stays, Time now) {
  std::erase_if(sessions_,
                [&](const Session& one) { return now - one.used >= kIdleMax || now - one.begun >= kSessionMax; });
  for (Session& one : sessions_) {
    if (!same_secret(one.id, session)) continue;
    if (stays) one.used = now;
    return one.token;
  }
  return "";
}

bool asked_untouched(std::string_view path) {
  // The plan and the list change by what customers do.
  constexpr std::array<std::string_view, 4> kPaths = {"/operator/state", "/operator/statistics.csv", "/operator/plan",
                                                      "/operator/sessions"};
  return std::find(kPaths.begin(), kPaths.end(), path) != kPaths.end();
}

bool same_secret(std::string_view secret, std::string_view given) {
  unsigned difference = secret.size() == given.size() ? 0 : 1;
  if (secret.empty()) return false;
  for (std::size_t i = 0; i < given.size(); ++i)
    difference |= static_cast<unsigned char>(given[i]) ^
                  static_cast<unsigned>(static_cast<unsigned char>(secret[i % secret.size()]));
  return difference == 0;
}

}  // namespace im2fit::apps

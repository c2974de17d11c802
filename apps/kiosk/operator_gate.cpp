// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/operator_gate.h"

#include <sys/stat.h>

#include <algorithm>
#include <cstdint>

#include "apps/kiosk/visit.h"
#include "core/file.h"
#include "core/text.h"

namespace im2fit::apps {
namespace {

constexpr std::size_t kPasswordBytesMax = 200;
// Its group may read it: systemd's credentials have an access list for their user, which shows as that.
constexpr mode_t kOthersMay = 027;
constexpr int kWrongMax = 5;
constexpr auto kWindow = std::chrono::seconds(1);

std::string base64(const std::string& text) {  // RFC 4648
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < text.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8U | (i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= text.size() ? kDigits[bits >> (18U - 6U * static_cast<unsigned>(k)) & 63U] : '=';
  }
  return out;
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

OperatorGate::OperatorGate(const std::string& password)
    : expected_(password.empty() ? "" : "Basic " + base64("operator:" + password)), token_(random_id()) {}

OperatorGate::Answer OperatorGate::admit(std::optional<std::string_view> authorization, Time now) {
  if (expected_.empty()) return Answer::admitted;
  if (!authorization) return Answer::password_needed;  // a browser's first request, before it asks its user
  if (now - window_ >= kWindow) {
    window_ = now;
    wrong_ = 0;
  }
  if (wrong_ >= kWrongMax) return Answer::too_many_tries;
  if (same_secret(expected_, *authorization)) return Answer::admitted;
  ++wrong_;
  return Answer::password_needed;
}

bool OperatorGate::is_token(std::string_view given) const {
  return same_secret(token_, given);
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

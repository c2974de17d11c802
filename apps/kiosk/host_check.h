// SPDX-License-Identifier: Apache-2.0
// Who may read the page: requests that name this machine, sent by its own page or by none. A page from elsewhere
// whose name was made to lead here (DNS rebinding) names another host; one that merely asks has another Origin.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace im2fit::apps {

class HostCheck {
 public:
  // `listening_at` as --host has it. At an address of this machine alone (127/8, ::1, localhost) only such are
  // answered. Elsewhere also every literal address, which no name server can give away, this machine's own name, with
  // and without ".local", and `listening_at`.
  explicit HostCheck(const std::string& listening_at);

  // A request's fields; nullopt for missing ones. Returns "" to answer it, otherwise the reason for refusing it.
  std::string refusal(std::optional<std::string_view> host, std::optional<std::string_view> origin,
                      std::optional<std::string_view> fetch_site) const;

 private:
  bool is_known(std::string_view host) const;
  bool local_only_;
  std::vector<std::string> names_;  // lower case
};

// The host of a Host field in lower case, without the port, brackets and a name's last dot; nullopt if it is not
// valid: RFC 9110 7.2, with names of letters, digits, '-', '_' and '.' and ports of 1 to 65535 only.
std::optional<std::string> host_of(std::string_view field);
// 127.0.0.0/8 as four decimal numbers without leading zeros, ::1 or localhost.
bool is_this_machine(std::string_view host);

}  // namespace im2fit::apps

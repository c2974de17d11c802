// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/host_check.h"

#include <arpa/inet.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace im2fit::apps {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return out;
}

bool is_port(std::string_view text) {
  unsigned port = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), port);
  return fault == std::errc() && end == text.data() + text.size() && text.size() <= 5 && port >= 1 && port <= 65535;
}

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= 253 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
  });
}

// inet_pton takes four decimal numbers without leading zeros, and nothing else.
std::optional<std::array<unsigned char, 4>> address4(std::string_view text) {
  std::array<unsigned char, 4> bytes{};
  if (::inet_pton(AF_INET, std::string(text).c_str(), bytes.data()) != 1) return std::nullopt;
  return bytes;
}
bool is_address6(std::string_view text) {
  std::array<unsigned char, 16> bytes{};
  return ::inet_pton(AF_INET6, std::string(text).c_str(), bytes.data()) == 1;
}

}  // namespace

std::optional<std::string> host_of(std::string_view field) {
  const std::string text = lower(field);
  std::string_view host = text, port;
  bool has_port = false;
  if (!host.empty() && host.front() == '[') {
    const std::size_t end = host.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    port = host.substr(end + 1);
    host = host.substr(1, end - 1);
    if (!is_address6(host)) return std::nullopt;
    has_port = !port.empty();
    if (has_port && port.front() != ':') return std::nullopt;
    if (has_port) port.remove_prefix(1);
  } else {
    const std::size_t colon = host.find(':');
    has_port = colon != std::string_view::npos;
    if (has_port) {
      port = host.substr(colon + 1);
      host = host.substr(0, colon);
    }
    if (!host.empty() && host.back() == '.') host.remove_suffix(1);
    if (!is_name(host)) return std::nullopt;
  }
  if (has_port && !is_port(port)) return std::nullopt;
  return std::string(host);
}

bool is_this_machine(std::string_view host) {
  if (host == "localhost" || host == "::1") return true;
  const auto address = address4(host);
  return address && (*address)[0] == 127;
}

HostCheck::HostCheck(const std::string& listening_at) : local_only_(is_this_machine(lower(listening_at))) {
  if (local_only_) return;
  names_.push_back(lower(listening_at));
  std::array<char, 256> own{};
  if (::gethostname(own.data(), own.size() - 1) == 0 && own[0] != '\0') {
    names_.push_back(lower(own.data()));
    names_.push_back(names_.back() + ".local");
  }
}

bool HostCheck::is_known(std::string_view host) const {
  if (is_this_machine(host)) return true;
  if (local_only_) return false;
  return address4(host) || is_address6(host) || std::find(names_.begin(), names_.end(), host) != names_.end();
}

std::string HostCheck::refusal(std::optional<std::string_view> host, std::optional<std::string_view> origin,
                               std::optional<std::string_view> fetch_site) const {
  const auto named = host ? host_of(*host) : std::nullopt;
  if (!named || !is_known(*named)) return "unknown address; open the one that im2fit serve printed";
  // https: behind a proxy that encrypts.
  if (origin && lower(*origin) != "http://" + lower(*host) && lower(*origin) != "https://" + lower(*host))
    return "the request comes from another site's page";
  if (fetch_site && *fetch_site != "same-origin" && *fetch_site != "none")
    return "the link is from another site's page; type the address";
  return "";
}

}  // namespace im2fit::apps

// SPDX-License-Identifier: Apache-2.0
// What a request says, and answers to it, over libmicrohttpd. Of a connection on the server's thread.
#pragma once

#include <microhttpd.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/kiosk/board.h"

namespace im2fit::apps {

inline constexpr const char* kPlainText = "text/plain; charset=utf-8";
inline constexpr const char* kNotKept = "no-store";

struct FreeResponse {
  void operator()(MHD_Response* response) const { MHD_destroy_response(response); }
};
using Response = std::unique_ptr<MHD_Response, FreeResponse>;  // null: no memory

// Of a field given once; none when it is absent, two of a kind are not decided between.
struct Field {
  std::optional<std::string_view> value;
  int count = 0;
};
Field field_of(MHD_Connection* connection, std::string_view name);
// Digits alone, so that no two readers of it disagree (RFC 9110 8.6).
std::optional<std::size_t> length_of(const Field& field);
std::vector<std::pair<std::string, std::string>> query_of(MHD_Connection* connection);
// RFC 9110 12.5.3, as far as gzip goes: named, and not with a weight of zero.
bool takes_gzip(std::string_view accepted);

Response lasting_bytes(std::string_view bytes);  // which outlive all answers
Response copied(const std::string& text);
// The file stays in memory until it is sent, whatever replaces it on the board.
Response shared(std::shared_ptr<const PageFile> file);

// With the headers that everything is sent with. MHD_NO, which closes the connection, for a null response.
MHD_Result send(MHD_Connection* connection, unsigned status, const Response& response, const char* type,
                const char* kept = kNotKept);
MHD_Result send_not_allowed(MHD_Connection* connection, const char* allowed);  // 405; `allowed`: "GET, HEAD"
MHD_Result send_answer(MHD_Connection* connection, PageAnswer answer);

}  // namespace im2fit::apps

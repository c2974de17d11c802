// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/http_message.h"

#include <strings.h>

#include <algorithm>
#include <cstring>

namespace im2fit::apps {
namespace {

// blob: the avatar's texture, which three.js takes out of the .glb.
constexpr std::pair<const char*, const char*> kHeaders[] = {
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; form-action 'none'; "
     "frame-ancestors 'none'"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Referrer-Policy", "no-referrer"},
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"}};

}  // namespace

Field field_of(MHD_Connection* connection, std::string_view name) {
  struct Search {
    std::string_view name;
    Field field;
  } search{name, {}};
  MHD_get_connection_values(
      connection, MHD_HEADER_KIND,
      [](void* closure, MHD_ValueKind, const char* key, const char* value) {
        auto& found = *static_cast<Search*>(closure);
        if (found.name.size() == std::strlen(key) && ::strncasecmp(key, found.name.data(), found.name.size()) == 0) {
          ++found.field.count;
          found.field.value = value == nullptr ? "" : value;
        }
        return MHD_YES;
      },
      &search);
  return search.field;
}

bool takes_gzip(std::string_view accepted) {
  while (!accepted.empty()) {
    std::string word;
    const std::size_t end = std::min(accepted.find(','), accepted.size());
    for (const char c : accepted.substr(0, end))
      if (c != ' ' && c != '\t') word += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    accepted.remove_prefix(std::min(end + 1, accepted.size()));
    if (word == "gzip") return true;
    if (word.rfind("gzip;q=", 0) == 0) return word.find_first_of("123456789", 7) != std::string::npos;
  }
  return false;
}

Response lasting_bytes(std::string_view bytes) {
  return Response(
      MHD_create_response_from_buffer(bytes.size(), const_cast<char*>(bytes.data()), MHD_RESPMEM_PERSISTENT));
}

Response copied(const std::string& text) {
  return Response(
      MHD_create_response_from_buffer(text.size(), const_cast<char*>(text.data()), MHD_RESPMEM_MUST_COPY));
}

Response shared(std::shared_ptr<const PageFile> file) {
  auto held = std::make_unique<std::shared_ptr<const PageFile>>(std::move(file));
  const std::string& bytes = (*held)->bytes;
  Response response(MHD_create_response_from_buffer_with_free_callback_cls(
      bytes.size(), const_cast<char*>(bytes.data()),
      [](void* closure) { delete static_cast<std::shared_ptr<const PageFile>*>(closure); }, held.get()));
  if (response) held.release();  // NOLINT(bugprone-unused-return-value): the response has it
  return response;
}

MHD_Result send(MHD_Connection* connection, unsigned status, const Response& response, const char* type,
                const char* kept) {
  if (!response) return MHD_NO;
  for (const auto& [name, value] : kHeaders) MHD_add_response_header(response.get(), name, value);
  MHD_add_response_header(response.get(), "Content-Type", type);
  MHD_add_response_header(response.get(), "Cache-Control", kept);
  return MHD_queue_response(connection, status, response.get());
}

std::optional<std::size_t> length_of(const Field& field) {
  if (field.count != 1 || field.value->empty() || field.value->size() > 9 ||
      field.value->find_first_not_of("0123456789") != std::string_view::npos)
    return std::nullopt;
  return std::stoul(std::string(*field.value));
}

std::vector<std::pair<std::string, std::string>> query_of(MHD_Connection* connection) {
  std::vector<std::pair<std::string, std::string>> query;
  MHD_get_connection_values(
      connection, MHD_GET_ARGUMENT_KIND,
      [](void* closure, MHD_ValueKind, const char* name, const char* value) {
        static_cast<decltype(query)*>(closure)->emplace_back(name, value == nullptr ? "" : value);
        return MHD_YES;
      },
      &query);
  return query;
}

MHD_Result send_not_allowed(MHD_Connection* connection, const char* allowed) {
  const Response response = copied("this method is not allowed\n");
  if (response) MHD_add_response_header(response.get(), "Allow", allowed);
  return send(connection, MHD_HTTP_METHOD_NOT_ALLOWED, response, kPlainText);
}

MHD_Result send_answer(MHD_Connection* connection, PageAnswer answer) {
  if (!answer.file) return send(connection, answer.status, copied(answer.text + "\n"), kPlainText);
  const std::string type = answer.file->type;
  return send(connection, answer.status, shared(std::move(answer.file)), type.c_str());
}

}  // namespace im2fit::apps

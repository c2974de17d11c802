// SPDX-License-Identifier: Apache-2.0
// The functions of <microhttpd.h> that the page calls, each handed on to the library of the same function.
#include "apps/kiosk/web_server_library.h"

#include <dlfcn.h>
#include <microhttpd.h>

#include <cstdarg>
#include <string>

namespace {

constexpr const char* kLibrary = IM2FIT_MICROHTTPD_SONAME;

// Never closed: its threads may outlive the last page.
void* library() {
  static void* const loaded = ::dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  return loaded;
}

// The library's function of this name; null without the library.
template <class Function>
Function* function(const char* name, Function& /*declared*/) {
  return library() != nullptr ? reinterpret_cast<Function*>(::dlsym(library(), name)) : nullptr;
}

}  // namespace

namespace im2fit::apps {

Status load_web_server_library() {
  if (library() != nullptr) return Ok{};
  return Error{ErrorCode::not_found, std::string(kLibrary) +
                                         " is missing, by which im2fit serve answers browsers; install libmicrohttpd "
                                         "(Debian: libmicrohttpd12)"};
}

}  // namespace im2fit::apps

// NOLINTBEGIN(readability-identifier-naming, cert-dcl50-cpp): names and signatures are the library's
extern "C" {

// Options come as one array: a list of arguments cannot be handed on.
MHD_Daemon* MHD_start_daemon(unsigned flags, std::uint16_t port, MHD_AcceptPolicyCallback accept,
                             void* accept_closure, MHD_AccessHandlerCallback answer, void* answer_closure, ...) {
  static auto* const start = function("MHD_start_daemon", MHD_start_daemon);
  va_list rest;
  va_start(rest, answer_closure);
  const auto option = static_cast<MHD_OPTION>(va_arg(rest, int));
  MHD_OptionItem* const options = option == MHD_OPTION_ARRAY ? va_arg(rest, MHD_OptionItem*) : nullptr;
  va_end(rest);
  if (start == nullptr || options == nullptr) return nullptr;
  return start(flags, port, accept, accept_closure, answer, answer_closure, MHD_OPTION_ARRAY, options,
               MHD_OPTION_END);
}
void MHD_stop_daemon(MHD_Daemon* daemon) {
  static auto* const stop = function("MHD_stop_daemon", MHD_stop_daemon);
  if (stop != nullptr) stop(daemon);
}
// Of the kinds of information that need no argument.
const MHD_ConnectionInfo* MHD_get_connection_info(MHD_Connection* connection, MHD_ConnectionInfoType kind, ...) {
  static auto* const get = function("MHD_get_connection_info", MHD_get_connection_info);
  return get != nullptr ? get(connection, kind) : nullptr;
}
int MHD_get_connection_values(MHD_Connection* connection, MHD_ValueKind kind, MHD_KeyValueIterator take,
                              void* closure) {
  static auto* const get = function("MHD_get_connection_values", MHD_get_connection_values);
  return get != nullptr ? get(connection, kind, take, closure) : 0;
}
const char* MHD_lookup_connection_value(MHD_Connection* connection, MHD_ValueKind kind, const char* key) {
  static auto* const look_up = function("MHD_lookup_connection_value", MHD_lookup_connection_value);
  return look_up != nullptr ? look_up(connection, kind, key) : nullptr;
}
MHD_Response* MHD_create_response_from_buffer(std::size_t size, void* bytes, MHD_ResponseMemoryMode mode) {
  static auto* const create = function("MHD_create_response_from_buffer", MHD_create_response_from_buffer);
  return create != nullptr ? create(size, bytes, mode) : nullptr;
}
MHD_Response* MHD_create_response_from_buffer_with_free_callback_cls(std::size_t size, void* bytes,
                                                                     MHD_ContentReaderFreeCallback free,
                                                                     void* closure) {
  static auto* const create = function("MHD_create_response_from_buffer_with_free_callback_cls",
                                       MHD_create_response_from_buffer_with_free_callback_cls);
  return create != nullptr ? create(size, bytes, free, closure) : nullptr;
}
MHD_Response* MHD_create_response_from_callback(std::uint64_t size, std::size_t block_size,
                                                MHD_ContentReaderCallback read, void* closure,
                                                MHD_ContentReaderFreeCallback free) {
  static auto* const create = function("MHD_create_response_from_callback", MHD_create_response_from_callback);
  return create != nullptr ? create(size, block_size, read, closure, free) : nullptr;
}
void MHD_destroy_response(MHD_Response* response) {
  static auto* const destroy = function("MHD_destroy_response", MHD_destroy_response);
  if (destroy != nullptr) destroy(response);
}
MHD_Result MHD_add_response_header(MHD_Response* response, const char* name, const char* value) {
  static auto* const add = function("MHD_add_response_header", MHD_add_response_header);
  return add != nullptr ? add(response, name, value) : MHD_NO;
}
MHD_Result MHD_queue_response(MHD_Connection* connection, unsigned status, MHD_Response* response) {
  static auto* const queue = function("MHD_queue_response", MHD_queue_response);
  return queue != nullptr ? queue(connection, status, response) : MHD_NO;
}
MHD_Result MHD_add_connection(MHD_Daemon* daemon, MHD_socket socket, const sockaddr* address, socklen_t size) {
  static auto* const add = function("MHD_add_connection", MHD_add_connection);
  return add != nullptr ? add(daemon, socket, address, size) : MHD_NO;
}
void MHD_suspend_connection(MHD_Connection* connection) {
  static auto* const suspend = function("MHD_suspend_connection", MHD_suspend_connection);
  if (suspend != nullptr) suspend(connection);
}
void MHD_resume_connection(MHD_Connection* connection) {
  static auto* const resume = function("MHD_resume_connection", MHD_resume_connection);
  if (resume != nullptr) resume(connection);
}

}  // extern "C"
// NOLINTEND(readability-identifier-naming, cert-dcl50-cpp)

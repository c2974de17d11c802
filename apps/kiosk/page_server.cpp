// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/page_server.h"

#include <microhttpd.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <list>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "apps/common/program.h"
#include "apps/kiosk/chores.h"
#include "apps/kiosk/host_check.h"
#include "apps/kiosk/http_message.h"
#include "apps/kiosk/listening_socket.h"
#include "apps/kiosk/operator_gate.h"
#include "apps/kiosk/visitors.h"
#include "apps/kiosk/web_files.h"
#include "formats/json_file.h"

namespace im2fit::apps {
namespace {

using Clock = Visitors::Clock;
using Patience = std::chrono::milliseconds;
constexpr Patience kTick{100};             // how late a connection may be found to be over its time
constexpr Patience kCommentPeriod{10000};  // a stream without news; then a comment shows whether a client is there
constexpr Patience kStuckMax{15000};       // a stream whose client reads nothing for so long is given up
constexpr Patience kFarewell{150};         // for streams to take their end
constexpr std::size_t kConnectionBytes = 16 * 1024;  // a header and the library's own; browsers send 1 KB
constexpr std::size_t kStreamBlockBytes = 4096;
// The library stops listening at its own limit. Ours is kept by cutting off others, which close a little later.
constexpr unsigned kSpareConnections = 64;

constexpr std::pair<std::string_view, PageAction> kActions[] = {
    {"/consent", PageAction::consent}, {"/touch", PageAction::touch}, {"/delete", PageAction::erase}};
constexpr std::string_view kOffer = "/hand-over", kTake = "/take", kFacts = "/facts";
constexpr std::string_view kSignIn = "/operator/sign-in", kSignOut = "/operator/sign-out";
constexpr std::size_t kSignInBytesMax = std::size_t{1} << 10;
constexpr const char* kCookie = "im2fit_operator_";  // and the port: browsers do not tell ports apart
constexpr const char* kKept = "private, max-age=31536000, immutable";

// A request that is being answered; for a POST with a body, also the result of reading it.
struct Upload {
  std::string path;
  std::string body;
  bool wanted = false;  // false: answered already
  std::size_t bytes_max = 0;
  std::string visit;  // of /facts
  // Of a sign-in: its answer, and when that is sent.
  std::optional<OperatorGate::SignIn> sign_in;
  Clock::time_point due;
  std::shared_ptr<const LaterAnswer> later;  // its answer, once another thread has it
};

// Of a server for phones, where "/" is handed.html.
const WebFile* phone_file(std::string_view path) {
  if (path == "/") return web_file("/handed.html");
  const bool known =
      path == "/handed.js" || path == "/words.js" || path == "/page.css" || path.rfind("/lang/", 0) == 0;
  return known ? web_file(path) : nullptr;
}

// Of a server for phones, the files that stand on its board.
bool is_shops(std::string_view path) {
  return path == "/shop.json" || path == "/shop.css" || path == "/shop.png";
}

bool is_operators(std::string_view path) {
  return path == "/operator" || path.rfind("/operator/", 0) == 0;
}

struct CloseSocket {
  int socket = -1;
  ~CloseSocket() {
    if (socket >= 0) ::close(socket);
  }
};

}  // namespace

struct PageServer::Parts {
  // One watcher. The library's thread reads it; the keeper wakes it when there are news.
  struct Stream {
    Parts& parts;
    MHD_Connection* connection;
    int socket;
    std::uint64_t seen = 0;
    std::string text;  // not yet taken
    bool waiting = false;
    Clock::time_point read;  // when the client last requested more
  };

  Parts(Board& b, const std::string& host, PageHandlers h)
      : board(b), check(host), handlers(std::move(h)), gate(handlers.operator_password) {}
  MHD_Result answer(MHD_Connection* connection, std::string_view method, Upload& upload);
  MHD_Result answer_operator(MHD_Connection* connection, std::string_view method, Upload& upload);
  MHD_Result answer_facts(MHD_Connection* connection, std::string_view method, Upload& upload);
  MHD_Result want_body(MHD_Connection* connection, Upload& upload, std::size_t bytes_max);
  MHD_Result use_body(MHD_Connection* connection, Upload& upload);
  MHD_Result answer_sign_in(MHD_Connection* connection, Upload& upload);
  MHD_Result operate(MHD_Connection* connection, Upload& upload);
  MHD_Result answer_now_or_later(MHD_Connection* connection, Upload& upload, PageAnswer answer);
  MHD_Result answer_later(MHD_Connection* connection, const Upload& upload);
  MHD_Result answer_file(MHD_Connection* connection, const WebFile& file);
  MHD_Result answer_post(MHD_Connection* connection, Upload& upload);
  MHD_Result answer_phone(MHD_Connection* connection, const std::string& path);
  MHD_Result answer_stream(MHD_Connection* connection);
  static ssize_t read_stream(void* closure, std::uint64_t position, char* to, std::size_t room);
  static void end_stream(void* closure);
  void keep();
  void wake_delayed(Clock::time_point now);
  void wake_streams(bool news, Clock::time_point now);
  Visitors::Visitor* visitor_of(MHD_Connection* connection) const;

  Board& board;
  HostCheck check;
  PageHandlers handlers;
  OperatorGate gate;
  Visitors visitors{VisitorLimits{}};
  std::string url, cookie;
  MHD_Daemon* daemon = nullptr;
  std::mutex mutex;  // of streams, delayed, awaiting and stopping
  std::list<Stream> streams;
  std::vector<std::pair<MHD_Connection*, Clock::time_point>> delayed;                    // suspended until then
  std::vector<std::pair<MHD_Connection*, std::shared_ptr<const LaterAnswer>>> awaiting;  // suspended until then
  bool stopping = false;
  std::atomic<int> watchers{0};
  std::thread keeper;
};

Visitors::Visitor* PageServer::Parts::visitor_of(MHD_Connection* connection) const {
  const auto* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
  return info == nullptr ? nullptr : static_cast<Visitors::Visitor*>(info->socket_context);
}

MHD_Result PageServer::Parts::answer(MHD_Connection* connection, std::string_view method, Upload& upload) {
  const std::string& path = upload.path;
  if (auto* visitor = visitor_of(connection)) visitors.now_does(visitor, Visitors::Doing::answering, Clock::now());
  const Field host = field_of(connection, "Host"), origin = field_of(connection, "Origin");
  const Field site = field_of(connection, "Sec-Fetch-Site");
  const bool doubled = host.count > 1 || origin.count > 1 || site.count > 1;
  // To the page for phones any scanner may lead: nothing is on it, and nothing is taken by GET.
  const bool leads_to_phone_page = handlers.take && method != "POST";
  if (const std::string why = check.refusal(doubled ? std::nullopt : host.value, origin.value,
                                            leads_to_phone_page ? std::nullopt : site.value);
      !why.empty())
    return send(connection, MHD_HTTP_FORBIDDEN, copied(why + "\n"), kPlainText);
  if (handlers.operate && is_operators(path)) return answer_operator(connection, method, upload);
  if (handlers.facts && path == kFacts) return answer_facts(connection, method, upload);
  const bool acts = handlers.take ? path == kTake
                                  : (handlers.offer && path == kOffer) ||
                                        (handlers.act && std::any_of(std::begin(kActions), std::end(kActions),
                                                                     [&](const auto& k) { return k.first == path; }));
  if (acts ? method != "POST" : method != "GET" && method != "HEAD")
    return send_not_allowed(connection, acts ? "POST" : "GET, HEAD");
  // Nothing here has a use for a body: who sends one is cut off.
  const Field length = field_of(connection, "Content-Length");
  if (field_of(connection, "Transfer-Encoding").count > 0 || (length.count > 0 && length.value != "0")) return MHD_NO;
  if (handlers.take) return answer_phone(connection, path);
  if (acts) return answer_post(connection, upload);
  if (path == "/events")
    return method == "GET" ? answer_stream(connection) : send(connection, 200, copied(""), "text/event-stream");
  if (const WebFile* fixed = is_operators(path) ? nullptr : web_file(path)) return answer_file(connection, *fixed);
  if (path == "/tryon.glb" && handlers.try_on) return send_answer(connection, handlers.try_on(query_of(connection)));
  if (path == "/cloth.bin" && handlers.cloth) return send_answer(connection, handlers.cloth(query_of(connection)));
  if (auto file = board.file(path)) {
    const std::string type = file->type;
    return send(connection, MHD_HTTP_OK, shared(std::move(file)), type.c_str());
  }
  return send(connection, MHD_HTTP_NOT_FOUND, copied("not found, or not available yet\n"), kPlainText);
}

// All that a request's header can be refused for, before a byte of its body is read.
MHD_Result PageServer::Parts::answer_operator(MHD_Connection* connection, std::string_view method, Upload& upload) {
  const bool post = method == "POST";
  if (!post && method != "GET" && method != "HEAD") return send_not_allowed(connection, "GET, HEAD, POST");
  if (!post) {
    const Field length = field_of(connection, "Content-Length");
    const bool chunked = field_of(connection, "Transfer-Encoding").count > 0;
    if (chunked || (length.count > 0 && length.value != "0")) return MHD_NO;
    if (upload.path == "/operator")
      return answer_file(connection, *web_file(upload.path));  // which shows nothing yet
  }
  const Field origin = field_of(connection, "Origin"), token = field_of(connection, "X-Im2fit-Token");
  const auto refuse = [&] {
    return send(connection, MHD_HTTP_FORBIDDEN, copied("only the operator's page may request this\n"), kPlainText);
  };
  if (post && origin.count != 1) return refuse();
  if (post && upload.path == kSignIn) return want_body(connection, upload, kSignInBytesMax);
  const char* given = MHD_lookup_connection_value(connection, MHD_COOKIE_KIND, cookie.c_str());
  const std::string_view session = given == nullptr ? "" : given;
  const std::string secret = gate.token_of(session, post || !asked_untouched(upload.path), Clock::now());
  if (secret.empty()) {
    const Response response = copied("sign in at /operator first\n");
    if (response)  // RFC 9110 11.6.1; of a scheme that no browser knows, so that none asks its user
      MHD_add_response_header(response.get(), "WWW-Authenticate", R"(Im2fit-Session realm="im2fit operator")");
    return send(connection, MHD_HTTP_UNAUTHORIZED, response, kPlainText);
  }
  if (!post)
    return upload.path == "/operator/token" ? send(connection, MHD_HTTP_OK, copied(secret), kPlainText)
                                            : operate(connection, upload);
  if (token.count != 1 || !same_secret(secret, *token.value)) return refuse();
  if (upload.path == kSignOut) gate.sign_out(session);
  return want_body(connection, upload, kBodyBytesMax);
}

MHD_Result PageServer::Parts::answer_facts(MHD_Connection* connection, std::string_view method, Upload& upload) {
  if (method != "POST") return send_not_allowed(connection, "POST");
  const Field origin = field_of(connection, "Origin"), visit = field_of(connection, "X-Im2fit-Visit");
  if (origin.count != 1 || visit.count != 1)
    return send(connection, MHD_HTTP_FORBIDDEN, copied("only the page itself may request this\n"), kPlainText);
  if (visit.value->size() > kActionTextMax)
    return send(connection, MHD_HTTP_BAD_REQUEST, copied("a header of the request is too long\n"), kPlainText);
  upload.visit = *visit.value;
  return want_body(connection, upload, kFactsBytesMax);
}

// JSON of a declared length comes next, or the request is refused.
MHD_Result PageServer::Parts::want_body(MHD_Connection* connection, Upload& upload, std::size_t bytes_max) {
  const Field length = field_of(connection, "Content-Length"), type = field_of(connection, "Content-Type");
  if (type.count != 1 || type.value != "application/json")
    return send(connection, MHD_HTTP_UNSUPPORTED_MEDIA_TYPE, copied("the Content-Type must be application/json\n"),
                kPlainText);
  const auto size = length_of(length);
  if (field_of(connection, "Transfer-Encoding").count > 0 || !size)
    return send(connection, MHD_HTTP_LENGTH_REQUIRED, copied("the Content-Length is missing\n"), kPlainText);
  if (*size > bytes_max)
    return send(connection, MHD_HTTP_CONTENT_TOO_LARGE,
                copied("the body has more than " + std::to_string(bytes_max >> 10U) + " kB\n"), kPlainText);
  upload.wanted = true;
  upload.bytes_max = bytes_max;
  return MHD_YES;
}

MHD_Result PageServer::Parts::use_body(MHD_Connection* connection, Upload& upload) {
  if (upload.path == kFacts) return send_answer(connection, handlers.facts(upload.visit, upload.body));
  if (upload.path == kSignIn) return answer_sign_in(connection, upload);
  if (upload.path == kSignOut) return send(connection, MHD_HTTP_OK, copied("signed out\n"), kPlainText);
  return operate(connection, upload);
}

// The library calls again for a connection that was suspended and resumed.
MHD_Result PageServer::Parts::answer_sign_in(MHD_Connection* connection, Upload& upload) {
  const auto now = Clock::now();
  if (!upload.sign_in) {
    const auto body = parse_json<nlohmann::json>(upload.body, "the request");
    const bool has = body && body->is_object() && body->contains("password") && (*body)["password"].is_string();
    const auto* visitor = visitor_of(connection);
    upload.sign_in = gate.sign_in(has ? (*body)["password"].get<std::string>() : "",
                                  visitor == nullptr ? "" : visitor->address, now);
    upload.due = now + upload.sign_in->wait;
  }
  if (now < upload.due) {
    const std::lock_guard lock(mutex);
    if (stopping) return MHD_NO;
    delayed.emplace_back(connection, upload.due);
    MHD_suspend_connection(connection);
    return MHD_YES;
  }
  if (upload.sign_in->session.empty())
    return send(connection, MHD_HTTP_FORBIDDEN, copied("this password is wrong\n"), kPlainText);
  const Response response = copied("signed in\n");
  if (response)
    MHD_add_response_header(
        response.get(), "Set-Cookie",
        (cookie + "=" + upload.sign_in->session + "; Path=/operator; HttpOnly; SameSite=Strict").c_str());
  return send(connection, MHD_HTTP_OK, response, kPlainText);
}

MHD_Result PageServer::Parts::operate(MHD_Connection* connection, Upload& upload) {
  const auto query = query_of(connection);
  return answer_now_or_later(connection, upload, handlers.operate({upload.wanted, upload.path, upload.body, query}));
}

MHD_Result PageServer::Parts::answer_now_or_later(MHD_Connection* connection, Upload& upload, PageAnswer answer) {
  if (!answer.later) return send_answer(connection, std::move(answer));
  upload.later = std::move(answer.later);
  return answer_later(connection, upload);
}

// The library calls again for a connection that was suspended and resumed.
MHD_Result PageServer::Parts::answer_later(MHD_Connection* connection, const Upload& upload) {
  if (auto given = upload.later->given()) return send_answer(connection, std::move(*given));
  const std::lock_guard lock(mutex);
  if (stopping) return MHD_NO;
  awaiting.emplace_back(connection, upload.later);
  MHD_suspend_connection(connection);
  return MHD_YES;
}

// The token comes by a field that no other site's page may send unasked.
MHD_Result PageServer::Parts::answer_phone(MHD_Connection* connection, const std::string& path) {
  if (path == kTake) {
    const Field origin = field_of(connection, "Origin"), token = field_of(connection, "X-Im2fit-Token");
    if (origin.count != 1 || token.count != 1)
      return send(connection, MHD_HTTP_FORBIDDEN, copied("only the page itself may request this\n"), kPlainText);
    return send_answer(connection, handlers.take(*token.value));
  }
  if (const WebFile* file = phone_file(path)) return answer_file(connection, *file);
  if (auto file = is_shops(path) ? board.file(path) : nullptr) {
    const std::string type = file->type;
    return send(connection, MHD_HTTP_OK, shared(std::move(file)), type.c_str());
  }
  return send(connection, MHD_HTTP_NOT_FOUND, copied("not found\n"), kPlainText);
}

MHD_Result PageServer::Parts::answer_post(MHD_Connection* connection, Upload& upload) {
  const std::string& path = upload.path;
  const Field origin = field_of(connection, "Origin"), visit = field_of(connection, "X-Im2fit-Visit");
  const Field note = field_of(connection, "X-Im2fit-Note");
  if (origin.count != 1 || visit.count != 1 || note.count > 1)
    return send(connection, MHD_HTTP_FORBIDDEN, copied("only the page itself may request this\n"), kPlainText);
  const std::string_view text = note.value.value_or("");
  if (visit.value->size() > kActionTextMax || text.size() > kActionTextMax)
    return send(connection, MHD_HTTP_BAD_REQUEST, copied("a header of the request is too long\n"), kPlainText);
  if (path == kOffer) return send_answer(connection, handlers.offer(*visit.value));
  const auto* action =
      std::find_if(std::begin(kActions), std::end(kActions), [&](const auto& known) { return known.first == path; });
  return answer_now_or_later(connection, upload, handlers.act(action->second, *visit.value, text));
}

MHD_Result PageServer::Parts::answer_file(MHD_Connection* connection, const WebFile& file) {
  const bool compressed =
      !file.gzip.empty() && takes_gzip(field_of(connection, "Accept-Encoding").value.value_or(""));
  const Response response = lasting_bytes(compressed ? file.gzip : file.bytes);
  if (response && compressed) MHD_add_response_header(response.get(), "Content-Encoding", "gzip");
  if (response && !file.gzip.empty()) MHD_add_response_header(response.get(), "Vary", "Accept-Encoding");
  return send(connection, MHD_HTTP_OK, response, file.type, file.lasting ? kKept : kNotKept);
}

MHD_Result PageServer::Parts::answer_stream(MHD_Connection* connection) {
  auto* visitor = visitor_of(connection);
  const auto now = Clock::now();
  std::unique_lock lock(mutex);
  if (visitor == nullptr || stopping || watchers >= kWatchersMax) {
    lock.unlock();
    return send(connection, MHD_HTTP_SERVICE_UNAVAILABLE, copied("too many pages are open; close another page\n"),
                kPlainText);
  }
  ++watchers;
  const auto* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
  // Who lost the stream asks again after a second: a page is to notice within three that all is well.
  streams.push_back({*this, connection, info->connect_fd, 0, "retry: 1000\n\n", false, now});
  Stream* stream = &streams.back();
  lock.unlock();
  const Response response(
      MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, kStreamBlockBytes, read_stream, stream, end_stream));
  if (!response) {
    end_stream(stream);
    return MHD_NO;
  }
  visitors.now_does(visitor, Visitors::Doing::watching, now);
  return send(connection, MHD_HTTP_OK, response, "text/event-stream");
}

ssize_t PageServer::Parts::read_stream(void* closure, std::uint64_t, char* to, std::size_t room) {
  Stream& stream = *static_cast<Stream*>(closure);
  Parts& parts = stream.parts;
  const auto now = Clock::now();
  const std::lock_guard lock(parts.mutex);
  if (parts.stopping) return MHD_CONTENT_READER_END_OF_STREAM;
  if (stream.text.empty()) stream.text = parts.board.wait(stream.seen, Patience(0));
  if (stream.text.empty() && now - stream.read >= kCommentPeriod) stream.text = ": still here\n\n";
  if (stream.text.empty()) {
    // Also for a client that has taken everything: only a client with text left is stuck.
    stream.waiting = true;
    MHD_suspend_connection(stream.connection);
    return 0;
  }
  stream.read = now;
  const std::size_t count = std::min(room, stream.text.size());
  std::memcpy(to, stream.text.data(), count);
  stream.text.erase(0, count);
  return static_cast<ssize_t>(count);
}

void PageServer::Parts::end_stream(void* closure) {
  auto* stream = static_cast<Stream*>(closure);
  Parts& parts = stream->parts;
  const std::lock_guard lock(parts.mutex);
  parts.streams.remove_if([&](const Stream& s) { return &s == stream; });
  --parts.watchers;
}

// Wakes waiting streams when there is something to send, or when their clients have gone; the library does not watch
// a stream that waits.
void PageServer::Parts::wake_streams(bool news, Clock::time_point now) {
  for (Stream& stream : streams) {
    if (!stream.waiting) {
      if (now - stream.read >= kStuckMax) cut(stream.socket);
      continue;
    }
    pollfd item{stream.socket, POLLRDHUP, 0};
    const bool gone = ::poll(&item, 1, 0) > 0;
    if (!news && !gone && !stopping && now - stream.read < kCommentPeriod) continue;
    stream.waiting = false;
    if (gone) stream.text = ": gone\n\n";  // else it would wait again: writing shows the library that it has
    MHD_resume_connection(stream.connection);
  }
}

void PageServer::Parts::wake_delayed(Clock::time_point now) {
  std::erase_if(delayed, [&](const auto& one) {
    if (!stopping && now < one.second) return false;
    MHD_resume_connection(one.first);
    return true;
  });
  std::erase_if(awaiting, [&](const auto& one) {
    if (!stopping && !one.second->given()) return false;
    MHD_resume_connection(one.first);
    return true;
  });
}

void PageServer::Parts::keep() {
  for (std::uint64_t known = 0;;) {
    const std::uint64_t number = board.await(known, kTick);
    const bool news = number != known;
    known = number;
    const auto now = Clock::now();
    visitors.cut_late(now);
    const std::lock_guard lock(mutex);
    stopping = stopping || board.closed();
    wake_delayed(now);
    wake_streams(news, now);
    if (stopping) return;
  }
}

Result<std::unique_ptr<PageServer>> PageServer::open(const PageAddress& address, Board& board,
                                                     PageHandlers handlers) {
  if (handlers.operate && handlers.operator_password.empty())
    return Error{ErrorCode::invalid_argument, "the operator's page needs a password"};
  CloseSocket listening{listen_at(address.host, address.port)};
  const int reason = errno;
  const auto failed = [&](int code) {
    return Error{ErrorCode::io, "cannot listen at " + address.host + ":" + std::to_string(address.port) +
                                    (code != 0 ? std::string(" (") + std::strerror(code) + ")" : std::string()) +
                                    "; try another " + address.options};
  };
  if (listening.socket < 0) return failed(reason);
  auto made = std::make_unique<Parts>(board, address.host, std::move(handlers));
  Parts& parts = *made;
  const bool v6 = address.host.find(':') != std::string::npos;
  parts.cookie = kCookie + std::to_string(port_of(listening.socket));
  parts.url = "http://" + (v6 ? "[" + address.host + "]" : address.host) + ":" +
              std::to_string(port_of(listening.socket)) + "/";

  const MHD_AccessHandlerCallback answer = [](void* closure, MHD_Connection* connection, const char* url,
                                              const char* method, const char*, const char* data, std::size_t* upload,
                                              void** request) -> MHD_Result {
    auto& parts = *static_cast<Parts*>(closure);
    try {
      if (*request == nullptr) {
        auto* begun = new Upload;  // until the request is completed
        begun->path = url;
        *request = begun;
        return parts.answer(connection, method, *begun);
      }
      auto& going = *static_cast<Upload*>(*request);
      const std::size_t count = std::exchange(*upload, 0);
      if (going.later) return parts.answer_later(connection, going);
      if (!going.wanted) return MHD_YES;  // a refused method may have a body
      if (count == 0) return parts.use_body(connection, going);
      if (count > going.bytes_max - going.body.size()) return MHD_NO;
      going.body.append(data, count);
      return MHD_YES;
    } catch (const std::exception& fault) {
      // In the library, which is C, it would end the program and everybody's page.
      const auto* going = static_cast<const Upload*>(*request);
      print_error("the page failed to answer " + std::string(method) + " " + (going == nullptr ? "" : going->path) +
                  ": " + fault.what());
      return send(connection, MHD_HTTP_INTERNAL_SERVER_ERROR, lasting_bytes("this failed; reload the page\n"),
                  kPlainText);
    }
  };
  const MHD_NotifyConnectionCallback connected = [](void* closure, MHD_Connection* connection, void** context,
                                                    MHD_ConnectionNotificationCode code) {
    Visitors& visitors = static_cast<Parts*>(closure)->visitors;
    if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
      visitors.left(static_cast<Visitors::Visitor*>(std::exchange(*context, nullptr)));
      return;
    }
    const int socket = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    const sockaddr* from = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS)->client_addr;
    *context = visitors.came(socket, from, Clock::now());
  };
  const MHD_RequestCompletedCallback completed = [](void* closure, MHD_Connection* connection, void** request,
                                                    MHD_RequestTerminationCode) {
    delete static_cast<Upload*>(std::exchange(*request, nullptr));
    auto* parts = static_cast<Parts*>(closure);
    if (auto* visitor = parts->visitor_of(connection))
      parts->visitors.now_does(visitor, Visitors::Doing::asking, Clock::now());
  };
  const unsigned limit = static_cast<unsigned>(VisitorLimits{}.visitors_max) + kSpareConnections;
  // In an array, which alone can be handed on to a library that is loaded later (web_server_library.h).
  MHD_OptionItem options[] = {
      {MHD_OPTION_LISTEN_SOCKET, listening.socket, nullptr},
      {MHD_OPTION_NOTIFY_CONNECTION, reinterpret_cast<std::intptr_t>(connected), &parts},
      {MHD_OPTION_NOTIFY_COMPLETED, reinterpret_cast<std::intptr_t>(completed), &parts},
      {MHD_OPTION_CONNECTION_MEMORY_LIMIT, static_cast<std::intptr_t>(kConnectionBytes), nullptr},
      {MHD_OPTION_CONNECTION_MEMORY_INCREMENT, 1024, nullptr},
      {MHD_OPTION_CONNECTION_LIMIT, static_cast<std::intptr_t>(limit), nullptr},
      {MHD_OPTION_STRICT_FOR_CLIENT, 1, nullptr},
      {MHD_OPTION_END, 0, nullptr}};
  parts.daemon = MHD_start_daemon(MHD_USE_POLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME, 0, nullptr, nullptr,
                                  answer, &parts, MHD_OPTION_ARRAY, options, MHD_OPTION_END);
  if (parts.daemon == nullptr) return failed(errno);
  listening.socket = -1;  // the daemon's
  parts.keeper = std::thread([&parts] { parts.keep(); });
  return std::unique_ptr<PageServer>(new PageServer(std::move(made)));
}

PageServer::PageServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

PageServer::~PageServer() {
  parts_->board.close();
  parts_->keeper.join();
  for (const auto end = Clock::now() + kFarewell; parts_->watchers > 0 && Clock::now() < end;)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  MHD_stop_daemon(parts_->daemon);
}

const std::string& PageServer::url() const {
  return parts_->url;
}
int PageServer::watchers() const {
  return parts_->watchers;
}

Status PageServer::add(int socket) {
  sockaddr_in nowhere{};
  nowhere.sin_family = AF_INET;
  if (MHD_add_connection(parts_->daemon, socket, reinterpret_cast<const sockaddr*>(&nowhere), sizeof nowhere) ==
      MHD_YES)
    return Ok{};
  return Error{ErrorCode::io, std::string("cannot serve a connection: ") + std::strerror(errno)};
}

}  // namespace im2fit::apps

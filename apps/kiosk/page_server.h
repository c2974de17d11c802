// SPDX-License-Identifier: Apache-2.0
// A board over HTTP: its files, its messages as a stream at /events, and the page that shows them.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/kiosk/board.h"
#include "core/status.h"

namespace im2fit::apps {

struct PageAddress {
  std::string host = "127.0.0.1";
  int port = 8017;                           // 0: any that is free
  std::string options = "--port or --host";  // the options named in the error when the address cannot be used
};

// What a page may ask for by POST, without a body.
enum class PageAction { consent, touch, erase };
// `visit`: the id that the page names (the field X-Im2fit-Visit), `note`: the page's note (X-Im2fit-Note), both at
// most kActionTextMax long. On the server's thread, which must not wait for a disk. 409 when the visit is over.
using PageActor = std::function<PageAnswer(PageAction action, std::string_view visit, std::string_view note)>;
inline constexpr std::size_t kActionTextMax = 64;
// The fields of the query of /tryon.glb or /cloth.bin, as they are. On the server's thread.
using PageQuery = std::function<PageAnswer(std::span<const std::pair<std::string, std::string>> fields)>;

// What the operator's page asks for, below /operator/: by GET, or by POST with a body of JSON.
struct PageRequest {
  bool post = false;
  std::string_view path;  // "/operator/save"
  std::string_view body;  // at most kBodyBytesMax; "" for GET
  std::span<const std::pair<std::string, std::string>> query;
};
using PageOperator = std::function<PageAnswer(const PageRequest& request)>;
inline constexpr std::size_t kBodyBytesMax = std::size_t{64} << 10;

// POST /facts of the page, for the visit it names: the facts that the person reports, JSON of kFactsBytesMax or less.
using PageFacts = std::function<PageAnswer(std::string_view visit, std::string_view body)>;
inline constexpr std::size_t kFactsBytesMax = std::size_t{1} << 10;

// POST /hand-over of the page itself, for the visit it names: how a phone may get its result, as JSON.
using PageOffer = std::function<PageAnswer(std::string_view visit)>;
// POST /take: what waits for this token, given once; 404 without it.
using PageTake = std::function<PageAnswer(std::string_view token)>;

struct PageHandlers {
  PageActor act;                  // without it POST is refused
  PageQuery try_on;               // without it there is no /tryon.glb
  PageQuery cloth;                // without it there is no /cloth.bin
  PageOperator operate;           // without it there is no /operator; on the server's thread
  std::string operator_password;  // needed with `operate`, at this machine too: a kiosk's customers are there
  PageOffer offer;                // without it there is no /hand-over
  PageFacts facts;                // without it there is no /facts
  // With it the server is one for phones: it answers for the page that shows the taken result, its files, POST /take,
  // of the board for /shop.json, /shop.css and /shop.png, and nothing else.
  PageTake take;
};

// One thread serves all connections, and waits for none of them, nor for an answer that comes later (chores.h):
// visitors.h limits their number and their time. A request's header may have 16 KB. Only POST /facts and the
// operator's POST may have a body. host_check.h lists the accepted hosts. GET and HEAD, and POST of /consent, /facts,
// /touch, /delete and /hand-over from the page itself: with its Origin, which browsers always send with a POST, and
// with a field that a page of another site cannot send without a preflight request (Fetch, CORS-preflight). Anybody
// gets the operator's page, which shows nothing before POST /operator/sign-in with the password; everything else
// below it needs the session of that (operator_gate.h), and POST also the Origin and the token from GET
// /operator/token, in the field X-Im2fit-Token. POST /operator/sign-out ends it.
class PageServer {
 public:
  static constexpr int kWatchersMax = 8;  // streams at once; further ones are answered 503

  // Answers from here on, on two threads of its own. `board` must outlive it. Errors: the address cannot be listened
  // at; an operator's page without a password.
  static Result<std::unique_ptr<PageServer>> open(const PageAddress& address, Board& board,
                                                  PageHandlers handlers = {});
  // Closes the board; streams get their end, everyone else is cut off. Takes less than half a second whatever clients
  // do.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  const std::string& url() const;  // "http://127.0.0.1:8017/"
  int watchers() const;            // streams open now
  // Serves a connected stream socket as one that was accepted, and owns it from here on.
  Status add(int socket);

 private:
  struct Parts;
  explicit PageServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace im2fit::apps

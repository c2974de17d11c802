// SPDX-License-Identifier: Apache-2.0
// serve: live, with a page for a browser.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>

#include "apps/im2fit/commands.h"
#include "apps/im2fit/live_run.h"
#include "apps/im2fit/remeasure.h"
#include "apps/kiosk/live_page.h"
#include "apps/kiosk/operator_gate.h"
#include "apps/kiosk/web_server_library.h"
#include "apps/sessions/store.h"
#include "engine/diagnosis.h"
#include "person/tape_file.h"

namespace im2fit::apps {
namespace {

constexpr auto kRetryPeriod = std::chrono::seconds(1);  // a page says within three that a camera is there
constexpr auto kPollPeriod = std::chrono::milliseconds(20);

struct ServeOptions {
  LiveOptions live;
  PageAddress address;
  bool no_consent = false;
  bool ask_facts = false;
  bool wait = false;
  bool desk = false;  // the operator's part of the page
  std::string password_file, sessions = sessions::default_root(), site;
  std::string shop;        // file of apps/kiosk/shop_file.h; "": none
  std::string statistics;  // file; "": none
  std::string phones;      // address where phones take results; "": they do not
  int phones_port = 8018;
};

// Of a model, in a pack or not. "": it cannot be read.
std::string digest_of(const std::string& path, const char* name) {
  const auto bytes = model_bytes(path, name);
  return bytes ? sessions::digest_of(*bytes) : "";
}

sessions::Versions versions_of(const SessionOptions& session) {
  return {IM2FIT_VERSION, digest_of(session.input.body, kPackedBody), digest_of(session.tracker, kPackedTracker),
          digest_of(session.index, kPackedIndex)};
}

class PageListener final : public LiveListener {
 public:
  PageListener(LivePage& page, const ServeOptions& options)
      : page_(page), options_(options), frames_wanted_(options.live.session.frames) {}
  void begin(const SessionOutcome& session) override {
    if (options_.desk) {
      const hal::SourceInfo& source = session.input.source->info();
      page_.use_source(source, versions_of(options_.live.session),
                       [&session, intrinsics = source.intrinsics](DepthView depth) {
                         return diagnose(depth, intrinsics, &session.data.tracker->model());
                       });
    }
    page_.begin(session.input.source->info().intrinsics, frames_wanted_);
    page_.trouble("");
    invite();
  }
  void invite() {
    if (!invited_) print_error("open " + page_.url() + " in a browser; Ctrl-C ends this");
    if (!invited_ && !options_.phones.empty())
      print_error("phones in this network fetch results at " + page_.phone_url());
    if (!invited_ && options_.desk)
      print_error("the operator's page is " + page_.url() + "operator; sessions go to " + options_.sessions);
    invited_ = true;
  }
  std::uint64_t permit() override { return page_.permit(); }
  void begin_person(std::uint64_t permit) override { page_.begin_person(permit); }
  ReportedFacts reported(std::uint64_t permit) override { return page_.reported(permit); }
  OperatorRegion region() override { return page_.region(); }
  void see(const FrameSeen& frame) override { page_.see(frame); }
  void publish(const Json& event) override { page_.publish(event); }
  Status measured(const SessionOutcome& session) override {
    if (!session.avatar) return Ok{};
    const body::Avatar& avatar = session.avatar->avatar;
    page_.may_try_on(
        {"", avatar.params, avatar.pose, session.person.result.answer.female > 0.5F, session.person.fits});
    return page_.measured(avatar, session.avatar->glb);
  }

 private:
  LivePage& page_;
  const ServeOptions& options_;
  int frames_wanted_;
  bool invited_ = false;
};

// What write_outputs() made, and the folder if nothing else is in it.
void erase_outputs(const std::string& folder) {
  std::error_code fault;
  for (const char* name :
       {"result.json", "overlay.png", "avatar.glb", "avatar.obj", "avatar.mtl", "avatar_skin.png", "avatar.bvh"}) {
    std::filesystem::remove(std::filesystem::path(folder) / name, fault);
    if (fault) print_error("cannot delete " + folder + "/" + name + ": " + fault.message());
  }
  std::filesystem::remove(folder, fault);  // an error when it is not empty: it stays
}

void sleep_unless_interrupted(std::chrono::milliseconds time) {
  for (auto slept = time * 0; slept < time && !interrupted(); slept += kPollPeriod)
    std::this_thread::sleep_for(kPollPeriod);
}

// For a page: whether it is the models that are missing, or the camera.
std::string_view trouble_of(const ServeOptions& options) {
  return load_measuring_data(options.live.session, options.live.session.input.body) ? "NO_CAMERA" : "MODELS_MISSING";
}

Result<int> serve_until_interrupted(const ServeOptions& options, LivePage& page) {
  LiveOptions live = options.live;
  live.print_results = options.no_consent;  // a service's output is kept in a journal
  live.recorded = options.desk;
  PageListener listener(page, options);
  std::string last_said;
  if (options.wait) listener.invite();
  for (;;) {
    auto code = run_live(live, &listener);
    if (code || !options.wait || interrupted()) return code;
    if (code.error().message != last_said) print_error(code.error().message + "; trying again until Ctrl-C");
    last_said = code.error().message;
    page.trouble(trouble_of(options));
    sleep_unless_interrupted(kRetryPeriod);
    if (interrupted()) return kExitOk;
  }
}

Result<OperatorSettings> operator_settings(const ServeOptions& options) {
  OperatorSettings desk;
  desk.root = options.sessions;
  desk.site = options.site;
  const SessionOptions& session = options.live.session;
  desk.settings = {session.frames,   session.turn,   session.calibration,
                   session.clothing, session.sensor, session.region};
  const auto tape = load_tapes(session.tapes);
  if (!tape) return tape.error();
  for (const body::TapeDefinition& d : tape->definitions) {
    if (unit_of(d) != "mm") continue;  // a scale is in the form; what cannot be measured here can by a tape
    Json names = Json::object();
    for (std::size_t i = 0; i < body::kTapeLanguages.size(); ++i)
      if (!d.names[i].empty()) names[std::string(body::kTapeLanguages[i])] = d.names[i];
    desk.tape.emplace_back(d.id, std::move(names));
  }
  desk.measure = [&options](const std::string& id) -> Result<Json> {
    RemeasureOptions again;
    again.root = options.sessions;
    again.id = id;
    again.body = options.live.session.input.body;
    again.tracker = options.live.session.tracker;
    again.index = options.live.session.index;
    auto done = remeasure(again);
    if (!done) return done.error();
    return Json{{"then", std::move(done->before)}, {"now", std::move(done->now)}};
  };
  return desk;
}

// What keeps the operator's part from being served.
Status check_operator(const ServeOptions& options) {
  if (!options.desk) {
    if (options.password_file.empty()) return Ok{};
    return Error{ErrorCode::invalid_argument, "--operator-password-file needs --operator; give both"};
  }
  if (options.no_consent)
    return Error{ErrorCode::invalid_argument, "--operator records people who consent; leave --no-consent out"};
  if (options.password_file.empty())  // at this machine too: customers use its browser
    return Error{
        ErrorCode::invalid_argument,
        "--operator lets who opens /operator read and delete sessions; it needs --operator-password-file FILE"};
  return Ok{};
}

// A code must name an address that a phone can go to; these name all of them.
Status check_hand_over(const ServeOptions& options) {
  if (options.phones != "0.0.0.0" && options.phones != "::") return Ok{};
  return Error{ErrorCode::invalid_argument, "--hand-over " + options.phones +
                                                " is not an address that a phone can open; give this machine's "
                                                "address in the network of the phones, such as 192.168.1.20"};
}

// With consent the next person is not yet known: facts come from the page.
Status check_facts(const ServeOptions& options) {
  if (options.ask_facts && options.no_consent)
    return Error{ErrorCode::invalid_argument,
                 "--ask-facts shows its form between consent and measuring; leave --no-consent out"};
  if (!options.no_consent && known_facts(options.live.session.known_words).given() != 0)
    return Error{ErrorCode::invalid_argument,
                 "height, weight, sex and age are options of a run with --no-consent; with consent give --ask-facts, "
                 "and each person may enter them on the page"};
  if (options.wait && known_facts(options.live.session.known_words).given() != 0)
    return Error{ErrorCode::invalid_argument,
                 "height, weight, sex and age describe one person; with --wait a camera that comes back may see "
                 "another one: leave one of them out"};
  return Ok{};
}

Result<int> run_serve(const ServeOptions& options) {
  if (const auto loaded = load_web_server_library(); !loaded) return loaded.error();
  if (const auto checked = check_facts(options); !checked) return checked.error();
  if (const auto checked = check_operator(options); !checked) return checked.error();
  if (const auto checked = check_hand_over(options); !checked) return checked.error();
  if (options.no_consent && !options.statistics.empty())
    return Error{ErrorCode::invalid_argument,
                 "--statistics counts visits, which begin with consent; leave --no-consent out"};
  if (!options.no_consent && !options.live.session.motion.empty())
    return Error{
        ErrorCode::invalid_argument,
        "--motion writes the movements of all people into one file, from which no one can be deleted; it needs "
        "--no-consent"};
  LivePageSettings settings;
  if (!options.shop.empty()) {
    auto shop = read_shop(options.shop);
    if (!shop) return shop.error();
    settings.shop = std::move(*shop);
  }
  catch_interrupt();
  settings.address = options.address;
  settings.body_path = options.live.session.input.body;
  settings.visit.ask = !options.no_consent;
  settings.visit.ask_facts = options.ask_facts;
  settings.keeps_files = !options.live.session.out.empty() || options.live.session.json;
  settings.consented = [](std::uint64_t visit, const std::string& text) {
    print_error(fmt::format("visit {}: consent to text {}", visit, text.empty() ? "unknown" : text));
  };
  settings.erase_folder = erase_outputs;
  settings.statistics_path = options.statistics;
  if (!options.phones.empty())
    settings.hand_over = {options.phones, options.phones_port, "--hand-over-port or --hand-over"};
  if (options.desk) {
    auto desk = operator_settings(options);
    if (!desk) return desk.error();
    settings.desk = std::move(*desk);
    auto password = read_password(options.password_file);
    if (!password) return password.error();
    settings.operator_password = std::move(*password);
  }
  auto page = LivePage::open(settings);
  if (!page) return page.error();
  auto code = serve_until_interrupted(options, **page);
  // A recording is over before people have read its result.
  while (code && !interrupted()) sleep_unless_interrupted(kRetryPeriod);
  return code;
}

}  // namespace

void add_serve(cli::App& app, Command& chosen) {
  auto options = std::make_shared<ServeOptions>();
  auto* sub = add_command<ServeOptions>(
      app, chosen, "serve", "Measure live and serve a web page with guidance, measurements and a moving 3D body",
      "  im2fit serve openni2 --rotate 90\n  im2fit serve FOLDER --no-consent --port 0\n  im2fit serve usb --rotate "
      "90 --host "
      "0.0.0.0     every machine that can reach this one can see the camera's pictures",
      options, run_serve);
  add_live_options(*sub, options->live);
  sub->remove_option(sub->get_option("--only"));  // the page shows everything
  sub->get_option("--count")->description("Measure N people, then only show the page; 0: until Ctrl-C");
  sub->add_flag("--no-consent", options->no_consent,
                "Measure the person in view without asking for consent; for recordings and for yourself");
  sub->add_flag(
      "--ask-facts", options->ask_facts,
      "After consent, show a form for height, weight, sex and age. One touch skips it. The entries are not kept "
      "after the visit, except in result.json of --out");
  sub->add_flag("--wait", options->wait,
                "Wait for a missing camera or missing models and show this on the page; for a service");
  sub->add_flag("--operator", options->desk,
                "Add a page at /operator that records people with tape values, see docs/sessions.md");
  sub->add_option("--operator-password-file", options->password_file,
                  "File with the operator's password, readable only by its owner; required with --operator")
      ->type_name("FILE");
  sub->add_option("--sessions", options->sessions, "Folder of the operator's sessions")
      ->type_name("DIR")
      ->capture_default_str();
  sub->add_option("--site", options->site, "Name of this place, entered in the operator's form by default")
      ->type_name("NAME");
  sub->add_option(
         "--shop", options->shop,
         "JSON file with the shop's name, logo and colours, and with operator, purpose and contact for the consent "
         "text; see docs/page.md")
      ->type_name("FILE");
  sub->add_option("--statistics", options->statistics,
                  "CSV file with counts of visits, sizes and reasons for missing measurements, over all people; see "
                  "docs/page.md")
      ->type_name("FILE");
  sub->add_option(
         "--hand-over", options->phones,
         "Address of this machine in the network of the phones. People can fetch their result there once, by a QR "
         "code; nothing else is served at this address")
      ->type_name("ADDRESS");
  sub->add_option("--hand-over-port", options->phones_port, "Port of --hand-over; 0: any free port")
      ->range(0, 65535)
      ->capture_default_str();
  sub->add_option("--host", options->address.host,
                  "Address to listen at; with any address other than 127.0.0.1, other machines can open the page")
      ->capture_default_str();
  sub->add_option("--port", options->address.port, "Port; 0: any free port")->range(0, 65535)->capture_default_str();
}

}  // namespace im2fit::apps

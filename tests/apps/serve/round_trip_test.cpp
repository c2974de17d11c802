// SPDX-License-Identifier: Apache-2.0
// The loop that a shop closes: people before a camera that is out of true, the operator's form over HTTP, their
// sessions, `study`, `calibrate`, and `measure` of a new person with the calibration.
#include <cmath>
#include <memory>
#include <optional>

#include "apps/sessions/store.h"
#include "core/file.h"
#include "depth_folder.h"
#include "measure_run.h"
#include "person/measuring_data.h"
#include "person/person_measurement.h"
#include "report/result_json.h"
#include "shown_page.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"
#include "well_formed.h"

namespace im2fit {
namespace {

using Json = nlohmann::json;

constexpr int kPeople = 12;       // two more than a calibration needs
constexpr int kFramesWanted = 5;  // behind each answer
constexpr int kFramesShownMax = 30;
// Of the depth delivered, by the true one: stature comes out some 25 mm too tall.
constexpr double kCameraScale = 1.015;
constexpr char kCamera[] = "a Kinect that was never calibrated";

// A person's pictures as that camera delivers them, upright.
class BadCamera {
 public:
  BadCamera(const body::BodyModel& model, const lab::Subject& subject)
      : sensor_(lab::kinect_intrinsics(320, 240)),
        delivered_(320UL * 240UL),
        upright_(320UL * 240UL),
        scene_(model, subject, staged(), lab::exact_sensor(), sensor_, 5) {}
  static Intrinsics intrinsics() { return hal::rotate_upright(lab::kinect_intrinsics(320, 240), kMounted); }
  DepthView take(std::uint64_t number) {
    scene_.render(number, {delivered_.data(), 320, 240});
    for (std::uint16_t& mm : delivered_) mm = static_cast<std::uint16_t>(std::lround(mm * kCameraScale));
    hal::rotate_upright(DepthView(delivered_.data(), 320, 240), kMounted, {upright_.data(), 240, 320});
    return {upright_.data(), 240, 320};
  }

 private:
  static constexpr int kMounted = 90;
  static lab::SceneOptions staged() {
    lab::SceneOptions options;
    options.rotate_deg = kMounted;
    options.yaw_deg = 0;
    options.pose = lab::StandingPose::arms_out;  // so that nobody needs guidance
    return options;
  }
  Intrinsics sensor_;
  std::vector<std::uint16_t> delivered_, upright_;
  lab::VirtualScene scene_;
};

hal::FrameInfo info_of(std::uint64_t number) {
  hal::FrameInfo info;
  info.sequence = number;
  info.host_ns = static_cast<std::int64_t>(number) * 33'333'333;
  return info;
}

// What a shop has: the page with its operator's part, and an engine behind it.
class Shop {
 public:
  explicit Shop(const std::string& root) : root_(root) {
    auto data = load_measuring_data({test::tracker_path(), test::index_path(), test::body_path(), {}});
    EXPECT_TRUE(data) << data.error().message;
    if (!data) return;
    data_ = std::make_unique<MeasuringData>(std::move(*data));
    source_.name = source_.uri = kCamera;
    source_.sensor = SensorKind::structured_light;
    source_.intrinsics = BadCamera::intrinsics();
    EngineSettings engine;
    engine.width = source_.intrinsics.width;
    engine.height = source_.intrinsics.height;
    engine.intrinsics = source_.intrinsics;
    engine.frames_wanted = kFramesWanted;
    engine.sensor = source_.sensor;
    engine.watch = [this](const FrameSeen& frame) { page_->page().see(frame); };
    auto made = make_engine(engine, *data_, kCamera);
    EXPECT_TRUE(made) << made.error().message;
    if (made) engine_ = std::move(*made);
    apps::LivePageSettings page;
    page.desk.emplace();
    page.desk->root = root;
    page.desk->site = "Shop 3";
    for (const MeasurementInfo& info : kMeasurementTable)
      page.desk->tape.emplace_back(std::string(info.id), Json::object());
    page.desk->settings = {kFramesWanted, "none", "none", "auto", "auto"};
    page_ = std::make_unique<test::ShownPage>(page);
    page_->page().use_source(
        source_, {"1.0.0", digest(test::body_path()), digest(test::tracker_path()), digest(test::index_path())});
  }
  const body::BodyModel& model() const { return *data_->body_model; }
  bool ready() const { return engine_ != nullptr; }

  // One person, from consent to the saved session; returns its id, "" without one.
  std::string visit(int number, const lab::Subject& subject) {
    EXPECT_EQ(post("/operator/begin", {{"language", "en"}, {"version", "1"}}), 200);
    // As run_live() does when another may be measured.
    engine_->reset();
    page_->begin_person();
    BadCamera camera(model(), subject);
    for (std::uint64_t i = 0; i < kFramesShownMax && !engine_->result().measured; ++i) {
      EXPECT_TRUE(engine_->push(camera.take(i), info_of(i)));
      EXPECT_TRUE(engine_->wait_idle(-1));
    }
    engine_->finish();
    const auto person = measurement_of(*engine_, data_->parts(), source_);
    if (!person || !person->result.measured) return "";
    page_->page().publish(apps::measured_event(1, number, result_json(*person)));
    EXPECT_EQ(post("/operator/save", form(number, subject)), 202);
    for (int i = 0; i < 2000; ++i) {
      const Json job =
          Json::parse(page_->operator_client().Get("/operator/state")->body).value("job", Json::object());
      if (job.value("running", true)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        continue;
      }
      EXPECT_EQ(job["error"], "");
      return job["id"];
    }
    return "";
  }

 private:
  static std::string digest(const std::string& path) { return sessions::digest_of(*read_file(path)); }
  int post(const std::string& path, const Json& body) const { return page_->post_operator(path, body).first; }
  // What a tape and a scale say that are right; girths twice, with a millimetre or two between.
  static Json form(int number, const lab::Subject& subject) {
    Json truth = {{"gender", subject.woman ? "female" : "male"}, {"clothing", "bare"}, {"tape", Json::object()}};
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const std::string id(kMeasurementTable[m].id);
      const double value = std::round(static_cast<double>(subject.truth[m]));
      if (kMeasurementTable[m].unit == "kg")
        truth["weight_kg"] = value;
      else if (id == "stature")
        truth["height_mm"] = value;
      else
        truth["tape"][id] = {value - 1, value + 1 + number % 2};
    }
    return {{"person", "P" + std::to_string(number)}, {"site", "Shop 3"}, {"notes", ""}, {"truth", truth}};
  }
  const std::string root_;
  std::unique_ptr<MeasuringData> data_;
  hal::SourceInfo source_;
  std::unique_ptr<test::ShownPage> page_;
  std::unique_ptr<Engine> engine_;  // last: its threads see the page
};

test::Run lab_run(const std::vector<std::string>& words) {
  std::vector<std::string> command = {test::kLab};
  command.insert(command.end(), words.begin(), words.end());
  return test::run_program(command);
}

// A person's clip from the same camera.
void write_clip(const std::string& folder, const body::BodyModel& model, const lab::Subject& subject) {
  auto writer = hal::FolderWriter::create(folder, BadCamera::intrinsics(), {});
  ASSERT_TRUE(writer) << writer.error().message;
  BadCamera camera(model, subject);
  for (std::uint64_t i = 0; i < 20; ++i) ASSERT_TRUE((*writer)->write(camera.take(i), info_of(i)));
  ASSERT_TRUE((*writer)->finish());
}

double stature_of(const Json& values) {
  return values["stature"]["value"];
}

TEST(RoundTrip, FromPeopleAndATapeToABetterMeasurement) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const std::string root = folder.path("sessions"), site = folder.path("shop.i2c");
  Shop shop(root);
  ASSERT_TRUE(shop.ready());
  const auto person = [&](int number) {
    return lab::draw_subject(shop.model(), lab::Family::training, 5, static_cast<std::uint64_t>(number));
  };
  std::string id;
  for (int i = 0; i < kPeople; ++i) {
    id = shop.visit(i, person(i));
    ASSERT_NE(id, "") << i;
  }

  // The recording holds the frames of that person that the engine saw, no more and no less: it gives the same bits.
  const test::Run again =
      test::run_program({test::kProgram, "sessions", "measure", id, "--root", root, "--json", "--body",
                         test::body_path(), "--tracker", test::tracker_path(), "--index", test::index_path()});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Json both = Json::parse(again.out);
  for (const char* field : {"measurements", "frames", "joints", "paper", "body"})
    EXPECT_EQ(both["then"][field], both["now"][field]) << field;

  const test::Run study = lab_run({"study", root, "--json", "--html", folder.path("study.html")});
  ASSERT_EQ(study.exit_code, 0) << study.err;
  const Json studied = Json::parse(study.out);
  EXPECT_EQ(studied["people"], kPeople);
  EXPECT_GT(studied["measurements"]["stature"]["bias"], 15);
  EXPECT_EQ(studied["measurements"]["waist_girth"]["tape"]["pairs"], kPeople);
  const std::string html = test::read_text(folder.path("study.html"));
  EXPECT_EQ(test::xml_fault(std::string_view(html).substr(std::string("<!doctype html>\n").size()), {"meta", "br"}),
            "");
  EXPECT_NE(html.find("Shop 3"), std::string::npos);

  const test::Run learned = lab_run({"calibrate", root, "--out", site, "--json"});
  ASSERT_EQ(learned.exit_code, 0) << learned.err;
  EXPECT_EQ(Json::parse(learned.out)["corrects"], "values");

  const lab::Subject fresh = person(kPeople);
  ASSERT_NO_FATAL_FAILURE(write_clip(folder.path("clip"), shop.model(), fresh));
  const std::vector<std::string> words = {"--frames",           "5", "--sensor", "structured-light",
                                          "--calibration-site", site};
  const test::Run corrected = test::measure(folder.path("clip"), folder.path("out"), words);
  ASSERT_EQ(corrected.exit_code, 0) << corrected.err;
  EXPECT_EQ(corrected.err, "");
  const Json result = Json::parse(test::read_text(folder.path("out/result.json")));
  ASSERT_TRUE(result.contains("calibration_site"));
  const Json& said = result["calibration_site"];
  EXPECT_EQ(said["name"], "Shop 3");
  EXPECT_EQ(said["people"], kPeople);
  EXPECT_EQ(said["index_known"], true);
  const double truth = static_cast<double>(fresh.truth[measurement_index(Measurement::stature)]);
  const double before = stature_of(said["uncorrected"]) - truth, after = stature_of(result["measurements"]) - truth;
  EXPECT_GT(before, 15);
  EXPECT_LT(std::abs(after), 0.4 * before);
  EXPECT_NEAR(stature_of(result["tape"]), stature_of(result["measurements"]), 2) << "one body: the mesh follows";

  // With another index the site's corrections fit less well: people are measured, with a warning.
  auto other = SiteCalibration::load(site);
  ASSERT_TRUE(other) << other.error().message;
  other->index_crc32c ^= 1U;
  ASSERT_TRUE(write_file_atomically(folder.path("other.i2c"), *other->file()));
  std::vector<std::string> of_other = words;
  of_other.back() = folder.path("other.i2c");
  const test::Run warned = test::measure(folder.path("clip"), folder.path("warned"), of_other);
  EXPECT_EQ(warned.exit_code, 0);
  EXPECT_NE(warned.err.find("other.i2c: made with another index than "), std::string::npos) << warned.err;
  const Json as_warned = Json::parse(test::read_text(folder.path("warned/result.json")));
  EXPECT_EQ(as_warned["calibration_site"]["index_known"], false);
  EXPECT_EQ(as_warned["measurements"], result["measurements"]);
}

}  // namespace
}  // namespace im2fit

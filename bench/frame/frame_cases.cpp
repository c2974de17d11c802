// SPDX-License-Identifier: Apache-2.0
// One whole frame at 640x480 (portrait: 480 wide), and its parts, as the engine runs them: a guided frame is
// PersonDetector::sense and Fuser::add, a measuring frame describes and queries the index as well. The variant is the
// best tier the build, the machine and IM2FIT_DISABLE_TIERS allow.
//
// Tracker and index: IM2FIT_TRACKER, IM2FIT_INDEX, else where scripts/test puts the small ones; the body:
// IM2FIT_BODY, else the cache's. Where they are absent the cases that need them are left out, and standard error says
// so.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/frame/room.h"
#include "bench/kernels/cases.h"
#include "body/fit/measurement_fit.h"
#include "body/fit/nearest_start.h"
#include "body/measure.h"
#include "body/start_bodies.h"
#include "core/file.h"
#include "core/rng.h"
#include "engine/engine.h"
#include "engine/sensing_stages.h"
#include "index/index.h"
#include "kernels/fpfh/fpfh.h"
#include "kernels/normals/normals.h"
#include "perception/fuse/decimate.h"
#include "perception/fuse/depth_fusion.h"
#include "perception/observe/edge_restorer.h"
#include "perception/observe/observe.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit::bench {
namespace {

constexpr int kAccumulated = 15;    // frames of a session, and of the fused picture that is described
constexpr int kWarmUp = 12;         // frames before the first measured one: floor and tracker converge
constexpr std::size_t kFrames = 2;  // with noise of their own

struct Room {
  test::Figure figure = test::standing_figure(0, kDistanceMm);
  std::array<std::vector<std::uint16_t>, kFrames> depth;
  std::vector<std::uint8_t> mask =
      std::vector<std::uint8_t>(static_cast<std::size_t>(kCamera.width * kCamera.height));
  Segmenter segmenter{kCamera.width, kCamera.height};
  PersonTracker people;
  Person person;  // in the last frame, whose mask is in `mask`
  std::size_t next = 0;

  Room() {
    for (std::size_t i = 0; i < kFrames; ++i) depth[i] = picture(figure, 7 + i);
    // The room is learned before anything is measured.
    for (int i = 0; i < kWarmUp; ++i) person = segmenter.run(frame(), kCamera, people, mask_image());
    if (!person.found) std::fprintf(stderr, "frame: the segmenter finds no person in the rendered room\n");
  }
  DepthView frame() {
    next = (next + 1) % kFrames;
    return last();
  }
  DepthView last() const { return {depth[next].data(), kCamera.width, kCamera.height}; }
  MaskImage mask_image() { return {mask.data(), kCamera.width, kCamera.height}; }
  Detection detection() const { return {person, figure.joints, 0}; }
};

// The fused person on the descriptor's grid.
struct Grid {
  explicit Grid(Room& room)
      : fusion(kCamera.width, kCamera.height),
        step(grid_step_px(kCamera, kDistanceMm)),
        k(grid_intrinsics(kCamera, step)),
        work(k.width, k.height) {
    const Person& p = room.person;
    for (int i = 0; i < kAccumulated; ++i)
      fusion.add(room.frame(), room.mask_image(), p.u_min, p.v_min, p.u_max, p.v_max);
    fusion.finish();
    for (auto& plane : planes) plane.resize(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
    decimate_once();
    normals_once();
  }
  void normals_once() {
    auto& p = planes;
    fastest(kNormalsKernels)(k, p[0].data(), p[1].data(), p[2].data(), 1, 60, p[3].data(), p[4].data(), p[5].data());
  }
  void decimate_once() { decimate(fusion.depth_q4(), fusion.mask(), k, step, planes[0], planes[1], planes[2]); }
  OrganisedCloud cloud() const {
    return {k,
            planes[0].data(),
            planes[1].data(),
            planes[2].data(),
            planes[3].data(),
            planes[4].data(),
            planes[5].data()};
  }

  DepthFusion fusion;
  int step;
  Intrinsics k;
  FpfhWorkspace work;
  std::array<std::vector<float>, 6> planes;  // x y z nx ny nz
  std::array<float, kFpfhSize * kJointCount> descriptors{};
};

// Everything that outlives the cases.
struct Bench {
  std::shared_ptr<Room> room = std::make_shared<Room>();
  std::shared_ptr<Fuser> fuser = std::make_shared<Fuser>(kCamera.width, kCamera.height);
  std::shared_ptr<MappedFile> tracker_file;
  std::shared_ptr<JointModel> tracker;
  std::shared_ptr<index::Index> index;

  void open_files() {
    const std::string tracker_path = file_of("IM2FIT_TRACKER", "tracker.i2t");
    const std::string index_path = file_of("IM2FIT_INDEX", "index.i2f");
    if (auto file = MappedFile::open(tracker_path)) {
      tracker_file = std::make_shared<MappedFile>(std::move(*file));
      if (auto model = JointModel::parse(tracker_file->bytes(), tracker_path))
        tracker = std::make_shared<JointModel>(std::move(*model));
    }
    if (auto opened = index::Index::open(index_path); opened && opened->feature_size() == kFeatureSize)
      index = std::make_shared<index::Index>(std::move(*opened));
    if (tracker == nullptr) std::fprintf(stderr, "frame: no tracker in %s: cases left out\n", tracker_path.c_str());
    if (index == nullptr)
      std::fprintf(stderr, "frame: no index of today's in %s: cases left out\n", index_path.c_str());
  }
};

const char* variant() {
  return tier_available(Tier::avx2) ? "avx2" : tier_available(Tier::neon) ? "neon" : "portable";
}

void add(Cases& cases, const char* name, Floor floor, std::function<void()> run) {
  const Tier tier = tier_available(Tier::avx2)   ? Tier::avx2
                    : tier_available(Tier::neon) ? Tier::neon
                                                 : Tier::portable;
  cases.push_back({std::string("frame/") + name, variant(), tier, 1, "frame", std::move(floor), std::move(run)});
}

// A guided frame as the engine divides it between its threads: SENSE finds the person, joints and pose, FIT
// accumulates.
void add_threads(Cases& cases, const Bench& b) {
  const auto sensor = std::make_shared<PersonDetector>(kCamera.width, kCamera.height, *b.tracker);
  const auto sensed = std::make_shared<Detection>();
  const auto sense = [b, sensor] { return sensor->sense(b.room->frame(), kCamera, b.room->mask_image()); };
  for (int i = 0; i < kWarmUp; ++i) {
    *sensed = sense();
    sensor->people().hold(sensed->person.id, true);
  }
  add(cases, "guided/sense", {0.1e3, "depth read, mask written and read: 1.2 MB at 11.6 GB/s"},
      [sense] { keep(sense()); });
  add(cases, "guided/fit", {0.06e3, "box of 92 k pixels: 8 bytes read and written"}, [b, sensed] {
    if (b.fuser->frame_count() >= kAccumulated) b.fuser->reset();
    b.fuser->add(b.room->last(), b.room->mask_image(), kCamera, *sensed);
  });
}

// Sense and add; `describe` and `query` on top when an index is given.
void add_whole(Cases& cases, const Bench& b) {
  const auto sensor = std::make_shared<PersonDetector>(kCamera.width, kCamera.height, *b.tracker);
  const auto sense_frame = [b, sensor] {
    const DepthView depth = b.room->frame();
    const Detection detection = sensor->sense(depth, kCamera, b.room->mask_image());
    if (b.fuser->frame_count() >= kAccumulated) b.fuser->reset();
    b.fuser->add(depth, b.room->mask_image(), kCamera, detection);
  };
  for (int i = 0; i < kWarmUp; ++i) sense_frame();
  add(cases, "guided", {0.13e3, "depth read twice, mask written and read: 1.5 MB at 11.6 GB/s"}, sense_frame);
  add_threads(cases, b);
  if (b.index == nullptr) return;
  const std::shared_ptr<index::Index::Scratch> scratch = b.index->make_scratch();
  add(cases, "measuring",
      {0.45e3, "guided; the grid's 0.14 M pairs at 19 vector operations, four a cycle; the mean's 0.8 MB"},
      [b, sense_frame, scratch] {
        sense_frame();
        index::QueryOptions options;
        options.frame_count = kAccumulated;
        keep(b.index->query(b.fuser->describe().feature, options, *scratch));
      });
  const auto feature = std::make_shared<Feature>(b.fuser->describe().feature);
  add(cases, "query", {10, "the feature times 40 targets: 50 k multiplications, 8 a cycle; one tree walk"},
      [b, feature, scratch] {
        index::QueryOptions options;
        options.frame_count = kAccumulated;
        keep(b.index->query(*feature, options, *scratch));
      });
}

// Whether a driver spoils edges, before a frame is guided: of a sensor just plugged in, and of one that is known.
void add_edges(Cases& cases, const Bench& b) {
  constexpr int kFramesInRun = 8;  // one of them is judged
  constexpr int kKnown = 64;       // frames after which a sensor is known whatever they show
  const auto judge = [b](EdgeRestorer& edges) {
    const DepthView depth = b.room->frame();
    edges.run({b.room->depth[b.room->next].data(), depth.width, depth.height}, kCamera.fx);
  };
  const auto first = std::make_shared<EdgeRestorer>(kCamera.width, kCamera.height);
  add(cases, "edges/first", {0.05e3, "0.6 MB of depth read at 11.6 GB/s"}, [judge, first] {
    first->reset();
    judge(*first);
  });
  const auto known = std::make_shared<EdgeRestorer>(kCamera.width, kCamera.height);
  for (int i = 0; i < kKnown; ++i) judge(*known);
  if (known->restored()) std::fprintf(stderr, "frame: the room's edges are taken for spoilt ones\n");
  add(cases, "edges/known", {0.05e3, "an eighth of 8 frames' 0.6 MB of depth read at 11.6 GB/s"}, [judge, known] {
    for (int i = 0; i < kFramesInRun; ++i) judge(*known);
  });
  cases.back().items = kFramesInRun;
  cases.back().item = "frame";
}

void add_sense_parts(Cases& cases, const Bench& b) {
  const auto room = b.room;
  add(cases, "segment", {0.08e3, "0.6 MB of depth read, 0.3 MB of mask written"}, [room] {
    room->person = room->segmenter.run(room->frame(), kCamera, room->people, room->mask_image());
    keep(room->person);
  });
  if (b.tracker != nullptr) {
    const auto tracker = std::make_shared<JointTracker>(*b.tracker);
    const auto joints = std::make_shared<JointSet>();
    *joints = tracker->track(room->last(), room->mask_image(), kCamera, room->person, false);
    add(cases, "joints", {}, [b, room, tracker, joints] {
      *joints = tracker->track(room->last(), room->mask_image(), kCamera, room->person, true);
      keep(*joints);
    });
  }
  add(cases, "fuse", {0.06e3, "box of 92 k pixels: 8 bytes read and written"}, [b, room] {
    if (b.fuser->frame_count() >= kAccumulated) b.fuser->reset();
    b.fuser->add(room->last(), room->mask_image(), kCamera, room->detection());
  });
}

void add_describe_parts(Cases& cases, const Bench& b) {
  const auto room = b.room;
  const auto accumulated = std::make_shared<Fuser>(kCamera.width, kCamera.height);
  for (int i = 0; i < kAccumulated; ++i)
    accumulated->add(room->last(), room->mask_image(), kCamera, room->detection());
  add(cases, "describe", {}, [accumulated] { keep(accumulated->describe()); });

  const auto grid = std::make_shared<Grid>(*room);
  add(cases, "describe/finish", {0.06e3, "one byte of mask a pixel, of the person's 14 more, at 11.6 GB/s"},
      [grid] { grid->fusion.finish(); });
  const auto paper = std::make_shared<PaperWorkspace>(kCamera.width, kCamera.height);
  add(cases, "describe/paper", {}, [room, grid, paper] {
    keep(measure_paper(grid->fusion.depth_q4(), grid->fusion.mask(), kCamera, room->figure.joints, *paper));
  });
  add(cases, "describe/grid", {0.08e3, "0.9 MB at 11.6 GB/s"}, [grid] { grid->decimate_once(); });
  add(cases, "describe/normals", {}, [grid] { grid->normals_once(); });
  add(cases, "describe/fpfh", {}, [room, grid] {
    fpfh(grid->cloud(), room->figure.joints.position_mm, kFpfhRadiusMm, grid->work, grid->descriptors);
  });
  const auto profile = std::make_shared<ProfileWorkspace>();
  const auto out = std::make_shared<std::vector<float>>(kProfileSize);
  add(cases, "describe/profile", {}, [room, grid, profile, out] {
    section_profile(grid->fusion.depth_q4(), grid->fusion.mask(), kCamera, room->figure.joints, {}, *profile, *out);
  });
}

// Enough of the stages to come to MEASURED.
class RestingStages final : public SensingStages {
 public:
  using SensingStages::SensingStages;
  // The figure has no face and is taken for a back.
  Detection sense(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds) override {
    Detection detection = SensingStages::sense(depth, intrinsics, mask, seconds);
    turn(detection);
    return detection;
  }
  bool measure(MeasuredPerson& /*person*/) override { return true; }

 private:
  static void turn(Detection& detection) {
    if (!detection.person.found) return;
    detection.view = ViewSide::front;
    detection.guidance &= ~static_cast<GuidanceSet>(Guidance::not_frontal);
  }
};

// Five seconds at 30 Hz in which nothing moves, on one thread: of an empty room, and of a person who was measured and
// stays. Five, since a frame is sensed that often.
void add_rest(Cases& cases, const Bench& b) {
  constexpr int kFramesInRun = 5 * 30;
  constexpr std::int64_t kPeriodNs = 33333333;
  for (const bool person : {false, true}) {
    EngineSettings settings;
    settings.intrinsics = kCamera;
    settings.width = kCamera.width;
    settings.height = kCamera.height;
    settings.frames_wanted = kAccumulated;
    settings.one_after_another = settings.rest = settings.single_thread = true;
    auto made = create_engine(settings, std::make_unique<RestingStages>(kCamera.width, kCamera.height, *b.tracker));
    const std::shared_ptr<Engine> engine = made ? std::move(*made) : nullptr;
    const auto pictures = std::make_shared<std::array<std::vector<std::uint16_t>, kFrames>>();
    for (std::size_t i = 0; i < kFrames; ++i)
      (*pictures)[i] = picture(test::standing_figure(0, person ? kDistanceMm : 100 * kDistanceMm), 7 + i);
    const auto sequence = std::make_shared<std::uint64_t>(0);
    const auto five_seconds = [b, engine, pictures, sequence] {  // b: the engine refers to its tracker
      for (int i = 0; i < kFramesInRun; ++i) {
        hal::FrameInfo info;
        info.sequence = (*sequence)++;
        info.host_ns = static_cast<std::int64_t>(*sequence) * kPeriodNs;
        const auto& pixels = (*pictures)[*sequence % kFrames];
        keep(engine->push({pixels.data(), kCamera.width, kCamera.height}, info));
      }
    };
    for (int i = 0; i < 2; ++i) five_seconds();
    if (engine->result().measured != person)
      std::fprintf(stderr, "frame: rest/%s is not what it says\n", person ? "measured" : "empty");
    add(cases, person ? "rest/measured" : "rest/empty", {}, five_seconds);
    cases.back().items = kFramesInRun / 30;
    cases.back().item = "s";
  }
}

// Once a session: the nearest start body found, and fitted to another person's measurements.
void add_body_parts(Cases& cases) {
  const std::string path = file_of("IM2FIT_BODY", "body.i2b", "");
  auto loaded = body::BodyModel::load(path);
  if (!loaded || loaded->start_bodies().size() == 0) {
    std::fprintf(stderr, "frame: no body with start bodies in %s: cases left out\n", path.c_str());
    return;
  }
  const auto model = std::make_shared<body::BodyModel>(std::move(*loaded));
  body::Params person;
  person.gender = 0;
  person.age_years = 61;
  person.muscle = 0.3F;
  person.weight = 0.8F;
  const MeasurementValues wanted = body::measure_person(*model, person);
  add(cases, "body/start", {}, [model, wanted] {
    const body::StartBodies& starts = model->start_bodies();
    keep(starts.params(body::nearest_start(starts, true, wanted)));
  });
  const body::StartBodies& starts = model->start_bodies();
  const auto entry = std::make_shared<body::Params>(starts.params(body::nearest_start(starts, true, wanted)));
  body::MeasurementGoals goals;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) goals[i] = {wanted[i], 0.01F * wanted[i]};
  const auto fitter = std::make_shared<body::MeasurementFitter>(*model);
  const auto params = std::make_shared<body::Params>(*entry);
  add(cases, "body/fit", {}, [model, fitter, entry, params, goals] {
    *params = *entry;
    keep(fitter->run(*params, goals));
  });
}

}  // namespace

Cases frame_cases(std::string_view only) {
  Bench b;
  b.open_files();
  const auto any_of = [only](std::initializer_list<const char*> names) {
    return only.empty() || std::any_of(names.begin(), names.end(), [only](const char* name) {
             return only.starts_with(std::string("frame/") + name);
           });
  };
  Cases cases;
  if (b.tracker != nullptr && any_of({"guided", "measuring", "query"})) add_whole(cases, b);
  if (any_of({"segment", "joints", "fuse"})) add_sense_parts(cases, b);
  if (any_of({"edges"})) add_edges(cases, b);
  if (any_of({"describe"})) add_describe_parts(cases, b);
  if (b.tracker != nullptr && any_of({"rest"})) add_rest(cases, b);
  if (any_of({"body"})) add_body_parts(cases);
  return cases.empty() && !only.empty() ? frame_cases({}) : cases;
}

}  // namespace im2fit::bench

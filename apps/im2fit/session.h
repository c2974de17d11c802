// SPDX-License-Identifier: Apache-2.0
// One session of the engine over one source, and everything that is written about it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/cli.h"
#include "apps/common/input.h"
#include "apps/common/known_options.h"
#include "apps/common/measuring.h"
#include "body/export/figure.h"
#include "report/motion_recording.h"

namespace im2fit::apps {

// The files of --out that are made. Nothing is computed for the others.
struct WantedFiles {
  bool result = true;   // result.json
  bool avatar = true;   // avatar.glb
  bool overlay = true;  // overlay.png
  bool clothes = true;  // avatar.glb in everyday clothes
  bool obj = true;      // avatar.obj and what it names
  bool bvh = true;      // avatar.bvh
  bool glb() const { return avatar || clothes; }
  bool body() const { return glb() || overlay || obj || bvh; }  // a mesh is made
};
// Of words of --only: "result,avatar". Error: a word is empty or unknown.
Result<WantedFiles> wanted_files(const std::string& words);

struct SessionOptions : MeasuringOptions {
  KnownOptions known_words;  // `known`, as the command line has it
  InputOptions input;
  std::string user_word = "nearest";  // `user`, as the command line has it
  std::string out;                    // "": no files
  std::string only;                   // words of wanted_files(); "": all files
  std::string motion;                 // file of the joints over time; "": none
  std::vector<std::string> exports;   // files of report/measurement_file.h
  std::string export_unit = "mm";     // of those that have a choice; mm, cm or in
  bool json = false;
  bool timing = false;
  bool paper = false;  // the paper's values in the table, beside ours
};
// Of options that passed the checks of add_session_options.
WantedFiles wanted_files(const SessionOptions& options);
// Options that name a single file override it when they are added later.
void add_models_option(cli::App& sub, std::string& tracker, std::string& index, std::string& body);
void add_session_options(cli::App& sub, SessionOptions& options);
void add_motion_option(cli::App& sub, std::string& path);

// Called for every frame read, with the engine's latest result.
using SessionWatch = std::function<void(std::uint64_t frame_count, const EngineResult& result)>;

// The measured body, morphed once for all files.
struct MeasuredAvatar {
  body::Avatar avatar;  // refers to the session's body model; once dressed, in everyday clothes of its size
  body::Figure figure;
  std::vector<std::byte> glb;  // once dressed
};

// The frame behind the report: the last used frame of the front, or the last frame seen while none was used. The
// choice depends on the frames alone. The last frame read does not: the engine may be some frames behind it.
class ShownFrame {
 public:
  // A FrameWatch. Copies the picture when it is one to keep.
  void see(const FrameSeen& frame);
  // Empty before the first. Not while the engine works on frames.
  DepthView depth() const;

 private:
  std::vector<std::uint16_t> pixels_;
  int width_ = 0, height_ = 0;
  std::uint64_t session_ = 0;
  std::uint64_t used_ = 0;  // of the front
};

// What a session ends with; owns all the report views into.
struct SessionOutcome {
  MeasuringData data;
  Input input;
  std::unique_ptr<MotionRecording> motion;  // with options.motion; the engine's threads write to it
  std::unique_ptr<ShownFrame> shown;        // they write to it too
  std::unique_ptr<Engine> engine;
  std::unique_ptr<FrameTap> tap;
  PersonMeasurement person;              // the engine's report when it was concluded
  std::optional<MeasuredAvatar> avatar;  // once dress() or write_outputs() was called
  std::optional<ResultTiming> timing;
};

// Opens everything (so that bad words fail before a frame is read) and makes the folder --out. `engine_watch` sees
// every frame processed, on the engine's thread; `watch` every frame read.
Result<SessionOutcome> open_session(const SessionOptions& options, FrameWatch engine_watch, FrameTap::Watch watch);
// Takes the engine's present result.
Status conclude(SessionOutcome& outcome);
// The measured person with other facts known. `unconditioned`: their result, read while no fact was known.
Status conclude_again(SessionOutcome& outcome, const EngineResult& unconditioned, const KnownFacts& facts);
// Opens, runs to the end or the measurement, concludes.
Result<SessionOutcome> run_session(const SessionOptions& options, const SessionWatch& watch);

// Makes `avatar` of the body in everyday clothes and its glb, if there is a body; some seconds. The outcome must stay
// where it is.
Status dress(SessionOutcome& outcome);

// Files, then the answer on stdout; exit 3 when there is none.
Result<int> report_session(SessionOutcome& outcome, const SessionOptions& options);
// result.json first; when measured, avatar.glb, .obj, .bvh; overlay.png after any frame.
Status write_outputs(SessionOutcome& outcome, const std::string& directory, const WantedFiles& wanted = {});
// After conclude_again(): the same without overlay.png, which shows the values of before and is deleted.
Status rewrite_outputs(SessionOutcome& outcome, const std::string& directory, const WantedFiles& wanted);
// What a person should know of a measurement beside its values: damaged frames, a back that was not used.
std::vector<std::string> session_notes(const SessionOutcome& outcome);
// The motion moves the body measured, or an average adult's. What was written, in a line with its end.
Result<std::string> write_motion(const MotionRecording& motion, const std::string& path, const body::BodyModel& model,
                                 const std::optional<AnsweredBody>& body);
// The same after a run that ended with `code`, where the options ask for it; printed unless --json. The exit code.
Result<int> report_motion(const SessionOutcome& outcome, const SessionOptions& options, Result<int> code);
// For people: value, interval, truth where it is known, and the paper's values when `paper`.
std::string result_table(const SessionOutcome& outcome, bool paper);

}  // namespace im2fit::apps

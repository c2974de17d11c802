// SPDX-License-Identifier: Apache-2.0
// The needs of a measuring program besides a source: files made once, an engine, and the report of its findings.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/paths.h"
#include "apps/common/region_text.h"
#include "estimate/known_facts.h"
#include "person/measuring_data.h"
#include "report/result_json.h"

namespace im2fit::apps {

struct MeasuringOptions {
  std::string tracker = default_tracker_path();
  std::string index = default_index_path();
  int frames = kFramesWantedDefault;
  std::string calibration = "none";      // or "psi"
  std::string turn = "none";             // or another of kTurnNames
  std::string clothing = "auto";         // or another of kClothingGivenNames
  std::string sensor = "auto";           // or another of kSensorKindNames; auto: as the source says
  std::vector<std::string> size_charts;  // empty: the built-in EN 13402-3
  std::string site;                      // .i2c (docs/calibration.md); "": none
  std::vector<std::string> tapes;        // files of definitions beside the shipped ones
  KnownFacts known;                      // of the first person; nothing by default
  int threads = 2;
  int user = 0;        // 0: the nearest
  std::string region;  // words of region_of(); "": everywhere
  bool live = false;
  bool one_after_another = false;  // as EngineSettings
  bool rest = false;               // as EngineSettings; recordings never rest
};

// "nearest": 0, or an id; nothing: it is neither.
std::optional<int> user_of(const std::string& word);

// Whether the models can be opened; nothing is read. Errors name the variable that chose a missing one.
Status check_models(const MeasuringOptions& options, const std::string& body);
// The files of the options, and the tape: the shipped one with people's own.
Result<MeasuringData> load_measuring_data(const MeasuringOptions& options, const std::string& body);

// `data` must outlive the engine. `watch` sees every frame processed, on the engine's thread.
Result<std::unique_ptr<Engine>> make_engine(const MeasuringOptions& options, const MeasuringData& data,
                                            const hal::SourceInfo& source, FrameWatch watch);

// measurement_of, and how garments would sit on the body.
Result<PersonMeasurement> measured_person(const Engine& engine, const MeasuringData& data,
                                          const hal::SourceInfo& source);
Result<PersonMeasurement> measured_person(const EngineResult& result, const MeasuringData& data,
                                          const hal::SourceInfo& source);

// People who came and went have used up every beginning of the session: only a new session measures the next person.
bool is_stuck(const EngineResult& result);

// "1743 mm, 72.1 kg, chest 980 mm, size M"
std::string summary(const PersonMeasurement& person);
// The message about the body when one of its girths is off the reported one by more than 2 mm, "" otherwise.
std::string body_note(const PersonMeasurement& person);
// Guidance codes in words of the enum, "ARMS_CLOSE left, MOVING"; "none" for none. `arms_close`: which arms that code
// is about; one of them alone is named.
std::string guidance_words(GuidanceSet guidance, ArmSet arms_close);

}  // namespace im2fit::apps

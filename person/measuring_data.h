// SPDX-License-Identifier: Apache-2.0
// The files made once that measuring needs, loaded in one place for programs and the C functions, and an engine on
// them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "body/tape.h"
#include "engine/engine.h"
#include "person/data_files.h"
#include "person/person_measurement.h"
#include "person/size_chart.h"

namespace im2fit {

// Each may name a model pack, which holds all three models.
struct MeasuringFiles {
  std::string tracker;                   // .i2t
  std::string index;                     // .i2f
  std::string body;                      // .i2b; "": none, so that features alone answer and no body is made
  std::vector<std::string> size_charts;  // empty: the built-in EN 13402-3
  std::string site = {};                 // .i2c; "": answers are not corrected
};
// The contents of files that a caller has in memory; messages then name them by the path.
struct MeasuringBytes {
  std::optional<std::vector<std::byte>> tracker, index, body, site;
  std::set<std::string> packed = {};  // which of them take_models read, by their names in a pack
};

// Of a model pack's bytes those of the files that are called `name` and that `bytes` lacks. Errors: as ModelPack's.
Status take_models(std::span<const std::byte> pack, const std::string& name, const MeasuringFiles& files,
                   MeasuringBytes& bytes);

// An engine refers to tracker, index and shape space, a measurement to model, charts and tape: they stay where they
// are when this is moved.
struct MeasuringData {
  MeasuringFiles files;
  std::unique_ptr<Tracker> tracker;
  std::unique_ptr<index::Index> index;
  std::unique_ptr<body::BodyModel> body_model;  // null: no file was named
  std::unique_ptr<SizeSystem> charts;
  std::unique_ptr<body::Tape> tape;       // null: no tape is measured
  std::unique_ptr<SiteCalibration> site;  // null: no file was named
  std::vector<std::string> warnings;      // a line for each two files that do not belong together

  // Whether a shape is fitted to the depth: the index was made with the shapes of this body.
  bool fits_shapes() const;
  MeasurementParts parts() const { return {index.get(), body_model.get(), charts.get(), tape.get(), site.get()}; }
};
// All but the tape. Errors name the file and the command that makes it.
Result<MeasuringData> load_measuring_data(const MeasuringFiles& files, MeasuringBytes bytes = {});
Result<std::unique_ptr<SizeSystem>> load_size_charts(const std::vector<std::string>& paths);

// `settings.shape_space` and `settings.site` are the data's, that of the camera of this name (hal::SourceInfo::name;
// "": not known); `data` must outlive the engine. Errors name index and tracker.
Result<std::unique_ptr<Engine>> make_engine(EngineSettings settings, const MeasuringData& data,
                                            const std::string& camera);

}  // namespace im2fit

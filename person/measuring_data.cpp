// SPDX-License-Identifier: Apache-2.0
#include "person/measuring_data.h"

#include <array>
#include <utility>

#include "body/shape_space.h"
#include "core/crc32c.h"
#include "core/file.h"
#include "formats/model_pack.h"

namespace im2fit {

Result<std::unique_ptr<SizeSystem>> load_size_charts(const std::vector<std::string>& paths) {
  if (paths.empty()) return std::make_unique<SizeSystem>(builtin_size_system());
  std::vector<SizeChart> charts;
  for (const std::string& path : paths) {
    auto chart = load_size_chart(path);
    if (!chart) return chart.error();
    charts.push_back(std::move(*chart));
  }
  auto system = make_size_system(std::move(charts));
  if (!system) return system.error();
  return std::make_unique<SizeSystem>(std::move(*system));
}

namespace {

// Whether the site was calibrated with this index. With another index the camera's and the tape's corrections stay
// valid, but the index's own do not: this adds a warning, and measuring continues.
Status compare_index(MeasuringData& data, std::optional<std::uint32_t> index_crc) {
  SiteCalibration& site = *data.site;
  if (site.index_crc32c == 0) return Ok{};
  if (!index_crc) {
    const auto file = MappedFile::open(data.files.index);
    if (!file) return file.error();
    index_crc = crc32c(file->bytes());
  }
  site.of_this_index = site.index_crc32c == *index_crc;
  if (!*site.of_this_index)
    data.warnings.push_back(data.files.site + ": made with another index than " + data.files.index +
                            ", so that its corrections fit less well; measure the sessions again with this index "
                            "and run im2fit-lab calibrate again");
  return Ok{};
}

// Whose bytes are still to be read from the pack, and which of its files they are.
struct PackedModel {
  const std::string& path;
  std::optional<std::vector<std::byte>>& bytes;
  const char* name;
};

std::array<PackedModel, 3> models_of(const MeasuringFiles& files, MeasuringBytes& bytes) {
  return {{{files.tracker, bytes.tracker, kPackedTracker},
           {files.index, bytes.index, kPackedIndex},
           {files.body, bytes.body, kPackedBody}}};
}

// Of a pack that is named for several models, all in one reading.
Status unpack_models(const MeasuringFiles& files, MeasuringBytes& bytes) {
  for (const PackedModel& first : models_of(files, bytes)) {
    if (first.bytes || first.path.empty() || !is_model_pack(first.path)) continue;
    const auto file = MappedFile::open(first.path);
    if (!file) return file.error();
    if (auto ok = take_models(file->bytes(), first.path, files, bytes); !ok) return ok;
  }
  return Ok{};
}

}  // namespace

Status take_models(std::span<const std::byte> pack, const std::string& name, const MeasuringFiles& files,
                   MeasuringBytes& bytes) {
  const auto opened = ModelPack::parse(pack, name, false);
  if (!opened) return opened.error();
  for (const PackedModel& model : models_of(files, bytes)) {
    if (model.bytes || model.path != name) continue;
    auto content = model_of(*opened, name, model.name);
    if (!content) return content.error();
    model.bytes = std::move(*content);
    bytes.packed.insert(model.name);
  }
  return Ok{};
}

bool MeasuringData::fits_shapes() const {
  return body_model != nullptr && index->fit_layout().size() > 0 &&
         index->shape_key() == body_model->shape_space().key;
}

Result<MeasuringData> load_measuring_data(const MeasuringFiles& files, MeasuringBytes bytes) {
  MeasuringData data;
  data.files = files;
  // What people write by hand comes first: models take longer to read.
  auto charts = load_size_charts(files.size_charts);
  if (!charts) return charts.error();
  data.charts = std::move(*charts);
  if (!files.site.empty() || bytes.site) {
    auto site = bytes.site ? SiteCalibration::parse(*bytes.site, files.site) : SiteCalibration::load(files.site);
    if (!site) return site.error();
    data.site = std::make_unique<SiteCalibration>(std::move(*site));
  }
  if (auto ok = unpack_models(files, bytes); !ok) return ok.error();
  // What messages call a model: its file, or the file in its pack.
  const auto name_of = [&](const std::string& path, const char* name) {
    return bytes.packed.contains(name) ? name_in_pack(path, name) : path;
  };
  auto tracker = bytes.tracker ? Tracker::parse(std::move(*bytes.tracker), name_of(files.tracker, kPackedTracker))
                               : Tracker::load(files.tracker);
  if (!tracker) return tracker.error();
  data.tracker = std::make_unique<Tracker>(std::move(*tracker));
  std::optional<std::uint32_t> index_crc;
  if (bytes.index) index_crc = crc32c(*bytes.index);
  auto index = bytes.index ? index::Index::parse(std::move(*bytes.index), name_of(files.index, kPackedIndex))
                           : load_index(files.index);
  if (!index) return index.error();
  data.index = std::make_unique<index::Index>(std::move(*index));
  if (!files.body.empty()) {
    auto model = bytes.body ? body::BodyModel::parse(std::move(*bytes.body), name_of(files.body, kPackedBody))
                            : load_body(files.body);
    if (!model) return model.error();
    data.body_model = std::make_unique<body::BodyModel>(std::move(*model));
  }
  if (data.body_model != nullptr && !data.fits_shapes())
    data.warnings.push_back(
        files.index + ": not made with the shapes of " + files.body +
        ": only features are used, with larger errors; build the index again with im2fit-lab index");
  if (data.site != nullptr)
    if (auto compared = compare_index(data, index_crc); !compared) return compared.error();
  return data;
}

Result<std::unique_ptr<Engine>> make_engine(EngineSettings settings, const MeasuringData& data,
                                            const std::string& camera) {
  if (data.site != nullptr) settings.site = data.site->for_camera(camera);
  if (data.body_model != nullptr) {
    settings.shape_space = &data.body_model->shape_space();
    settings.body = &*data.body_model;
  }
  auto engine = Engine::create(settings, data.tracker->model(), *data.index);
  if (!engine)
    return Error{engine.error().code,
                 data.files.index + " with " + data.files.tracker + ": " + engine.error().message};
  return engine;
}

}  // namespace im2fit

// SPDX-License-Identifier: Apache-2.0
// N subjects with their truth as CSV, and statistics and a plot of the population.
#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/common/paths.h"
#include "apps/common/progress.h"
#include "apps/im2fit-lab/commands.h"
#include "core/file.h"
#include "evaluation/population/population_check.h"
#include "evaluation/population/proportions_check.h"
#include "person/data_files.h"
#include "report/text_table.h"
#include "train/camera/synthetic_person.h"
#include "train/common/parallel.h"
#include "train/population/proportions.h"

namespace im2fit::apps {
namespace {

struct PopulationOptions {
  std::uint64_t subjects = 200;
  std::string preset = "training";
  std::uint64_t seed = 1;
  std::string out;
  std::string ansur;
  std::string plot;
  std::string proportions_plot;
  std::string body = made_body_path();
  int threads = default_threads();
  bool json = false;
};

struct Moments {
  int count = 0;
  double mean = 0;
  double sd = 0;
};

Moments moments(const std::vector<lab::Subject>& subjects, bool woman, std::size_t measurement) {
  Moments m;
  double sum = 0;
  double squares = 0;
  for (const auto& s : subjects) {
    if (s.woman != woman) continue;
    ++m.count;
    sum += s.truth[measurement];
    squares += static_cast<double>(s.truth[measurement]) * s.truth[measurement];
  }
  if (m.count == 0) return m;
  m.mean = sum / m.count;
  m.sd = std::sqrt(std::max(0.0, squares / m.count - m.mean * m.mean));
  return m;
}

std::string csv_of(const std::vector<lab::Subject>& subjects, const std::vector<body::Dimensions>& dimensions) {
  std::string csv = "subject,woman,age_years,gender,muscle,weight_slider,height_slider,proportions";
  for (const auto& info : kMeasurementTable) csv += fmt::format(",{}_{}", info.id, info.unit);
  for (std::size_t d = 0; d < body::kDimensionCount; ++d)
    csv += fmt::format(",ansur_{}", lab::ansur_column(static_cast<body::Dimension>(d)).name);
  csv += "\n";
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    const auto& s = subjects[i];
    csv += fmt::format("{},{},{:.2f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}", i, s.woman ? 1 : 0, s.params.age_years,
                       s.params.gender, s.params.muscle, s.params.weight, s.params.height, s.params.proportions);
    for (const float value : s.truth) csv += fmt::format(",{:.2f}", value);
    for (std::size_t d = 0; d < body::kDimensionCount; ++d)  // as ANSUR II would have them
      csv += fmt::format(",{:.2f}",
                         dimensions[i].mm[d] / lab::ansur_column(static_cast<body::Dimension>(d)).mesh_factor);
    csv += "\n";
  }
  return csv;
}

void print_summary(const std::vector<lab::Subject>& subjects, bool json) {
  TextTable table({"synthetic", "women", "SD", "men", "SD"});
  nlohmann::ordered_json out;
  out["label"] = "synthetic";
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const auto& info = kMeasurementTable[i];
    const Moments women = moments(subjects, true, i);
    const Moments men = moments(subjects, false, i);
    const auto cell = [](const Moments& m, double value) { return m.count > 0 ? number(value, 1) : "-"; };
    table.add({fmt::format("{} {}", info.id, info.unit), cell(women, women.mean), cell(women, women.sd),
               cell(men, men.mean), cell(men, men.sd)});
    out["women"]["count"] = women.count;
    out["men"]["count"] = men.count;
    out["women"][std::string(info.id)] = {{"mean", women.mean}, {"sd", women.sd}, {"unit", info.unit}};
    out["men"][std::string(info.id)] = {{"mean", men.mean}, {"sd", men.sd}, {"unit", info.unit}};
  }
  fmt::print("{}", json ? out.dump(1) + "\n" : table.text());
}

Result<int> run_population(const PopulationOptions& options) {
  const auto family = family_of(options.preset);
  if (!family) return family.error();
  const auto model = load_body(options.body);
  if (!model) return model.error();
  std::vector<lab::Subject> subjects(options.subjects);
  std::vector<body::Dimensions> dimensions(options.subjects);
  Progress progress("subjects", options.subjects);
  lab::for_each_item(
      options.subjects, options.threads,
      [&](std::uint64_t i) {
        std::vector<Vec3f> rest;
        subjects[i] = lab::draw_subject(*model, *family, options.seed, i, rest);
        dimensions[i] = body::dimensions_of(*model, rest);
      },
      [&](std::uint64_t done) { progress.update(done); });
  if (!options.out.empty())
    if (const auto written = write_file_atomically(options.out, csv_of(subjects, dimensions)); !written)
      return written.error();
  print_summary(subjects, options.json);
  if (options.ansur.empty()) return kExitOk;
  const auto comparison = compare_population(subjects, dimensions, options.ansur);
  if (!comparison) return comparison.error();
  const auto proportions = compare_proportions(subjects, dimensions, options.ansur);
  if (!proportions) return proportions.error();
  if (!options.json) fmt::print("\n{}\n{}", text_of(*comparison), text_of(*proportions));
  if (!options.plot.empty()) {
    const auto picture = plot_of(*comparison);
    if (!picture) return picture.error();
    if (const auto written = write_file_atomically(options.plot, *picture); !written) return written.error();
  }
  if (!options.proportions_plot.empty())
    if (const auto written = write_file_atomically(options.proportions_plot, plot_of(*proportions)); !written)
      return written.error();
  std::vector<std::string> broken = comparison->broken;
  broken.insert(broken.end(), proportions->broken.begin(), proportions->broken.end());
  if (broken.empty()) return kExitOk;
  return Error{ErrorCode::invalid_argument,
               fmt::format("population: {} of its figures are beyond tolerance, the first: {}", broken.size(),
                           broken.front())};
}

}  // namespace

void add_population(cli::App& app, Command& chosen) {
  auto options = std::make_shared<PopulationOptions>();
  auto* sub = add_command<PopulationOptions>(
      app, chosen, "population", "Draw synthetic people; print means and spreads, write true values as CSV",
      "  im2fit-lab population --subjects 500 --out people.csv\n"
      "  im2fit-lab population --preset paper --subjects 200\n"
      "  im2fit-lab population --subjects 4000 --ansur DIR --plot people.png",
      options, run_population);
  sub->add_option("--subjects", options->subjects, "Number of people")->range(1, 1000000)->capture_default_str();
  sub->add_option("--preset", options->preset, "Population")
      ->one_of({"paper", "training", "held_out"})
      ->capture_default_str();
  sub->add_option("--seed", options->seed, "Seed")->capture_default_str();
  sub->add_option("--out", options->out, "CSV file to write")->type_name("FILE");
  auto* ansur = sub->add_option("--ansur", options->ansur,
                                "Compare with real people: folder of ANSUR_II_{FEMALE,MALE}_Public.csv; exit 1 if a "
                                "tolerance is exceeded");
  ansur->type_name("DIR");
  sub->add_option("--plot", options->plot, "PNG of that comparison")->type_name("FILE")->needs(ansur);
  sub->add_option("--proportions-plot", options->proportions_plot, "SVG of all dimensions, compared with ANSUR II")
      ->type_name("FILE")
      ->needs(ansur);
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--threads", options->threads, "Threads")->range(1, 256)->capture_default_str();
  sub->add_flag("--json", options->json, "Summary as JSON");
}

}  // namespace im2fit::apps

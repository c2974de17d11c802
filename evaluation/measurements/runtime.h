// SPDX-License-Identifier: Apache-2.0
// The paper's runtime figure: how long an answer takes against the number of models, to the measurements, to a naked
// body, to a dressed one. Processor time of one thread, on the machine that runs this.
#pragma once

#include <string>
#include <vector>

#include "evaluation/measurements/session.h"

namespace im2fit::lab {

struct RuntimeRow {
  std::string file;
  std::size_t models = 0;  // entries
  double query_p50_ms = 0, query_p99_ms = 0;
  // From fused frames: features and query; then also the body posed and written as .glb, bare and in a garment.
  double measurements_ms = 0, naked_ms = 0, clothed_ms = 0;  // medians over people; bodies 0 where it has none
};

// The index of `models`, then those of `files`, queried with the same few people, in the order of their sizes.
// `options`: the people and their views. Errors: files that are not an index, or of another feature. Indexes of
// people this program cannot draw (bench/index' own) have no bodies.
Result<std::vector<RuntimeRow>> measure_runtime(const SessionModels& models, const std::string& name,
                                                const std::vector<std::string>& files,
                                                const EvaluationOptions& options);

// A line of bench/results/index-references.json, as `bench/index/index_references` writes it: query time by models of
// us and of a reference implementation.
struct ReferenceLine {
  std::string name;
  struct Point {
    double models = 0, p50_ms = 0, p99_ms = 0;
  };
  std::vector<Point> points;
};
// Ours and the paper's search (every model's 501 values). Errors name the file.
Result<std::vector<ReferenceLine>> read_index_references(const std::string& path);

}  // namespace im2fit::lab

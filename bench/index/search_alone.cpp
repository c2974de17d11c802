// SPDX-License-Identifier: Apache-2.0
#include "bench/index/search_alone.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <stdexcept>

#include "index/answering.h"
#include "index/format.h"

namespace im2fit::bench {
namespace {

using Found = std::vector<std::uint32_t>;

std::vector<float> places_of(const index::Contents& contents, std::size_t dimensions) {
  std::vector<float> out;
  out.reserve(contents.meta.entry_count * dimensions);
  for (std::uint32_t entry = 0; entry < contents.meta.entry_count; ++entry) {
    const index::Position place = contents.code_place(entry);
    for (std::size_t d = 0; d < dimensions; ++d) out.push_back(static_cast<float>(place[d]));
  }
  return out;
}

class Contest {
 public:
  Contest(const Exam& exam, std::size_t count) : exam_(exam), count_(count) {}
  // The first search to be measured gives the right answers.
  Row measure(const std::string& name, const std::function<void(std::size_t query, Found& found)>& search) {
    Row row;
    row.kind = "search";
    row.reference = name;
    row.models = exam_.models.size();
    row.densified = exam_.models.densified_count();
    Found found(count_);
    std::size_t right = 0, queries = 0;
    const Times times = timed(
        exam_.queries.size(), exam_.seconds / 2, [&](std::size_t q) { search(q, found); },
        [&](std::size_t q) {
          Found sorted = found;
          std::sort(sorted.begin(), sorted.end());
          if (truth_.size() == q) truth_.push_back(sorted);
          Found both;
          std::set_intersection(sorted.begin(), sorted.end(), truth_[q].begin(), truth_[q].end(),
                                std::back_inserter(both));
          right += both.size();
          ++queries;
          return queries < truth_.size() || truth_.size() == q + 1;
        });
    row.queries = queries;
    row.p50_us = times.p50_us;
    row.p99_us = times.p99_us;
    row.recall_own = static_cast<double>(right) / static_cast<double>(queries * count_);
    return row;
  }

 private:
  const Exam& exam_;
  std::size_t count_;
  std::vector<Found> truth_;
};

}  // namespace

std::vector<Row> search_alone(std::span<const std::byte> file, const Exam& exam, bool graphs) {
  const auto contents = index::parse_contents(file, "the new index");
  if (!contents) throw std::runtime_error(contents.error().message);
  const int dimensions = static_cast<int>(contents->meta.dimensions);
  const auto width = static_cast<std::size_t>(dimensions);
  const std::size_t count =
      std::min<std::size_t>(std::max<std::uint32_t>(contents->meta.neighbour_count, 1), contents->meta.entry_count);
  const index::Answerer answerer(*contents);
  index::Answerer::Workspace work(answerer);
  std::vector<index::Coordinates> grid;
  std::vector<float> places;
  for (const index::Sample& query : exam.queries) {
    const index::Position place =
        index::project(answerer.regressed(query.feature, work), static_cast<int>(contents->meta.target_count),
                       contents->projection, dimensions);
    grid.push_back(index::to_grid(place, dimensions, contents->meta.grid_unit));
    for (std::size_t d = 0; d < width; ++d) places.push_back(static_cast<float>(place[d]));
  }
  Contest contest(exam, count);
  const auto keep = [](std::span<const index::Neighbour> from, Found& found) {
    for (std::size_t k = 0; k < found.size(); ++k) found[k] = from[k].index;
  };
  std::vector<Row> rows;
  const double code_bytes =
      static_cast<double>(contents->tree.blocks.size_bytes() + contents->tree.leaf_boxes.size_bytes() +
                          contents->tree.group_boxes.size_bytes() + contents->tree.leaf_first.size_bytes()) /
      static_cast<double>(exam.models.size());
  rows.push_back(contest.measure("im2fit, exhaustive, int8", [&](std::size_t q, Found& found) {
    keep(work.search.exhaustive(grid[q], count), found);
  }));
  rows.push_back(contest.measure(
      "im2fit, int8", [&](std::size_t q, Found& found) { keep(work.search.nearest(grid[q], count), found); }));
  for (Row& row : rows) row.bytes_a_model = code_bytes;
  std::vector<std::unique_ptr<PlaceSearch>> references;
  references.push_back(make_nanoflann_places());
#ifdef IM2FIT_REFERENCES_HNSWLIB
  if (graphs) references.push_back(make_hnswlib_places());
#endif
  for (auto& reference : references) {
    auto all = places_of(*contents, width);
    const auto start = std::chrono::steady_clock::now();
    reference->build(std::move(all), width);
    const double build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    rows.push_back(contest.measure(reference->name(),
                                   [&](std::size_t q, Found& found) { reference->find(&places[q * width], found); }));
    rows.back().build_s = build_s;
    rows.back().bytes_a_model = reference->bytes() / static_cast<double>(exam.models.size());
    reference.reset();
  }
  for (Row& row : rows)
    row.note = std::to_string(count) + " neighbours in " + std::to_string(dimensions) + " dimensions";
  return rows;
}

}  // namespace im2fit::bench

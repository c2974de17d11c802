// SPDX-License-Identifier: Apache-2.0
// Features -> supervised, noise-aware projection -> quantised codes -> nanoflann's leaves -> k neighbours -> local
// regression. The file is a .i2f (core/container.h, docs/formats-index.md): mapped, used where it lies, never read
// past its end.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/measurement.h"
#include "core/status.h"
#include "index/refinement.h"

namespace im2fit::index {

// A value and the interval it lies in with 95 % probability.
struct IntervalEstimate {
  float value = 0;
  float low = 0;
  float high = 0;
};

// What an answer rests on. around: a turn, which no index answers (estimate/turn_measurement.h).
enum class AnsweredFrom { front, fitted_front, front_and_back, around };

struct Answer {
  std::array<IntervalEstimate, kMeasurementCount> measurements;
  float female = 0.5F;  // probability
  AnsweredFrom from = AnsweredFrom::front;
  bool clothed = false;  // mostly by what was learned of people in clothes
  struct Clothing {
    float probability =
        std::numeric_limits<float>::quiet_NaN();              // of being dressed, by the frames alone; NaN: unknown
    float ease_mm = std::numeric_limits<float>::quiet_NaN();  // of cloth off the trunk's skin, expected
  };
  Clothing clothing;
  std::uint32_t nearest = 0;   // entry: of the neighbours, the one whose true body is closest to the estimate
  float nearest_distance = 0;  // in the projected space, whose unit is one standard deviation of the error
  // For the evaluation: the nearest entry's own measurements, without the regression that follows.
  MeasurementValues nearest_values{};
};

struct QueryOptions {
  int neighbour_count = 0;  // 0: what the builder found best; otherwise clamped to 1..512
  int frame_count = 1;      // frames fused behind the feature: widens the interval when few
  // Camera to person, as perception/observe sees it: widens the interval when far; 0: not known, as if 4 m.
  int distance_mm = 0;
  bool exhaustive = false;  // scans every entry: the same answer, for checking the search
};

// Whose body an entry holds: these three name the draw that makes it again on a workstation
// (train/population/drawn_people.h).
struct IndexedPerson {
  std::uint32_t version = 0;  // of the rules by which people are drawn
  std::uint64_t seed = 0;
  std::uint64_t number = 0;
};

// What the builder learned and measured, for people to read. Every error is cross-fitted: no subject had a part
// in the regression that answered it.
struct Info {
  struct Group {
    std::string name;
    std::uint32_t first = 0;  // first feature
    std::uint32_t count = 0;
    float weight = 0;         // scaling relative to the heaviest group: 1 heaviest, 0 left out
    float error_without = 0;  // mean absolute error, in standard deviations of people, when left out
  };
  std::string provenance;
  std::uint32_t subject_count = 0;
  std::uint32_t entry_count = 0;  // captures of subjects, densified ones included
  std::uint32_t densified_count =
      0;  // entries mixed from two real ones (train/index/densify.h): for measuring speed only
  std::uint32_t tracker_key = 0;  // JointModel::key() of the one that saw these people; 0: unknown
  std::vector<Group> groups;
  float error_with_all = 0;           // to compare Group::error_without with
  std::vector<float> dimension_bits;  // information of each projected dimension about the body
  std::string method;                 // what follows the ridge regression
  int neighbour_count = 0;
  MeasurementValues prior_mae{};    // mean of all subjects
  MeasurementValues ridge_mae{};    // regression alone
  MeasurementValues nearest_mae{};  // nearest entry in the projected space
  MeasurementValues answer_mae{};   // what query() answers
  MeasurementValues coverage{};     // share of subjects inside the 95 % interval, 0..1
  float sex_accuracy = 0;           // 0..1
  // Of index/refinement.h's answers; sample count 0: none.
  struct Refined {
    std::uint32_t sample_count = 0;
    MeasurementValues mae{};
    MeasurementValues coverage{};
  };
  std::array<Refined, kRefinementCount> refined;
  // Of how likely people are dressed, from the front and from both sides; sample count 0: none.
  struct Clothing {
    std::uint32_t sample_count = 0;
    float right_share = 0;  // of people it was not learned from
  };
  std::array<Clothing, 2> clothing;
};

class Index {
 public:
  static Result<Index> open(const std::string& path);
  // The same from memory; `what` names it in errors.
  static Result<Index> parse(std::vector<std::byte> bytes, const std::string& what);
  Index(Index&&) noexcept;
  Index& operator=(Index&&) noexcept;
  ~Index();

  std::size_t size() const;  // entries
  int dimensions() const;    // of the projected space
  std::size_t feature_size() const;
  const Info& info() const;
  // Memory one query needs; made once, reused. Not shareable between threads; the index is.
  class Scratch;
  std::unique_ptr<Scratch, void (*)(Scratch*)> make_scratch() const;
  // No allocation. NaN in the feature means "not measured" and is imputed by the training mean; a feature of
  // another size than feature_size() is read as if all of it were NaN. Errors: a part of the file that the
  // query reads is damaged (parts are checked against their checksums when they are first read).
  Result<Answer> query(std::span<const float> feature, const QueryOptions& options, Scratch& scratch) const;
  // The same from all data of a person: refined (index/refinement.h) where the index was trained for it and the sizes
  // fit.
  Result<Answer> query(const Seen& seen, const QueryOptions& options, Scratch& scratch) const;
  // Entries whose features resemble these most, nearest first, into `entries`: as many as fit, 512 at most;
  // returns how many. What is known of them holds for the one seen with the share of them it holds for. Errors: as of
  // query().
  Result<std::size_t> alike(const Seen& seen, std::span<std::uint32_t> entries, Scratch& scratch) const;
  // The layout of the fit that refinements need, and the key of the shape space it must be of; 0: the index has none.
  FitLayout fit_layout() const;
  // Whether it was trained to answer people in clothes, from the front and from both sides.
  bool knows_clothed() const;
  std::uint32_t shape_key() const;
  // Whose body an entry is. `entry` < size(), as below. Errors: as of query().
  Result<IndexedPerson> person_of(std::uint32_t entry) const;
  // That person's age in years: the middle of a half year. Errors: as of query().
  Result<float> age_of(std::uint32_t entry) const;
  // Truth of an entry to within the rounding of its codes (a seventh of the regression's error) and the part that the
  // projected space leaves out.
  Result<MeasurementValues> measurements_of(std::uint32_t entry) const;
  // Sizes and names of the file's sections, in the order of the file.
  struct Section {
    std::string name;
    std::uint64_t size = 0;
  };
  std::vector<Section> sections() const;
  // Checks what opening a file does not: the checksums of each entry's data, that every entry lies in its leaf's box
  // and every leaf in its group's, and that the search equals an exhaustive one at `trials` entries. An error names
  // the fault and its place. Opening has already checked the other sections against their CRC and the records against
  // their ranges.
  Status verify(int trials) const;
  // How much of the file the scratch's last query read.
  struct Work {
    std::size_t leaves = 0, points = 0;
    std::size_t pages = 0;  // of 4096 bytes, at most
  };
  Work work_of(const Scratch& scratch) const;
  // Pages of 4096 bytes of the entries' data that were read, and found intact, since the file was opened.
  std::size_t pages_seen() const;

  struct Data;

 private:
  Index();
  std::unique_ptr<Data> data_;
};

}  // namespace im2fit::index

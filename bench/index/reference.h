// SPDX-License-Identifier: Apache-2.0
// What answers a feature, behind one interface: ours, and reference implementations (FAISS,
// hnswlib, nanoflann, brute force), which a user would pick instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/index/models.h"
#include "bench/index/people.h"

namespace im2fit::bench {

struct Question {
  std::span<const float> feature;  // all of it, NaN where not measured
  std::span<const float> raw;      // kRawSize values, means where not measured
};

struct Reply {
  std::uint32_t model = 0;
  std::optional<MeasurementValues> values;          // none: those of `model`
  std::optional<MeasurementValues> nearest_values;  // of ours: before the regression
};

class Reference {
 public:
  virtual ~Reference() = default;
  virtual std::string name() const = 0;
  virtual std::string note() const { return ""; }
  // What is built may be queried by more than one method; the others follow the first. All below depends on the
  // method.
  virtual std::size_t method_count() const { return 1; }
  virtual void use_method(std::size_t) {}
  // Spends the returned seconds on itself (the making of features not counted).
  virtual double build(const Models& models) = 0;
  virtual Reply ask(const Question& question) = 0;
  virtual double bytes() const = 0;  // of the data needed to answer
  // Of ours, the index' file.
  virtual std::span<const std::byte> file() const { return {}; }
  // The nearest in the reference's own space by looking at every model. Where there is none, the raw features are its
  // space.
  virtual std::optional<Reply> ask_exhaustively(const Question&) { return std::nullopt; }
};

struct ReferenceKind {
  std::string id;       // option --references
  std::size_t from;     // models; below it makes no sense
  std::size_t to;       // models; above it does not fit a time or a memory
  std::size_t to_full;  // the same with --full
  std::function<std::unique_ptr<Reference>(const People&)> make;
};
std::vector<ReferenceKind> all_references();

std::unique_ptr<Reference> make_ours(const People& people, bool raw_only);
std::unique_ptr<Reference> make_brute_force();
std::unique_ptr<Reference> make_nanoflann_raw();
std::unique_ptr<Reference> make_nanoflann_pca();
std::unique_ptr<Reference> make_faiss_ivf_pq();
std::unique_ptr<Reference> make_faiss_hnsw();
std::unique_ptr<Reference> make_hnswlib();

}  // namespace im2fit::bench

// SPDX-License-Identifier: Apache-2.0
#include "bench/index/reference.h"

namespace im2fit::bench {
namespace {

constexpr std::size_t kAll = 16'000'000;
constexpr std::size_t kMinutes = 60'000;    // above it a graph over 501 values is minutes in the making
constexpr std::size_t kMemory = 1'000'000;  // above it raw features and their graph are many GB

}  // namespace

std::vector<ReferenceKind> all_references() {
  return {
      {"ours", 0, kAll, kAll, [](const People& p) { return make_ours(p, false); }},
      {"ours501", 0, kMinutes, kAll, [](const People& p) { return make_ours(p, true); }},
      {"brute", 0, kMemory, kMemory, [](const People&) { return make_brute_force(); }},
      {"nanoflann", 0, kMinutes, kMemory, [](const People&) { return make_nanoflann_raw(); }},
      {"pca", 0, kAll, kAll, [](const People&) { return make_nanoflann_pca(); }},
#ifdef IM2FIT_REFERENCES_FAISS
      {"ivfpq", 4'000, kAll, kAll, [](const People&) { return make_faiss_ivf_pq(); }},
      {"hnsw", 0, kMinutes, kMemory, [](const People&) { return make_faiss_hnsw(); }},
#endif
#ifdef IM2FIT_REFERENCES_HNSWLIB
      {"hnswlib", 0, kMinutes, kMemory, [](const People&) { return make_hnswlib(); }},
#endif
  };
}

}  // namespace im2fit::bench

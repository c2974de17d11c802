// SPDX-License-Identifier: Apache-2.0
// The measured calls: one case per kernel or function, variant and size. bench_time times them (Google Benchmark),
// bench_count runs one of them N times so that an emulator's plugin can count its instructions.
//
// A kernel topic's file, NAME_cases.cpp, defines `void add_TOPIC_cases(Cases&)`; cases.cpp lists the topics, and the
// lists of cases: kernels, frame, growth, cloth.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kernels/tier.h"

namespace im2fit::bench {

// Back of the envelope: what one run cannot take less than, on one core of 2.5 GHz with 32-byte vectors that reads
// 11.6 GB/s. `why` is the sum, in words.
struct Floor {
  double us = 0;
  std::string why;
};

struct Case {
  std::string kernel;   // "contour/480x640": topic and size
  std::string variant;  // the name of its row in the kernel's table; "frame" cases: how the whole was chosen
  Tier tier = Tier::portable;
  double items = 0;  // what one run handles, for a rate
  std::string item;  // "px", "pair"
  Floor floor;
  std::function<void()> run;
};

using Cases = std::vector<Case>;

// Adds one case per row of a kernel's table that can run here, `ref` included only when it is quick enough to repeat.
// make(function) returns what a run calls; it owns its data (a shared_ptr captured by value) and must not let the
// compiler drop the result.
template <class Variants, class Make>
void add_variants(Cases& cases, const std::string& kernel, const Variants& variants, double items,
                  const std::string& item, const Floor& floor, bool with_ref, Make make) {
  for (const auto& variant : variants) {
    if (!tier_available(variant.tier) || (variant.tier == Tier::ref && !with_ref)) continue;
    cases.push_back({kernel, variant.name, variant.tier, items, item, floor, make(variant.function)});
  }
}

// Adds the one case of a function without variants.
inline void add_plain(Cases& cases, const std::string& kernel, double items, const std::string& item,
                      const Floor& floor, std::function<void()> run) {
  cases.push_back({kernel, "portable", Tier::portable, items, item, floor, std::move(run)});
}

// Keeps a result alive without storing it.
template <class T>
void keep(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

struct CaseList {
  const char* name;
  // Every case of the list; with a case's name only its topic's, so that an emulator need not make the others' data.
  Cases (*cases)(std::string_view only);
};
// nullptr: none of this name.
const CaseList* case_list(std::string_view name);
std::string case_list_names();  // "kernels, frame, ..."

Cases kernel_cases(std::string_view only);
Cases frame_cases(std::string_view only);
Cases growth_cases(std::string_view only);
Cases cloth_cases(std::string_view only);

}  // namespace im2fit::bench

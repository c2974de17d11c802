// SPDX-License-Identifier: Apache-2.0
// A wardrobe as three rows, of numbers, whole numbers and texts, in which its fields follow one another: how it is
// compiled in. One function names the order for both ways.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "person/wardrobe.h"

namespace im2fit {

// `Row` has number(float), whole(integer, enumeration or bool), text(std::string) and list(vector, each): WardrobeRow
// writes, the reader of builtin_wardrobe.cpp reads. The wardrobe is const when written.
template <class Row, class Form>
void put_form(Row& row, Form& form) {
  row.number(form.mm);
  row.list(form.terms, [&](auto& term) {
    row.whole(term.of);
    row.whole(term.index);
    row.number(term.factor);
  });
}

template <class Row, class Pattern>
void put_pattern(Row& row, Pattern& p) {
  row.text(p.id);
  for (auto& name : p.names) row.text(name);
  row.whole(p.hang);
  row.whole(p.legs);
  row.text(p.fabric);
  for (auto& share : p.colour) row.number(share);
  row.list(p.length_ids, [&](auto& id) { row.text(id); });
  row.list(p.lengths, [&](auto& form) { put_form(row, form); });
  row.list(p.points, [&](auto& point) {
    row.text(point.id);
    row.whole(point.has_back);
    for (auto* form : {&point.x, &point.y, &point.back_x, &point.back_y}) put_form(row, *form);
  });
  row.whole(p.start);
  row.list(p.edges, [&](auto& edge) {
    row.whole(edge.kind);
    row.whole(edge.to);
    row.list(edge.via, [&](auto& at) { row.whole(at); });
  });
  row.whole(p.gusset.at);
  row.number(p.gusset.more);
  row.number(p.gusset.reach_mm);
  row.list(p.regions, [&](auto& region) {
    row.text(region.id);
    row.text(region.measure);
    put_form(row, region.girth);
    for (auto* mm : {&region.tight_mm, &region.good_low_mm, &region.good_high_mm}) row.number(*mm);
  });
}

template <class Row, class Clothes>
void put_wardrobe(Row& row, Clothes& wardrobe) {
  row.list(wardrobe.garments, [&](auto& pattern) { put_pattern(row, pattern); });
  row.list(wardrobe.fabrics, [&](auto& f) {
    row.text(f.id);
    for (auto* value :
         {&f.weight_g_m2, &f.stretch_warp_n_m, &f.stretch_weft_n_m, &f.bending_un_m, &f.friction, &f.thickness_mm})
      row.number(*value);
  });
  for (auto& lines : wardrobe.regression.lines)
    for (auto& line : lines) {
      row.number(line.mm);
      row.number(line.per_chest);
    }
}

// Writes.
struct WardrobeRow {
  std::vector<float> numbers;
  std::vector<int> wholes;
  std::vector<std::string> texts;

  void number(float value) { numbers.push_back(value); }
  template <class T>
  void whole(T value) {
    wholes.push_back(static_cast<int>(value));
  }
  void text(const std::string& words) { texts.push_back(words); }
  template <class T, class Each>
  void list(const std::vector<T>& all, Each each) {
    whole(all.size());
    for (const T& one : all) each(one);
  }
};

}  // namespace im2fit

// SPDX-License-Identifier: Apache-2.0
// The files of size charts: our own, and what shops have in their spreadsheets.
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>

#include "core/file.h"
#include "core/text.h"
#include "formats/csv.h"
#include "person/builtin_tape.h"
#include "person/size_chart.h"

namespace im2fit {
namespace {

constexpr std::size_t kRowCountMax = 128;  // trousers by waist and inside leg have 60
constexpr std::size_t kMeasureCountMax = 8;
constexpr std::size_t kChartBytesMax = 64 * 1024;  // a chart is a page, anything larger is another file
// A newborn's chest is 330 mm; no survey of adults has one of 2 m. Wrists and shoulders are shorter.
constexpr double kGirthMinMm = 300, kLengthMinMm = 50, kMaxMm = 2500;
constexpr std::size_t kSizeLettersMax = 15;
constexpr std::size_t kSizeBytesMax = 30;  // with a sign and an end, what the C interface has place for
constexpr double kMmPerInch = 25.4, kMmPerCm = 10;
constexpr float kOnlySizeMm = 20;  // either side of a size made for one value, where no other value is near

struct Unit {
  const char* name;
  double mm;
};
constexpr Unit kUnits[] = {{"mm", 1}, {"cm", kMmPerCm}, {"in", kMmPerInch}};

// What shops call a measurement; the tape's own ids are known besides.
struct Word {
  std::string_view word, id;
};
constexpr Word kWords[] = {{"", "chest_girth"},
                           {"chest", "chest_girth"},
                           {"bust", "chest_girth"},
                           {"brustumfang", "chest_girth"},
                           {"waist", "waist_girth"},
                           {"w", "waist_girth"},
                           {"taille", "waist_girth"},
                           {"taillenumfang", "waist_girth"},
                           {"hip", "hip_girth"},
                           {"hips", "hip_girth"},
                           {"seat", "hip_girth"},
                           {"hüftumfang", "hip_girth"},
                           {"high_hip", "high_hip_girth"},
                           {"neck", "neck_girth"},
                           {"collar", "neck_girth"},
                           {"under_bust", "under_bust_girth"},
                           {"underbust", "under_bust_girth"},
                           {"band", "under_bust_girth"},
                           {"thigh", "thigh_girth"},
                           {"calf", "calf_girth"},
                           {"upper_arm", "upper_arm_girth"},
                           {"bicep", "upper_arm_girth"},
                           {"biceps", "upper_arm_girth"},
                           {"wrist", "wrist_girth"},
                           {"inside_leg", "inside_leg"},
                           {"inseam", "inside_leg"},
                           {"inleg", "inside_leg"},
                           {"l", "inside_leg"},
                           {"inside_leg_length", "inside_leg"},
                           {"outside_leg", "outside_leg"},
                           {"outseam", "outside_leg"},
                           {"height", "stature"},
                           {"body_height", "stature"},
                           {"sleeve", "sleeve_length"},
                           {"arm", "arm_length"},
                           {"shoulder", "shoulder_breadth"},
                           {"shoulders", "shoulder_breadth"},
                           {"shoulder_width", "shoulder_breadth"}};

enum class Bound { both, low, high };

struct Column {
  std::string id;
  Bound bound = Bound::both;
  const Unit* unit = nullptr;  // null: the header's
  std::size_t measure = 0;
};

const Unit* unit_named(std::string_view name) {
  if (name == "inch" || name == "inches" || name == "\"" || name == "″") name = "in";
  for (const Unit& unit : kUnits)
    if (name == unit.name) return &unit;
  return nullptr;
}

// The words of a column's name: "Waist (cm)" has waist and cm.
std::vector<std::string> words_in(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    if (std::string_view(" _-()[]/.,:").find(c) == std::string_view::npos)
      words.back() += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

std::optional<std::string> measure_named(const std::string& name) {
  for (const Word& word : kWords)
    if (name == word.word) return std::string(word.id);
  const std::string girth = name + "_girth";
  for (const body::TapeDefinition& definition : builtin_tape().definitions)
    if ((definition.id == name || definition.id == girth) && unit_of(definition) == "mm" &&
        definition.kind != body::TapeKind::refused)
      return definition.id;
  return std::nullopt;
}

std::optional<Bound> bound_named(const std::string& word) {
  if (word == "low" || word == "min" || word == "from" || word == "lower") return Bound::low;
  if (word == "high" || word == "max" || word == "to" || word == "upper") return Bound::high;
  return std::nullopt;
}

std::vector<std::string> words_without_fillers(std::vector<std::string> words) {
  std::erase_if(words, [](const std::string& word) {
    return word == "girth" || word == "circumference" || word == "range" || word == "body" || word == "size";
  });
  return words;
}

// By all words, else without those that say little. None: no words are left, or they name nothing.
std::optional<std::string> measure_of(const std::vector<std::string>& words) {
  const auto named = [](const std::vector<std::string>& some) -> std::optional<std::string> {
    std::string joined;
    for (const std::string& word : some) joined += (joined.empty() ? "" : "_") + word;
    return joined.empty() ? std::nullopt : measure_named(joined);
  };
  const auto id = named(words);
  return id ? id : named(words_without_fillers(words));
}

// None: the column is none of a chart's.
std::optional<Column> column_named(const std::string& name) {
  Column column;
  std::vector<std::string> words;
  for (const std::string& word : words_in(name)) {
    if (const Unit* unit = unit_named(word); unit != nullptr && column.unit == nullptr)
      column.unit = unit;
    else
      words.push_back(word);
  }
  // "upper arm" and "high hip" are places of the body: an end of a range is the first or last word, and only where
  // all words together name no measure.
  auto id = measure_of(words);
  if (!id && !words.empty()) {
    const auto from_end = bound_named(words.back());
    const auto bound = from_end ? from_end : bound_named(words.front());
    if (bound) {
      column.bound = *bound;
      words.erase(from_end ? words.end() - 1 : words.begin());
      id = measure_of(words);
    }
  }
  // "low_mm" is of the chest; a bare unit is nothing.
  if (!id && words_without_fillers(words).empty() && (column.bound != Bound::both || words_in(name).size() > 1))
    id = measure_named("");
  if (!id) return std::nullopt;
  column.id = *id;
  return column;
}

// "86-94", with any dash or the word: the place and length of the sign between two numbers; none: one number.
std::optional<std::pair<std::size_t, std::size_t>> dash_in(const std::string& cell) {
  for (const std::string_view sign : {" to ", "–", "—", "-"})
    if (const std::size_t at = cell.find(sign, 1); at != std::string::npos) return std::pair(at, sign.size());
  return std::nullopt;
}

std::string bare(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

// "86 cm" in a column of centimetres.
std::string without_unit(const std::string& cell, const Unit& unit) {
  const std::size_t end = cell.find_last_of("0123456789");
  if (end == std::string::npos) return cell;
  return unit_named(bare(cell.substr(end + 1))) == &unit ? cell.substr(0, end + 1) : cell;
}

class ChartParser {
 public:
  ChartParser(std::string_view text, const std::string& what) : what_(what), csv_(text, what) {}

  Result<SizeChart> parse() {
    for (std::vector<std::string> cells;;) {
      const auto more = csv_.next(cells);
      if (!more) return more.error();
      if (!*more) return finish();
      if (auto ok = take_line(cells); !ok) return ok.error();
    }
  }

 private:
  Error error(const std::string& field, const std::string& problem) const {
    return {ErrorCode::corrupt, what_ + " line " + std::to_string(csv_.line()) + ": " + field + " " + problem};
  }
  static std::string joined(const std::vector<std::string>& cells) {
    std::string text;
    for (const std::string& cell : cells) text += (text.empty() ? "" : ",") + cell;
    return text;
  }

  Status take_line(const std::vector<std::string>& cells) {
    if (!cells[0].empty() && cells[0].front() == '#') return take_header(std::string_view(cells[0]).substr(1));
    if (columns_.empty()) return take_columns(cells);
    return take_row(cells);
  }

  // "# word: value"; other comments are left alone.
  Status take_header(std::string_view line) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return Ok{};
    const std::string key = bare(line.substr(0, colon)), value = bare(line.substr(colon + 1));
    headers_seen_ = headers_seen_ || key == "name" || key == "source" || key == "date" || key == "sex";
    if (key == "name") chart_.name = value;
    if (key == "source") chart_.source = value;
    if (key == "date") chart_.date = value;
    if (key == "unit") {
      unit_ = unit_named(value);
      if (unit_ == nullptr) return error("unit", "is '" + excerpt(value) + "', expected mm, cm or in");
    }
    if (key == "sex") {
      if (value != "men" && value != "women" && value != "any")
        return error("sex", "is '" + value + "', expected men, women or any");
      chart_.sex = value == "men" ? ChartSex::men : value == "women" ? ChartSex::women : ChartSex::any;
      sex_seen_ = true;
    }
    return Ok{};
  }

  Status take_columns(const std::vector<std::string>& cells) {
    const auto first = words_in(cells[0]);
    const auto wrong = [&](const std::string& why) {
      return error("column line", "is '" + excerpt(joined(cells)) + "', expected 'size,low_mm,high_mm' or other " +
                                      "measurements of the body, such as 'size,chest_cm,waist_cm,hip_cm'" + why);
    };
    const bool named = first.size() == 1 && (first[0] == "size" || first[0] == "sizes" || first[0] == "größe" ||
                                             first[0] == "groesse" || first[0] == "label");
    if (!named || cells.size() < 2) return wrong("");
    for (std::size_t i = 1; i < cells.size(); ++i) {
      auto column = column_named(cells[i]);
      if (!column)
        return wrong("; '" + excerpt(cells[i]) +
                     "' is not known: remove the column, or use an id of the tape (docs/tape.md)");
      if (column->unit != nullptr && unit_ != nullptr && column->unit != unit_)
        return error("column " + excerpt(cells[i]), std::string("is in ") + column->unit->name +
                                                        ", and '# unit:' is " + unit_->name +
                                                        "; correct one of them");
      const auto known = std::find(chart_.measures.begin(), chart_.measures.end(), column->id);
      column->measure = static_cast<std::size_t>(known - chart_.measures.begin());
      if (known == chart_.measures.end()) chart_.measures.push_back(column->id);
      for (const Column& other : columns_)
        if (other.measure == column->measure &&
            (other.bound == column->bound || other.bound == Bound::both || column->bound == Bound::both))
          return wrong("; " + column->id + " appears twice");
      if (column->unit == nullptr && unit_ == nullptr)
        return error("column " + excerpt(cells[i]),
                     "has no unit; write it as 'Chest (cm)', or add a line '# unit: cm' (mm, cm or in)");
      columns_.push_back(std::move(*column));
    }
    if (chart_.measures.size() > kMeasureCountMax)
      return error("column line", "has more than " + std::to_string(kMeasureCountMax) + " measurements");
    for (std::size_t m = 0; m < chart_.measures.size(); ++m)
      if (const auto count = std::count_if(columns_.begin(), columns_.end(),
                                           [&](const Column& c) { return c.measure == m && c.bound != Bound::both; });
          count == 1)
        return wrong("; " + chart_.measures[m] + " has a low or a high end alone");
    return Ok{};
  }

  Status take_row(const std::vector<std::string>& cells) {
    const std::size_t expected = columns_.size() + 1;
    if (cells.size() != expected)
      return error("row", "'" + excerpt(joined(cells)) + "' does not have the " + std::to_string(expected) +
                              " fields of the column line");
    SizeRow row;
    row.size = cells[0];
    const std::size_t letters = character_count(row.size);
    if (letters < 1 || letters > kSizeLettersMax || row.size.size() > kSizeBytesMax)
      return error("size", "must have 1 to 15 characters (30 bytes)");
    std::vector<SizeRange> ranges(chart_.measures.size());
    for (std::size_t i = 0; i < columns_.size(); ++i)
      if (auto ok = take_cell(columns_[i], cells[i + 1], ranges[columns_[i].measure]); !ok) return ok;
    for (std::size_t m = 0; m < ranges.size(); ++m)
      if (!(ranges[m].low_mm <= ranges[m].high_mm))
        return error(field_of(m, Bound::high), "must be more than " + field_of(m, Bound::low));
    for (const SizeRow& other : chart_.rows)
      if (other.size == row.size) return error("size", "'" + excerpt(row.size) + "' appears twice");
    if (chart_.rows.size() == kRowCountMax)
      return error("row", "is one too many: at most " + std::to_string(kRowCountMax));
    lines_.push_back(csv_.line());
    ranges_.push_back(std::move(ranges));
    chart_.rows.push_back(std::move(row));
    return Ok{};
  }

  // As the column line has it, for errors.
  std::string field_of(std::size_t measure, Bound bound) const {
    const std::string id = chart_.measures[measure];
    std::string end = bound == Bound::low ? "low_mm" : bound == Bound::high ? "high_mm" : "";
    if (id == "chest_girth" && !end.empty()) return end;
    return end.empty() ? id : id + " " + end;
  }

  Status take_cell(const Column& column, const std::string& cell, SizeRange& range) {
    if (column.bound != Bound::both)
      return take_number(column, cell, column.bound == Bound::low ? range.low_mm : range.high_mm);
    const auto dash = dash_in(cell);
    if (!dash) {
      if (auto ok = take_number(column, cell, range.low_mm); !ok) return ok;
      range.high_mm = range.low_mm;
      return Ok{};
    }
    if (auto ok = take_number(column, bare(cell.substr(0, dash->first)), range.low_mm); !ok) return ok;
    return take_number(column, bare(cell.substr(dash->first + dash->second)), range.high_mm);
  }

  Status take_number(const Column& column, const std::string& cell, float& value) {
    const Unit& unit = column.unit != nullptr ? *column.unit : *unit_;
    const std::string field = field_of(column.measure, column.bound);
    const std::string words = unit.mm == 1 ? "millimetres" : unit.mm == kMmPerCm ? "centimetres" : "inches";
    double number = 0;
    if (!csv_.number(without_unit(cell, unit), number) || !(number > 0))
      return error(field, "is '" + excerpt(cell) + "', expected " + words);
    const bool girth = column.id == "chest_girth" || column.id == "waist_girth" || column.id == "hip_girth";
    const double least = girth ? kGirthMinMm : kLengthMinMm;
    const double mm = number * unit.mm;
    if (mm < least || mm > kMaxMm) {
      std::string likely;
      for (const Unit& other : {kUnits[1], kUnits[2], kUnits[0]})
        if (likely.empty() && other.mm != unit.mm && number * other.mm >= 2 * least && number * other.mm <= kMaxMm)
          likely = other.name;
      return error(field, "is '" + excerpt(cell) + "' " + unit.name + ", expected a " +
                              (column.id == "chest_girth" ? "chest girth" : column.id) + " of " +
                              std::to_string(static_cast<int>(least)) + " to 2500 mm" +
                              (likely == "cm"   ? "; if these are centimetres, write '# unit: cm'"
                               : likely == "in" ? "; if these are inches, write '# unit: in'"
                               : likely == "mm" ? "; if these are millimetres, write '# unit: mm'"
                                                : ""));
    }
    value = static_cast<float>(mm);
    return Ok{};
  }

  // One value a size becomes a range: half the way to the next other value, to either side.
  Status widen(std::size_t m) {
    std::vector<float> values;
    std::size_t single = 0;
    for (const auto& row : ranges_) {
      single += row[m].low_mm == row[m].high_mm ? 1 : 0;
      values.push_back(row[m].low_mm);
    }
    if (single == 0) return Ok{};
    for (std::size_t i = 0; i < ranges_.size(); ++i)
      if (single != ranges_.size() && ranges_[i][m].low_mm == ranges_[i][m].high_mm)
        return Error{ErrorCode::corrupt, what_ + " line " + std::to_string(lines_[i]) + ": " +
                                             field_of(m, Bound::high) + " must be more than " +
                                             field_of(m, Bound::low) + ", as in the other sizes"};
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    for (auto& row : ranges_) {
      const auto at = std::lower_bound(values.begin(), values.end(), row[m].low_mm);
      const bool has_less = at != values.begin(), has_more = at + 1 != values.end();
      const float less = has_less ? (*at - *(at - 1)) / 2 : has_more ? (*(at + 1) - *at) / 2 : kOnlySizeMm;
      const float more = has_more ? (*(at + 1) - *at) / 2 : has_less ? less : kOnlySizeMm;
      row[m] = {*at - less, *at + more};
    }
    return Ok{};
  }

  // The chest comes first: garments are cut by it.
  void give_rows() {
    const auto chest = std::find(chart_.measures.begin(), chart_.measures.end(), "chest_girth");
    const auto place = chest == chart_.measures.end() ? 0 : chest - chart_.measures.begin();
    std::rotate(chart_.measures.begin(), chart_.measures.begin() + place, chart_.measures.begin() + place + 1);
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      auto& ranges = ranges_[i];
      std::rotate(ranges.begin(), ranges.begin() + place, ranges.begin() + place + 1);
      chart_.rows[i].low_mm = ranges.front().low_mm;
      chart_.rows[i].high_mm = ranges.front().high_mm;
      chart_.rows[i].more.assign(ranges.begin() + 1, ranges.end());
    }
  }

  // Large to small is as good. By one measure a size must not lie within another: nobody would know whose it is.
  Status put_in_order() {
    std::stable_sort(chart_.rows.begin(), chart_.rows.end(), [](const SizeRow& a, const SizeRow& b) {
      for (std::size_t m = 0; m <= a.more.size(); ++m) {
        const float left = a.range(m).low_mm + a.range(m).high_mm, right = b.range(m).low_mm + b.range(m).high_mm;
        if (left != right) return left < right;
      }
      return false;
    });
    if (chart_.measures.size() > 1) return Ok{};
    for (std::size_t i = 1; i < chart_.rows.size(); ++i) {
      const SizeRow &a = chart_.rows[i - 1], &b = chart_.rows[i];
      if (!(b.low_mm > a.low_mm && b.high_mm > a.high_mm))
        return error("size", "'" + excerpt(b.size) + "' lies within size '" + excerpt(a.size) +
                                 "', or the other way round; correct the numbers");
    }
    return Ok{};
  }

  Result<SizeChart> finish() {
    if (headers_seen_) {
      if (chart_.name.empty()) return error("header", "has no '# name:' line");
      if (!sex_seen_) return error("header", "has no '# sex:' line");
      if (chart_.source.empty()) return error("header", "has no '# source:' line");
      if (chart_.date.empty()) return error("header", "has no '# date:' line");
    } else {
      chart_.name = std::filesystem::path(what_).stem().string();
      chart_.source = std::filesystem::path(what_).filename().string();
    }
    if (chart_.rows.empty()) return error("chart", "has no sizes");
    for (std::size_t m = 0; m < chart_.measures.size(); ++m)
      if (auto ok = widen(m); !ok) return ok.error();
    give_rows();
    if (auto ok = put_in_order(); !ok) return ok.error();
    return std::move(chart_);
  }

  const std::string& what_;
  CsvReader csv_;
  const Unit* unit_ = nullptr;
  bool headers_seen_ = false;
  bool sex_seen_ = false;
  std::vector<Column> columns_;
  // As the file has the rows and measures.
  std::vector<int> lines_;
  std::vector<std::vector<SizeRange>> ranges_;
  SizeChart chart_;
};

}  // namespace

Result<SizeChart> parse_size_chart(std::string_view text, const std::string& what) {
  return ChartParser(text, what).parse();
}

Result<SizeChart> load_size_chart(const std::string& path) {
  auto bytes = read_file(path, kChartBytesMax);
  if (!bytes) return bytes.error();
  return parse_size_chart({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
}

}  // namespace im2fit

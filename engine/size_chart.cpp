// SPDX-License-Identifier: Apache-2.0
#include "engine/size_chart.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <utility>

#include "core/file.h"
#include "engine/builtin_charts.h"

namespace im2fit {
namespace {

constexpr std::size_t kRowCountMax = 32;
constexpr std::size_t kTextSizeMax = 64 * 1024;  // bytes; a chart is a page, anything larger is another file
constexpr float kGirthMaxMm = 5000;
constexpr double kNormal95 = 1.959963984540054;  // half width of the 95 % interval, in standard deviations

std::string_view trim(std::string_view s) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = s.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(kBlank) - first + 1);
}

class ChartParser {
 public:
  explicit ChartParser(const std::string& what) : what_(what) {}

  Result<SizeChart> parse(std::string_view text) {
    if (text.size() > kTextSizeMax) return error("file", "is larger than 64 KiB: this is no size chart");
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      ++line_;
      if (auto ok = take_line(trim(text.substr(0, end))); !ok) return ok.error();
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    return finish();
  }

 private:
  Error error(const std::string& field, const std::string& problem) const {
    return {ErrorCode::corrupt, what_ + " line " + std::to_string(line_) + ": " + field + " " + problem};
  }

  Status take_line(std::string_view line) {
    if (line.empty()) return Ok{};
    if (line.front() == '#') return take_header(trim(line.substr(1)));
    if (!columns_seen_) {
      if (line != "size,low_mm,high_mm")
        return error("column line", "is '" + std::string(line) + "', expected 'size,low_mm,high_mm'");
      columns_seen_ = true;
      return Ok{};
    }
    return take_row(line);
  }

  // "# word: value"; other comments are left alone.
  Status take_header(std::string_view line) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return Ok{};
    const std::string_view key = trim(line.substr(0, colon));
    const std::string value(trim(line.substr(colon + 1)));
    if (key == "name") chart_.name = value;
    if (key == "source") chart_.source = value;
    if (key == "date") chart_.date = value;
    if (key == "unit") {
      if (value != "mm") return error("unit", "is '" + value + "', expected 'mm'");
      unit_seen_ = true;
    }
    if (key == "sex") {
      if (value != "men" && value != "women" && value != "any")
        return error("sex", "is '" + value + "', expected men, women or any");
      chart_.sex = value == "men" ? ChartSex::men : value == "women" ? ChartSex::women : ChartSex::any;
      sex_seen_ = true;
    }
    return Ok{};
  }

  Status take_row(std::string_view line) {
    const std::size_t first = line.find(',');
    const std::size_t second = first == std::string_view::npos ? first : line.find(',', first + 1);
    if (second == std::string_view::npos || line.find(',', second + 1) != std::string_view::npos)
      return error("row", "'" + std::string(line) + "' has not the 3 fields size,low_mm,high_mm");
    SizeRow row;
    row.size = trim(line.substr(0, first));
    if (row.size.empty() || row.size.size() > 15) return error("size", "must have 1 to 15 characters");
    if (auto ok = take_number("low_mm", trim(line.substr(first + 1, second - first - 1)), row.low_mm); !ok) return ok;
    if (auto ok = take_number("high_mm", trim(line.substr(second + 1)), row.high_mm); !ok) return ok;
    if (!(row.low_mm < row.high_mm)) return error("high_mm", "must be more than low_mm");
    if (!chart_.rows.empty() && row.low_mm < chart_.rows.back().high_mm)
      return error("low_mm", "overlaps size " + chart_.rows.back().size + ": rows go from small to large");
    for (const SizeRow& other : chart_.rows)
      if (other.size == row.size) return error("size", "'" + row.size + "' is there twice");
    if (chart_.rows.size() == kRowCountMax) return error("row", "is one too many: at most 32");
    chart_.rows.push_back(std::move(row));
    return Ok{};
  }

  // Whole millimetres or with a decimal part. from_chars for floats is not in every standard library we build with.
  Status take_number(const char* field, std::string_view text, float& value) {
    std::uint32_t whole = 0;
    const char* end = text.data() + text.size();
    auto [at, fault] = std::from_chars(text.data(), end, whole);
    double number = whole;
    double place = 0.1;
    bool good = fault == std::errc{} && whole > 0;
    if (good && at != end) good = *at++ == '.' && at != end;
    for (; good && at != end; ++at, place /= 10) {
      good = *at >= '0' && *at <= '9';
      number += place * (*at - '0');
    }
    if (!good || number > static_cast<double>(kGirthMaxMm))
      return error(field, "is '" + std::string(text) + "', expected millimetres from 1 to 5000");
    value = static_cast<float>(number);
    return Ok{};
  }

  Result<SizeChart> finish() {
    if (chart_.name.empty()) return error("header", "has no '# name:' line");
    if (!sex_seen_) return error("header", "has no '# sex:' line");
    if (!unit_seen_) return error("header", "has no '# unit: mm' line");
    if (chart_.source.empty()) return error("header", "has no '# source:' line");
    if (chart_.date.empty()) return error("header", "has no '# date:' line");
    if (chart_.rows.empty()) return error("chart", "has no sizes");
    return std::move(chart_);
  }

  const std::string& what_;
  int line_ = 0;
  bool columns_seen_ = false;
  bool sex_seen_ = false;
  bool unit_seen_ = false;
  SizeChart chart_;
};

SizeSystem parse_builtin() {
  // The text is ours and a test parses it; a fault here would be a fault of the build.
  auto men = parse_size_chart(kBuiltinMenChart, "built-in men's chart");
  auto women = parse_size_chart(kBuiltinWomenChart, "built-in women's chart");
  return men && women ? SizeSystem{std::move(*men), std::move(*women)} : SizeSystem{};
}

void add(SizeAnswer& answer, const std::string& size, double probability) {
  for (SizeAnswer::Entry& entry : answer.entries) {
    if (entry.size != size) continue;
    entry.probability += probability;
    return;
  }
  answer.entries.push_back({size, probability});
}

// Where a chart leaves a gap between two sizes, each takes its half.
double upper_edge(const SizeChart& chart, std::size_t row) {
  const double high = static_cast<double>(chart.rows[row].high_mm);
  if (row + 1 == chart.rows.size()) return high;
  return 0.5 * (high + static_cast<double>(chart.rows[row + 1].low_mm));
}

void add_chart(SizeAnswer& answer, const SizeChart& chart, double mean_mm, double sd_mm, double share) {
  if (chart.rows.empty()) return;
  const auto below = [&](double girth_mm) { return normal_cdf((girth_mm - mean_mm) / sd_mm); };
  double previous = below(static_cast<double>(chart.rows.front().low_mm));
  add(answer, "<" + chart.rows.front().size, share * previous);
  for (std::size_t i = 0; i < chart.rows.size(); ++i) {
    const double next = below(upper_edge(chart, i));
    add(answer, chart.rows[i].size, share * (next - previous));
    previous = next;
  }
  add(answer, ">" + chart.rows.back().size, share * (1 - previous));
}

}  // namespace

Result<SizeChart> parse_size_chart(std::string_view text, const std::string& what) {
  return ChartParser(what).parse(text);
}

Result<SizeChart> load_size_chart(const std::string& path) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return parse_size_chart({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
}

Result<SizeSystem> make_size_system(std::vector<SizeChart> charts) {
  if (charts.size() == 1 && charts[0].sex == ChartSex::any) return SizeSystem{charts[0], charts[0]};
  if (charts.size() == 2 && charts[0].name == charts[1].name) {
    if (charts[0].sex == ChartSex::women && charts[1].sex == ChartSex::men) std::swap(charts[0], charts[1]);
    if (charts[0].sex == ChartSex::men && charts[1].sex == ChartSex::women)
      return SizeSystem{std::move(charts[0]), std::move(charts[1])};
  }
  return Error{ErrorCode::invalid_argument,
               "size charts: give one chart of sex any, or a men's and a women's chart of the same name"};
}

const SizeSystem& builtin_size_system() {
  static const SizeSystem system = parse_builtin();
  return system;
}

double normal_cdf(double x) {
  if (x < 0) return 1 - normal_cdf(-x);
  const double sum =
      1 + x * (0.0498673470 +
               x * (0.0211410061 + x * (0.0032776263 + x * (0.0000380036 + x * (0.0000488906 + x * 0.0000053830)))));
  const double square = sum * sum;
  const double fourth = square * square;
  const double eighth = fourth * fourth;
  return 1 - 0.5 / (eighth * eighth);
}

SizeAnswer size_probabilities(const SizeSystem& system, const index::IntervalEstimate& chest_mm, float female) {
  const double mean = static_cast<double>(chest_mm.value);
  const double width = static_cast<double>(chest_mm.high) - static_cast<double>(chest_mm.low);
  // An interval of no width still leaves the tape's own millimetre.
  const double sd = std::max(width / (2 * kNormal95), 1.0);
  const double share = std::clamp(static_cast<double>(female), 0.0, 1.0);
  SizeAnswer answer;
  answer.chart = system.men.name;
  add_chart(answer, system.men, mean, sd, 1 - share);
  add_chart(answer, system.women, mean, sd, share);
  double best = -1;
  for (const SizeAnswer::Entry& entry : answer.entries) {
    if (entry.probability <= best) continue;
    best = entry.probability;
    answer.best = entry.size;
  }
  return answer;
}

}  // namespace im2fit

// SPDX-License-Identifier: Apache-2.0
#include "person/size_chart.h"

#include <algorithm>
#include <utility>

#include "core/file.h"
#include "core/text.h"
#include "formats/csv.h"

namespace im2fit {
namespace {

constexpr std::size_t kRowCountMax = 32;
constexpr std::size_t kChartBytesMax = 64 * 1024;  // a chart is a page, anything larger is another file
// A newborn's chest is 330 mm; no survey of adults has one of 2 m.
constexpr double kGirthMinMm = 300, kGirthMaxMm = 2500;
constexpr std::size_t kSizeLettersMax = 15;
constexpr std::size_t kSizeBytesMax = 30;        // with a sign and an end, what the C interface has place for
constexpr double kNormal95 = 1.959963984540054;  // half width of the 95 % interval, in standard deviations

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
    if (!columns_seen_) {
      if (cells != std::vector<std::string>{"size", "low_mm", "high_mm"})
        return error("column line", "is '" + joined(cells) + "', expected 'size,low_mm,high_mm'");
      columns_seen_ = true;
      return Ok{};
    }
    return take_row(cells);
  }

  static std::string trim(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return {};
    return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
  }

  // "# word: value"; other comments are left alone.
  Status take_header(std::string_view line) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return Ok{};
    const std::string key = trim(line.substr(0, colon)), value = trim(line.substr(colon + 1));
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

  Status take_row(const std::vector<std::string>& cells) {
    if (cells.size() != 3)
      return error("row", "'" + joined(cells) + "' does not have the 3 fields size,low_mm,high_mm");
    SizeRow row;
    row.size = cells[0];
    const std::size_t letters = character_count(row.size);
    if (letters < 1 || letters > kSizeLettersMax || row.size.size() > kSizeBytesMax)
      return error("size", "must have 1 to 15 characters (30 bytes)");
    if (auto ok = take_number("low_mm", cells[1], row.low_mm); !ok) return ok;
    if (auto ok = take_number("high_mm", cells[2], row.high_mm); !ok) return ok;
    if (!(row.low_mm < row.high_mm)) return error("high_mm", "must be more than low_mm");
    if (!chart_.rows.empty() && row.low_mm < chart_.rows.back().high_mm)
      return error("low_mm", "overlaps size " + chart_.rows.back().size + ": rows go from small to large");
    for (const SizeRow& other : chart_.rows)
      if (other.size == row.size) return error("size", "'" + row.size + "' appears twice");
    if (chart_.rows.size() == kRowCountMax) return error("row", "is one too many: at most 32");
    chart_.rows.push_back(std::move(row));
    return Ok{};
  }

  Status take_number(const char* field, const std::string& cell, float& value) {
    double number = 0;
    if (!csv_.number(cell, number) || !(number > 0)) return error(field, "is '" + cell + "', expected millimetres");
    if (number < kGirthMinMm || number > kGirthMaxMm)
      return error(field, "is '" + cell + "' mm, expected a chest girth of 300 to 2500 mm" +
                              (number >= kGirthMinMm / 10 && number <= kGirthMaxMm / 10
                                   ? "; if these are centimetres, write millimetres"
                                   : ""));
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
  CsvReader csv_;
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
  return ChartParser(text, what).parse();
}

Result<SizeChart> load_size_chart(const std::string& path) {
  auto bytes = read_file(path, kChartBytesMax);
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

// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/statistics.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>
#include <utility>
#include <vector>

#include "core/file.h"
#include "core/text.h"
#include "formats/csv.h"

namespace im2fit::apps {
namespace {

constexpr char kHead[] = "period,what,name,count\n";
constexpr std::size_t kDayCharacters = 10, kMonthCharacters = 7, kNameBytesMax = 60;
constexpr std::array kDaily = {"visits", "measured"}, kMonthly = {"size", "not_measured"};

// "2026-11-30" or "2026-11"
bool is_period(const std::string& text, std::size_t characters) {
  constexpr std::string_view kForm = "dddd-dd-dd";
  if (text.size() != characters) return false;
  for (std::size_t i = 0; i < characters; ++i)
    if (kForm[i] == 'd' ? text[i] < '0' || text[i] > '9' : text[i] != kForm[i]) return false;
  return true;
}

// One cell of the table: a chart may name its sizes as it likes. Of such a cell it makes the same.
std::string cell_of(const std::string& name) {
  std::string cell = printable(name);
  std::replace_if(
      cell.begin(), cell.end(), [](char c) { return c == ',' || c == '"' || c == ';'; }, ' ');
  cell.erase(0, std::min(cell.find_first_not_of(' '), cell.size()));  // readers leave out blanks at the ends
  // A spreadsheet would compute what begins like this.
  if (!cell.empty() && std::string_view("=+-@").find(cell.front()) != std::string_view::npos) cell.insert(0, 1, '\'');
  std::size_t end = std::min(cell.size(), kNameBytesMax);
  while (end < cell.size() && end > 0 && (static_cast<unsigned char>(cell[end]) & 0xC0) == 0x80) --end;
  cell.resize(end);
  cell.resize(cell.find_last_not_of(' ') + 1);
  return cell;
}

}  // namespace

std::string local_day() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  ::localtime_r(&now, &local);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d", &local)};
}

Result<std::unique_ptr<Statistics>> Statistics::open(const std::string& path) {
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes && bytes.error().code != ErrorCode::not_found) return bytes.error();
  auto made = parse(bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : kHead, path);
  if (!made) return made;
  (*made)->changed_ = true;  // found out now, and not with the first visit: the file cannot be written
  if (auto written = (*made)->flush(); !written) return written.error();
  return made;
}

Result<std::unique_ptr<Statistics>> Statistics::parse(const std::string& text, const std::string& path) {
  std::unique_ptr<Statistics> made(new Statistics(path));
  if (auto read = made->read(text); !read) return read.error();
  return made;
}

Status Statistics::read(const std::string& text) {
  CsvReader reader(text, path_);
  std::vector<std::string> cells;
  const auto wrong = [&](const std::string& problem) {
    return Error{ErrorCode::corrupt, path_ + ":" + std::to_string(reader.line()) + ": " + problem};
  };
  bool head = true;
  for (;;) {
    const auto more = reader.next(cells);
    if (!more) return more.error();
    if (!*more) return head ? Status(wrong("expected the columns period,what,name,count")) : Status(Ok{});
    if (std::exchange(head, false)) {
      if (cells != std::vector<std::string>{"period", "what", "name", "count"})
        return wrong("expected the columns period,what,name,count");
      continue;
    }
    if (cells.size() != 4) return wrong("has " + std::to_string(cells.size()) + " cells, expected 4");
    const bool daily = std::find(kDaily.begin(), kDaily.end(), cells[1]) != kDaily.end();
    if (!daily && std::find(kMonthly.begin(), kMonthly.end(), cells[1]) == kMonthly.end())
      return wrong("what is " + excerpt(cells[1]) + ", expected visits, measured, size or not_measured");
    if (!is_period(cells[0], daily ? kDayCharacters : kMonthCharacters))
      return wrong("period is " + excerpt(cells[0]) + ", expected " + (daily ? "2026-11-30" : "2026-11"));
    std::uint64_t count = 0;
    const char* end = cells[3].data() + cells[3].size();
    const auto [stop, error] = std::from_chars(cells[3].data(), end, count);
    if (error != std::errc() || stop != end) return wrong("count is " + excerpt(cells[3]) + ", expected a number");
    counts_[{cells[0], cells[1], cell_of(cells[2])}] += count;
  }
}

void Statistics::add(std::string period, const char* what, const std::string& name) {
  const std::lock_guard lock(mutex_);
  ++counts_[{std::move(period), what, cell_of(name)}];
  changed_ = true;
}

void Statistics::visit(const std::string& day) {
  add(day, "visits", "");
}

void Statistics::measured(const std::string& day, const std::string& size) {
  add(day, "measured", "");
  if (!size.empty()) add(day.substr(0, kMonthCharacters), "size", size);
}

void Statistics::not_measured(const std::string& day, const std::string& reason) {
  add(day.substr(0, kMonthCharacters), "not_measured", reason);
}

std::string Statistics::csv() const {
  const std::lock_guard lock(mutex_);
  std::string text = kHead;
  for (const auto& [key, count] : counts_) {
    const auto& [period, what, name] = key;
    text += period + "," + what + "," + name + "," + std::to_string(count) + "\n";
  }
  return text;
}

Status Statistics::flush() {
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(changed_, false)) return Ok{};
  }
  auto written = write_file_atomically(path_, csv(), Readable::by_owner);
  if (!written) {
    const std::lock_guard lock(mutex_);
    changed_ = true;
  }
  return written;
}

}  // namespace im2fit::apps

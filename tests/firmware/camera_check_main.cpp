// SPDX-License-Identifier: Apache-2.0
// Takes frames from a source and finds for each the equal frame of a depth folder, pixel for pixel. Prints one line
// of figures at the end. Runs inside the guest of scripts/firmware-test.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <map>
#include <optional>
#include <thread>

#include "core/crc32c.h"
#include "hal/folder/depth_folder.h"
#include "hal/open/open.h"
#include "tests/devices/process_state.h"
#include "tests/devices/words.h"

namespace im2fit {
namespace {

constexpr const char* kUsage =
    "usage: im2fit-camera-check SOURCE DEPTH_FOLDER [--frames 60] [--rounds 0] [--patience-ms 5000] [--period-ns 0]\n"
    "  a camera is opened with the folder's calibration\n"
    "  --rounds N: the camera is unplugged N times meanwhile; it is opened once and has to come back by itself\n"
    "  --period-ns: of the camera's clock; says how far time stamps strayed from it";

std::int64_t now_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

class Clip {
 public:
  static Result<Clip> load(const std::string& path) {
    auto folder = hal::FolderSource::open(path);
    if (!folder) return folder.error();
    if (auto ok = (*folder)->start(); !ok) return ok.error();
    const Intrinsics& k = (*folder)->info().intrinsics;
    Clip clip;
    for (;;) {
      std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
      const auto frame = (*folder)->next({pixels.data(), k.width, k.height}, 0);
      if (!frame && frame.error().code == ErrorCode::end_of_stream) return clip;
      if (!frame) return frame.error();
      clip.by_crc_.emplace(crc_of(pixels), static_cast<int>(clip.frames_.size()));
      clip.frames_.push_back(std::move(pixels));
    }
  }
  // The number of the frame that has these pixels, -1 for none.
  int find(const std::vector<std::uint16_t>& pixels) const {
    const auto found = by_crc_.find(crc_of(pixels));
    if (found == by_crc_.end() || frames_[static_cast<std::size_t>(found->second)] != pixels) return -1;
    return found->second;
  }
  int size() const { return static_cast<int>(frames_.size()); }

 private:
  static std::uint32_t crc_of(const std::vector<std::uint16_t>& pixels) {
    return crc32c(std::as_bytes(std::span(pixels)));
  }
  std::vector<std::vector<std::uint16_t>> frames_;
  std::map<std::uint32_t, int> by_crc_;
};

// How far stamps are from where a clock of the wanted period has them, the first frame's being right.
class Stray {
 public:
  void saw(std::uint64_t sequence, std::int64_t stamp_ns, std::int64_t period_ns) {
    if (!first_) first_ = {sequence, stamp_ns};
    last_ns_ = stamp_ns - first_->second - static_cast<std::int64_t>(sequence - first_->first) * period_ns;
    min_ns_ = std::min(min_ns_, last_ns_);
    max_ns_ = std::max(max_ns_, last_ns_);
  }
  long long last_us() const { return last_ns_ / 1000; }
  long long range_us() const { return (max_ns_ - min_ns_) / 1000; }

 private:
  std::optional<std::pair<std::uint64_t, std::int64_t>> first_;
  std::int64_t last_ns_ = 0, min_ns_ = 0, max_ns_ = 0;
};

struct Figures {
  int delivered = 0, exact = 0, foreign = 0;
  int in_order = 0;   // the clip's next frame after the one before it
  int repeated = 0;   // the same once more
  int reversals = 0;  // of time or of the number
  hal::SourceStats stats;
  std::int64_t first_ns = 0;
  hal::FrameInfo last;
  int lost = 0, rounds = 0;  // rounds: lost and back
  Stray host, device;
  std::optional<Vec3f> down;
};

// What must not grow from round to round, and from frame to frame.
void say_state(const char* when) {
  std::printf("state %s rss_kb=%ld threads=%d files=%d\n", when, devices::resident_kb(), devices::threads(),
              devices::open_files());
}

void say_when(const char* what) {
  std::printf("%s at_ms=%lld\n", what, static_cast<long long>(now_ms()));
  std::fflush(stdout);
}

struct Wanted {
  std::string uri, folder;
  int frames = 60, rounds = 0;
  std::int64_t patience_ms = 5000, period_ns = 0;
};

void count(const Clip& clip, const std::vector<std::uint16_t>& pixels, const hal::FrameInfo& info,
           std::int64_t period_ns, int& previous, Figures& figures) {
  const int found = clip.find(pixels);
  const bool first = figures.delivered == 0;
  if (first) figures.first_ns = info.host_ns;
  if (!first && (info.host_ns <= figures.last.host_ns || info.sequence <= figures.last.sequence)) ++figures.reversals;
  figures.last = info;
  figures.host.saw(info.sequence, info.host_ns, period_ns);
  if (info.device_us >= 0) figures.device.saw(info.sequence, info.device_us * 1000, period_ns);
  ++figures.delivered;
  if (found < 0)
    ++figures.foreign;
  else
    ++figures.exact;
  if (found >= 0 && previous >= 0 && found == (previous + 1) % clip.size()) ++figures.in_order;
  if (found >= 0 && previous >= 0 && found == previous) ++figures.repeated;
  previous = found;
}

// The first rounds, and the first frames, fill pools and tables.
void tell(const hal::ReconnectStats& stats, const Wanted& wanted, Figures& figures) {
  figures.lost = static_cast<int>(stats.lost);
  figures.rounds = static_cast<int>(stats.recovered);
  if (stats.presence == hal::Presence::present) return say_when("first");
  std::printf("lost at_ms=%lld: %s\n", static_cast<long long>(now_ms()), stats.last_error.c_str());
  if (figures.lost == 3) say_state("early");
  if (figures.lost == wanted.rounds) say_state("last");
}

// Frames until there are enough of them and of losses; the error that ended it, if any.
Status take(hal::Source& source, const Clip& clip, const Wanted& wanted, Figures& figures) {
  if (auto ok = source.start(); !ok) return ok;
  const Intrinsics& k = source.info().intrinsics;
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  int previous = -1;
  std::int64_t heard_ms = now_ms();
  while (figures.rounds < wanted.rounds || figures.delivered < wanted.frames) {
    const auto frame = source.next({pixels.data(), k.width, k.height}, 250);
    if (frame) {
      if (figures.delivered == 0) say_when("first");
      heard_ms = now_ms();
      count(clip, pixels, *frame, wanted.period_ns, previous, figures);
      if (wanted.rounds == 0 && figures.delivered == wanted.frames / 10) say_state("early");
      if (wanted.rounds > 0 && figures.delivered > 20 * wanted.frames)
        return Error{ErrorCode::invalid_argument, "the loss waited for did not come"};
    } else if (frame.error().code == ErrorCode::corrupt) {
      previous = -1;
    } else if (frame.error().code != ErrorCode::timeout || now_ms() - heard_ms >= wanted.patience_ms) {
      return frame.error();
    }
  }
  if (wanted.rounds == 0) say_state("last");
  figures.down = source.down();
  return Ok{};
}

// A camera that was just plugged in may need a moment.
Result<std::unique_ptr<hal::Source>> open_patiently(const Wanted& wanted, const hal::ReconnectOptions& reconnect) {
  hal::OpenOptions options;
  if (wanted.uri.find(':') != std::string::npos) options.camera_yaml_path = wanted.folder + "/camera.yaml";
  const std::int64_t began_ms = now_ms();
  for (;;) {
    auto source = wanted.rounds > 0 ? hal::open_reconnecting(wanted.uri, options, reconnect)
                                    : hal::open_source(wanted.uri, options);
    if (source || now_ms() - began_ms > wanted.patience_ms) return source;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

Status check(const Wanted& wanted, Figures& figures) {
  const auto clip = Clip::load(wanted.folder);
  if (!clip) return clip.error();
  hal::ReconnectOptions reconnect;
  reconnect.changed = [&](const hal::ReconnectStats& stats) { tell(stats, wanted, figures); };
  auto source = open_patiently(wanted, reconnect);
  if (!source) return source.error();
  auto taken = take(**source, *clip, wanted, figures);
  figures.stats = (*source)->stats();
  (*source)->stop();
  return taken;
}

void say_figures(const Figures& f, std::int64_t period_ns) {
  const double seconds = static_cast<double>(f.last.host_ns - f.first_ns) * 1e-9;
  std::printf(
      "figures delivered=%d exact=%d foreign=%d in_order=%d repeated=%d damaged=%llu gaps=%llu reversals=%d lost=%d "
      "rounds=%d fps=%.2f",
      f.delivered, f.exact, f.foreign, f.in_order, f.repeated, static_cast<unsigned long long>(f.stats.damaged),
      static_cast<unsigned long long>(f.stats.gaps), f.reversals, f.lost, f.rounds,
      seconds > 0 ? (f.delivered - 1) / seconds : 0.0);
  if (f.down) std::printf(" down_x=%.3f down_y=%.3f down_z=%.3f", f.down->x, f.down->y, f.down->z);
  if (period_ns > 0) std::printf(" drift_us=%lld stray_us=%lld", f.host.last_us(), f.host.range_us());
  if (period_ns > 0 && f.last.device_us >= 0)
    std::printf(" device_drift_us=%lld device_stray_us=%lld", f.device.last_us(), f.device.range_us());
  std::printf("\n");
}

}  // namespace
}  // namespace im2fit

int main(int argc, char** argv) {
  using namespace im2fit;
  const devices::Words words(argc, argv, {{"frames", 60}, {"rounds", 0}, {"patience-ms", 5000}, {"period-ns", 0}},
                             kUsage);
  if (words.words().size() != 2) return std::fprintf(stderr, "%s\n", kUsage), 2;
  const Wanted wanted{words.words()[0],      words.words()[1],     words.whole("frames"),
                      words.whole("rounds"), words["patience-ms"], words["period-ns"]};
  Figures figures;
  const auto checked = check(wanted, figures);
  say_figures(figures, wanted.period_ns);
  if (checked) return 0;
  std::printf("ended: %s\n", checked.error().message.c_str());
  return 1;
}

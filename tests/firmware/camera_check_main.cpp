// SPDX-License-Identifier: Apache-2.0
// Takes frames from a source and says of each which frame of a depth folder it is, pixel for pixel. One line of
// figures at the end; inside the guest of scripts/firmware-test.
#include <dirent.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <map>
#include <thread>

#include "base/crc32c.h"
#include "hal/folder/depth_folder.h"
#include "hal/open/open.h"
#include "tests/devices/words.h"

namespace im2fit {
namespace {

constexpr const char* kUsage =
    "usage: im2fit-camera-check SOURCE DEPTH_FOLDER [--frames 60] [--rounds 0] [--patience-ms 5000]\n"
    "  a camera is opened with the folder's calibration; --rounds N: the camera is unplugged N times meanwhile, open "
    "it "
    "again";

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

struct Figures {
  int delivered = 0, exact = 0, foreign = 0;
  int in_order = 0;  // the clip's next frame after the one before it
  int repeated = 0;  // the same once more
  std::uint64_t damaged = 0, gaps = 0;
  std::int64_t first_ns = 0, last_ns = 0;
  int time_reversals = 0;
  int rounds = 0;
};

int count_entries(const char* path) {
  int count = 0;
  DIR* folder = ::opendir(path);
  if (folder == nullptr) return -1;
  while (::readdir(folder) != nullptr) ++count;
  ::closedir(folder);
  return count;
}

long resident_kb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::strtol(line.c_str() + 6, nullptr, 10);
  return -1;
}

// What must not grow from round to round.
void say_state(const char* when) {
  std::printf("state %s rss_kb=%ld threads=%d files=%d\n", when, resident_kb(), count_entries("/proc/self/task") - 2,
              count_entries("/proc/self/fd") - 3);
}

void count(const Clip& clip, const std::vector<std::uint16_t>& pixels, const hal::FrameInfo& info, int& previous,
           Figures& figures) {
  const int found = clip.find(pixels);
  if (figures.delivered == 0) figures.first_ns = info.host_ns;
  if (figures.delivered > 0 && info.host_ns <= figures.last_ns) ++figures.time_reversals;
  figures.last_ns = info.host_ns;
  ++figures.delivered;
  if (found < 0)
    ++figures.foreign;
  else
    ++figures.exact;
  if (found >= 0 && previous >= 0 && found == (previous + 1) % clip.size()) ++figures.in_order;
  if (found >= 0 && previous >= 0 && found == previous) ++figures.repeated;
  previous = found;
}

struct Wanted {
  std::string uri, folder;
  int frames = 60, rounds = 0;
  long long patience_ms = 5000;
};

// Frames from one opening to its end; the error that ended it, if any.
Status take(hal::Source& source, const Clip& clip, const Wanted& wanted, bool to_the_loss, Figures& figures) {
  if (auto ok = source.start(); !ok) return ok;
  const Intrinsics& k = source.info().intrinsics;
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  int previous = -1;
  bool first = true;
  Status ended = Ok{};
  const int frames_max = figures.delivered + 20 * wanted.frames;
  for (std::int64_t heard_ms = now_ms(); to_the_loss || figures.delivered < wanted.frames;) {
    const auto frame = source.next({pixels.data(), k.width, k.height}, 250);
    if (figures.delivered > frames_max) {
      ended = Error{ErrorCode::invalid_argument, "the loss waited for did not come"};
      break;
    }
    if (frame) {
      if (first) {
        std::printf("first at_ms=%lld\n", static_cast<long long>(now_ms()));
        std::fflush(stdout);
      }
      first = false;
      heard_ms = now_ms();
      count(clip, pixels, *frame, previous, figures);
      continue;
    }
    if (frame.error().code == ErrorCode::corrupt) {
      previous = -1;
      continue;
    }
    if (frame.error().code == ErrorCode::timeout && now_ms() - heard_ms < wanted.patience_ms) continue;
    ended = frame.error();
    break;
  }
  figures.damaged += source.stats().damaged;
  figures.gaps += source.stats().gaps;
  source.stop();
  return ended;
}

Status check(const Wanted& wanted, Figures& figures) {
  const auto clip = Clip::load(wanted.folder);
  if (!clip) return clip.error();
  hal::OpenOptions options;
  if (wanted.uri.find(':') != std::string::npos) options.camera_yaml_path = wanted.folder + "/camera.yaml";
  std::int64_t heard_ms = now_ms();
  for (;;) {
    auto source = hal::open_source(wanted.uri, options);
    Status ended = source ? take(**source, *clip, wanted, figures.rounds < wanted.rounds, figures) : source.error();
    if (ended) return ended;
    if (source && ended.error().code == ErrorCode::no_device && figures.rounds < wanted.rounds) {
      ++figures.rounds;
      std::printf("lost at_ms=%lld: %s\n", static_cast<long long>(now_ms()), ended.error().message.c_str());
      // The first rounds fill pools and tables.
      if (figures.rounds == 3) say_state("early");
      if (figures.rounds == wanted.rounds) say_state("last");
      heard_ms = now_ms();
    } else if (source && ended.error().code != ErrorCode::no_device) {
      return ended;
    }
    source = Error{};  // closed before it is opened anew
    if (now_ms() - heard_ms > wanted.patience_ms) return ended;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

}  // namespace
}  // namespace im2fit

int main(int argc, char** argv) {
  using namespace im2fit;
  const devices::Words words(argc, argv, {{"frames", 60}, {"rounds", 0}, {"patience-ms", 5000}}, kUsage);
  if (words.words().size() != 2) return std::fprintf(stderr, "%s\n", kUsage), 2;
  const Wanted wanted{words.words()[0], words.words()[1], words.whole("frames"), words.whole("rounds"),
                      words["patience-ms"]};
  Figures f;
  const auto checked = check(wanted, f);
  say_state("end");
  const double seconds = static_cast<double>(f.last_ns - f.first_ns) * 1e-9;
  std::printf(
      "figures delivered=%d exact=%d foreign=%d in_order=%d repeated=%d damaged=%llu gaps=%llu reversals=%d "
      "rounds=%d "
      "fps=%.2f\n",
      f.delivered, f.exact, f.foreign, f.in_order, f.repeated, static_cast<unsigned long long>(f.damaged),
      static_cast<unsigned long long>(f.gaps), f.time_reversals, f.rounds,
      seconds > 0 ? (f.delivered - 1) / seconds : 0.0);
  if (checked) return 0;
  std::printf("ended: %s\n", checked.error().message.c_str());
  return 1;
}

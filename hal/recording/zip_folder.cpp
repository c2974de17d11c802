// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/zip_folder.h"

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/text.h"
#include "hal/recording/temporary_folder.h"

#if IM2FIT_HAVE_ZIP
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <span>

#include "hal/recording/file_cursor.h"
#endif

namespace im2fit::hal {
namespace {

// The source of an unpacked folder, in the archive's name.
class ZipSource final : public Source {
 public:
  ZipSource(std::string path, TemporaryFolder folder, std::unique_ptr<Source> source)
      : path_(std::move(path)), folder_(std::move(folder)), source_(std::move(source)), info_(source_->info()) {
    info_.uri = info_.name = path_;
  }
  // The temporary folder is no place that a user knows.
  static Error renamed(Error error, const std::string& folder, const std::string& path) {
    for (std::size_t at = 0; (at = error.message.find(folder, at)) != std::string::npos; at += path.size())
      error.message.replace(at, folder.size(), path);
    return error;
  }

  const SourceInfo& info() const override { return info_; }
  Status start() override {
    auto status = source_->start();
    if (!status) return renamed(status.error(), folder_.path(), path_);
    return status;
  }
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override {
    auto frame = source_->next(depth, timeout_ms);
    if (!frame) return renamed(frame.error(), folder_.path(), path_);
    return frame;
  }
  void stop() override { source_->stop(); }
  SourceStats stats() const override { return source_->stats(); }
  std::optional<Vec3f> down() const override { return source_->down(); }
  const Source& inner() const { return *source_; }

 private:
  std::string path_;
  TemporaryFolder folder_;
  std::unique_ptr<Source> source_;
  SourceInfo info_;
};

#if IM2FIT_HAVE_ZIP

constexpr std::size_t kFileBytesMax = std::size_t{64} << 20;           // as a depth folder's
constexpr std::uint64_t kDirectoryBytesMax = std::uint64_t{16} << 20;  // of the archive's table of contents
constexpr zip_int64_t kZipEntriesMax = 65'534;                         // more have another table of contents (zip64)
constexpr std::size_t kDepthMax = 8;

Error refused(const std::string& path, ErrorCode code, const std::string& problem) {
  return {code, path + " " + problem};
}
Error too_many(const std::string& path) {
  return refused(path, ErrorCode::unsupported, "has more files than a recording; unpack it and give the folder");
}

// The end of the archive names the size of its table of contents, which libzip reads whole. What looks like an end is
// one for libzip, in the archive's comment, too; before it may stand the locator of another end, which libzip
// prefers.
Status check_directory(const std::string& path) {
  constexpr std::size_t kEndBytes = 22, kCommentMax = 65535, kLocatorBytes = 20;
  constexpr int kEndsMax = 4;  // libzip reads a table of contents for each
  auto file = FileCursor::open(path);
  if (!file) return file.error();
  const std::uint64_t tail = std::min<std::uint64_t>(file->size(), kLocatorBytes + kEndBytes + kCommentMax);
  std::string bytes(static_cast<std::size_t>(tail), '\0');
  file->seek(file->size() - tail);
  if (auto ok = file->read(std::as_writable_bytes(std::span(bytes))); !ok) return ok;
  const Error no_archive = refused(path, ErrorCode::corrupt,
                                   "is not a whole .zip archive; copy it again, or unpack it and give the folder");
  const auto number = [&](std::size_t at, std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  int ends = 0;
  for (std::size_t at = 0; (at = bytes.find("PK\5\6", at)) != std::string::npos; ++at) {
    if (at + kEndBytes > bytes.size()) break;
    if (++ends > kEndsMax) return no_archive;
    if (number(at + 10, 2) > static_cast<std::uint64_t>(kZipEntriesMax) || number(at + 12, 4) > kDirectoryBytesMax)
      return too_many(path);
    if (at >= kLocatorBytes && bytes.compare(at - kLocatorBytes, 4, "PK\6\7") == 0)
      return refused(path, ErrorCode::unsupported,
                     "has a table of contents for huge archives (zip64); unpack it and give the folder");
  }
  if (ends == 0) return no_archive;
  return Ok{};
}

struct Archive {
  zip_t* zip = nullptr;
  ~Archive() {
    if (zip) zip_discard(zip);
  }
};

struct Entry {
  zip_uint64_t index = 0;
  std::uint64_t size = 0;
  std::string name;
};

bool is_wanted(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  const std::string last = name.substr(slash == std::string::npos ? 0 : slash + 1);
  if (last.empty() || last.front() == '.' || name.rfind("__MACOSX/", 0) == 0) return false;
  std::string ending = std::filesystem::path(last).extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const char* wanted : {".png", ".pgm", ".csv", ".yaml", ".json", ".txt"})
    if (ending == wanted) return true;
  return false;
}

// Of "./depth/000000.png" (bsdtar) and of PowerShell's backslashes.
std::string with_slashes(std::string_view name) {
  std::string plain;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find_first_of("/\\", begin), name.size());
    const std::string_view part = name.substr(begin, end - begin);
    if (part != ".") plain.append(part);
    if (part != "." && end < name.size()) plain += '/';
    begin = end + 1;
  }
  return plain;
}

// Plain names between slashes.
bool is_inside(const std::string& name) {
  constexpr std::size_t kPartMax = 200;
  std::size_t parts = 0;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    const std::string_view part = std::string_view(name).substr(begin, end - begin);
    if (part.empty() || part == "." || part == ".." || part.size() > kPartMax || ++parts > kDepthMax) return false;
    for (const char c : part)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) return false;
    if (end == name.size()) return true;
    begin = end + 1;
  }
}

Result<std::vector<Entry>> wanted_entries(zip_t* zip, const std::string& path) {
  std::vector<Entry> entries;
  const zip_int64_t count = zip_get_num_entries(zip, 0);
  if (count > kZipEntriesMax) return too_many(path);  // libzip takes the count of the archive's end as modulo 65536
  std::uint64_t total = 0;
  for (zip_int64_t i = 0; i < count; ++i) {
    zip_stat_t about;
    zip_stat_init(&about);
    if (zip_stat_index(zip, static_cast<zip_uint64_t>(i), 0, &about) != 0 || about.name == nullptr ||
        (about.valid & ZIP_STAT_SIZE) == 0)
      return refused(path, ErrorCode::corrupt, "has a damaged table of contents; copy it again");
    const std::string name = with_slashes(about.name);
    if (!is_wanted(name)) continue;
    const std::string shown = excerpt(name);
    if (!is_inside(name))
      return refused(path, ErrorCode::corrupt, "has the file " + shown + ", which lies outside of it; do not use it");
    if ((about.valid & ZIP_STAT_ENCRYPTION_METHOD) != 0 && about.encryption_method != ZIP_EM_NONE)
      return refused(path, ErrorCode::unsupported, "is encrypted; unpack it and give the folder");
    if (about.size > kFileBytesMax)
      return refused(path, ErrorCode::unsupported,
                     "has the file " + shown + " of " + std::to_string(about.size) + " bytes, expected at most " +
                         std::to_string(kFileBytesMax));
    total += about.size;
    if (total > kZipBytesMax)
      return refused(path, ErrorCode::unsupported,
                     "holds more than " + std::to_string(kZipBytesMax >> 30) + " GB; unpack it and give the folder");
    entries.push_back({static_cast<zip_uint64_t>(i), about.size, name});
  }
  if (entries.empty())
    return refused(path, ErrorCode::not_found, "holds no pictures; expected the folder of a recording in it");
  return entries;
}

// Of one folder that all are in: "c00a170fe1/".
void leave_folder(std::vector<Entry>& entries) {
  for (;;) {
    const std::string& first = entries.front().name;
    const std::size_t slash = first.find('/');
    if (slash == std::string::npos) return;
    const std::string folder = first.substr(0, slash + 1);
    // depth/ alone may be a part of a recording.
    if (folder == "depth/") return;
    for (const Entry& entry : entries)
      if (entry.name.rfind(folder, 0) != 0) return;
    for (Entry& entry : entries) entry.name.erase(0, folder.size());
  }
}

Status unpack_entry(zip_t* zip, const Entry& entry, const std::string& path, const std::string& to,
                    std::vector<char>& buffer) {
  const auto damaged = [&] {
    return refused(path, ErrorCode::corrupt, "is damaged at " + excerpt(entry.name) + "; copy it again");
  };
  zip_file_t* in = zip_fopen_index(zip, entry.index, 0);
  if (in == nullptr && zip_error_code_zip(zip_get_error(zip)) == ZIP_ER_COMPNOTSUPP)
    return refused(path, ErrorCode::unsupported,
                   "is compressed by a method this build does not read; unpack it and give the folder");
  if (in == nullptr) return damaged();
  const int out = ::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  Status status = Ok{};
  if (out < 0 && errno == EEXIST)
    status = refused(path, ErrorCode::corrupt, "has the file " + excerpt(entry.name) + " twice; make it again");
  else if (out < 0)
    status = Error{ErrorCode::io, "cannot unpack " + path + ": " + std::strerror(errno)};
  std::uint64_t have = 0;
  while (status) {
    const zip_int64_t got = zip_fread(in, buffer.data(), buffer.size());
    if (got < 0 || have + static_cast<std::uint64_t>(got) > entry.size) status = damaged();
    if (got <= 0 || !status) break;
    have += static_cast<std::uint64_t>(got);
    for (zip_int64_t written = 0; written < got && status;) {
      const auto done = ::write(out, buffer.data() + written, static_cast<std::size_t>(got - written));
      if (done < 0 && errno != EINTR)
        status = Error{ErrorCode::io,
                       "cannot unpack " + path + ": " + std::strerror(errno) + "; set TMPDIR to a folder with room"};
      written += done > 0 ? done : 0;
    }
  }
  if (status && have != entry.size) status = damaged();
  if (out >= 0) ::close(out);
  if (zip_fclose(in) != 0 && status) status = damaged();
  return status;
}

// Nothing else is in it.
bool holds_only(const std::string& folder, const std::string& name) {
  std::error_code code;
  std::filesystem::directory_iterator it(folder, code);
  if (code || it == std::filesystem::directory_iterator() || it->path().filename() != name) return false;
  it.increment(code);
  return !code && it == std::filesystem::directory_iterator();
}

#endif

}  // namespace

#if IM2FIT_HAVE_ZIP
Status unpack_zip(const std::string& path, const std::string& folder) {
  if (auto ok = check_directory(path); !ok) return ok;
  int code = 0;
  Archive archive{zip_open(path.c_str(), ZIP_RDONLY, &code)};
  if (archive.zip == nullptr)
    return refused(path, ErrorCode::corrupt,
                   "is not a whole .zip archive; copy it again, or unpack it and give the folder");
  auto entries = wanted_entries(archive.zip, path);
  if (!entries) return entries.error();
  leave_folder(*entries);
  std::vector<char> buffer(std::size_t{64} << 10);
  std::set<std::string> made;
  for (const Entry& entry : *entries) {
    const std::size_t slash = entry.name.rfind('/');
    const std::string inner = slash == std::string::npos ? "" : entry.name.substr(0, slash);
    if (!inner.empty() && made.insert(inner).second) {
      std::error_code failed;
      std::filesystem::create_directories(folder + "/" + inner, failed);
      if (failed) return Error{ErrorCode::io, "cannot unpack " + path + ": " + failed.message()};
    }
    if (auto ok = unpack_entry(archive.zip, entry, path, folder + "/" + entry.name, buffer); !ok) return ok;
  }
  return Ok{};
}

Result<std::unique_ptr<Source>> open_zip(
    const std::string& path, const std::function<Result<std::unique_ptr<Source>>(const std::string& folder)>& open) {
  auto folder = TemporaryFolder::make();
  if (!folder) return folder.error();
  if (auto ok = unpack_zip(path, folder->path()); !ok) return ok.error();
  auto source = open(folder->path());
  // A depth folder may have this name itself.
  if (!source && source.error().code == ErrorCode::not_found && holds_only(folder->path(), "depth"))
    source = open(folder->path() + "/depth");
  if (!source) return ZipSource::renamed(source.error(), folder->path(), path);
  return std::unique_ptr<Source>(new ZipSource(path, std::move(*folder), std::move(*source)));
}
#else
Status unpack_zip(const std::string& path, const std::string& /*folder*/) {
  return Error{ErrorCode::unsupported,
               path + " is an archive, and this build has no libzip; unpack it and give the folder"};
}

Result<std::unique_ptr<Source>> open_zip(const std::string& path,
                                         const std::function<Result<std::unique_ptr<Source>>(const std::string&)>&) {
  return unpack_zip(path, "").error();
}
#endif

const FolderSource* folder_of(const Source& source) {
  const auto* zip = dynamic_cast<const ZipSource*>(&source);
  return dynamic_cast<const FolderSource*>(zip ? &zip->inner() : &source);
}

}  // namespace im2fit::hal

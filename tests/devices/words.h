// SPDX-License-Identifier: Apache-2.0
// The command line of the small programs that run inside the guest: words, and --key value pairs of numbers.
#pragma once

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace im2fit::devices {

class Words {
 public:
  // Ends the program with `usage` when a --key is not in `keys` (which holds the defaults) or has no number.
  Words(int argc, char** argv, std::map<std::string, long long> keys, const char* usage) : keys_(std::move(keys)) {
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word.rfind("--", 0) != 0) {
        words_.push_back(word);
        continue;
      }
      const auto key = keys_.find(word.substr(2));
      const std::string value = i + 1 < argc ? argv[++i] : "";
      const char* end = value.data() + value.size();
      if (key == keys_.end() || value.empty() || std::from_chars(value.data(), end, key->second).ptr != end) {
        std::fprintf(stderr, "%s: bad option %s %s\n%s\n", argv[0], word.c_str(), value.c_str(), usage);
        std::exit(2);
      }
    }
  }
  long long operator[](const std::string& key) const { return keys_.at(key); }
  int whole(const std::string& key) const { return static_cast<int>(keys_.at(key)); }
  const std::vector<std::string>& words() const { return words_; }

 private:
  std::map<std::string, long long> keys_;
  std::vector<std::string> words_;
};

}  // namespace im2fit::devices

// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/web_files.h"

#include <algorithm>
#include <array>

// The assembler reads the file (GNU as, .incbin); CMake names the folders and rebuilds this when the files change.
// NOLINTBEGIN(bugprone-macro-parentheses): names that are declared
#define IM2FIT_EMBED(name, path)                                                                         \
  asm(".pushsection .rodata\n" #name ":\n.incbin \"" path "\"\n" #name "_end:\n.byte 0\n.popsection\n"); \
  extern "C" __attribute__((visibility("hidden"))) const char name[], name##_end[];
// NOLINTEND(bugprone-macro-parentheses)

IM2FIT_EMBED(im2fit_web_index, IM2FIT_PAGE_MADE_DIR "/index.html")
IM2FIT_EMBED(im2fit_web_style, IM2FIT_WEB_DIR "/page.css")
IM2FIT_EMBED(im2fit_web_words, IM2FIT_WEB_DIR "/words.js")
IM2FIT_EMBED(im2fit_web_icons, IM2FIT_WEB_DIR "/icons.js")
IM2FIT_EMBED(im2fit_web_sounds, IM2FIT_WEB_DIR "/sounds.js")
IM2FIT_EMBED(im2fit_web_mirror, IM2FIT_WEB_DIR "/mirror.js")
IM2FIT_EMBED(im2fit_web_en, IM2FIT_WEB_DIR "/lang/en.json")
IM2FIT_EMBED(im2fit_web_de, IM2FIT_WEB_DIR "/lang/de.json")
IM2FIT_EMBED(im2fit_web_es, IM2FIT_WEB_DIR "/lang/es.json")
IM2FIT_EMBED(im2fit_web_fr, IM2FIT_WEB_DIR "/lang/fr.json")
IM2FIT_EMBED(im2fit_web_zh, IM2FIT_WEB_DIR "/lang/zh.json")
IM2FIT_EMBED(im2fit_web_stage, IM2FIT_WEB_DIR "/stage.js")
IM2FIT_EMBED(im2fit_web_cloth, IM2FIT_WEB_DIR "/cloth.js")
IM2FIT_EMBED(im2fit_web_tryon, IM2FIT_WEB_DIR "/tryon.js")
IM2FIT_EMBED(im2fit_web_tryon_style, IM2FIT_WEB_DIR "/tryon.css")
IM2FIT_EMBED(im2fit_web_facts, IM2FIT_WEB_DIR "/facts.js")
IM2FIT_EMBED(im2fit_web_facts_style, IM2FIT_WEB_DIR "/facts.css")
IM2FIT_EMBED(im2fit_web_page, IM2FIT_WEB_DIR "/page.js")
IM2FIT_EMBED(im2fit_web_handed, IM2FIT_WEB_DIR "/handed.html")
IM2FIT_EMBED(im2fit_web_handed_script, IM2FIT_WEB_DIR "/handed.js")
IM2FIT_EMBED(im2fit_web_operator, IM2FIT_WEB_DIR "/operator.html")
IM2FIT_EMBED(im2fit_web_operator_script, IM2FIT_WEB_DIR "/operator.js")
IM2FIT_EMBED(im2fit_web_operator_style, IM2FIT_WEB_DIR "/operator.css")
IM2FIT_EMBED(im2fit_web_three, IM2FIT_THREE_DIR "/build/three.min.js")
IM2FIT_EMBED(im2fit_web_loader, IM2FIT_THREE_DIR "/examples/js/loaders/GLTFLoader.js")
IM2FIT_EMBED(im2fit_web_orbit, IM2FIT_THREE_DIR "/examples/js/controls/OrbitControls.js")
IM2FIT_EMBED(im2fit_web_three_gzip, IM2FIT_PAGE_MADE_DIR "/three.gz")
IM2FIT_EMBED(im2fit_web_loader_gzip, IM2FIT_PAGE_MADE_DIR "/loader.gz")
IM2FIT_EMBED(im2fit_web_orbit_gzip, IM2FIT_PAGE_MADE_DIR "/orbit.gz")

namespace im2fit::apps {
namespace {

constexpr const char* kWords = "application/json; charset=utf-8";
constexpr const char* kScript = "text/javascript; charset=utf-8";

}  // namespace

const WebFile* web_file(std::string_view path) {
  const auto between = [](const char* begin, const char* end) { return std::string_view(begin, end); };
  const auto own = [&](const char* path, const char* type, const char* begin, const char* end) {
    return WebFile{path, type, between(begin, end), {}, false};
  };
  static const std::array kFiles = {
      own("/", "text/html; charset=utf-8", im2fit_web_index, im2fit_web_index_end),
      own("/page.css", "text/css; charset=utf-8", im2fit_web_style, im2fit_web_style_end),
      own("/words.js", kScript, im2fit_web_words, im2fit_web_words_end),
      own("/icons.js", kScript, im2fit_web_icons, im2fit_web_icons_end),
      own("/sounds.js", kScript, im2fit_web_sounds, im2fit_web_sounds_end),
      own("/mirror.js", kScript, im2fit_web_mirror, im2fit_web_mirror_end),
      own("/lang/en.json", kWords, im2fit_web_en, im2fit_web_en_end),
      own("/lang/de.json", kWords, im2fit_web_de, im2fit_web_de_end),
      own("/lang/es.json", kWords, im2fit_web_es, im2fit_web_es_end),
      own("/lang/fr.json", kWords, im2fit_web_fr, im2fit_web_fr_end),
      own("/lang/zh.json", kWords, im2fit_web_zh, im2fit_web_zh_end),
      own("/stage.js", kScript, im2fit_web_stage, im2fit_web_stage_end),
      own("/cloth.js", kScript, im2fit_web_cloth, im2fit_web_cloth_end),
      own("/tryon.js", kScript, im2fit_web_tryon, im2fit_web_tryon_end),
      own("/tryon.css", "text/css; charset=utf-8", im2fit_web_tryon_style, im2fit_web_tryon_style_end),
      own("/facts.js", kScript, im2fit_web_facts, im2fit_web_facts_end),
      own("/facts.css", "text/css; charset=utf-8", im2fit_web_facts_style, im2fit_web_facts_style_end),
      own("/page.js", kScript, im2fit_web_page, im2fit_web_page_end),
      own("/handed.html", "text/html; charset=utf-8", im2fit_web_handed, im2fit_web_handed_end),
      own("/handed.js", kScript, im2fit_web_handed_script, im2fit_web_handed_script_end),
      own("/operator", "text/html; charset=utf-8", im2fit_web_operator, im2fit_web_operator_end),
      own("/operator.js", kScript, im2fit_web_operator_script, im2fit_web_operator_script_end),
      own("/operator.css", "text/css; charset=utf-8", im2fit_web_operator_style, im2fit_web_operator_style_end),
      WebFile{"/" IM2FIT_PAGE_THREE, kScript, between(im2fit_web_three, im2fit_web_three_end),
              between(im2fit_web_three_gzip, im2fit_web_three_gzip_end), true},
      WebFile{"/" IM2FIT_PAGE_LOADER, kScript, between(im2fit_web_loader, im2fit_web_loader_end),
              between(im2fit_web_loader_gzip, im2fit_web_loader_gzip_end), true},
      WebFile{"/" IM2FIT_PAGE_ORBIT, kScript, between(im2fit_web_orbit, im2fit_web_orbit_end),
              between(im2fit_web_orbit_gzip, im2fit_web_orbit_gzip_end), true}};
  const auto* found = std::find_if(kFiles.begin(), kFiles.end(), [&](const WebFile& f) { return f.path == path; });
  return found == kFiles.end() ? nullptr : found;
}

}  // namespace im2fit::apps

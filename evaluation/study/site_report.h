// SPDX-License-Identifier: Apache-2.0
// A site's study for people and for programs.
#pragma once

#include <string>
#include <vector>

#include "evaluation/study/site_statistics.h"

namespace im2fit::lab {

std::string text_of(const SiteStudy& study);
// im2fit.study/1
std::string json_of(const SiteStudy& study);
// One page, inline pictures, no external files. `title`: the name of the site; `synthetic`: its people are.
std::string html_of(const SiteStudy& study, const std::vector<SitePerson>& visits, const std::string& title,
                    bool synthetic);

}  // namespace im2fit::lab

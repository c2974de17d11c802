// SPDX-License-Identifier: Apache-2.0
// How reports of one page look: no fonts, scripts or pictures from elsewhere.
#pragma once

namespace im2fit::lab {

inline constexpr const char* kPageStyle = R"(
:root{color-scheme:light}
body{margin:0;background:#f3f5f7;color:#22262b;font:16px/1.55 system-ui,sans-serif}
main{max-width:1000px;margin:0 auto;padding:32px 20px 80px}
h1{font-size:32px;line-height:1.2;margin:0 0 6px}
h2{font-size:21px;margin:0 0 4px}
p{margin:6px 0 12px;max-width:760px}
.quiet{color:#5d6570;font-size:14px}
.synthetic{display:inline-block;background:#22262b;color:#fff;border-radius:4px;padding:1px 8px;font-size:13px}
section{background:#fff;border-radius:10px;padding:22px 26px;margin:20px 0;box-shadow:0 1px 3px #0001}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(145px,1fr));gap:14px;margin:22px 0}
.card{background:#fff;border-radius:10px;padding:14px 15px;box-shadow:0 1px 3px #0001}
.card b{display:block;font-size:25px;line-height:1.25}
.card span{color:#5d6570;font-size:13px;display:block}
svg{width:100%;height:auto;display:block}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}
th,td{padding:5px 7px;text-align:right;white-space:nowrap;border-bottom:1px solid #e4e7eb}
th{font-weight:600;color:#5d6570;white-space:normal;vertical-align:bottom}
td:first-child,th:first-child{text-align:left}
.in{color:#00795a}.over{color:#b84a00}
nav a{color:#0072b2;text-decoration:none;margin-right:14px;font-size:14px}
)";

}  // namespace im2fit::lab

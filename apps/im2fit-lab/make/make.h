// SPDX-License-Identifier: Apache-2.0
// Makers of files of this repository: tables compiled into the library, and pictures of the manual. Each takes its
// words as a program does (argv[0]: its name), prints what is wrong and returns the exit code.
#pragma once

namespace im2fit::apps {

int make_avatar_plate(int argc, char** argv);
int make_cut_regression(int argc, char** argv);
int make_error_correlation(int argc, char** argv);
int make_garment_plate(int argc, char** argv);
int make_garment_sheets(int argc, char** argv);
int make_garment_sizes(int argc, char** argv);
int make_measurement_regression(int argc, char** argv);
int make_tape_regression(int argc, char** argv);
int make_tape_table(int argc, char** argv);
int make_wardrobe_table(int argc, char** argv);

}  // namespace im2fit::apps

/** @file
 * Values of options as text: parsed strictly, with errors that say what would be accepted. Options that may
 * be repeated.
 */
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "recurse/core/io/text.h"
#include "recurse/model/camera/camera.h"
#include "recurse/pathclasses/pathEvent.h"

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace recurse::apps {

/** Adds an option that takes one value each time it is given; `values` receives all of them, in order. What
 * follows a value belongs to the command. */
CLI::Option* addRepeatedOption(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                               const std::string& description);

[[noreturn]] void badUsage(const std::string& message);

/** Every function throws Error (BAD_USAGE) that names the option. */

/** Duration [s], above zero: "30s", "2m", "1h30m", "90" (seconds). */
double parseDuration(const std::string& option, const std::string& text);
/** Parts between separators; one empty part for an empty text. */
std::vector<std::string> split(const std::string& text, char separator);

/** Width and height, "640x480". */
std::array<int, 2> parseResolution(const std::string& option, const std::string& text);
/** Crop window, "x0,x1,y0,y1", each in [0, 1]. */
std::array<double, 4> parseCropWindow(const std::string& option, const std::string& text);
/** A whole number in [minimum, maximum]; "1000000", "1e6", "1M" and "1000k" are the same. */
int64_t parseCount(const std::string& option, const std::string& text, int64_t minimum, int64_t maximum);
/** Pixel "X,Y" within a crop window. */
std::array<int, 2> parsePixel(const std::string& option, const std::string& text, const PixelBounds& crop);
uint64_t parseSeed(const std::string& option, const std::string& text);
/** Path class, "NAME=EXPRESSION". */
PathClass parseClass(const std::string& option, const std::string& text);
/** A finite number. */
double parseReal(const std::string& option, const std::string& text);

/** Duration as text: "2h05m", "3m07s", "12.3s". */
std::string durationText(double seconds);
/** Count as text: "12.3M", with at most three digits before the letter. */
std::string countText(double count);
std::string bytesText(double bytes);
/** The folder with a slash at its end. */
std::string folderName(const std::string& folder);
/** Text quoted for a shell, where it needs quotes. */
std::string shellQuoted(const std::string& text);

} // namespace recurse::apps

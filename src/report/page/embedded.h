/** @file
 * The files of the page as they are beside this one, put into the program by cmake/embed.cmake.
 */
#pragma once

#include <string_view>

namespace recurse::page {

extern const std::string_view STILLS_HTML, STILLS_CSS, STILLS_DATA_JS, STILLS_VIEW_JS, STILLS_JS;

} // namespace recurse::page

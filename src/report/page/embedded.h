/** @file
 * Files of the pages, which are in the folders beside this one, embedded in the program by cmake/embed.cmake.
 */
#pragma once

#include <string_view>

namespace recurse::page {

extern const std::string_view FRAME_HTML, PAGE_CSS, PIXELS_JS, TONE_JS, LOCAL_TONE_JS, EDGES_JS, VIEW_JS;
extern const std::string_view DEVELOP_HTML, DEVELOP_JS;
extern const std::string_view STILLS_HTML, STILLS_CSS, STILLS_DATA_JS, STILLS_JS;
extern const std::string_view CONVERGE_HTML, CONVERGE_CSS, CONVERGE_JS;
extern const std::string_view METHODS_HTML, METHODS_CSS, METHODS_JS;
extern const std::string_view MARKING_HTML, MARKING_CSS, MARKING_JS;
extern const std::string_view LIVE_HTML, LIVE_CSS, LIVE_JS;
extern const std::string_view INSPECT_HTML, INSPECT_CSS, PATH_EXPRESSION_JS, SCENE_VIEW_JS, PATH_VIEW_JS,
    ESTIMATE_JS, PHOTON_VIEW_JS, FLIGHT_VIEW_JS, BOX_VIEW_JS, PATCH_VIEW_JS, INSPECT_JS;
extern const std::string_view THREE_MIN_JS, ORBIT_CONTROLS_JS; ///< three.js, from its Debian package
extern const std::string_view CHART_MIN_JS;                    ///< Chart.js, from its Debian package

} // namespace recurse::page

/** @file
 * Examples for a first render.
 */
#include "apps/help/quickStart.h"

namespace recurse::apps {

std::string quickStart() {
  return "Recurse renders scene files (pbrt-v4) and models (glTF, OBJ) by photon mapping and path "
         "tracing.\n"
         "  recurse render scene.pbrt --check                      what the scene contains, or its errors\n"
         "  recurse render scene.pbrt -o scene.png --live          renders, and shows progress in a browser\n"
         "  recurse render scene.pbrt -o scene.exr --time-limit 5m renders five minutes, linear values\n"
         "  recurse develop scene.exr -o scene.png --exposure +1   makes a picture for a display of it\n"
         "  recurse stills scene.pbrt -o stills                    one picture for each class of light "
         "paths\n"
         "  recurse methods scene.pbrt -o methods                  the scene by every integrator, with "
         "errors\n"
         "  recurse compare scene.exr reference.exr                error measures between two pictures\n"
         "  recurse reference glass                                what scene files can say about glass\n"
         "All commands: recurse --help. Options and examples of a command: recurse render --help\n";
}

} // namespace recurse::apps

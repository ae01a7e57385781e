/** @file
 * Five small scenes for marks, which together show all default classes of paths except media.
 */
#pragma once

#include <string>

namespace markingScenes {

/** Film and camera, then the world. */
inline std::string sceneOf(const std::string& lookAt, int fov, const std::string& world) {
  return "Film \"rgb\" \"integer xresolution\" 64 \"integer yresolution\" 48\nPixelFilter \"box\"\nLookAt " +
         lookAt + "\nCamera \"perspective\" \"float fov\" " + std::to_string(fov) + "\nWorldBegin\n" + world;
}

inline std::string square(const std::string& colour, const std::string& points) {
  return "Material \"diffuse\" \"rgb reflectance\" [ " + colour +
         " ]\nShape \"bilinearmesh\" \"point3 P\" [ " + points + " ]\n";
}

inline std::string ball(const std::string& material, const std::string& place, double radius) {
  return "AttributeBegin\nMaterial " + material + "\nTranslate " + place +
         "\nShape \"sphere\" \"float radius\" " + std::to_string(radius) + "\nAttributeEnd\n";
}

inline std::string matt(const std::string& colour) {
  return "\"diffuse\" \"rgb reflectance\" [ " + colour + " ]";
}
inline std::string mirror() { return "\"conductor\" \"rgb reflectance\" [ .85 .85 .85 ]"; }

inline std::string lamp(const std::string& radiance, const std::string& shape) {
  return "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ " + radiance + " ]\n" + shape +
         "\nAttributeEnd\n";
}

/** A room lit by a disk that faces up: most of its light is scattered many times. */
inline std::string room() {
  return sceneOf("0 -3.6 1.4  0 0 1  0 0 1", 50,
                 square(".75 .7 .65", "-2 -4 0  2 -4 0  -2 2 0  2 2 0") +
                     square(".75 .7 .65", "-2 -4 2.6  2 -4 2.6  -2 2 2.6  2 2 2.6") +
                     square(".75 .7 .65", "-2 2 0  2 2 0  -2 2 2.6  2 2 2.6") +
                     square(".7 .25 .2", "-2 -4 0  -2 2 0  -2 -4 2.6  -2 2 2.6") +
                     square(".2 .5 .3", "2 -4 0  2 2 0  2 -4 2.6  2 2 2.6") +
                     ball(matt(".8 .8 .3"), ".7 .6 .6", 0.6) +
                     lamp("40 36 30", "Translate -.9 .4 1.3\nShape \"disk\" \"float radius\" .25"));
}

/** Outdoors, with a matt ball and a mirror ball that reflects the sky onto the ground. */
inline std::string outdoors() {
  return sceneOf("3 -5 2.2  0 0 .6  0 0 1", 34,
                 "LightSource \"infinite\" \"rgb L\" [ .4 .55 .8 ]\nLightSource \"distant\" \"point3 from\" "
                 "[ -2 -3 4 ] \"point3 to\" [ 0 0 0 ] \"rgb L\" [ 2.2 2 1.6 ]\n" +
                     square(".4 .5 .3", "-8 -8 0  8 -8 0  -8 8 0  8 8 0") +
                     ball(matt(".7 .3 .2"), "-1.1 .2 .6", 0.6) + ball(mirror(), ".9 .5 .7", 0.7));
}

/** Two balls in front of a wall with a mirror, under a large lamp. */
inline std::string wallWithMirror() {
  return sceneOf(
      "0 -4.4 1.6  0 0 .9  0 0 1", 40,
      square(".6 .6 .6", "-3 -3 0  3 -3 0  -3 2 0  3 2 0") +
          square(".6 .6 .6", "-3 2 0  3 2 0  -3 2 3  3 2 3") + "Material " + mirror() +
          "\nShape \"bilinearmesh\" \"point3 P\" [ -2 1.9 .3  -.2 1.9 .3  -2 1.9 2  -.2 1.9 2 ]\n" +
          ball(matt(".2 .3 .7"), ".9 .2 .5", 0.5) + ball(matt(".7 .6 .2"), "-.8 .3 .4", 0.4) +
          lamp("20 20 20", "Shape \"bilinearmesh\" \"point3 P\" [ .4 0 2.6  1.4 0 2.6  .4 -1 2.6  "
                           "1.4 -1 2.6 ]"));
}

/** A corner with red and green walls, a visible lamp, and a box of mirrors. */
inline std::string corner() {
  return sceneOf("2.6 -2.8 2  0 .2 .7  0 0 1", 45,
                 square(".7 .7 .7", "-2 -3 0  2.5 -3 0  -2 1.5 0  2.5 1.5 0") +
                     square(".65 .15 .1", "-2 1.5 0  2.5 1.5 0  -2 1.5 2.4  2.5 1.5 2.4") +
                     square(".15 .55 .2", "-2 -3 0  -2 1.5 0  -2 -3 2.4  -2 1.5 2.4") +
                     ball(mirror(), "-.3 .3 .5", 0.5) + ball(matt(".3 .3 .8"), ".8 .4 .35", 0.35) +
                     lamp("9 9 8", "Translate -1.2 -.3 1.9\nShape \"sphere\" \"float radius\" .35"));
}

/** A glass ball on a floor under a broad lamp: a soft caustic. */
inline std::string glass() {
  return sceneOf("0 -4 2  0 0 .5  0 0 1", 38,
                 square(".7 .6 .5", "-3 -3 0  3 -3 0  -3 3 0  3 3 0") +
                     square(".3 .4 .7", "-3 1.5 0  3 1.5 0  -3 1.5 3  3 1.5 3") +
                     ball("\"dielectric\" \"float eta\" 1.5", "-.6 -.2 .7", 0.5) +
                     ball(mirror(), ".8 .2 .5", 0.5) +
                     lamp("4 3.8 3.4", "Translate -1 -.6 3.4\nShape \"sphere\" \"float radius\" 1"));
}

} // namespace markingScenes
